"""Figures of the pages on concepts, drawn at build from the library itself.

``python docs/figures.py FOLDER`` writes them; the site's build does so in drawn/.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import hefting
from hefting.core.files import write_atomically
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.moments import Moments
from hefting.core.regressor import dynamism, features
from hefting.plots.style import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    SKY,
    VERMILION,
    picture_of,
    style,
)
from hefting.simulation import UR5, hammer, simulate, sinusoids, wield
from hefting.simulation.demo import POSE, SEED
from hefting.simulation.wield import POSE_NOISE

KEPT = Path(__file__).resolve().parents[1] / "benchmarks" / "against.json"
"""What `benchmarks.against` measured."""
NAMES = ("m", "m cx", "m cy", "m cz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")


def exact(speed: float = 1.0) -> Measurements:
    """Ten seconds of the demo's hammer at a mean angular speed [rad/s], without
    noise."""
    body = hammer().parameters.moved(POSE)
    return wield(UR5.motion(sinusoids(10.0, 100.0, speed)), body)


def noisy() -> hefting.Recording:
    """The demo's recording."""
    motion, body = UR5.motion(sinusoids(10.0, 100.0, 1.0)), hammer().parameters
    return simulate(
        motion,
        body.moved(POSE),
        noise=NOISE_LEVELS["moderate"],
        pose_noise=POSE_NOISE,
        seed=SEED,
    )


def shape() -> hefting.Shape:
    """The hammer's points in the sensor frame."""
    return hefting.Shape.from_mesh(hammer().mesh(), pose=POSE)


