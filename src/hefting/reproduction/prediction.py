"""Torques along another motion, predicted by PMD-5K's estimate from 1.5 s."""

import numpy as np

from hefting.core.regressor import predict_wrench
from hefting.estimators import PMD
from hefting.plots.style import COMPONENTS, INK, drawing
from hefting.reproduction.experiment import (
    OBJECTS,
    RATE,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    thing,
    wielded,
)
from hefting.reproduction.filtered import Observed, motions
from hefting.reproduction.robot import SPEED
from hefting.simulation import WRENCH_NOISE, XARM7, random_smooth, wield_in_mujoco

SHOWN = "tee"
"""The object of the figure."""
C1 = 5e3
ENOUGH = 5.0
"""Duration of the motion for identification, in which the filter settles [s]."""
DURATION = 10.0
"""Duration of the predicted motion [s]."""
DRAWN = 4
"""Number of samples per sample of the figure."""
KINDS = ("warm", "cold")


def jobs(quick: bool) -> list[Job]:
    """A job for each object."""
    return [{"object": name, "seed": 3} for name in ((SHOWN,) if quick else OBJECTS)]


def run(job: Job) -> Result:
    """True and predicted torques [N m]; root mean squares of the wrench and of prediction
    errors [N], [N m]."""
    subject = thing(job["object"])
    seed = (job["seed"], OBJECTS.index(job["object"]))
    observed = Observed.of(
        wielded(job["object"], SPEED, "xarm7", ENOUGH), WRENCH_NOISE["ft300"], seed
    )
    joints = random_smooth(DURATION, RATE, SPEED, job["seed"], XARM7)
    other = wield_in_mujoco(XARM7, joints, subject.held.parameters).measurements
    falling = np.cross(subject.held.parameters.vector[1:4], -other.gravity)
    result: Result = {
        "inertial": _rms(other.torque - falling),
        "time": other.time[::DRAWN].tolist(),
        "true": other.torque[::DRAWN].tolist(),
        "size": _sizes(other.wrench),
    }
    each = motions(observed)
    for kind in KINDS:
        z = next(each[kind])
        predicted = predict_wrench(
            other, PMD(subject.shape, c1=C1, intervals=False).fit(z).parameters.vector
        )
        wrong = predicted - other.wrench
        result[kind] = {
            "torque": predicted[::DRAWN, 3:].tolist(),
            "error": _sizes(wrong),
        }
    return result


def _sizes(wrench: np.ndarray) -> list[float]:
    """Root mean squares of force, torque and the torque's components."""
    force, torque = wrench[:, :3], wrench[:, 3:]
    return [_rms(force), _rms(torque), *map(_rms, torque.T)]


def _rms(values: np.ndarray) -> float:
    squares = np.square(values)
    return float(
        np.sqrt(np.mean(squares.sum(axis=-1) if values.ndim == 2 else squares))
    )


def report(results: Results) -> Report:
    """The paper's figure, and the prediction errors of every object."""
    rows = []
    for kind in KINDS:
        for job, result in results:
            error, size = np.array(result[kind]["error"]), np.array(result["size"])
            numbers = map(float, (*error, *(100.0 * error[:2] / size[:2])))
            rows.append((kind, job["object"], *numbers))
        means = np.mean([row[2:] for row in rows if row[0] == kind], axis=0)
        rows.append((kind, "mean", *map(float, means)))
    columns = (
        "motion filter",
        "object",
        "force N",
        "torque N m",
        "x N m",
        "y N m",
        "z N m",
        "force %",
        "torque %",
    )
    title = (
        f"Predicted minus true wrench over {DURATION:g} s: root mean square, "
        "of the vectors and of the torque's axes"
    )
    tables = (Table("prediction", title, columns, rows),)
    shown = next(result for job, result in results if job["object"] == SHOWN)
    share = {
        kind: next(row[-1] for row in rows if row[:2] == (kind, SHOWN))
        for kind in KINDS
    }
    notes = (
        f"PMD with c1 = {C1:g} (PMD-5K) identified each object from 1.5 s at {SPEED} rad/s on the xArm 7, with the "
        f"FT-300's noise; the motion predicted is another, of all joints ({SPEED} rad/s too), its true torques "
        f"MuJoCo's. For the {SHOWN} with the filter warm the torque is {share['warm']:.2g} % off, as a share of its "
        f"root mean square, and {share['cold']:.2g} % with the filter cold; the paper shows a figure without numbers.",
        "Most of the torque is gravity's, which mass and COM make: the rest is "
        f"{100.0 * shown['inertial'] / shown['size'][1]:.0f} % of its root mean square for the {SHOWN}.",
    )
    return Report(tables, {"prediction": _figure(shown)}, notes)


def _figure(result: Result):
    from matplotlib.lines import Line2D

    time = np.array(result["time"])
    true = np.array(result["true"])
    found = np.array(result["warm"]["torque"])
    with drawing(3.0) as figure:
        torques, rest = figure.subplots(
            2, 1, sharex=True, gridspec_kw={"height_ratios": (2.6, 1.0)}
        )
        for i, colour in enumerate(COMPONENTS.values()):
            torques.plot(time, true[:, i], color=colour, linewidth=0.9)
            torques.plot(
                time, found[:, i], color=INK, linewidth=0.9, linestyle=(0, (2, 2))
            )
            rest.plot(time, 1e3 * (found - true)[:, i], color=colour, linewidth=0.8)
        handles = [
            Line2D([], [], color=colour, label=f"{name}, true")
            for name, colour in COMPONENTS.items()
        ]
        handles.append(
            Line2D([], [], color=INK, linestyle=(0, (2, 2)), label="predicted")
        )
        figure.legend(
            handles=handles, loc="outside upper center", ncols=4, handlelength=1.8
        )
        rest.axhline(0.0, color=INK, linewidth=0.4)
        torques.set(ylabel="torque [N m]")
        rest.set(xlabel="time [s]", ylabel="difference\n[mN m]", xlim=(0.0, DURATION))
        figure.align_ylabels()
    return figure


EXPERIMENT = Experiment(
    "prediction",
    "Predicted torques",
    "Figure on predicted and true torques of the Tee",
    jobs,
    run,
    report,
)
