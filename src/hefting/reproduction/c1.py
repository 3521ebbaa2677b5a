"""The hyperparameter c1: PMD's error over time by speed; together with `density` the
paper's 328 runs."""

import numpy as np

from hefting.core.measurements import NOISE_LEVELS
from hefting.core.spatial import SPEED_LIMIT
from hefting.estimators import PMD
from hefting.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    drawing,
)
from hefting.reproduction.experiment import (
    C1,
    OBJECTS,
    QUANTITIES,
    RATE,
    SPEEDS,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    jobs_of,
    over_limit,
    speeds_of,
    thing,
    wielded,
)

VALUES = (10.0, 30.0, 100.0, 300.0, 1000.0, 5000.0, 25000.0)
"""Values of c1, including the paper's 300 (simulation), 5e3 and 25e3 (robot)."""
COLOURS = (SKY, BLUE, GREEN, BLACK, ORANGE, VERMILION, PURPLE)
TIMES = (0.25, 0.5, 1.0, 1.5, 2.5, 4.0, 6.5, 10.0, 15.0, 23.0, 35.0)
"""Times of the estimates [s]."""
SHOWN = (1.5, 10.0)
"""Times in the table [s]."""
SEEDS = 8
"""Number of noise seeds for each object and speed."""


def jobs(quick: bool) -> list[Job]:
    """A job for each object and speed."""
    objects, speeds, seeds = (
        (("hammer",), (1.0, 2.0, 4.0), 1) if quick else (OBJECTS, tuple(SPEEDS), SEEDS)
    )
    return jobs_of(objects, speeds, seeds=seeds)


def run(job: Job) -> Result:
    """Errors (values of c1, times) by quantity, averaged over the seeds, and the mean
    weight of the full model (values of c1,); all values of c1 have the same noise."""
    subject = thing(job["object"])
    exact = wielded(job["object"], job["speed"]).measurements
    errors = {name: np.zeros((len(VALUES), len(TIMES))) for name in QUANTITIES}
    for seed in range(job["seeds"]):
        key = (seed, OBJECTS.index(job["object"]), round(10 * job["speed"]))
        z = exact.with_noise(NOISE_LEVELS["moderate"], key)
        for i, value in enumerate(VALUES):
            method = PMD(subject.shape, c1=value, intervals=False)
            state, begin = method.start(), 0
            for j, end in enumerate(round(t * RATE) for t in TIMES):
                state, begin = method.update(state, z[begin:end]), end
                found = subject.errors(method.estimate(state))
                for name, values in errors.items():
                    values[i, j] += getattr(found, name) / job["seeds"]
    weights = [
        float(np.mean(PMD(subject.shape, c1=value).weight(exact))) for value in VALUES
    ]
    return {"weights": weights} | {
        name: values.tolist() for name, values in errors.items()
    }


def report(results: Results) -> Report:
    """Errors after 1.5 and 10 s, the best c1 of each speed, and errors over time."""
    speeds = speeds_of(results)
    found = {  # (values, times) by quantity and speed, averaged over objects
        name: {
            s: np.mean([r[name] for job, r in results if job["speed"] == s], axis=0)
            for s in speeds
        }
        for name in (*QUANTITIES, "weights")
    }
    places = [TIMES.index(t) for t in SHOWN]
    rows = []
    for speed in speeds:
        for i, value in enumerate(VALUES):
            each = [found[name][speed][i, k] for k in places for name in QUANTITIES]
            numbers = map(float, (found["weights"][speed][i], *each))
            rows.append((value, speed, *numbers))
    columns = [f"{name} %, {t:g} s" for t in SHOWN for name in QUANTITIES.values()]
    best = []
    for s in speeds:
        errors = (found[name][s][:, k] for k in places for name in list(QUANTITIES)[1:])
        best.append((s, *(VALUES[int(np.argmin(each))] for each in errors)))
    chosen = [f"{name}, {t:g} s" for t in SHOWN for name in ("COM", "inertia")]
    seeds, objects = results[0][0]["seeds"], len({job["object"] for job, _ in results})
    tables = (
        Table(
            "errors",
            f"Mean errors of PMD over {objects} objects and {seeds} noise seeds",
            ("c1", "rad/s", "mean w", *columns),
            rows,
        ),
        Table("best", "The c1 of least mean error", ("rad/s", *chosen), best),
    )
    notes = (
        "The paper gives no numbers for this figure, nor its noise: assumed is the moderate noise of its table II on "
        f"the exact accelerations and wrench. Its c1 = {C1:g} is drawn thick; inertia errors are about the sensor's "
        "origin.",
    )
    figures = {
        "inertia": _figure(found["inertia_at_origin"], "inertia error [%]"),
        "center-of-mass": _figure(found["center_of_mass"], "COM error [%]"),
    }
    return Report(tables, figures, notes)


def _figure(found: dict[float, np.ndarray], label: str):
    """A panel per speed with a line per c1, and a legend in the next panel."""
    rows = len(found) // 2 + 1
    with drawing(1.35 * rows + 0.25) as figure:
        panels = figure.subplots(
            rows, 2, sharex=True, sharey=True, squeeze=False
        ).ravel()
        for axes, (speed, errors) in zip(panels, found.items(), strict=False):
            for value, colour, line in zip(VALUES, COLOURS, errors, strict=True):
                own = {"linewidth": 0.9}
                if value == C1:
                    own = {"linewidth": 2.4, "zorder": 1, "alpha": 0.55}
                axes.plot(TIMES, line, color=colour, label=f"c1 = {value:g}", **own)
            mark = " (> ISO)" if over_limit(speed) else ""
            axes.set(
                xscale="log",
                yscale="log",
                title=f"{speed:g} rad/s, {SPEEDS[speed]:g} m/s{mark}",
            )
            axes.set_xticks([0.3, 1, 3, 10, 30], ["0.3", "1", "3", "10", "30"])
            axes.set_xticks([], minor=True)
        for axes in panels[len(found) :]:
            axes.set_axis_off()
        limit = f"> ISO: above {SPEED_LIMIT} m/s\n(ISO 10218-1)"
        panels[len(found)].legend(
            *panels[0].get_legend_handles_labels(),
            loc="center",
            title=limit,
            title_fontsize=6.5,
        )
        for axes in panels[max(len(found) - 2, 0) : len(found)]:
            axes.tick_params(labelbottom=True)
        panels[len(found) - 1].set_xlabel("time [s]")
        for axes in panels[0 : len(found) : 2]:
            axes.set_ylabel(label)
    return figure


EXPERIMENT = Experiment(
    "c1",
    "PMD's error over time by c1 and speed",
    "Figure on the c1 parameter",
    jobs,
    run,
    report,
)
