// The limit: a platform with viscous and dry friction, exact stick and slip, in rwjax's own step. Windows lie side by side
// in SIMD lanes and carry forward sensitivities; condensed multiple shooting with Levenberg-Marquardt damping.
//
// Numbers z: logarithms of inertia I, viscous b and dry friction c. Columns of a window: these three, its first rate,
// its first angle (which only shifts the angle: it has no response to carry along).
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LANES 8
#define CARRIED 4
#define COLUMNS 5
#define PAIRS 15
#define STRIDE (PAIRS + COLUMNS + 2 + 2 * CARRIED) // what an evaluation leaves of a window
#define LONGEST_LOG_STEP 0.7
#define WINDOW_STEPS 8

typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef long mask __attribute__((vector_size(8 * LANES)));
#define PICK(m, a, b) ((lanes)(((m) & (mask)(a)) | (~(m) & (mask)(b))))

typedef struct {
    double gain, I, b, c, h;
    double E, P, Q;             // rate: E w + P n; angle: psi + P w + Q n; n = (gain u - friction) / I
    double dE[2], dP[2], dQ[2]; // by log I and log b
} Plant;

typedef struct {
    int windows, samples, substeps; // samples of each window, grid steps of each sample
    double gain, h;
    const double *command, *reading, *weight; // in the order of time
    const double *lane_command, *lane_reading, *lane_weight; // lane by lane: the windows of a group next to each other
} Data;

static Plant plant_of(const double *z, double gain, double h) {
    Plant p = {.gain = gain, .I = exp(z[0]), .b = exp(z[1]), .c = exp(z[2]), .h = h};
    double a = -h * p.b / p.I, sum = 1.0;
    for (int k = 20; k >= 4; k--) sum = 1.0 + a * sum / k;
    double phi3 = sum / 6.0, phi2 = 0.5 + a * phi3, phi1 = 1.0 + a * phi2;
    p.E = 1.0 + a * phi1, p.P = h * phi1, p.Q = h * h * phi2;
    for (int j = 0; j < 2; j++) {
        double da = j ? a : -a;
        p.dE[j] = da * p.E, p.dP[j] = da * h * (phi1 - phi2), p.dQ[j] = da * h * h * (phi2 - 2.0 * phi3);
    }
    return p;
}

// Ends a step in which the rate changed sign from w to w1: stops at the crossing, goes on or stays. With Sp, Sw (responses
// at the start) and Sw1 (at the unmended end) given, also their responses at the end.
static void cross(const Plant *p, double u, double psi, double w, double *psi1, double *w1,
                  const double *Sp, const double *Sw, double *Sp1, double *Sw1) {
    double s = w > 0.0 ? 1.0 : -1.0, drive = p->gain * u;
    double swift = p->h * (drive - p->b * w - s * p->c) / p->I, bend = *w1 - w - swift;
    double root = sqrt(swift * swift - 4.0 * bend * w), below = s * root - swift, share = 2.0 * w / below;
    double free0 = drive - p->b * w, free1 = drive - p->b * *w1, free = free0 + share * (free1 - free0);
    double middle = 0.5 * (free + free1), side = middle > p->c ? 1.0 : middle < -p->c ? -1.0 : 0.0;
    int slides = fabs(free) > p->c && side != 0.0;
    double net = slides ? middle - side * p->c : 0.0, left = (1.0 - share) * p->h, turned = left * net / p->I;
    double mean = w + share * (swift / 2.0 + share * bend / 3.0);
    for (int j = 0; Sp && j < CARRIED; j++) {
        double dw = Sw[j], dw1 = Sw1[j], dI = j == 0, db = j == 1 ? p->b : 0.0, dc = j == 2 ? p->c : 0.0;
        double dswift = p->h * (-p->b * dw - db * w - s * dc) / p->I - swift * dI, dbend = dw1 - dw - dswift;
        double droot = (swift * dswift - 2.0 * (dbend * w + bend * dw)) / root;
        double dshare = (2.0 * dw - share * (s * droot - dswift)) / below;
        double dfree0 = -p->b * dw - db * w, dfree1 = -p->b * dw1 - db * *w1;
        double dfree = dfree0 + dshare * (free1 - free0) + share * (dfree1 - dfree0);
        double dnet = slides ? 0.5 * (dfree + dfree1) - side * dc : 0.0;
        double dturned = (left * dnet - dshare * p->h * net) / p->I - turned * dI;
        double dmean = dw + dshare * (swift / 2.0 + 2.0 * share * bend / 3.0) + share * (dswift / 2.0 + share * dbend / 3.0);
        Sp1[j] = Sp[j] + p->h * (dshare * mean + share * dmean) + 0.5 * (left * dturned - dshare * p->h * turned);
        Sw1[j] = dturned;
    }
    *psi1 = psi + share * p->h * mean + 0.5 * left * turned;
    *w1 = turned;
}

