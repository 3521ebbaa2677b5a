"""Point density: accuracy and compute time of PMD; with `c1` the paper's 328 runs."""

import time
from collections.abc import Callable
from functools import cache
from itertools import product

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import NOISE_LEVELS
from hefting.estimators import PMD
from hefting.plots.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, drawing
from hefting.reproduction.c1 import VALUES
from hefting.reproduction.experiment import (
    C1,
    OBJECTS,
    RATE,
    SPEEDS,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    Thing,
    legend_above,
    marked,
    thing,
    wielded,
)
from hefting.shapes import Shape
from hefting.simulation import paper_points

DENSITIES = (0.01, 0.02, 0.04, 0.09, 0.2, 0.5)
"""points/cm³"""
COMPARED = (0.04, 0.09)
"""Densities of which the paper states that the second is no better for the COM."""
SPEED = 1.5
"""Average angular speed [rad/s]: the fastest of the paper's within ISO 10218-1."""
TIMES = (1.5, 35.0)
"""Times of the estimates [s]."""
SEEDS = 10
"""Number of noise seeds for each object."""
LAMBDA, USUAL = 0.1, 56
"""PMD's regularization in the paper, and its number of points there."""
SERIES = {
    "noise-free": ("none", False),
    "moderate": ("moderate", False),
    "moderate, lambda kept": ("moderate", True),
}
"""Noise level, and whether lambda grows as the root of the number of points, which keeps
lambda |m| of equal masses constant."""
COUNTS = (150, 500, 1000, 2000, 3500)
"""Numbers of observations for which time is measured."""
REPEATS = 15
"""Number of measurements, the shortest of which counts."""
NAMES = {
    "mass": "mass %",
    "center_of_mass": "COM %",
    "across": "COM along z %",
    "inertia_at_origin": "inertia about the sensor %",
    "inertia_at_com": "inertia about the COM %",
}
"""Quantities and their columns; z is the direction of the plate's thickness."""
ACCURACY = ("noise", "points/cm³", "points", "layers", "observations")
CLAIM = (
    "noise", "error", "observations", "at 0.04 %", "at 0.09 %", "difference", "standard error", "objects", "verdict",
)  # fmt: skip
"""Columns of the tables of errors and of the claim."""
CONFIDENCE = 0.975
"""Quantile of Student's t above which a difference is significant."""


def jobs(quick: bool) -> list[Job]:
    """A job for each object, and one for the compute time of each density."""
    objects = ("hammer", "half-n-half", "rod") if quick else OBJECTS
    densities = (0.01, *COMPARED) if quick else DENSITIES
    every = {"densities": list(densities), "seeds": 2 if quick else SEEDS}
    accuracy = [{"kind": "accuracy", "object": name, **every} for name in objects]
    timed = {"kind": "time", "object": objects[0]}
    return [*accuracy, *(timed | {"density": d, "seed": 0} for d in densities)]


def run(job: Job) -> Result:
    """Mean errors over the seeds (times, densities) by series and quantity; or compute
    times (counts,) [s]."""
    return _timed(job) if job["kind"] == "time" else _accuracy(job)


@cache
def points(density: float) -> Shape:
    """The grid of a density [points/cm³], in the sensor frame, for all eight objects,
    which have one shape."""
    return paper_points(thing("uniform").held, density)


def _accuracy(job: Job) -> Result:
    subject, exact = thing(job["object"]), wielded(job["object"], SPEED).measurements
    shapes = [points(density) for density in job["densities"]]
    errors = {}
    for series, (level, kept) in SERIES.items():
        seeds = 1 if level == "none" else job["seeds"]
        methods = [
            PMD(
                s,
                c1=C1,
                regularization=LAMBDA * (np.sqrt(s.n / USUAL) if kept else 1.0),
                intervals=False,
            )
            for s in shapes
        ]
        sums = {name: np.zeros((len(TIMES), len(shapes))) for name in NAMES}
        for seed in range(seeds):
            z = exact.with_noise(
                NOISE_LEVELS[level], (seed, OBJECTS.index(job["object"]))
            )
            state, begin = methods[0].start(), 0
            for i, end in enumerate(round(t * RATE) for t in TIMES):
                # the state does not depend on the points
                state, begin = methods[0].update(state, z[begin:end]), end
                for j, method in enumerate(methods):
                    for name, value in _errors(subject, method.estimate(state)).items():
                        sums[name][i, j] += value / seeds
        errors[series] = {name: values.tolist() for name, values in sums.items()}
    return {"errors": errors}


