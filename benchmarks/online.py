"""`python -m benchmarks.online [faulty|swapped|until|recorded|long] [--seeds N]`: the
live pipeline on streams that are played as fast as it goes.

faulty: simulated streams with 30 ms delay, 20 N of drifting bias, the other sign,
spikes and touches; how often the 95 % intervals hold at 2, 5 and 10 s. until: the same,
how often what `until` promises holds where it is said first. swapped: the object is
swapped at 6 s; how often that is noticed, how soon, and how often in streams without
(half of the seeds each). recorded: the recordings of HEFTING_DATA; the last live answer
before the end against that of all samples. long: ten minutes of 1 kHz in real time;
memory, and how long `add` takes.
"""

import argparse
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    from hefting.core.recording import Recording
    from hefting.online.live_estimate import LiveEstimate

INSTANTS = (2.0, 5.0, 10.0)
"""[s]"""
UNTIL = "mass=2%,com=3mm"
RECORDINGS = (
    "panda-optoforce/run1",
    "panda-optoforce/run3",
    "kuka-ati/baseline",
    "kuka-ati/vibrations",
    "axia80/dwells",
)


def played(recording: "Recording", **options: Any) -> "Iterator[LiveEstimate]":
    """Live estimates of a recording, without the final answer."""
    from benchmarks.online_streams import parts
    from hefting.online import LiveIdentifier

    live = LiveIdentifier(in_process=False, **options)
    for samples in parts(recording, live.period):
        for each in samples:
            live.add(each)
        now = live.step()
        if now is not None:
            yield now


def held(estimate: Any, body: Any) -> "list[bool]":
    """Whether the intervals of mass, COM and inertia hold a body's."""
    import numpy as np

    truth = {
        "mass": np.atleast_1d(body.mass),
        "center_of_mass": body.center_of_mass,
        "inertia_at_com": body.inertia_at_com[np.triu_indices(3)],
    }
    found: list[bool] = []
    for name, value in truth.items():
        low, high = np.asarray(estimate.interval(name))
        if name == "inertia_at_com":
            low, high = low[np.triu_indices(3)], high[np.triu_indices(3)]
        inside = (np.atleast_1d(low) <= value) & (value <= np.atleast_1d(high))
        found += inside.tolist()
    return found


def faulty(seeds: int) -> None:
    """Print how often the intervals hold."""
    import numpy as np

    from benchmarks.online_streams import faulty as stream

    at: dict[float, list[list[bool]]] = {instant: [] for instant in INSTANTS}
    absent = dict.fromkeys(INSTANTS, 0)
    alarms = 0
    for seed in range(seeds):
        case, last = stream(seed, 10.2), None
        left = list(INSTANTS)
        for now in played(case.recording):
            last = now
            while left and now.time >= left[0] - 1e-6:
                instant = left.pop(0)
                if now.estimate is None:
                    absent[instant] += 1
                else:
                    at[instant].append(held(now.estimate, case.body))
        alarms += last is not None and last.object > 1
    for instant, rows in at.items():
        share = 100.0 * np.array(rows, dtype=float).reshape(-1, 10)
        mass, com, inertia = share[:, 0], share[:, 1:4], share[:, 4:]
        print(
            f"{instant:4g} s: {len(rows)} answers, {absent[instant]} none yet; hold "
            f"{share.mean():.1f} % (mass {mass.mean():.1f}, COM {com.mean():.1f}, "
            f"inertia {inertia.mean():.1f})"
        )
    print(f"taken for another object: {alarms} of {seeds}")


def until(seeds: int) -> None:
    """Print how often the promise of `until` holds where it is said first."""
    import numpy as np

    from benchmarks.online_streams import faulty as stream

    kept, times = [], []
    for seed in range(seeds):
        case = stream(seed, 15.0)
        for now in played(case.recording, until=UNTIL):
            if now.sufficient and now.estimate is not None:
                body, found = case.body, now.estimate
                off = np.abs(found.center_of_mass - body.center_of_mass).max()
                right = abs(found.mass - body.mass) <= 0.02 * body.mass
                kept.append(right and off <= 0.003)
                times.append(now.time)
                break
    share = 100.0 * float(np.mean(kept)) if kept else np.nan
    print(
        f"until {UNTIL}: said in {len(kept)} of {seeds}, at {np.median(times):.1f} s "
        f"(median), kept in {share:.1f} %"
    )


def swapped(seeds: int) -> None:
    """Print how often another object is noticed, and how often where there is none."""
    import numpy as np

    from benchmarks.online_streams import swapped as stream

    delays, missed, early, alarms = [], [], 0, 0
    for seed in range(seeds):
        for change in (True, False):
            case = stream(seed, change, duration=9.0, time=6.0)
            seen = next((e.time for e in played(case.recording) if e.object > 1), None)
            if not change:
                alarms += seen is not None
            elif seen is None or case.other is None:
                missed.append(seed)
            elif seen < 6.0:
                early += 1
            else:
                delays.append(seen - 6.0)
    soon = int(np.sum(np.array(delays) <= 2.0))
    print(
        f"swapped: {soon} of {seeds} noticed within 2 s, median "
        f"{np.median(delays):.2f} s, longest {max(delays):.2f} s; never {missed}, "
        f"before it was {early}; undisturbed: {alarms} of {seeds} false alarms"
    )


def recorded(_: int) -> None:
    """Print how far the last live answers are from those of all samples."""
    import numpy as np

    from hefting import identify, read_log

    for name in RECORDINGS:
        log = read_log(Path(os.environ["HEFTING_DATA"]) / f"{name}.csv")
        whole, last = identify(log), None
        for now in played(log):
            last = now
        assert last is not None
        assert last.estimate is not None
        found, std = last.estimate, whole.estimate.std
        assert std is not None
        offset = found.provenance["clock_offset"] - whole.ingested.conditioned.offset
        mass = (found.mass - whole.mass) / std["mass"]
        com = (found.center_of_mass - whole.center_of_mass) / std["center_of_mass"]
        same = found.provenance["wrench"] == whole.ingested.sign.name
        print(
            f"{name:22} mass {mass:+.2f} std, COM {np.round(com, 2)} std, offset "
            f"{1e3 * offset:+.1f} ms, {'same' if same else 'OTHER'} sign, bias "
            f"{whole.ingested.conditioned.bias.kind}, object {last.object}",
            flush=True,
        )


def long(minutes: int) -> None:
    """Print memory and the times of `add`, of a stream of 1 kHz in real time."""
    from benchmarks.online_pace import run

    run(minutes)


def main() -> None:
    """Print what was asked for."""
    kinds: dict[str, Callable[[int], None]] = {
        "faulty": faulty,
        "until": until,
        "swapped": swapped,
        "recorded": recorded,
        "long": long,
    }
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.online", description=__doc__
    )
    parser.add_argument("kind", choices=kinds)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--minutes", type=int, default=10)
    arguments = parser.parse_args()
    is_long = arguments.kind == "long"
    kinds[arguments.kind](arguments.minutes if is_long else arguments.seeds)


if __name__ == "__main__":
    main()