// One grid step of a free run.
static inline void advance(const Plant *p, double u, double *psi, double *w) {
    double drive = p->gain * u;
    if (*w == 0.0 && fabs(drive) <= p->c) return;
    double s = *w > 0.0 ? 1.0 : *w < 0.0 ? -1.0 : drive > 0.0 ? 1.0 : -1.0, n = (drive - s * p->c) / p->I;
    double w1 = p->E * *w + p->P * n, psi1 = *psi + p->P * *w + p->Q * n;
    if (*w * w1 < 0.0) cross(p, u, *psi, *w, &psi1, &w1, 0, 0, 0, 0);
    *psi = psi1, *w = w1;
}

// Angles of a free run at all samples.
void simulate(int samples, int substeps, double gain, double h, const double *command, const double *z,
              const double *first, double *angle) {
    Plant p = plant_of(z, gain, h);
    double psi = first[0], w = first[1];
    for (int k = 0; k < samples; k++) {
        angle[k] = psi;
        for (int q = 0; q < substeps; q++) advance(&p, command[k], &psi, &w);
    }
}

// Half sum of squares of a free run that begins at the first node, whose other nodes it fills in.
static double run(const Data *d, const double *z, double *Xp, double *Xw) {
    Plant p = plant_of(z, d->gain, d->h);
    double psi = Xp[0], w = Xw[0], cost = 0.0;
    size_t at = 0;
    for (int window = 0; window < d->windows; window++) {
        Xp[window] = psi, Xw[window] = w;
        for (int k = 0; k < d->samples; k++, at++) {
            double r = d->weight[at] * (psi - d->reading[at]);
            cost += r * r;
            for (int q = 0; q < d->substeps; q++) advance(&p, d->command[at], &psi, &w);
        }
    }
    return 0.5 * cost;
}

// Windows from their nodes: of each the normal matrix (lower half), gradient, end and the end's responses.
static void evaluate(const Data *d, const double *z, const double *Xp, const double *Xw, double *out) {
    const Plant p = plant_of(z, d->gain, d->h);
    const lanes zero = {0}, one = zero + 1.0;
    const size_t W = d->windows;
    for (size_t b = 0; b < W; b += LANES) {
        lanes psi, w, Sp[CARRIED], Sw[CARRIED], H[PAIRS], g[COLUMNS];
        memcpy(&psi, Xp + b, sizeof psi), memcpy(&w, Xw + b, sizeof w);
        for (int j = 0; j < CARRIED; j++) Sp[j] = Sw[j] = zero;
        for (int j = 0; j < PAIRS; j++) H[j] = zero;
        for (int j = 0; j < COLUMNS; j++) g[j] = zero;
        Sw[3] = one;
        for (int k = 0; k < d->samples; k++) {
            lanes u, y, weight, J[COLUMNS];
            size_t at = b * d->samples + (size_t)k * LANES;
            memcpy(&u, d->lane_command + at, sizeof u), memcpy(&y, d->lane_reading + at, sizeof y);
            memcpy(&weight, d->lane_weight + at, sizeof weight);
            lanes r = (psi - y) * weight;
            for (int j = 0; j < CARRIED; j++) J[j] = Sp[j] * weight;
            J[4] = weight;
#pragma GCC unroll 8
            for (int i = 0; i < COLUMNS; i++) {
                g[i] += J[i] * r;
#pragma GCC unroll 8
                for (int j = 0; j <= i; j++) H[i * (i + 1) / 2 + j] += J[i] * J[j];
            }
            lanes drive = p.gain * u;
            mask held = (drive <= p.c) & (drive >= -p.c);
            for (int q = 0; q < d->substeps; q++) {
                lanes s = PICK(w > 0.0, one, PICK(w < 0.0, -one, PICK(drive > 0.0, one, -one)));
                lanes by_c = -s * (p.c / p.I), n = drive / p.I + by_c;
                lanes w1 = p.E * w + p.P * n, psi1 = psi + p.P * w + p.Q * n, Sp1[CARRIED], Sw1[CARRIED];
                for (int j = 0; j < CARRIED; j++) Sw1[j] = p.E * Sw[j], Sp1[j] = Sp[j] + p.P * Sw[j];
                for (int j = 0; j < 2; j++) Sw1[j] += p.dE[j] * w + p.dP[j] * n, Sp1[j] += p.dP[j] * w + p.dQ[j] * n;
                Sw1[0] -= p.P * n, Sp1[0] -= p.Q * n, Sw1[2] += p.P * by_c, Sp1[2] += p.Q * by_c;
                mask crossed = w * w1 < 0.0, stuck = (w == 0.0) & held;
                long any = 0;
                for (int l = 0; l < LANES; l++) any |= crossed[l];
                for (int l = 0; any && l < LANES; l++) {
                    if (!crossed[l]) continue;
                    double e[2] = {0.0, w1[l]}, a[4][CARRIED];
                    for (int j = 0; j < CARRIED; j++) a[0][j] = Sp[j][l], a[1][j] = Sw[j][l], a[3][j] = Sw1[j][l];
                    cross(&p, u[l], psi[l], w[l], &e[0], &e[1], a[0], a[1], a[2], a[3]);
                    psi1[l] = e[0], w1[l] = e[1];
                    for (int j = 0; j < CARRIED; j++) Sp1[j][l] = a[2][j], Sw1[j][l] = a[3][j];
                }
                psi = PICK(stuck, psi, psi1), w = PICK(stuck, zero, w1);
                for (int j = 0; j < CARRIED; j++) Sp[j] = PICK(stuck, Sp[j], Sp1[j]), Sw[j] = PICK(stuck, zero, Sw1[j]);
            }
        }
        double *o = out + b;
#define LEAVE(v) (memcpy(o, &(v), sizeof(lanes)), o += W)
        for (int j = 0; j < PAIRS; j++) LEAVE(H[j]);
        for (int j = 0; j < COLUMNS; j++) LEAVE(g[j]);
        LEAVE(psi), LEAVE(w);
        for (int j = 0; j < CARRIED; j++) LEAVE(Sp[j]);
        for (int j = 0; j < CARRIED; j++) LEAVE(Sw[j]);
    }
}