def _errors(subject: Thing, estimate: Estimate) -> dict[str, float]:
    axis, found = subject.held.pose[:3, 2], subject.errors(estimate)
    wrong = estimate.parameters.center_of_mass - subject.held.parameters.center_of_mass
    across = 100.0 * abs(float(axis @ wrong)) / float(subject.held.extents[2])
    return {
        name: across if name == "across" else getattr(found, name) for name in NAMES
    }


def _timed(job: Job) -> Result:
    z = wielded(job["object"], SPEED).measurements.with_noise(
        NOISE_LEVELS["moderate"], job["seed"]
    )
    method = PMD(points(job["density"]), c1=C1, intervals=False)
    method.fit(z[:10])  # computes what is kept for a shape
    solve, whole = [], []
    for count in COUNTS:
        some = z[:count]
        state = method.update(method.start(), some)
        solve.append(_seconds(lambda: method.estimate(state)))  # noqa: B023
        whole.append(_seconds(lambda: method.fit(some)))  # noqa: B023
    grid = {"points": method.shape.n, "layers": layers(method.shape)}
    return grid | {"solve": solve, "whole": whole}


def _seconds(work: Callable[[], object]) -> float:
    taken = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


def report(results: Results) -> Report:
    """Errors by density, the claim about the two densities, and the compute times."""
    done = [(job, result) for job, result in results if job["kind"] == "accuracy"]
    timed = [(job, result) for job, result in results if job["kind"] == "time"]
    densities, seeds = done[0][0]["densities"], done[0][0]["seeds"]
    found = {  # (objects, times, densities) by series and quantity
        series: {
            name: np.array([result["errors"][series][name] for _, result in done])
            for name in NAMES
        }
        for series in SERIES
    }
    grids = {
        job["density"]: (result["points"], result["layers"]) for job, result in timed
    }
    accuracy = []
    for series, errors in found.items():
        for (i, t), (j, d) in product(enumerate(TIMES), enumerate(densities)):
            means = (float(e[:, i, j].mean()) for e in errors.values())
            accuracy.append((series, d, *grids[d], round(t * RATE), *means))
    claims = _claims(found, densities)
    title = f"Mean errors of PMD, {SPEED:g} rad/s: {len(done)} objects, {seeds} noise seeds each"
    tables = (
        Table("accuracy", title, (*ACCURACY, *NAMES.values()), accuracy),
        Table(
            "claim",
            "0.09 points/cm³ against 0.04, paired over the objects",
            CLAIM,
            claims,
        ),
        _times_table(timed),
    )
    figures = {
        "accuracy": accuracy_figure(densities, found),
        "times": times_figure(timed),
    }
    return Report(tables, figures, _notes(claims))


def _claims(
    found: dict[str, dict[str, np.ndarray]], densities: list[float]
) -> list[tuple]:
    """Rows on the `COMPARED` densities, from errors (objects, times, densities) by series
    and quantity."""
    columns = [densities.index(d) for d in COMPARED]
    return [
        (
            series,
            *claim(
                NAMES[name],
                round(t * RATE),
                *(found[series][name][:, i, j] for j in columns),
            ),
        )
        for name in ("center_of_mass", "inertia_at_origin")
        for series in SERIES
        for i, t in enumerate(TIMES)
    ]


def _times_table(timed: list[tuple[Job, Result]]) -> Table:
    first = timed[0][1]["whole"][0]
    rows = [
        (result["points"], count, 1e3 * solve, 1e3 * whole, whole / first)
        for _, result in timed
        for count, solve, whole in zip(
            COUNTS, result["solve"], result["whole"], strict=True
        )
    ]
    columns = (
        "points",
        "observations",
        "estimate from moments ms",
        "fold and estimate ms",
        "relative to the first",
    )
    title = "Compute time of one process (quickest of several; the only table that differs between runs)"
    return Table("times", title, columns, rows)


def layers(shape: Shape) -> int:
    """Number of layers of points through the thickness of the plate."""
    return len(np.unique(shape.positions[:, 2].round(6)))


