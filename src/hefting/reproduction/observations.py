"""After 150 observations: four methods, three speeds, motion by a Kalman filter."""

from collections.abc import Iterable, Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.estimators import GEO
from hefting.plots.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from hefting.reproduction.experiment import (
    DURATION,
    MOSTLY_WRONG,
    OBJECTS,
    QUANTITIES,
    Cell,
    Experiment,
    Job,
    Method,
    Report,
    Result,
    Results,
    Table,
    errors_figure,
    over_limit,
    pmd,
    printed,
    speeds_of,
    thing,
    wielded,
)
from hefting.reproduction.experiment import METHODS as PAPERS
from hefting.reproduction.filtered import (
    OBSERVATIONS,
    SCORES,
    Observed,
    begun_with,
    causal_filter,
    doubled,
    motions,
    noise_found,
    score,
    weak_geo,
    windows,
)
from hefting.simulation import WRENCH_NOISE, Wielding
from hefting.simulation.wield import POSE_NOISE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ANGULAR = (1.0, 1.5, 2.0)
"""Average angular speeds [rad/s]."""
PUBLISHED: dict[str, tuple[tuple[float, ...], ...]] = {
    "OLS": ((1.36, 2.88, 3.22), (34.4, 44.0, 36.1), (MOSTLY_WRONG,) * 3),
    "RTLS": ((1.84, 1.77, 2.41), (97.5, 37.7, 38.2), (MOSTLY_WRONG,) * 3),
    "GEO": ((1.45, 2.65, 4.09), (33.0, 33.1, 32.6), (MOSTLY_WRONG, 252.0, 109.0)),
    "PMD": ((1.34, 2.15, 1.91), (9.83, 15.5, 16.4), (44.1, 43.5, 43.6)),
}
"""Errors [%] of mass, COM, inertia at these speeds; 500 where the paper has "> 500"."""
LABELS = tuple(QUANTITIES.values())
FIRST, SHARP = "cold, first 1.5 s", "cold, first 1.5 s, sharper poses"
KINDS = ("warm", "cold", "smoother", FIRST, SHARP)
"""Kinds of motion: windows of it by the paper's filter and this project's smoother, and
its first 1.5 s."""
COMPARED = ("warm", "cold", FIRST, SHARP)
"""Kinds by the paper's filter, which are compared with the published figures."""
ALIKE = 2.0
"""Largest factor between a figure and the published one that it reproduces."""
GEOS = ("GEO, weak", "GEO, literature", "GEO, noise found")
MAIN = ("OLS", "RTLS", *GEOS, "PMD")
TOPS = (20.0, 500.0, 5e3)
"""Upper ends of the figure's panels [%], where larger values are drawn."""
DRAWN = {"published": (BLACK, "x"), "warm": (BLUE, "o"), "cold": (ORANGE, "^")}
DRAWN |= {FIRST: (VERMILION, "s"), SHARP: (PURPLE, "v"), "smoother": (GREEN, "d")}

Scores = dict[tuple[str, str, float], Array]
"""By kind of motion, method and speed: (windows of all objects, `SCORES`)."""

STARTS = 10
"""Number of starts of the motion, each with other noise."""
SHARPER = 0.1
"""Factor of the pose noise: in a simulator poses are exact."""
QUICK = ("tee", "half-n-half")
NOTE = (
    f"Poses have {1e3 * POSE_NOISE[0]:.2g} mm and {np.degrees(POSE_NOISE[1]):.2g}° of noise per axis; the filters' "
    "bandwidth is the most likely one for each motion. Errors of the inertia are about the sensor's origin; the "
    "table of everything has those about the COM beside. In the figure what the paper gives as over 500 stands at "
    "500, and what is above a panel at its upper edge."
)
"""Conventions of tables and figure; ``docs/reproduction.md`` discusses them."""


METHODS: dict[str, Method] = {
    "OLS": PAPERS["OLS"],
    "RTLS": PAPERS["RTLS"],
    "GEO, weak": weak_geo,
    "GEO, literature": PAPERS["GEO"],
    "GEO, noise found": noise_found,
    "PMD": PAPERS["PMD"],
    "PMD, c1 = 3": pmd(3.0),
    "PMD, c1 = 30": pmd(30.0),
    "PMD, c1 = 5e3": pmd(5e3),
    "GEO, wrench noise known": lambda thing, z: GEO(
        thing.shape, noise=NOISE_LEVELS["moderate"], intervals=False
    ),
    "GEO, prior moved twice": doubled,
}
"""Methods, the main table's first; the literature's weight of GEO is 1e-5 tr(A'A)."""


