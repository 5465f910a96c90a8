// What a program written for one plant can do: Routh tests of a cubic over gains, and the closed loop of a reaction rig with
// Stribeck friction in the library's own step (exponential Runge-Kutta, exact stick), eight loops in one vector.
#include <math.h>
#include <string.h>
typedef double v8 __attribute__((vector_size(64)));
typedef long long m8 __attribute__((vector_size(64)));
v8 _ZGVeN8v_exp(v8);
#define AI static inline __attribute__((always_inline))

// s^3 + c2 s^2 + (c1 + g1 kd) s + (c0 + g0 kp), already shifted: coefficients of a row of kp (a) and of a column of kd (b)
void region_grid(long np, long nd, const double *kp, const double *kd, const double *base, const double *byp, const double *byd,
                 unsigned char *out) {
  double b2 = base[1];
  for (long i = 0; i < np; i++) {
    double a1 = base[2] + byp[2] * kp[i], a0 = base[3] + byp[3] * kp[i];
    for (long j = 0; j < nd; j++) {
      double b1 = a1 + byd[2] * kd[j], b0 = a0 + byd[3] * kd[j];
      out[i * nd + j] = (b2 > 0) & (b1 > 0) & (b0 > 0) & (b2 * b1 > b0);
    }
  }
}

// how many of m plants (4 base, 4 by kp, 4 by kd each) every pair stabilises
void region_count(long n, const double *kp, const double *kd, long m, const double *base, const double *byp, const double *byd,
                  unsigned short *count) {
  enum { BLOCK = 2048 };
  for (long s = 0; s < n; s += BLOCK) {
    long e = s + BLOCK < n ? s + BLOCK : n;
    for (long i = s; i < e; i++) count[i] = 0;
    for (long q = 0; q < m; q++) {
      const double *c = base + 4 * q, *p = byp + 4 * q, *d = byd + 4 * q;
      double b2 = c[1], c1 = c[2], c0 = c[3], p1 = p[2], p0 = p[3], d1 = d[2], d0 = d[3];
      int ok = b2 > 0;
      for (long i = s; i < e; i++) {
        double b1 = c1 + p1 * kp[i] + d1 * kd[i], b0 = c0 + p0 * kp[i] + d0 * kd[i];
        count[i] += ok & (b1 > 0) & (b0 > 0) & (b2 * b1 > b0);
      }
    }
  }
}

typedef struct {
  double I, Mc, Me, ivs, gw, gO, gi, hw;  // free torque I w' = gw w + gO O + gi i ; w' has h
  double E[16], P1[16], P2[16];           // over psi, w, Omega, i
  double bi;                              // di/dt per volt
  double h, limit, smooth, period;
} Rig;

AI v8 sel(m8 c, v8 a, v8 b) { return (v8)((c & (m8)a) | (~c & (m8)b)); }
AI v8 all(double x) { v8 z = {0}; return z + x; }
AI v8 mx(v8 a, v8 b) { return sel(a > b, a, b); }
AI v8 mn(v8 a, v8 b) { return sel(a < b, a, b); }
AI v8 ab(v8 a) { return mx(a, -a); }
AI v8 root(v8 a) { v8 r; for (int k = 0; k < 8; k++) r[k] = sqrt(a[k]); return r; }

AI v8 level(const Rig *r, v8 w) { v8 q = w * r->ivs; return r->Mc + r->Me * _ZGVeN8v_exp(-q * q); }