def _notes(claims: list[tuple]) -> tuple[str, ...]:
    com = [row for row in claims if row[1] == NAMES["center_of_mass"]]
    com = [row for row in com if row[0] != "moderate, lambda kept"]
    better = any(row[-1] == "better" for row in com)
    holds = "does NOT hold everywhere" if better else "holds"
    settings = len(OBJECTS) * (len(DENSITIES) + len(SPEEDS) * len(VALUES))
    return (
        "The paper gives no numbers for this figure, nor its speed, noise or duration: assumed are "
        f"{SPEED:g} rad/s, c1 = {C1:g}, and none or the moderate noise of its table II on accelerations and wrench. "
        f"With experiment `c1` there are {settings} settings, as in the paper, each with several noise seeds.",
        f"Published: the COM at 0.09 points/cm³ is not significantly better than at 0.04. It {holds}: "
        + "; ".join(
            f"{row[0]}, {row[2]} observations: {row[5]:+.2g} percentage points, {row[-1]}"
            for row in com
        )
        + ". An object's seeds are averaged first, as its grid is the same in all; the standard error is over objects.",
    )


def claim(name: str, count: int, coarse: np.ndarray, fine: np.ndarray) -> tuple:
    """A row of the claim: paired t test of errors (n,) of coarser and finer grid."""
    from scipy.stats import t

    difference, n = fine - coarse, len(fine)
    mean, error = float(difference.mean()), float(difference.std(ddof=1) / np.sqrt(n))
    limit = float(t.ppf(CONFIDENCE, n - 1)) * error
    verdict = "no better (within chance)"
    if abs(mean) > limit:
        verdict = "better" if mean < 0.0 else "no better (worse)"
    means = float(coarse.mean()), float(fine.mean())
    return name, count, *means, mean, error, n, verdict


EXPERIMENT = Experiment(
    "density",
    "Accuracy and compute time by point density",
    "Figure on point density, and the discussion of 0.04 and 0.09 points/cm³",
    jobs,
    run,
    report,
)


def accuracy_figure(densities: list[float], found: dict[str, dict[str, np.ndarray]]):
    """Errors by density: mean over the objects, with standard error."""
    panels = {
        "mass": "mass error [%]",
        "center_of_mass": "COM error [%]",
        "inertia_at_origin": "inertia error [%]",
    }
    lines = (
        ("moderate", 0, VERMILION, "o", "moderate noise, 1.5 s"),
        ("moderate, lambda kept", 0, ORANGE, "D", "the same, lambda kept"),
        ("moderate", 1, BLUE, "^", "moderate noise, 35 s"),
        ("noise-free", 1, GREEN, "s", "noise-free, 35 s"),
    )
    with drawing(4.2) as figure:
        for axes, (name, label) in zip(
            figure.subplots(3, 1, sharex=True), panels.items(), strict=True
        ):
            for k, (series, time_index, colour, marker, what) in enumerate(lines):
                values = found[series][name][:, time_index]
                error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
                shown = marked(colour, marker) | {"elinewidth": 0.6}
                place = np.array(densities) * 1.03 ** (k - 1.5)
                axes.errorbar(
                    place,
                    np.maximum(values.mean(axis=0), 1e-12),
                    error,
                    label=what,
                    **shown,
                )
            axes.set(xscale="log", yscale="log", ylabel=label)
        axes.set_xlabel("points/cm³")
        axes.set_xticks(densities, [f"{d:g}" for d in densities])
        axes.set_xticks([], minor=True)
        figure.align_ylabels()
        legend_above(figure, axes, 2)
    return figure


def times_figure(timed: Results):
    """Compute times, a line per density."""
    colours = (SKY, BLUE, VERMILION, ORANGE, GREEN, PURPLE)
    with drawing(2.6) as figure:
        left, right = figure.subplots(1, 2, sharey=True)
        for k, (_, result) in enumerate(timed):
            line = marked(colours[k], "os^Dv*"[k])
            left.plot(
                COUNTS,
                1e3 * np.array(result["solve"]),
                label=f"{result['points']} points",
                **line,
            )
            right.plot(COUNTS, 1e3 * np.array(result["whole"]), **line)
        left.set(
            ylim=(0.0, None),
            ylabel="time [ms]",
            xlabel="observations",
            title="estimate from the moments",
        )
        right.set(xlabel="observations", title="all folded, then estimated")
        for axes in (left, right):
            axes.set_xlim(0, 1.03 * COUNTS[-1])
            axes.set_xticks([0, 1000, 2000, 3000])
        legend_above(figure, left, 3)
    return figure
