"""Condition number of the scaled regressor, by speed, and for the robot's motion."""

import numpy as np

from hefting.core.measurements import NOISE_LEVELS
from hefting.core.moments import Moments
from hefting.ingest.identifiability import condition_number
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.reproduction.experiment import (
    DURATION,
    SPEEDS,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    legend_above,
    mark_limit,
    marked,
    wielded,
)

PUBLISHED = {
    ("ur5", 1.0): 147.0,
    ("ur5", 1.5): 68.4,
    ("ur5", 2.0): 58.0,
    ("xarm7", 1.1): 178.0,
}
"""Published condition numbers by arm and average angular speed [rad/s]."""
ROBOT = ("xarm7", 1.1, 1.5)
"""Arm, mean angular speed [rad/s] and duration [s] of the paper's robot experiments."""
SIZES = (0.1, 0.15, 0.2, 0.3)
"""[m] Sizes of the body that scales the columns: its sides are 0.05, 0.2 and 0.3 m."""
EXACT, AVERAGED = 0.2, 0.15
"""Sizes [m] of the two readings that are compared with the published figures."""
TICKS = (10, 20, 50, 100, 200, 400)
SEEDS = 5
WINDOW = 150
"""Number of observations in a window."""


def jobs(quick: bool) -> list[Job]:
    """A job for each motion: the regressor does not depend on the object."""
    speeds = (1.0, 2.0) if quick else tuple(SPEEDS)
    seeds = 2 if quick else SEEDS
    return [
        {"arm": arm, "speed": speed, "duration": duration, "seeds": seeds}
        for arm, speed, duration in (*(("ur5", s, DURATION) for s in speeds), ROBOT)
    ]


def run(job: Job) -> Result:
    """Condition numbers by noise level and size, averaged over the seeds; and the mean
    over windows of exact motion."""
    exact = wielded("hammer", job["speed"], job["arm"], job["duration"]).measurements
    levels = {}
    for level, noise in NOISE_LEVELS.items():
        seeds = job["seeds"] if level != "none" else 1
        moments = [
            Moments.of(exact.with_noise(noise, (seed, round(10 * job["speed"]))))
            for seed in range(seeds)
        ]
        levels[level] = [
            float(np.mean([condition_number(m, size) for m in moments]))
            for size in SIZES
        ]
    starts = range(0, len(exact) - WINDOW + 1, WINDOW)
    windows = [
        condition_number(Moments.of(exact[k : k + WINDOW]), EXACT) for k in starts
    ]
    return {"levels": levels, "windows": float(np.mean(windows))}


def report(results: Results) -> Report:
    """Both readings compared with the published figures."""
    summary, every = [], []
    for job, result in results:
        exact, known = _exact(result), PUBLISHED.get((job["arm"], job["speed"]))
        averaged = _averaged(result)
        at = None if known is None else EXACT * exact / known
        ratios = (None, None) if known is None else (exact / known, averaged / known)
        rising = job["speed"] ** 2 * exact
        motion = job["arm"], job["speed"], job["duration"]
        summary.append((*motion, known, exact, averaged, *ratios, rising, at))
        for level, values in result["levels"].items():
            windows = result["windows"] if level == "none" else None
            every.append((*motion[:2], level, *values, windows))
    tables = (
        Table(
            "condition",
            "Condition number of the scaled regressor",
            (
                "arm",
                "rad/s",
                "s",
                "published",
                f"exact motion, size {EXACT} m",
                f"mean over noise levels, size {AVERAGED} m",
                "first / published",
                "second / published",
                "first x (rad/s)²",
                "size that gives the published figure m",
            ),
            summary,
        ),
        Table(
            "every",
            "By noise of the motion and size of the body",
            (
                "arm",
                "rad/s",
                "noise",
                *(f"{size} m" for size in SIZES),
                f"mean over {WINDOW} observations, {EXACT} m",
            ),
            every,
        ),
    )
    return Report(tables, {"condition": _figure(results)}, _notes(results))


def _exact(result: Result) -> float:
    return result["levels"]["none"][SIZES.index(EXACT)]


def _averaged(result: Result) -> float:
    return float(
        np.mean([values[SIZES.index(AVERAGED)] for values in result["levels"].values()])
    )


def _notes(results: Results) -> tuple[str, ...]:
    known = [
        (PUBLISHED[key], r)
        for job, r in results
        if (key := (job["arm"], job["speed"])) in PUBLISHED
    ]
    exact, averaged = ([f(r) / p for p, r in known] for f in (_exact, _averaged))
    return (
        "The paper scales after Gautier & Khalil (1992), but does not say by which magnitudes, nor what it averages. "
        "Here columns are in the units of a body of 1 kg and a given size, torques in force times that size. Two "
        f"readings are shown: exact motion at {EXACT} m ({min(exact):.2g} to {max(exact):.2g} times the published "
        f"figures), and the mean over the four noise levels at {AVERAGED} m ({min(averaged):.2g} to "
        f"{max(averaged):.2g} times).",
    )


def _figure(results: Results):
    simulated = [
        (job["speed"], result) for job, result in results if job["arm"] == "ur5"
    ]
    robot = next(result for job, result in results if job["arm"] == "xarm7")
    speeds = [speed for speed, _ in simulated]
    with drawing(2.7) as figure:
        axes = figure.subplots()
        exact = np.array([result["levels"]["none"] for _, result in simulated])
        band = f"exact motion, {SIZES[0]} to {SIZES[-1]} m"
        axes.fill_between(
            speeds,
            exact[:, 0],
            exact[:, -1],
            color=BLUE,
            alpha=0.15,
            linewidth=0.0,
            label=band,
        )
        for colour, marker, what, label in (
            (BLUE, "o", _exact, f"exact motion, {EXACT} m"),
            (VERMILION, "s", _averaged, f"mean of noise levels, {AVERAGED} m"),
        ):
            line = marked(colour, marker)
            axes.plot(
                speeds, [what(result) for _, result in simulated], label=label, **line
            )
            axes.plot(ROBOT[1], what(robot), "*", color=colour, markersize=6.0)
        known = [(s, p) for (arm, s), p in PUBLISHED.items() if arm == "ur5"]
        axes.plot(
            *zip(*known, strict=True), "D", color=INK, markersize=3.5, label="published"
        )
        axes.plot(
            ROBOT[1],
            PUBLISHED[ROBOT[:2]],
            "*",
            color=INK,
            markersize=6.0,
            label="stars: xArm 7, 1.5 s",
        )
        mark_limit(axes)
        axes.set(
            xlabel="average angular speed [rad/s]",
            ylabel="condition number",
            yscale="log",
        )
        axes.set_yticks(TICKS, [f"{tick}" for tick in TICKS])
        axes.set_yticks([], minor=True)
        axes.set_ylim(0.9 * exact.min(), 1.1 * exact.max())
        legend_above(figure, axes, 2)
    return figure


EXPERIMENT = Experiment(
    "condition",
    "Condition number of the scaled regressor",
    "Sections V-D and V-E: 147, 68.4 and 58.0 in simulation, 178 on the robot",
    jobs,
    run,
    report,
)
