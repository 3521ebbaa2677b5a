"""Gravity's share in force and torque: of human and of simulated motions."""

import numpy as np

from hefting.core.spatial import STANDARD_GRAVITY
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.reproduction.experiment import (
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
    marked,
    speeds_of,
    thing,
    wielded,
)

ALPHA = "angular acceleration rad/s²"
HUMAN = {
    "linear velocity m/s": (0.206, 0.128),
    "angular velocity rad/s": (1.08, 0.703),
    "linear acceleration m/s²": (1.45, 1.20),
    ALPHA: (11.34, 8.38),
    "object mass kg": (0.257, 0.110),
    "object radius m": (0.081, 0.068),
}
"""Means and medians of daily human manipulation (Nadeau et al. 2022, table I)."""
YCB_OBJECTS = 63
"""Number of the Yale-CMU-Berkeley set's 77 objects that the paper averages over."""
DOMINANCE = 5.0
"""Published approximate factor by which gravity dominates."""
MOTION = ("sensor_speed", "com_speed", "linear_acceleration", "angular_acceleration")
BALL = 0.4
"""Moment of inertia of a homogeneous ball over mass and squared radius."""
G = float(np.linalg.norm(STANDARD_GRAVITY))


def jobs(quick: bool) -> list[Job]:
    """A job for each object and speed."""
    objects, speeds = (
        (("hammer", "empty"), (1.0, 4.0)) if quick else (OBJECTS, tuple(SPEEDS))
    )
    return jobs_of(objects, speeds)


def run(job: Job) -> Result:
    """Mean magnitudes of the parts of force [N] and torque [N m] by gravity and by
    motion, and of the motion."""
    exact = wielded(job["object"], job["speed"])
    body = thing(job["object"]).held.parameters
    z = exact.measurements
    force = -body.mass * z.gravity
    torque = np.cross(body.center_of_mass, force)

    def size(vectors: np.ndarray) -> float:
        return float(np.linalg.norm(vectors, axis=1).mean())

    return {
        "force": [size(force), size(z.force - force)],
        "torque": [size(torque), size(z.torque - torque)],
        "sensor_speed": exact.motion.mean_speeds[1],
        "linear_acceleration": size(z.linear_acceleration),
        "angular_acceleration": size(z.angular_acceleration),
        "com_speed": float(exact.motion.linear_speed(body.center_of_mass).mean()),
    }


def human(k: int) -> dict[str, float]:
    """Ratios of the parts of force and torque by motion to those by gravity, from means
    (k = 0) or medians (1) of `HUMAN`.

    Magnitudes are added as if in one direction. The object's mass is at its radius from
    the hand, orthogonal to the rotation axis.
    """
    _, w, a, alpha, _, r = (values[k] for values in HUMAN.values())
    rotation = r * (alpha + w * w)
    return {
        "force, the hand's acceleration alone": a / G,
        "force, with the rotation": (a + rotation) / G,
        "torque, a mass at the radius": (a + rotation) / G,
        "torque, a ball at the radius": (a + rotation + BALL * r * alpha) / G,
    }


def report(results: Results) -> Report:
    """The paper's ratios recomputed, its object statistics, and simulated motions."""
    speeds = speeds_of(results)
    shares = {  # (objects,) by quantity and speed
        part: {
            s: np.array(
                [r[part][0] / sum(r[part]) for job, r in results if job["speed"] == s]
            )
            for s in speeds
        }
        for part in ("force", "torque")
    }
    recomputed = _recomputed_rows()
    tables = (
        _human_table(recomputed),
        _objects_table(),
        _simulated_table(results, shares),
    )
    return Report(tables, {"share": _figure(speeds, shares)}, _notes(recomputed))


def _recomputed_rows() -> list[tuple]:
    """Ratios of gravity and of all forces, or torques, from the published statistics: a
    row for each quantity and statistic."""
    rows = []
    for k, statistic in enumerate(("mean", "median")):
        for name, others in human(k).items():
            total = 1.0 + others
            ratios = others / total, total / others, 1.0 / others, 100.0 / total
            rows.append((name, statistic, *ratios))
    return rows


