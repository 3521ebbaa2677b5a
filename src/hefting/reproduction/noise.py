"""Noise by speed: 8 objects x 5 speeds x 4 noise levels x 4 methods, error after 10 s
and over time."""

from typing import Any

import numpy as np

from hefting.core.measurements import NOISE_LEVELS
from hefting.plots.style import INK, drawing
from hefting.reproduction.experiment import (
    COLOURS,
    MARKERS,
    METHODS,
    OBJECTS,
    SPEEDS,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    jobs_of,
    legend_above,
    mark_limit,
    mean,
    over_limit,
    signal_to_noise,
    speeds_of,
    thing,
    wielded,
)

TIMES = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 19.0, 25.0, 35.0)
"""Times of the estimates [s]."""
SHOWN = 10.0
"""[s] Time at which the paper compares the methods."""
LINES = {"OLS": "-", "RTLS": (0, (2, 2)), "GEO": "-", "PMD": "-"}
"""Line styles: RTLS often coincides with OLS."""
RANGE, SNR_RANGE = (0.1, 1e3), (1.0, 1e4)
"""Ranges of errors [%] and signal-to-noise ratios in the figures."""


def jobs(quick: bool) -> list[Job]:
    """A job for each object and speed."""
    objects = ("hammer", "half-n-half") if quick else OBJECTS
    speeds = (1.0, 2.0) if quick else SPEEDS
    return jobs_of(objects, speeds, seed=1)


def run(job: Job) -> Result:
    """Errors of each method by noise level and time; all methods have the same noise."""
    subject = thing(job["object"])
    exact = wielded(job["object"], job["speed"]).measurements
    seed = (job["seed"], OBJECTS.index(job["object"]), round(100 * job["speed"]))
    levels = {}
    for level, noise in NOISE_LEVELS.items():
        z = exact.with_noise(noise, seed) if level != "none" else exact
        found = {
            name: _over_time(method(subject, z), z, subject)
            for name, method in METHODS.items()
        }
        levels[level] = {"methods": found}
        if level != "none":
            levels[level]["snr"] = signal_to_noise(exact, noise)
    return {"levels": levels}


def _over_time(estimator, z, subject) -> dict[str, list]:
    state, begin = estimator.start(), 0
    rows = []
    for end in np.searchsorted(z.time - z.time[0], TIMES):
        state, begin = estimator.update(state, z[begin:end]), end
        estimate = estimator.estimate(state)
        e, can_be = subject.errors(estimate), estimate.physically_consistent
        rows.append((e.mass, e.center_of_mass, e.inertia_at_origin, can_be))
    names = ("mass", "center_of_mass", "inertia", "consistent")
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))


def report(results: Results) -> Report:
    """Errors after 10 s, over time, and the paper's two figures."""
    speeds = speeds_of(results)
    by_speed = {s: [r for job, r in results if job["speed"] == s] for s in speeds}
    at = TIMES.index(SHOWN)

    def average(
        speed: float, level: str, method: str, what: str, k: int
    ) -> float | None:
        return mean(
            float(r["levels"][level]["methods"][method][what][k])
            for r in by_speed[speed]
        )

    columns = [
        f"{method}: {what} %"
        for method in METHODS
        for what in ("mass", "COM", "inertia", "possible")
    ]
    rows, over_time = [], []
    for level in NOISE_LEVELS:
        for speed in speeds:
            snr = None
            if level != "none":
                snr = mean(r["levels"][level]["snr"] for r in by_speed[speed])
            cells = []
            for method in METHODS:
                cells += [
                    average(speed, level, method, w, at)
                    for w in ("mass", "center_of_mass", "inertia")
                ]
                cells.append(
                    100.0 * (average(speed, level, method, "consistent", at) or 0.0)
                )
            rows.append((level, speed, snr, *cells))
            for k, t in enumerate(TIMES):
                inertia = (average(speed, level, m, "inertia", k) for m in METHODS)
                over_time.append((level, speed, t, *inertia))
    title = "Mean errors over the objects after 10 s, and the share of bodies that can exist"
    tables = (
        Table("after-10-s", title, ("noise", "rad/s", "SNR", *columns), rows),
        Table(
            "over-time",
            "Mean inertia error [%] over time",
            ("noise", "rad/s", "s", *METHODS),
            over_time,
        ),
    )
    experiments = len(results) * len(NOISE_LEVELS) * len(METHODS)
    notes = (
        f"{experiments} experiments: objects x speeds x noise levels x methods, each 35 s at 100 Hz. Noise is added to "
        "the exact accelerations and wrench, as in the paper; inertia errors are about the sensor's origin. The SNR is "
        "mean-squared signal over noise variance, the geometric mean over the twelve channels of accelerations and "
        "wrench: the paper does not say how it averages.",
        "The paper gives no numbers for these two figures. GEO starts from the homogeneous body with the mass that "
        "least squares finds and the weight of its authors' code; PMD has c1 = 300.",
    )
    figures = {
        "error-by-speed": _by_speed_figure(speeds, average, by_speed, at),
        "error-over-time": _over_time_figure(speeds, average),
    }
    return Report(tables, figures, notes)


