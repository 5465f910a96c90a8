"""Eq. 4.11, Figs. 4.3 and 4.4: the stable gains, as printed and corrected, the spread of the poles, and slices with an integral."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.thesis.regenerate import FRICTION
from experiments.thesis.table import row, save
from experiments.thesis.testbed import INERTIA, L_CHAPTER_4, RIG, J, K, R, yaw_testbed
from rwjax.control.boundary import boundary, real_boundary
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import LoopPolynomial, pd_loop, pid_loop
from rwjax.control.stability import stable
from rwjax.control.transfer import Transfer, transfer

GRID = np.linspace(0.0, 100.0, 101)
SIGMA = 0.5  # 1/s
INTEGRALS = (0.0, 20.0, 60.0, 120.0)  # V/(rad s)
DAMPINGS, RATES = (0.2, 0.4, 0.6, 0.8), (5.0, 10.0, 15.0)  # of the grid of Fig. 4.4; rad/s


def as_printed(inductance: float = L_CHAPTER_4) -> Transfer:
    """Listing A.4: R b2/(I L) stands in the coefficient of s²; it belongs to s."""
    b, b2 = RIG.numbers["motor.friction"], FRICTION.coef[1]
    motor = (R * b + K**2) / (J * inductance)
    den = [1.0, R / inductance + b / J + b2 + b2 * R / inductance, motor + b2 * b / J, b2 * motor]
    return Transfer(np.array([K / (inductance * INERTIA)]), np.array(den), ())


def corrected(inductance: float = L_CHAPTER_4) -> Transfer:
    """The plant of the rig file, linearised."""
    return transfer(linearised(yaw_testbed(inductance)))


def count(plant: Transfer, sigma: float = SIGMA) -> int:
    """Stable pairs on the thesis's grid of 101 times 101."""
    return int(stable(pd_loop(plant), GRID[:, None], GRID[None, :], sigma=sigma).sum())


def with_integral(plant: Transfer, ki: float) -> np.ndarray:
    """Stable pairs of the grid beside an integral gain; without one its state is not there either."""
    if ki == 0.0:
        return stable(pd_loop(plant), GRID[:, None], GRID[None, :], sigma=SIGMA)
    return stable(pid_loop(plant), GRID[:, None], np.array(ki), GRID[None, :], sigma=SIGMA)


def poles(loop: LoopPolynomial, gains: np.ndarray) -> np.ndarray:
    """Poles `(g, n)` at gain pairs `(g, 2)`."""
    return np.array([loop.poles(*pair) for pair in gains])


def region(folder: Path) -> None:
    """Eq. 4.11, Figs. 4.3 and 4.4: the region of stable gains and the spread of the poles."""
    right, printed = corrected(), as_printed()
    row(
        "sign of the gain of eq. 4.11 (a command turns the axis the other way, eq. 4.2)",
        "+",
        "-" if right.num[0] < 0.0 else "+",
    )
    row("stable pairs of 10201 at sigma = -0.5, listing A.4 as printed", "", f"{count(printed)}")
    row("… corrected", "", f"{count(right)}")
    row("… corrected, with Table 3.1's L = 0.0641 H", "", f"{count(corrected(0.0641))}")
    row("pole that no gain moves: momentum I psi' + b2 psi + J Omega", "", ", ".join(f"{p:g}" for p in right.hidden))
    loop = pd_loop(right)
    for pair in ((40.0, 10.0), (100.0, 10.0)):
        slowest = loop.poles(*pair)[np.argmax(loop.poles(*pair).real)]
        zeta = -slowest.real / abs(slowest)
        row(f"slowest pole at {pair} [1/s], damping ratio", "inside", f"{slowest:.2f}, {zeta:.2f}")
    damped = stable(loop, GRID[:, None], GRID[None, :], sigma=SIGMA, damping=0.4)
    row("pairs with a damping ratio of 0.4 besides", "", f"{int(damped.sum())}")
    slices = [with_integral(right, ki) for ki in INTEGRALS]
    row(
        f"stable pairs with K_i = {', '.join(f'{k:g}' for k in INTEGRALS)}",
        "",
        ", ".join(str(int(s.sum())) for s in slices),
    )
    save(_regions(right, printed), folder, "fig_4_3")
    save(_spread(loop), folder, "fig_4_4")
    save(_slices(slices), folder, "pid_slices")