def model() -> Figure:
    """A body at a sensor: what is known, measured and wanted."""
    figure = Figure(figsize=(5.2, 2.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_axis_off()
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    radius = 1.0 + 0.18 * np.cos(3 * angle + 0.6) + 0.08 * np.sin(5 * angle)
    axes.fill(
        2.6 + 1.5 * radius * np.cos(angle),
        0.5 + 0.9 * radius * np.sin(angle),
        color="#E8EEF4",
        edgecolor=INK,
        linewidth=0.8,
    )
    arrow = {"arrowstyle": "-|>", "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}

    def draw(
        start: tuple[float, float],
        by: tuple[float, float],
        colour: str,
        text: str,
        at: tuple[float, float],
    ) -> None:
        end = (start[0] + by[0], start[1] + by[1])
        axes.annotate("", end, start, arrowprops=arrow | {"color": colour})
        axes.text(*at, text, color=colour)

    draw((0, 0), (0.55, 0.0), INK, "x", (0.6, -0.12))
    draw((0, 0), (0.0, 0.55), INK, "z", (-0.12, 0.62))
    draw((0, 0), (-0.75, 0.85), BLUE, "force f", (-1.15, 0.95))
    draw((2.7, 0.45), (0.0, -1.1), VERMILION, "m g", (2.78, -0.75))
    draw((0, 0), (2.7, 0.45), GREEN, "COM c", (1.15, 0.42))
    axes.plot(0, 0, "o", color=INK, markersize=5)
    axes.plot(2.7, 0.45, "P", color=VERMILION, markersize=7)
    turn = np.linspace(0.6, 5.3, 60)
    axes.plot(0.42 * np.cos(turn), 0.42 * np.sin(turn), color=SKY, linewidth=1.4)
    axes.text(-1.05, -0.42, "torque τ", color=SKY)
    axes.text(-1.3, -0.95, "sensor: f and τ measured, about its origin", color=INK)
    axes.text(2.95, 0.75, "mass m, inertia J", color=INK)
    axes.set_xlim(-1.5, 4.6)
    axes.set_ylim(-1.1, 1.7)
    return figure


def dynamism_figure() -> Figure:
    """Dynamism over time, and the weight of the full model by c1."""
    figure = Figure(figsize=(6.4, 2.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for speed, colour in ((0.5, SKY), (1.0, BLUE), (2.0, VERMILION)):
        z = exact(speed)
        left.plot(z.time, dynamism(z), color=colour, label=f"{speed:g} rad/s")
    left.set_yscale("log")
    left.set_xlabel("time [s]")
    left.set_ylabel("dynamism ν")
    left.set_ylim(0.1, 400.0)
    left.legend(ncols=3, loc="upper center")
    nu = np.geomspace(0.05, 1e4, 300)
    for c1, colour in ((1.0, GREEN), (300.0, ORANGE), (5e3, INK)):
        right.plot(nu, np.tanh(3.0 * nu / c1), color=colour, label=f"c1 = {c1:g}")
    right.set_xscale("log")
    right.set_xlabel("dynamism ν")
    right.set_ylabel("weight w of the full model")
    right.legend()
    return figure


def points_figure() -> Figure:
    """The hammer's points, their masses by PMD, the cross its COM."""
    held = shape()
    found = hefting.identify(noisy(), held, method="PMD").estimate
    masses = found.point_masses
    assert masses is not None
    truth = hammer().parameters.moved(POSE).center_of_mass
    figure = Figure(figsize=(6.4, 2.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    where = 1e3 * held.positions[:, [1, 0]]
    left.scatter(*where.T, s=14, color=SKY)
    left.set_title(f"{held.n} points that fill the shape")
    right.scatter(*where.T, s=4e3 * masses, color=BLUE, alpha=0.5)
    right.plot(1e3 * truth[1], 1e3 * truth[0], "P", color=VERMILION, markersize=7)
    right.set_title("their masses by PMD (area), true COM (cross)")
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.margins(0.12)
        axes.set_xlabel("y [mm]")
    left.set_ylabel("x [mm]")
    return figure


def samples_figure() -> Figure:
    """1,000 samples, and the 22 with the same sums."""
    z = hefting.identify(noisy(), method="OLS").measurements
    x = features(z)
    scale = np.sqrt(np.mean(np.square(x), axis=0))
    scale[scale == 0.0] = 1.0
    factor = np.asarray(Moments.of(z).factor) / scale  # the signs of rows do not matter
    figure = Figure(figsize=(6.4, 2.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.0))
    shown: dict[str, Any] = {"cmap": "RdBu", "aspect": "auto", "interpolation": "none"}
    left.imshow(x[::8] / scale, vmin=-2.5, vmax=2.5, extent=(0, 22, 1000, 0), **shown)
    left.set_title("1,000 samples of 22 features")
    left.set_ylabel("sample")
    faint = np.cbrt(factor / np.abs(factor).max())
    right.imshow(faint, vmin=-1.0, vmax=1.0, extent=(0, 22, 22, 0), **shown)
    right.set_title("22 virtual samples: one triangular factor")
    right.set_ylabel("virtual sample")
    for axes in (left, right):
        axes.set_xlabel("feature")
        axes.set_xticks(range(0, 23, 2))
        axes.spines[:].set_visible(False)
    return figure


def identifiability_figure() -> Figure:
    """Standard deviations of least squares for four motions; beyond the top, not
    determined."""
    noise = NOISE_LEVELS["moderate"]
    still = exact(0.0001)[:1]
    moving = exact()
    rests = rested(moving)
    cases = {
        "one pose": (still, INK),
        "two poses": (rests[[0, 700]], ORANGE),
        "twelve poses": (rests[::84], SKY),
        "ten seconds of motion": (moving, BLUE),
    }
    figure = Figure(figsize=(6.4, 2.3), layout="constrained")
    axes = figure.add_subplot()
    for k, (name, (z, colour)) in enumerate(cases.items()):
        ols = hefting.OLS(noise=noise, intervals=False)
        covariance = ols.fit(z).covariance
        assert covariance is not None
        std = np.sqrt(covariance.diagonal())
        place = np.arange(10) + 0.18 * (k - 1.5)
        known = np.isfinite(std)
        axes.plot(place[known], std[known], "o", color=colour, label=name, markersize=4)
        axes.plot(
            place[~known],
            np.full((~known).sum(), 3.0),
            "x",
            color=colour,
            markersize=4,
        )
    axes.set_yscale("log")
    axes.set_ylim(top=8.0)
    axes.set_xticks(range(10), NAMES)
    axes.set_ylabel("standard deviation\n(kg, kg m, kg m²)")
    axes.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.2))
    return figure


def bayes_figure() -> Figure:
    """95 % intervals of Jzz over time: least squares, Bayes without and with the
    shape."""
    z = hefting.identify(noisy()).measurements
    truth = 1e3 * hammer().parameters.moved(POSE).inertia_at_com[2, 2]
    figure = Figure(figsize=(6.4, 2.2), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    for each, name, method in (
        (axes[0], "OLS", hefting.OLS()),
        (axes[1], "Bayes, no shape", hefting.Bayes()),
        (axes[2], "Bayes with the shape", hefting.Bayes(shape())),
    ):
        ends = [
            (t, *_jzz(method, z, t)) for t in (0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
        ]
        t, low, high = np.array(ends).T
        each.fill_between(t, 1e3 * low, 1e3 * high, color=SKY, alpha=0.5, linewidth=0)
        each.axhline(truth, color=VERMILION, linewidth=1.0)
        each.set_ylim(0.0, 8.0)
        each.set_title(name)
        each.set_xlabel("seconds used")
    axes[0].set_ylabel("Jzz at COM [g m²]")
    return figure


def _jzz(method: Any, z: Measurements, seconds: float) -> tuple[float, float]:
    """Interval of Jzz from the first seconds."""
    used = z[: int(np.searchsorted(z.time, z.time[0] + seconds))]
    intervals = method.fit(used).intervals
    assert intervals is not None
    low, high = intervals["inertia_at_com"][:, 2, 2]
    return float(low), float(high)


def rested(z: Measurements) -> Measurements:
    """The same poses at rest, with the wrench of the hammer there."""
    zero = np.zeros_like(z.gravity)
    force, torque = held_at_rest(z)
    return Measurements(z.time, z.gravity, zero, zero, zero, force, torque)


def held_at_rest(z: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque of the hammer in each pose."""
    body = hammer().parameters.moved(POSE)
    force = -body.mass * np.asarray(z.gravity)
    return force, np.cross(body.center_of_mass, force)


def peers_figure() -> Figure:
    """Cost beside that of peers, as it was measured last."""
    sys.path.append(str(KEPT.parents[1]))
    from benchmarks.against.figure import cost_figure

    return cost_figure(json.loads(KEPT.read_text())["cost"])


FIGURES: dict[str, Callable[[], Figure]] = {
    "model": model,
    "dynamism": dynamism_figure,
    "points": points_figure,
    "samples": samples_figure,
    "identifiability": identifiability_figure,
    "bayes": bayes_figure,
    "peers": peers_figure,
}
"""Every figure by the name of its file."""


def write(folder: Path) -> None:
    """Write those that are older than this file, or than what was measured."""
    folder.mkdir(parents=True, exist_ok=True)
    changed = max(path.stat().st_mtime for path in (Path(__file__), KEPT))
    for name, draw in FIGURES.items():
        path = folder / f"{name}.svg"
        if path.exists() and path.stat().st_mtime > changed:
            continue
        with style():
            write_atomically(path, picture_of(draw(), ".svg"))


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "figures"))