// Normal equations of numbers and first state, windows' states eliminated by linearised continuity. `chain`: for each
// window the responses of its angle and rate (COLUMNS each) and their shifts.
static void condense(const double *out, size_t W, const double *Xp, const double *Xw, double *H, double *g, double *chain) {
    const double *left = out, *gradient = left + PAIRS * W, *end_p = gradient + COLUMNS * W, *end_w = end_p + W;
    const double *Sp = end_w + W, *Sw = Sp + CARRIED * W;
    double C[COLUMNS][COLUMNS] = {{0}}, shift[COLUMNS] = {0};
    for (int j = 0; j < COLUMNS; j++) C[j][j] = 1.0;
    memset(H, 0, sizeof(double) * COLUMNS * COLUMNS), memset(g, 0, sizeof(double) * COLUMNS);
    for (size_t k = 0; k < W; k++) {
        double *row = chain + 2 * (COLUMNS + 1) * k, h[COLUMNS][COLUMNS], HC[COLUMNS][COLUMNS], f[COLUMNS];
        memcpy(row, C[4], sizeof C[4]), memcpy(row + COLUMNS, C[3], sizeof C[3]);
        row[2 * COLUMNS] = shift[4], row[2 * COLUMNS + 1] = shift[3];
        for (int i = 0; i < COLUMNS; i++)
            for (int j = 0; j <= i; j++) h[i][j] = h[j][i] = left[(i * (i + 1) / 2 + j) * W + k];
        for (int i = 0; i < COLUMNS; i++) {
            f[i] = gradient[i * W + k] + h[i][3] * shift[3] + h[i][4] * shift[4];
            for (int j = 0; j < COLUMNS; j++) HC[i][j] = (j < 3 ? h[i][j] : 0.0) + h[i][3] * C[3][j] + h[i][4] * C[4][j];
        }
        for (int i = 0; i < COLUMNS; i++) {
            g[i] += (i < 3 ? f[i] : 0.0) + C[3][i] * f[3] + C[4][i] * f[4];
            for (int j = 0; j < COLUMNS; j++)
                H[i * COLUMNS + j] += (i < 3 ? HC[i][j] : 0.0) + C[3][i] * HC[3][j] + C[4][i] * HC[4][j];
        }
        if (k + 1 == W) break;
        double rate[COLUMNS], angle[COLUMNS], by_p = Sp[3 * W + k], by_w = Sw[3 * W + k];
        for (int j = 0; j < COLUMNS; j++) {
            angle[j] = (j < 3 ? Sp[j * W + k] : 0.0) + by_p * C[3][j] + C[4][j];
            rate[j] = (j < 3 ? Sw[j * W + k] : 0.0) + by_w * C[3][j];
        }
        shift[4] += by_p * shift[3] + end_p[k] - Xp[k + 1];
        shift[3] = by_w * shift[3] + end_w[k] - Xw[k + 1];
        memcpy(C[3], rate, sizeof rate), memcpy(C[4], angle, sizeof angle);
    }
}