def jobs(quick: bool) -> list[Job]:
    """A job for each object and speed."""
    objects, duration, starts = (
        (QUICK, 6.0, 2) if quick else (OBJECTS, DURATION, STARTS)
    )
    return [
        {
            "object": name,
            "speed": speed,
            "duration": duration,
            "starts": starts,
            "seed": 1,
        }
        for speed in ANGULAR
        for name in objects
    ]


def run(job: Job) -> Result:
    """Scores (windows, 5) of each method, and root mean squares of accelerations and
    their errors, by kind of motion."""
    subject = thing(job["object"])
    exact = wielded(job["object"], job["speed"], duration=job["duration"])
    kinds = {}
    for kind, each in _motions(job, exact):
        scores: dict[str, list] = {name: [] for name in METHODS}
        accelerations = []
        for window, z in each:
            for name, method in METHODS.items():
                scores[name].append(score(subject, method(subject, z), z))
            true = exact.measurements[window]
            a, alpha = true.linear_acceleration, true.angular_acceleration
            wrong = z.linear_acceleration - a, z.angular_acceleration - alpha
            accelerations.append((a, alpha, *wrong))
        rms = [
            float(np.sqrt(np.mean(np.square(part))))
            for part in zip(*accelerations, strict=True)
        ]
        kinds[kind] = {"scores": scores, "accelerations": rms}
    return {"kinds": kinds}


def _motions(
    job: Job, exact: Wielding
) -> Iterator[tuple[str, Iterator[tuple[slice, Measurements]]]]:
    seed = (job["seed"], OBJECTS.index(job["object"]), round(10 * job["speed"]))
    observed = Observed.of(exact, WRENCH_NOISE["moderate"], seed)
    places = windows(job["duration"])
    for kind, each in motions(observed).items():
        yield kind, zip(places, each, strict=True)
    for kind, share in ((FIRST, 1.0), (SHARP, SHARPER)):
        yield kind, _first(exact, seed, job["starts"], share)


def _first(
    exact: Wielding, seed: tuple[int, ...], count: int, share: float
) -> Iterator[tuple[slice, Measurements]]:
    """The motion's first window by a filter that starts with it, `count` times with other
    noise; `share` is the factor of the pose noise."""
    window, live = slice(0, OBSERVATIONS), None
    for k in range(count):
        noise = share * POSE_NOISE[0], share * POSE_NOISE[1]
        observed = Observed.of(exact, WRENCH_NOISE["moderate"], (*seed, k), noise)
        live = live or causal_filter(observed)
        yield window, begun_with(observed[window], live)


def report(results: Results) -> Report:
    """Tables and figure."""
    scores = pooled(results)
    speeds = speeds_of(results)
    figures = {"observations": figure(scores, speeds)}
    return Report(tables(results, scores, speeds), figures, (NOTE,))


def tables(results: Results, scores: Scores, speeds: list[float]) -> tuple[Table, ...]:
    """Published and own errors, settings, differences, errors of motion, results."""
    others = [name for name in METHODS if name not in MAIN]
    columns = (
        "motion",
        "method",
        *(f"{q} %, {s:g} rad/s" for q in LABELS for s in speeds),
        "consistent %",
    )
    windows, starts = (len(scores[kind, "PMD", speeds[0]]) for kind in ("warm", FIRST))
    objects = len({job["object"] for job, _ in results})
    return (
        Table(
            "observations",
            f"Mean errors after {OBSERVATIONS} observations: {objects} objects, each {windows // objects} windows or "
            f"{starts // objects} starts",
            columns,
            (*_published_rows(speeds), *_rows(scores, MAIN, speeds)),
        ),
        Table(
            "settings",
            "The same with other hyperparameters",
            columns,
            _rows(scores, ("PMD", *others), speeds),
        ),
        differences(scores, speeds),
        _motion(results, speeds),
        _everything(scores),
    )


def pooled(results: Results) -> Scores:
    """Scores of all windows of all objects."""
    scores: dict[tuple[str, str, float], list] = {}
    for job, result in results:
        for kind, part in result["kinds"].items():
            for method, values in part["scores"].items():
                scores.setdefault((kind, method, job["speed"]), []).extend(values)
    return {key: np.array(values) for key, values in scores.items()}


def _published_rows(speeds: list[float]) -> list[tuple[Cell, ...]]:
    """The published errors of each method at some of the angular speeds `ANGULAR`, and
    the share of its estimates that are consistent, in words or [%]."""
    share = {"OLS": "few", "RTLS": "few", "GEO": 100.0, "PMD": 100.0}
    return [
        (
            "published",
            name,
            *(printed(each[ANGULAR.index(s)]) for each in errors for s in speeds),
            share[name],
        )
        for name, errors in PUBLISHED.items()
    ]