def _regions(right: Transfer, printed: Transfer) -> plt.Figure:
    figure, axes = plt.subplots(1, 2, figsize=(9, 4), sharey=True, layout="constrained")
    omega = np.geomspace(0.01, 100.0, 2000)
    for ax, plant, title in zip(axes, (printed, right), ("as printed", "corrected"), strict=True):
        found = stable(pd_loop(plant), GRID[:, None], GRID[None, :], sigma=SIGMA)
        ax.pcolormesh(GRID, GRID, np.where(found.T, 1.0, np.nan), cmap="Blues", vmin=0.0, vmax=2.5, rasterized=True)
        ax.plot(*boundary(plant, omega, SIGMA), color="tab:blue", label=f"a pair at −{SIGMA:g} ± jω")
        ax.plot(real_boundary(plant, GRID, SIGMA), GRID, color="tab:red", label=f"a real pole at −{SIGMA:g}")
        ax.plot([40.0, 100.0], [10.0, 10.0], "k.", label="tested: (40, 10), (100, 10)")
        ax.set(xlim=(0, 102), ylim=(0, 100), xlabel="K$_p$ [V/rad]", title=f"{title}: {int(found.sum())} of 10201")
    axes[0].set_ylabel("K$_d$ [V s/rad]")
    axes[0].legend(frameon=False, fontsize=8, loc="upper right")
    figure.suptitle("Fig. 4.3: gains with every pole left of −0.5 1/s")
    return figure


def _spread(loop: LoopPolynomial) -> plt.Figure:
    figure, ax = plt.subplots(figsize=(6.5, 5), layout="constrained")
    chosen = np.stack(np.meshgrid(GRID[::2], GRID[::2], indexing="ij"), -1).reshape(-1, 2)
    found = chosen[stable(loop, chosen[:, 0], chosen[:, 1], sigma=SIGMA)]
    at = poles(loop, found)
    shown = ax.scatter(at.real.ravel(), at.imag.ravel(), s=2, c=np.repeat(found[:, 1], at.shape[1]), cmap="viridis")
    figure.colorbar(shown, label="K$_d$ [V s/rad]")
    for zeta in DAMPINGS:
        ax.plot([0.0, -100.0 * zeta], [0.0, 100.0 * np.sqrt(1.0 - zeta**2)], color="#999999", lw=0.7)
        ax.plot([0.0, -100.0 * zeta], [0.0, -100.0 * np.sqrt(1.0 - zeta**2)], color="#999999", lw=0.7)
        far = min(21.0 / np.sqrt(1.0 - zeta**2), 11.0 / zeta)
        ax.text(-far * zeta, far * np.sqrt(1.0 - zeta**2), f"ζ {zeta:g}", fontsize=7, color="#666666")
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 200)
    for omega in RATES:
        ax.plot(omega * np.cos(turn), omega * np.sin(turn), color="#999999", lw=0.7, ls=":")
        ax.text(0.1, omega, f"{omega:g} rad/s", fontsize=7, color="#666666")
    ax.axvline(-SIGMA, color="tab:red", lw=1)
    ax.set(xlim=(-12, 1.5), ylim=(-22, 22), xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
    ax.set_title("Fig. 4.4: poles of every stable pair of the region")
    return figure


def _slices(slices: list[np.ndarray]) -> plt.Figure:
    figure, axes = plt.subplots(1, len(slices), figsize=(12, 3.4), sharey=True, layout="constrained")
    for ax, ki, found in zip(axes, INTEGRALS, slices, strict=True):
        ax.pcolormesh(GRID, GRID, np.where(found.T, 1.0, np.nan), cmap="Blues", vmin=0.0, vmax=2.5, rasterized=True)
        ax.set(xlabel="K$_p$ [V/rad]", title=f"K$_i$ = {ki:g}: {int(found.sum())} of 10201")
    axes[0].set_ylabel("K$_d$ [V s/rad]")
    figure.suptitle("Slices of the PID region: every pole left of −0.5 1/s")
    return figure
