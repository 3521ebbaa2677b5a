"""`python -m benchmarks.pose_faults [--seeds N] [--unchecked]`: what faults of the pose
stream cost.

A simulated UR5 wields a hammer in random smooth motion, stop-and-go and trapezoid
moves, for 10 s at 100 Hz, with pose noise of 0, 0.1 and 1 mm. Each recording is then
given glitches, stalls, and poses of a driver that has not begun or has ended, in three
strengths. An answer is good where its errors of mass, centre of mass and inertia are
within 1.3 times the largest of three: that of the recording without the fault, the root
mean square of such recordings, and that of an oracle, who leaves out the faulty poses
by truth. A minute and a half for each seed.
"""

import argparse
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    from hefting.core.recording import Recording
    from hefting.core.spatial import Array, Mask
    from hefting.simulation import Faults, Wielding

SEEDS = 2
DURATION, RATE = 10.0, 100.0
WRENCH_NOISE = (0.1, 0.1, 0.1, 0.005, 0.005, 0.005)
"""Standard deviations [N (3), N m (3)]."""
POSE_NOISE = (0.0, 1e-4, 1e-3)
"""Standard deviations of position [m]; that of orientation is 3.5 rad/m times it."""
MOTIONS = ("random", "stop-and-go", "trapezoids")
FAULTS: dict[str, tuple[dict, ...]] = {
    "small to huge glitches": tuple(
        {"pose_glitches": 0.003, "pose_glitch_size": size}
        for size in ((0.02, 0.2), (0.3, 1.0), (1000.0, 3.0))
    ),
    "many glitches": tuple({"pose_glitches": share} for share in (0.01, 0.02, 0.04)),
    "long glitches": tuple(
        {
            "pose_glitches": 0.01,
            "pose_glitch_duration": lasts,
            "pose_glitch_size": (0.1, 0.5),
        }
        for lasts in (0.02, 0.05, 0.1)
    ),
    "stalls": tuple({"pose_stalls": share} for share in (0.03, 0.06, 0.12)),
    "startup": tuple({"pose_startup": lasts} for lasts in (0.01, 0.1, 1.0)),
    "shutdown": tuple({"pose_shutdown": lasts} for lasts in (0.01, 0.1, 1.0)),
}
"""Faults in three strengths."""
CODES = {
    "stalls": {"poses-frozen"},
    "startup": {"poses-held-at-ends", "pose-glitches"},
    "shutdown": {"poses-held-at-ends", "pose-glitches"},
}
"""Codes of the notes that name each fault; of the others ``pose-glitches``."""
MARGIN = 1.3
"""Ratio of errors up to which an answer is as good as another."""


@dataclass(frozen=True, eq=False)
class Clean:
    """A recording without faults of its poses."""

    wielding: "Wielding"
    faults: "Faults"
    seed: int
    recording: "Recording"
    errors: "Array"
    """(3,) of mass, centre of mass and inertia"""
    codes: set[str]

    def faulty(self, fault: dict) -> tuple["Recording", "Mask"]:
        """The same recording with a fault, and a mask (K,) of its faulty poses."""
        from hefting.simulation import Rates, record

        log = record(self.wielding, replace(self.faults, **fault), Rates(), self.seed)
        changed = log["position"].values != self.recording["position"].values
        return log, changed.any(axis=1)

    def less(self, bad: "Mask") -> "Recording":
        """The recording without poses that an oracle knows to be faulty."""
        streams = dict(self.recording.streams)
        for name in ("position", "orientation"):
            streams[name] = streams[name][~bad]
        return replace(self.recording, streams=streams)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a fault did."""

    fault: str
    strength: int
    ratio: float
    """largest ratio of the errors to those of the recording without the fault, or of
    such recordings"""
    ratio_to_oracle: float
    """the same, or to those of an oracle"""
    named: bool


def main() -> None:
    """Print the shares of good answers and of faults that were named."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.pose_faults", description=main.__doc__
    )
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument(
        "--unchecked", action="store_true", help="take all poses as they are"
    )
    arguments = parser.parse_args()
    if arguments.unchecked:
        from hefting.ingest import unmeasured

        unmeasured.find_discontinuities = lambda *_: None
    found = list(outcomes(range(arguments.seeds)))
    print(f"{'':26}{'good':10}{'but for data lost':20}{'named':10}recordings")
    for fault in FAULTS:
        for strength in range(3):
            chosen = [o for o in found if (o.fault, o.strength) == (fault, strength)]
            good, lost, named = shares(chosen)
            label = f"{fault}, {strength + 1}"
            row = f"{label:26}{good:<10.2f}{lost:<20.2f}{named:<10.2f}"
            print(f"{row}{len(chosen)}")
    good, lost, named = shares(found)
    print(f"{'all':26}{good:<10.3f}{lost:<20.3f}{named:<10.3f}{len(found)}")