def _rows(
    scores: Scores, methods: Iterable[str], speeds: list[float]
) -> list[tuple[Cell, ...]]:
    rows = []
    for kind, method in product(KINDS, methods):
        means = [
            printed(error(scores, kind, method, s, i))
            for i in range(len(LABELS))
            for s in speeds
        ]
        # share of windows whose estimate is a possible body
        shares = [scores[kind, method, s][:, -1].mean() for s in speeds]
        rows.append((kind, method, *means, 100.0 * float(np.mean(shares))))
    return rows


def error(scores: Scores, kind: str, method: str, speed: float, quantity: int) -> float:
    """Mean error [%] over windows; `quantity` is an index in `LABELS`."""
    return float(scores[kind, method, speed][:, quantity].mean())


def differences(scores: Scores, speeds: list[float]) -> Table:
    """Published figures, own ones over them, and kinds of motion within `ALIKE`."""
    rows = []
    for name, errors in PUBLISHED.items():
        for method in GEOS[:2] if name == "GEO" else (name,):
            for quantity, label in enumerate(LABELS):
                for s in speeds:
                    theirs = errors[quantity][ANGULAR.index(s)]
                    ratios = [
                        error(scores, kind, method, s, quantity) / theirs
                        for kind in COMPARED
                    ]
                    pairs = zip(COMPARED, ratios, strict=True)
                    like = "; ".join(k for k, r in pairs if _is_alike(r, theirs))
                    rows.append(
                        (method, label, s, printed(theirs), *ratios, like or "none")
                    )
    columns = (
        "method",
        "error",
        "rad/s",
        "published %",
        *(f"{kind} / published" for kind in COMPARED),
        "within a factor of 2",
    )
    title = "Published figures, and how far ours are from them"
    return Table("differences", title, columns, rows)


def _is_alike(ratio: float, theirs: float) -> bool:
    return ratio >= 1.0 / ALIKE and (ratio <= ALIKE or theirs >= MOSTLY_WRONG)


def _motion(results: Results, speeds: list[float]) -> Table:
    rows = []
    for kind, s in product(KINDS, speeds):
        parts = [result["kinds"][kind] for job, result in results if job["speed"] == s]
        means = np.mean([part["accelerations"] for part in parts], axis=0)
        rows.append((kind, s, *map(float, means[[0, 2, 1, 3]])))
    title = "Accelerations and their errors: root mean square, per axis"
    linear, angular = ("a m/s²", "its error m/s²"), ("alpha rad/s²", "its error rad/s²")
    return Table("motion", title, ("motion", "rad/s", *linear, *angular), rows)


def _everything(scores: Scores) -> Table:
    rows = []
    for (kind, method, speed), values in scores.items():
        middle = np.median(values[:, :4], axis=0)
        means, share = values[:, :4].mean(axis=0), 100.0 * values[:, -1].mean()
        numbers = map(float, (*means, *middle, share))
        rows.append((kind, method, speed, len(values), *numbers))
    names = [name.replace("_", " ") for name in SCORES[:4]]
    columns = (
        "motion",
        "method",
        "rad/s",
        "windows",
        *(f"mean {n} %" for n in names),
        *(f"median {n} %" for n in names),
        "consistent %",
    )
    return Table("all", "All methods: means and medians", columns, rows)


def figure(scores: Scores, speeds: list[float]):
    """A panel per error with a group per method, and in it a line per kind of motion."""
    methods = ("OLS", "RTLS", *GEOS[:2], "PMD")

    def draw(axes: "Axes", quantity: int) -> None:
        for (i, method), (j, (kind, (colour, marker))) in product(
            enumerate(methods), enumerate(DRAWN.items())
        ):
            if kind == "published":
                row = PUBLISHED[method.split(",")[0]][quantity]
                values = [row[ANGULAR.index(s)] for s in speeds]
            else:
                values = [error(scores, kind, method, s, quantity) for s in speeds]
            axes.plot(
                i + 0.14 * (j - 2.5) + 0.04 * (np.arange(len(speeds)) - 1),
                np.minimum(values, TOPS[quantity]),
                marker=marker,
                color=colour,
                linewidth=0.7,
                markersize=2.8,
                label=kind if i == 0 else None,
                clip_on=False,
            )

    listed = ", ".join(f"{s:g}" + " (> ISO)" * over_limit(s) for s in speeds)
    below = f"within a group, left to right: {listed} rad/s; > ISO: above {SPEED_LIMIT} m/s (ISO 10218-1)"
    return errors_figure(2.9, methods, TOPS, draw, below)


EXPERIMENT = Experiment(
    "observations",
    "After 150 observations",
    "Table on a limited number of observations (about 150)",
    jobs,
    run,
    report,
)