AI void step(const Rig *r, v8 *psi, v8 *w, v8 *O, v8 *i, v8 V) {
  const v8 zero = {0};
  const double *E = r->E, *P = r->P1, *Q = r->P2;
  double h = r->h;
  v8 w0 = *w;
  m8 pos = w0 > zero, neg = w0 < zero;
  v8 f0 = r->gw * w0 + r->gO * *O + r->gi * *i, l0 = level(r, w0);
  v8 hold0 = mn(mx(f0, -l0), l0);
  v8 fr0 = sel(pos, l0, sel(neg, -l0, hold0)), ex0 = f0 - hold0;
  v8 n0 = fr0 * (-1.0 / r->I), ni = V * r->bi;
  v8 rate0 = (f0 - fr0) * (1.0 / r->I);
  v8 ap = *psi + E[1] * w0 + E[2] * *O + E[3] * *i + P[1] * n0 + P[3] * ni;
  v8 aw = E[5] * w0 + E[6] * *O + E[7] * *i + P[5] * n0 + P[7] * ni;
  v8 aO = E[10] * *O + E[11] * *i + P[11] * ni;
  v8 ai = E[14] * *O + E[15] * *i + P[15] * ni;
  v8 f1 = r->gw * aw + r->gO * aO + r->gi * ai, l1 = level(r, aw);
  v8 hold1 = mn(mx(f1, -l1), l1);
  v8 fr1 = sel(pos, l1, sel(neg, -l1, hold1)), ex1 = f1 - hold1;
  v8 dn = (fr1 - fr0) * (-1.0 / r->I);
  v8 p1 = ap + Q[1] * dn, w1 = aw + Q[5] * dn;
  // stop, turn, stick or break loose
  v8 rest = all(r->Mc + r->Me);
  m8 crossed = w0 * w1 < zero;
  v8 swift = h * rate0, bend = w1 - w0 - swift;
  v8 sg = sel(pos, all(1.0), sel(neg, all(-1.0), zero));
  v8 turn = sel(crossed, swift * swift - 4.0 * bend * w0, all(1.0));
  v8 share = sel(crossed, 2.0 * w0 / sel(crossed, sg * root(turn) - swift, all(1.0)), zero);
  v8 fs = f0 + share * (f1 - f0), mid = 0.5 * (fs + f1);
  m8 slides = (fs > rest) | (fs < -rest);
  v8 net = sel(slides, mid - mn(mx(mid, -rest), rest), zero);
  v8 left = (1.0 - share) * h, turned = left * net * (1.0 / r->I);
  m8 rested = (w0 == zero) & (ex0 == zero), stuck = rested & (ex1 == zero), breaking = rested & (ex1 != zero);
  v8 spare = sel(ex1 > zero, rest - f0, rest + f0);
  v8 late = spare / sel(breaking, spare + ab(ex1), all(1.0));
  v8 end = sel(stuck, zero, sel(breaking, (1.0 - late) * w1, sel(crossed, turned, w1)));
  v8 until = share * h * (w0 + share * (swift * 0.5 + share * bend * (1.0 / 3.0)));
  v8 through = *psi + until + 0.5 * left * turned, away = *psi + (1.0 - late) * h * end * (1.0 / 3.0);
  *psi = sel(stuck, *psi, sel(breaking, away, sel(crossed, through, p1)));
  *w = end;
  *O = aO;
  *i = ai;
}

// squared error over the run, of each gain pair; n a multiple of 8; `sign` of the plant
void sweep(int n, int samples, int steps, const Rig *rig, const double *ref, const double *kp, const double *kd, double sign,
           double *cost, int threads) {
#pragma omp parallel for num_threads(threads) schedule(dynamic, 4)
  for (int g = 0; g < n; g += 8) {
    Rig r = *rig;
    v8 z = {0}, psi = z, w = z, O = z, i = z, c = z, p, d, slope = z;
    memcpy(&p, kp + g, 64);
    memcpy(&d, kd + g, 64);
    v8 before = ref[0] - z;
    v8 top = all(r.limit);
    for (int k = 0; k < samples; k++) {
      v8 e = ref[k] - psi;
      slope = (r.smooth * slope + e - before) * (1.0 / (r.smooth + r.period));
      before = e;
      v8 u = p * e + d * slope;
      u = sign * mn(mx(u, -top), top);
      c += e * e * r.period;
      for (int s = 0; s < steps; s++) step(&r, &psi, &w, &O, &i, u);
    }
    memcpy(cost + g, &c, 64);
  }
}