def _by_speed_figure(speeds, average, by_speed, at):
    levels = [level for level in NOISE_LEVELS if level != "none"]
    with drawing(2.6, width=7.2) as figure:
        axes = figure.subplots(1, len(levels), sharey=True)
        for ax, level in zip(axes, levels, strict=True):
            for method in METHODS:
                values = np.clip(
                    [average(s, level, method, "inertia", at) for s in speeds], *RANGE
                )
                ax.plot(speeds, values, color=COLOURS[method], **_line(method))
            ax.set(
                title=f"{level} noise",
                xlabel="average angular speed [rad/s]",
                yscale="log",
                ylim=RANGE,
            )
            ax.plot(
                [],
                [],
                color=INK,
                linestyle="--",
                linewidth=1.6,
                label="SNR (scale on the right)",
            )
            mark_limit(ax)
            ratios = ax.twinx()
            snr = [mean(r["levels"][level]["snr"] for r in by_speed[s]) for s in speeds]
            ratios.plot(speeds, snr, color=INK, linestyle="--", linewidth=1.6)
            ratios.set(yscale="log", ylim=SNR_RANGE)
            if ax is axes[-1]:
                ratios.spines["right"].set_visible(True)
                ratios.set_ylabel("signal-to-noise ratio [-]")
            else:
                ratios.yaxis.set_visible(False)
        axes[0].set_ylabel("inertia error after 10 s [%]")
        legend_above(figure, axes[0], len(METHODS) + 2)
    return figure


def _over_time_figure(speeds, average):
    with drawing(2.3, width=7.2) as figure:
        axes = np.atleast_1d(figure.subplots(1, len(speeds), sharey=True))
        for ax, speed in zip(axes, speeds, strict=True):
            for method in METHODS:
                values = np.clip(
                    [
                        average(speed, "moderate", method, "inertia", k)
                        for k in range(len(TIMES))
                    ],
                    *RANGE,
                )
                look = {"linestyle": LINES[method], "label": method}
                ax.plot(TIMES, values, color=COLOURS[method], **look)
            ax.set(
                title=f"{speed:g} rad/s, {SPEEDS[speed]:g} m/s",
                xlabel="time [s]",
                yscale="log",
                xscale="log",
                ylim=RANGE,
            )
            ax.set_xticks([1, 10], ["1", "10"])
            if over_limit(speed):
                ax.text(
                    0.97,
                    0.97,
                    "above ISO 10218-1",
                    transform=ax.transAxes,
                    ha="right",
                    va="top",
                    size=6.5,
                )
        axes[0].set_ylabel("inertia error [%]")
        legend_above(figure, axes[0], len(METHODS))
    return figure


def _line(method: str) -> dict[str, Any]:
    return {
        "marker": MARKERS[method],
        "markersize": 3,
        "linestyle": LINES[method],
        "label": method,
    }


EXPERIMENT = Experiment(
    "noise",
    "Inertia error by speed and noise",
    "Figures 5 and 6: 640 experiments at five speeds and four noise levels",
    jobs,
    run,
    report,
)
