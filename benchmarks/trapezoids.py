"""`python -m benchmarks.trapezoids [--seeds N] [--quick]`: what smoothing costs where the
acceleration jumps.

A simulated UR5 makes trapezoid moves with rests between, and for comparison random
smooth motion, with a hammer or the paper's tee in its hand. The inertia about the sensor
is identified from noisy poses and from the exact motion, and the standard deviations
that the smoother claims are compared with its errors, near the jumps and elsewhere. A
minute for ten seeds.
"""

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    import numpy as np

    from hefting.core.recording import Recording
    from hefting.shapes import Shape
    from hefting.simulation import HeldObject, JointMotion, Wielding

SEEDS, QUICK_SEEDS = 10, 1
DURATION, QUICK_DURATION = 12.0, 6.0
"""Length of a recording [s]."""
RATES = (100.0, 500.0)
"""Samples of poses and wrench per second."""
MOVES = ((0.6, 1.2), (1.05, 1.4), (1.5, 4.0), (2.0, 8.0))
"""Speed [rad/s] and acceleration [rad/s²] of the fastest joint of a trapezoid move."""
SPEEDS = (0.5, 0.8, 1.2, 1.8)
"""Mean angular speed of the random smooth motions [rad/s]."""
WRENCH_NOISE = (0.1, 0.1, 0.1, 0.005, 0.005, 0.005)
"""Standard deviations [N (3), N m (3)]; the poses' are those of a cobot (0.1 mm, 0.02°)."""
METHODS = ("Bayes", "GEO")
DISTANCES = (0.02, 0.06, 0.15)
"""[s] Distances from the nearest jump that separate the neighbourhoods."""
STILL = 1e-9
"""[rad/s²] Changes of a joint's acceleration below this are rounding."""


@dataclass(frozen=True, eq=False)
class Case:
    """A simulated recording."""

    kind: str
    """``"trapezoids"`` or ``"random"``"""
    rate: float
    """[Hz]"""
    level: int
    """index of its speed"""
    seed: int
    held: "HeldObject"
    shape: "Shape"
    wielding: "Wielding"
    recording: "Recording"