static int solve(double *A, double *b) {
    const int n = COLUMNS;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double s = A[i * n + j];
            for (int k = 0; k < j; k++) s -= A[i * n + k] * A[j * n + k];
            if (i == j && !(s > 0.0)) return 0;
            A[i * n + j] = i == j ? sqrt(s) : s / A[j * n + j];
        }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) b[i] -= A[i * n + k] * b[k];
        b[i] /= A[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) b[i] -= A[k * n + i] * b[k];
        b[i] /= A[i * n + i];
    }
    return 1;
}

// Damped Gauss-Newton step of numbers and first state, in z_new and the nodes of a linearised run. Returns the largest
// change of a logarithm, or -1 where the equations cannot be solved.
static double move(size_t W, const double *H, const double *g, const double *chain, double damping, const double *z,
                   const double *Xp, const double *Xw, double *z_new, double *Xp_new, double *Xw_new) {
    double A[COLUMNS * COLUMNS], step[COLUMNS], longest = 0.0;
    memcpy(A, H, sizeof A);
    for (int i = 0; i < COLUMNS; i++) A[i * (COLUMNS + 1)] *= 1.0 + damping, step[i] = -g[i];
    if (!solve(A, step)) return -1.0;
    for (int i = 0; i < 3; i++) longest = fmax(longest, fabs(step[i]));
    double share = longest > LONGEST_LOG_STEP ? LONGEST_LOG_STEP / longest : 1.0;
    for (int i = 0; i < COLUMNS; i++) step[i] *= share;
    for (int i = 0; i < 3; i++) z_new[i] = z[i] + step[i];
    for (size_t k = 0; k < W; k++) {
        const double *row = chain + 2 * (COLUMNS + 1) * k;
        double p = Xp[k] + share * row[2 * COLUMNS], w = Xw[k] + share * row[2 * COLUMNS + 1];
        for (int j = 0; j < COLUMNS; j++) p += row[j] * step[j], w += row[COLUMNS + j] * step[j];
        Xp_new[k] = p, Xw_new[k] = w;
    }
    return longest;
}

// Fits z (3) and the nodes Xp, Xw (windows) in place: first through the windows, then on the free run itself. Returns the
// number of evaluations with sensitivities.
int fit(int windows, int samples, int substeps, double gain, double h, const double *command, const double *reading,
        const double *weight, const double *lane_command, const double *lane_reading, const double *lane_weight, double *z, double *Xp, double *Xw, double tolerance, int most, double *cost) {
    const Data d = {windows, samples, substeps, gain,        h,           command,
                    reading, weight,  lane_command, lane_reading, lane_weight};
    const size_t W = windows;
    double *out = malloc(STRIDE * W * sizeof(double)), *chain = malloc(2 * (COLUMNS + 1) * W * sizeof(double));
    double *nodes = malloc(2 * W * sizeof(double)), H[COLUMNS * COLUMNS], g[COLUMNS], z_new[3], damping = 1e-3;
    int taken = 0;
    for (double change = 1.0; taken < WINDOW_STEPS && change >= 1e-3;) {
        evaluate(&d, z, Xp, Xw, out), taken++;
        condense(out, W, Xp, Xw, H, g, chain);
        change = move(W, H, g, chain, damping, z, Xp, Xw, z, Xp, Xw);
    }
    *cost = run(&d, z, Xp, Xw);
    for (int fresh = 1, settled = 0; taken < most && !settled && damping < 1e8;) {
        if (fresh) evaluate(&d, z, Xp, Xw, out), taken++, condense(out, W, Xp, Xw, H, g, chain);
        double change = move(W, H, g, chain, damping, z, Xp, Xw, z_new, nodes, nodes + W);
        double then = change < 0.0 ? INFINITY : run(&d, z_new, nodes, nodes + W);
        fresh = then <= *cost;
        settled = fresh ? *cost - then <= tolerance * *cost : change >= 0.0 && change < 1e-10;
        damping = fresh ? fmax(0.1 * damping, 1e-10) : 8.0 * fmax(damping, 1e-6);
        if (fresh) {
            memcpy(z, z_new, sizeof z_new), memcpy(Xp, nodes, W * sizeof(double));
            memcpy(Xw, nodes + W, W * sizeof(double)), *cost = then;
        }
    }
    free(out), free(nodes), free(chain);
    return taken;
}
