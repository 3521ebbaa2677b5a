"""`python -m benchmarks.clean [--recordings N]`: the verdict on recordings without any
mistake.

Thirteen kinds of motion, from 0.1 to 2.5 rad/s, objects of 50 g to 5 kg, three levels of noise, a biased sensor;
every other one with a shape. Printed is how many get a verdict below good, by cause, and
how much of the time of an identification the search for mistakes takes.
"""

import argparse
import os
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

DURATION, RATE = 12.0, 100.0
POSES = 30
"""Static poses of a recording that has them."""
MOTIONS = (
    *("sinusoids 0.5", "sinusoids 1", "sinusoids 2"),
    *("random 0.7", "random 1.5", "random 2.5"),
    *("stop-and-go", "trapezoids", "static", "slow"),
    *("random 0.1", "random 0.3", "slow trapezoids"),
)
LEVELS = ("low", "moderate", "high")
UNDETERMINED = frozenset({"mass-undetermined", "sign-uncertain", "bias-unknown"})
"""Codes that say that the recording is too poor for the object."""


@dataclass(frozen=True)
class Verdict:
    """What was said of one recording."""

    motion: str
    noise: str
    mass: float
    level: str
    reasons: tuple[str, ...]
    seconds: float
    """of processor time of the identification"""
    judging: float
    """of processor time of the search for mistakes within it"""


def recording(number: int):
    """The recording of a number, and its shape where it has one."""
    made, body, motion, level, mass = simulated(number, DURATION)
    return made, body.shape if number % 2 else None, motion, level, mass


def simulated(number: int, duration: float, wrench_delay: float = 0.0):
    """The recording of a number, with the body it is of, the motion, the level of noise
    and the mass; `duration` and `wrench_delay` in s."""
    from benchmarks.bodies import FILLINGS, random_body
    from hefting.core.inertia import InertialParameters
    from hefting.core.recording import Recording, Stream
    from hefting.core.spatial import STANDARD_GRAVITY
    from hefting.simulation import UR5, random_smooth, sinusoids, stop_and_go
    from hefting.simulation.faults import WRENCH_NOISE, Faults, record
    from hefting.simulation.joints import trapezoids
    from hefting.simulation.wield import wield_analytically

    rng = np.random.default_rng([17, number])
    motion, level = MOTIONS[number % len(MOTIONS)], LEVELS[(number // len(MOTIONS)) % 3]
    body = random_body(list(FILLINGS)[number % len(FILLINGS)], 70_000 + number)
    # as heavy as things of its size are
    densest = 3_000.0 * float(body.mesh.convex_hull.volume)
    mass = min(float(np.exp(rng.uniform(np.log(0.05), np.log(5.0)))), densest)
    thing = InertialParameters(body.parameters.vector * mass / body.parameters.mass)
    kind, _, speed = motion.partition(" ")
    kind = motion if motion == "slow trapezoids" else kind
    joints = {
        "sinusoids": lambda: sinusoids(duration, RATE, float(speed or 1.0)),
        "random": lambda: random_smooth(duration, RATE, float(speed or 1.0), number),
        "stop-and-go": lambda: stop_and_go(duration, RATE, seed=number),
        "trapezoids": lambda: trapezoids(duration, RATE, seed=number),
        "slow trapezoids": lambda: trapezoids(duration, RATE, 0.2, 0.3, seed=number),
        "static": lambda: random_smooth(duration, RATE, 2.0, number),
        "slow": lambda: sinusoids(duration, RATE, 1.0, speed_limit=0.25),
    }[kind]()
    wielding = wield_analytically(UR5, joints, thing, STANDARD_GRAVITY)
    bias = np.repeat((3.0, 0.15), 3) * rng.uniform(-1.0, 1.0, 6)
    wrong = Faults(
        wrench_noise=WRENCH_NOISE[level],
        bias=tuple(bias),  # type: ignore[arg-type]
        wrench_delay=wrench_delay,
    )
    made = record(wielding, wrong, seed=number)
    if kind == "static":
        rows = np.linspace(0, len(wielding.measurements) - 1, POSES).astype(int)
        gravity = wielding.measurements.gravity[rows]
        force = -mass * gravity
        wrench = np.hstack((force, np.cross(thing.center_of_mass, force))) + bias
        # each is the average over a second
        noise = np.array(WRENCH_NOISE[level]) / RATE**0.5
        wrench += noise * rng.normal(size=wrench.shape)
        index = np.arange(POSES, dtype=float)
        streams = {
            "wrench": Stream(index, wrench),
            "position": Stream(index, made["position"].values[rows]),
            "orientation": Stream(index, made["orientation"].values[rows]),
        }
        made = Recording(streams, static=True, source="simulation")
    return made, body, motion, level, mass


def verdict(number: int) -> Verdict:
    """Identify one."""
    import hefting.ingest.chosen_part as choosing
    from hefting.core.errors import HeftingError
    from hefting.identification import identify

    made, shape, motion, level, mass = recording(number)
    spent = 0.0
    search = choosing.doubt_of

    def timed(case, **how):
        nonlocal spent
        began = time.process_time()
        found = search(case, **how)
        spent += time.process_time() - began
        return found

    choosing.doubt_of = timed
    began = time.process_time()
    try:
        found = identify(made, shape).estimate.verdict
        said = found.level, tuple(reason.code for reason in found.reasons)
    except HeftingError as error:
        said = "refused", (type(error).__name__,)
    finally:
        choosing.doubt_of = search
    seconds = time.process_time() - began
    return Verdict(motion, level, mass, *said, seconds, spent)


def run(count: int, jobs: int = 1) -> list[Verdict]:
    """The verdicts on the first recordings."""
    if jobs == 1:
        return [verdict(number) for number in range(count)]
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(verdict, range(count), chunksize=5))


def doubted(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Those below good for anything but an undetermined parameter."""
    return [
        v
        for v in verdicts
        if v.level != "good"
        and v.level != "refused"
        and not set(v.reasons) & UNDETERMINED
    ]


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.clean")
    parser.add_argument("--recordings", type=int, default=520)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    found = run(arguments.recordings, arguments.jobs)
    print(f"{len(found)} recordings: {dict(Counter(v.level for v in found))}")
    open_ = [v for v in found if set(v.reasons) & UNDETERMINED or v.level == "refused"]
    print(
        f"undetermined: {len(open_)}, the heaviest {max((v.mass for v in open_), default=0.0):.2g} kg"
    )
    below = doubted(found)
    print(
        f"below good for another cause: {len(below)} ({100 * len(below) / len(found):.1f} %)"
    )
    for code, count in Counter(code for v in below for code in v.reasons).most_common():
        where = Counter(f"{v.motion}, {v.noise}" for v in below if code in v.reasons)
        print(
            f"  {code}: {count} ({'; '.join(f'{k} {n}' for k, n in where.most_common(3))})"
        )
    shares = np.array([v.judging / max(v.seconds - v.judging, 1e-9) for v in found])
    total = sum(v.judging for v in found) / sum(v.seconds - v.judging for v in found)
    print(f"search for mistakes: {100 * total:.1f} % of the rest in all, median {100 * np.median(shares):.1f} %, "
          f"90th percentile {100 * np.percentile(shares, 90):.1f} %")  # fmt: skip


if __name__ == "__main__":
    main()