def main() -> None:
    """Print errors with smoothed and with exact motion, and how true the deviations
    are."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.trapezoids", description=main.__doc__
    )
    parser.add_argument("--seeds", type=int, help=f"of each kind; {SEEDS} by default")
    parser.add_argument(
        "--quick", action="store_true", help="one short recording of each kind"
    )
    arguments = parser.parse_args()
    seeds = arguments.seeds or (QUICK_SEEDS if arguments.quick else SEEDS)
    duration = QUICK_DURATION if arguments.quick else DURATION
    print(
        "Error of the inertia about the sensor [% of its norm], median and 90th "
        "percentile"
    )
    print(f"{'':34}{'smoothed':16}{'exact':16}{'ratio':14}in pairs")
    for kind in ("trapezoids", "random"):
        for rate in RATES:
            show(kind, rate, list(cases(kind, rate, seeds, duration)))


def cases(kind: str, rate: float, seeds: int, duration: float) -> Iterator[Case]:
    """Recordings of a kind at a rate, of all speeds and seeds."""
    from hefting.simulation import (
        UR5,
        Faults,
        HeldObject,
        Rates,
        hammer,
        held_modular,
        record,
        wield_analytically,
    )
    from hefting.simulation.demo import POSE

    objects = (HeldObject.of(hammer(), POSE), held_modular("Tee"))
    shapes = [held.points() for held in objects]
    for level in range(len(MOVES)):
        for seed in range(seeds):
            which = (seed + level) % 2
            held = objects[which]
            joints = moves(kind, rate, level, seed, duration)
            wielding = wield_analytically(UR5, joints, held.parameters)
            faults = Faults(wrench_noise=WRENCH_NOISE)
            log = record(wielding, faults, Rates(), seed)
            yield Case(kind, rate, level, seed, held, shapes[which], wielding, log)


def moves(
    kind: str, rate: float, level: int, seed: int, duration: float
) -> "JointMotion":
    """Motion of the joints; seeds are those of no test."""
    from hefting.simulation import random_smooth, trapezoids

    if kind == "random":
        return random_smooth(duration, rate, SPEEDS[level], seed=100 + seed)
    return trapezoids(duration, rate, *MOVES[level], seed=100 + seed)


def show(kind: str, rate: float, found: list[Case]) -> None:
    """Print the rows of one kind of motion at one rate."""
    import numpy as np

    every = np.array([[errors_of(case, log(case)) for log in LOGS] for case in found])
    levels = np.array([case.level for case in found])
    for index, method in enumerate(METHODS):
        errors = every[..., index]
        for level in (None, *range(len(MOVES))):
            chosen = errors if level is None else errors[levels == level]
            name = f"{kind} {rate:.0f} Hz {method} {speed(kind, level)}"
            print(f"{name:34}{shown(chosen)}", flush=True)
    for name, quantity in (("a", "linear"), ("alpha", "angular")):
        print(
            f"{kind} {rate:.0f} Hz, claimed deviation of {name} over its error: "
            f"{claims(found, quantity)}",
            flush=True,
        )


def speed(kind: str, level: int | None) -> str:
    """What the rows of one speed are called."""
    if level is None:
        return "all"
    return str(SPEEDS[level] if kind == "random" else MOVES[level])


def shown(errors: "np.ndarray") -> str:
    """Columns of a row, of errors (n, 2) with smoothed and with exact motion."""
    import numpy as np

    median, high = np.median(errors, axis=0), np.percentile(errors, 90, axis=0)
    pairs = np.median(errors[:, 0] / errors[:, 1])
    columns = [
        f"{100 * a:.2f} {100 * b:.2f}" for a, b in zip(median, high, strict=True)
    ]
    ratio = f"{median[0] / median[1]:.2f} {high[0] / high[1]:.2f}"
    return f"{columns[0]:16}{columns[1]:16}{ratio:14}{pairs:.2f}"


def smoothed_log(case: Case) -> "Recording":
    """The recording as it is."""
    return case.recording


def exact_log(case: Case) -> "Recording":
    """The recording with exact poses, velocities and accelerations beside the same
    wrench."""
    from dataclasses import replace

    from scipy.spatial.transform import Rotation

    from hefting.core.recording import Stream

    motion = case.wielding.motion
    columns = {
        "position": motion.position,
        "orientation": Rotation.from_matrix(motion.rotation).as_quat(),
        "linear_velocity": motion.linear_velocity,
        "angular_velocity": motion.angular_velocity,
        "linear_acceleration": motion.linear_acceleration,
        "angular_acceleration": motion.angular_acceleration,
    }
    streams = {name: Stream(motion.time, values) for name, values in columns.items()}
    return replace(case.recording, streams={**case.recording.streams, **streams})


LOGS: tuple[Callable[[Case], "Recording"], ...] = (smoothed_log, exact_log)


def errors_of(case: Case, log: "Recording") -> list[float]:
    """Relative error of the inertia about the sensor by each method."""
    import numpy as np

    from hefting import identify

    results = identify(log, case.shape, method=list(METHODS)).results
    truth = case.held.parameters.inertia_at_origin
    return [
        float(
            np.linalg.norm(results[method].parameters.inertia_at_origin - truth)
            / np.linalg.norm(truth)
        )
        for method in METHODS
    ]


def claims(found: list[Case], quantity: str) -> str:
    """Root mean square of the claimed deviations over that of the errors: of all
    samples, and by distance from the nearest jump."""
    import numpy as np

    from hefting.motion import smooth

    name = f"{quantity}_acceleration"
    claimed, missed, distance = [], [], []
    for case in found:
        log = case.recording
        motion = smooth(
            log["position"].time, log["position"].values, log["orientation"].values
        )
        truth = getattr(case.wielding.measurements, name)
        claimed.append(np.square(getattr(motion, f"{name}_std")))
        missed.append(np.mean((getattr(motion, name) - truth) ** 2, axis=1))
        distance.append(from_jump(case))
    variance, square, apart = map(np.concatenate, (claimed, missed, distance))

    def ratio(chosen: "np.ndarray") -> str:
        return f"{np.sqrt(variance[chosen].sum() / square[chosen].sum()):.2f}"

    words = [f"{ratio(apart >= 0.0)} overall"]
    if np.isfinite(apart).any():
        for near, far in zip((0.0, *DISTANCES), (*DISTANCES, np.inf), strict=True):
            inside = (apart >= near) & (apart < far)
            words.append(f"{ratio(inside)} at {1e3 * near:.0f} to {1e3 * far:.0f} ms")
    return ", ".join(words)


def from_jump(case: Case) -> "np.ndarray":
    """(K,) [s] time from the nearest jump of the acceleration; infinite for random
    motion."""
    import numpy as np

    joints = case.wielding.joints
    if case.kind == "random":
        return np.full(len(joints.time), np.inf)
    change = np.abs(np.diff(joints.acceleration, axis=0)).max(axis=1)
    jumps = joints.time[1:][change > STILL] - 0.5 / case.rate
    return np.abs(joints.time[:, None] - jumps).min(axis=1)


if __name__ == "__main__":
    main()