def _human_table(recomputed: list[tuple]) -> Table:
    published = ("published, over other forces", "about", None, DOMINANCE, None, None)
    columns = (
        "quantity",
        "statistic",
        "other / total",
        "total / other",
        "gravity / other",
        "gravity's share %",
    )
    title = "Human manipulation, from the published statistics"
    return Table("human", title, columns, (*recomputed, published))


def _objects_table() -> Table:
    mass, radius = HUMAN["object mass kg"][0], HUMAN["object radius m"][0]
    own = float(np.mean([thing(name).held.parameters.mass for name in OBJECTS]))
    title = f"YCB, {YCB_OBJECTS} objects, published"
    rows = (
        (title, mass, radius, mass * G, mass * G * radius),
        ("modular object, eight configurations", own, None, own * G, None),
    )
    columns = (
        "objects",
        "mean mass kg",
        "mean radius m",
        "weight N",
        "its torque at the radius N m",
    )
    return Table("objects", "Object statistics", columns, rows)


def _simulated_table(
    results: Results, shares: dict[str, dict[float, np.ndarray]]
) -> Table:
    """Motion at each speed, and gravity's `shares` (objects,) by quantity and speed."""
    rows = []
    for s in next(iter(shares.values())):
        motion = (_mean(results, s, name) for name in MOTION)
        percent = (100.0 * float(each[s].mean()) for each in shares.values())
        times = (float(np.mean(1.0 / (1.0 - each[s]))) for each in shares.values())
        rows.append((s, SPEEDS[s], *motion, *percent, *times))
    columns = (
        "rad/s",
        "published m/s",
        "sensor m/s",
        "COM m/s",
        "sensor m/s²",
        "rad/s²",
        "share in force %",
        "share in torque %",
        "force: total / other",
        "torque: total / other",
    )
    title = "Gravity's share on the simulated motions, mean over the objects"
    return Table("simulated", title, columns, rows)


def _notes(recomputed: list[tuple]) -> tuple[str, ...]:
    factors = [row[3] for row in recomputed if row[1] == "mean"]
    return (
        'Published: gravity dominates "by a factor of about five" in daily living. From the means of the paper\'s '
        f"table I the total is {min(factors):.1f} to {max(factors):.1f} times the non-gravitational part, "
        f"{factors[1]:.2f} times when the object's rotation about the hand counts: the claim is reproduced as total "
        f"over other; gravity alone over other is one less, {factors[1] - 1.0:.2f}.",
        f"The mean mass and radius of {YCB_OBJECTS} objects of the Yale-CMU-Berkeley set are the paper's: the data set "
        "is not part of this project, so they were not computed again.",
    )


def _mean(results: Results, speed: float, name: str) -> float:
    return float(
        np.mean([result[name] for job, result in results if job["speed"] == speed])
    )


def _figure(speeds: list[float], shares: dict[str, dict[float, np.ndarray]]):
    with drawing(2.5) as figure:
        axes = figure.subplots()
        for (part, found), colour, marker in zip(
            shares.items(), (BLUE, VERMILION), "os", strict=True
        ):
            values = 100.0 * np.array([found[s] for s in speeds])
            line = marked(colour, marker)
            axes.plot(
                speeds, values.mean(axis=1), label=f"{part}: mean and range", **line
            )
            axes.fill_between(
                speeds,
                values.min(axis=1),
                values.max(axis=1),
                color=colour,
                alpha=0.2,
                linewidth=0.0,
            )
        ratio = human(0)["force, with the rotation"]
        place = HUMAN["angular velocity rad/s"][0]
        axes.plot(
            place,
            100.0 / (1.0 + ratio),
            "*",
            color=INK,
            markersize=7.0,
            label="human (published means)",
        )
        mark_limit(axes)
        axes.set(
            xlabel="average angular speed [rad/s]",
            ylabel="gravity's share [%]",
            ylim=(0.0, 102.0),
        )
        legend_above(figure, axes, 2)
    return figure


EXPERIMENT = Experiment(
    "gravity",
    "Gravity as the dominating force",
    "Section III-A and table I: human manipulation in daily living",
    jobs,
    run,
    report,
)