def shares(found: list[Outcome]) -> tuple[float, float, float]:
    """Shares of answers as good as without the fault, of answers as good as an
    oracle's, and of faults that were named."""
    n = max(len(found), 1)
    return (
        sum(o.ratio <= MARGIN for o in found) / n,
        sum(o.ratio_to_oracle <= MARGIN for o in found) / n,
        sum(o.named for o in found) / n,
    )


def outcomes(seeds: range, noises: tuple[float, ...] = POSE_NOISE) -> Iterator[Outcome]:
    """Of all faults on all motions."""
    import numpy as np

    for motion in MOTIONS:
        for noise in noises:
            clean = [clean_recording(motion, noise, seed) for seed in seeds]
            typical = np.sqrt(np.mean([c.errors**2 for c in clean], axis=0))
            for each in clean:
                yield from _of_one(each, np.maximum(each.errors, typical))


def _of_one(clean: Clean, usual: "Array") -> Iterator[Outcome]:
    """Outcomes of all faults on one recording, against its usual errors (3,)."""
    import numpy as np

    for fault, strengths in FAULTS.items():
        for strength, parameters in enumerate(strengths):
            log, bad = clean.faulty(parameters)
            if not bad.any():
                continue
            errors, said = answer(log, clean.wielding)
            oracle, _ = answer(clean.less(bad), clean.wielding)
            named = bool(said & CODES.get(fault, {"pose-glitches"}))
            ratio = float(np.max(errors / usual))
            to_oracle = float(np.max(errors / np.maximum(usual, oracle)))
            yield Outcome(fault, strength, ratio, to_oracle, named)


def clean_recording(motion: str, noise: float, seed: int) -> Clean:
    """A recording without faults of its poses, and what is made of it."""
    from hefting.simulation import (
        UR5,
        Faults,
        Rates,
        held_modular,
        random_smooth,
        record,
        stop_and_go,
        trapezoids,
        wield_analytically,
    )

    joints = {
        "random": lambda: random_smooth(DURATION, RATE, 1.0, seed=1000 + seed),
        "stop-and-go": lambda: stop_and_go(DURATION, RATE, seed=1000 + seed),
        "trapezoids": lambda: trapezoids(DURATION, RATE, seed=1000 + seed),
    }[motion]()
    wielding = wield_analytically(UR5, joints, held_modular("hammer").parameters)
    faults = Faults(wrench_noise=WRENCH_NOISE, pose_noise=(noise, 3.5 * noise))
    log = record(wielding, faults, Rates(), seed)
    return Clean(wielding, faults, seed, log, *answer(log, wielding))


def answer(log: "Recording", wielding: "Wielding") -> tuple["Array", set[str]]:
    """Errors (3,) of mass [relative], centre of mass [m] and inertia about the sensor
    [kg m²] by least squares, infinite where there is no answer; and codes of what was
    said."""
    import numpy as np

    from hefting.core.errors import HeftingError
    from hefting.core.messages import codes
    from hefting.core.spatial import vector_to_tensor
    from hefting.ingest.ingest import ingest

    try:
        found = ingest(log)
    except HeftingError:
        return np.full(3, np.inf), set()
    v, truth = found.fit.vector, wielding.body.vector
    errors = (
        abs(v[0] / truth[0] - 1.0),
        np.linalg.norm(v[1:4] / v[0] - truth[1:4] / truth[0]),
        np.linalg.norm(vector_to_tensor(v[4:] - truth[4:])),
    )
    return np.array(errors), codes([*found.notes, *found.warnings])


if __name__ == "__main__":
    main()
