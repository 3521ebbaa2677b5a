"""Stop-and-go: PMD's mass and COM from samples at rest in many poses."""

from dataclasses import fields
from functools import cache

import numpy as np

from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.estimators import PMD
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.reproduction.experiment import (
    C1,
    OBJECTS,
    QUANTITIES,
    RATE,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    Thing,
    legend_above,
    thing,
)
from hefting.simulation import UR5, JointMotion, stop_and_go, wield_in_mujoco

DURATION, DWELL, MOVE = 40.0, 0.75, 1.25
"""Durations of the motion, a rest and a move [s]: 20 poses."""
SEEDS = 10
"""Number of noise seeds for each object."""
BOUND = 0.1
"""Published upper bound of the errors of mass and COM [%]."""
MODERATE = NOISE_LEVELS["moderate"]
SETTINGS = {
    "noise-free": Noise(),
    "moderate": Noise(MODERATE.force, MODERATE.torque),
    "moderate, motion too": MODERATE,
}
"""Noise: of the wrench alone, as the robot is known to rest, or of accelerations too."""


def jobs(quick: bool) -> list[Job]:
    """A job for each object."""
    objects, seeds = (("hammer", "corners"), 2) if quick else (OBJECTS, SEEDS)
    return [{"object": name, "motion_seed": 0, "seeds": seeds} for name in objects]


def run(job: Job) -> Result:
    """Errors by setting: [mass, COM, inertia] of each seed."""
    subject = thing(job["object"])
    exact = rests(job["object"], job["motion_seed"])
    errors = {}
    for setting, noise in SETTINGS.items():
        seeds = job["seeds"] if setting != "noise-free" else 1
        keys = [(seed, OBJECTS.index(job["object"])) for seed in range(seeds)]
        errors[setting] = [
            _errors(subject, exact.with_noise(noise, key)) for key in keys
        ]
    return {"observations": len(exact), "poses": _poses(exact), "errors": errors}


@cache
def rests(name: str, seed: int) -> Measurements:
    """All samples at rest of a stop-and-go motion, from MuJoCo."""
    joints = stop_and_go(DURATION, RATE, DWELL, MOVE, seed)
    still = ~np.any((joints.velocity != 0.0) | (joints.acceleration != 0.0), axis=1)
    joints = JointMotion(*(getattr(joints, f.name)[still] for f in fields(joints)))
    return wield_in_mujoco(UR5, joints, thing(name).held.parameters).measurements


def _errors(subject: Thing, z: Measurements) -> list[float]:
    found = subject.errors(PMD(subject.shape, c1=C1, intervals=False).fit(z))
    return [getattr(found, name) for name in QUANTITIES]


def _poses(z: Measurements) -> int:
    return int(np.sum(np.linalg.norm(np.diff(z.gravity, axis=0), axis=1) > 1e-6)) + 1


def report(results: Results) -> Report:
    """Errors of each object by setting, and the published bound."""
    found = {
        setting: np.array(
            [np.mean(result["errors"][setting], axis=0) for _, result in results]
        )
        for setting in SETTINGS
    }
    names = [job["object"] for job, _ in results]
    columns = ["object"]
    for setting in SETTINGS:
        columns += [f"mass %, {setting}", f"COM %, {setting}"]
    body = np.hstack([values[:, :2] for values in found.values()])
    rows = [
        *((name, *map(float, line)) for name, line in zip(names, body, strict=True)),
        ("mean", *map(float, body.mean(axis=0))),
        ("largest", *map(float, body.max(axis=0))),
        ("published", f"< {BOUND}", f"< {BOUND}", None, None, None, None),
    ]
    exact, noisy = found["noise-free"], found["moderate"]
    largest = float(exact[:, :2].max())
    first, seeds = results[0][1], results[0][0]["seeds"]
    held = "below" if largest < BOUND else "NOT below"
    notes = (
        f"{first['observations']} samples at rest in {first['poses']} poses, velocity and acceleration exactly zero; "
        f"the noisy columns are means over {seeds} seeds.",
        f"Noise-free, the largest error is {largest:.2g} %, {held} the published {BOUND} %. With moderate noise of the "
        f"wrench the mean errors are {noisy[:, 0].mean():.2g} % (mass) and {noisy[:, 1].mean():.2g} % (COM).",
    )
    table = Table("errors", "Errors of PMD from stop-and-go motion", columns, rows)
    return Report((table,), {"errors": _figure(names, exact, noisy)}, notes)


def _figure(names: list[str], exact: np.ndarray, noisy: np.ndarray):
    with drawing(2.3) as figure:
        axes = figure.subplots()
        place = np.arange(len(names))
        for i, (label, colour, marker) in enumerate(
            (("mass", BLUE, "o"), ("COM", VERMILION, "s"))
        ):
            at = place + 0.2 * (i - 0.5)
            axes.plot(
                at,
                noisy[:, i],
                marker,
                color=colour,
                markersize=4.0,
                label=f"{label}, moderate noise",
            )
            hollow = {"markerfacecolor": "white", "markersize": 4.0, "color": colour}
            axes.plot(
                at,
                np.maximum(exact[:, i], 1e-14),
                marker,
                label=f"{label}, noise-free",
                **hollow,
            )
        axes.axhline(
            BOUND,
            color=INK,
            linewidth=0.8,
            linestyle="--",
            label=f"published: below {BOUND} %",
        )
        axes.set(yscale="log", ylabel="error [%]")
        axes.set_xticks(place, names, rotation=30, ha="right")
        legend_above(figure, axes, 2)
    return figure


EXPERIMENT = Experiment(
    "stop-and-go",
    "Stop-and-go motion",
    "Section V-D: mass and COM from samples at rest",
    jobs,
    run,
    report,
)
