"""`python -m benchmarks.live [FILE ...] [--until ...]`: a recording replayed as a robot
would stream it.

Poses and wrenches go in as they were recorded, some milliseconds at a time: poses
through a `PoseFilter`, tuned on the first second, its motion with the wrench of the
same instants into `Bayes`. Nothing is known beforehand but gravity, the wrench's sign
and a coarse box; the bias is found with the object. Prints how estimate and interval
develop.
"""

import argparse
import os
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def main() -> None:
    """Print one history for each recording."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.live", description=main.__doc__
    )
    folder = Path(os.environ.get("HEFTING_DATA", "."))
    default = [folder / "panda-optoforce" / f"{run}.csv" for run in ("run1", "run3")]
    parser.add_argument("files", nargs="*", type=Path, default=default)
    parser.add_argument("--until", default="mass=1%,com=2mm,inertia=20%")
    parser.add_argument("--every", type=float, default=0.5, help="s between estimates")
    arguments = parser.parse_args()

    from benchmarks.live_replay import BOX, Stream, replayed
    from hefting.estimators import Bayes
    from hefting.logs import read_log
    from hefting.shapes import Shape

    for file in arguments.files:
        stream = Stream.of(read_log(file))
        estimator = Bayes(Shape.from_box(*BOX), bias="estimate", until=arguments.until)
        print(
            f"\n{file.name} until {arguments.until}\n   time    mass   95 % interval      sure to (95 %)"
        )
        stopped = None
        for now, estimate in replayed(stream, estimator, arguments.every):
            assert estimate.intervals is not None
            low, high = estimate.intervals["mass"]
            stopped = now if estimate.sufficient and stopped is None else stopped
            print(f"{now:6.1f} s  {estimate.parameters.mass:6.3f}  {low:6.3f} to {high:6.3f}    {estimate.accuracy}"
                  f"{'   sufficient' if estimate.sufficient else ''}", flush=True)  # fmt: skip
        print(
            "never sufficient"
            if stopped is None
            else f"first sufficient after {stopped:.1f} s"
        )


if __name__ == "__main__":
    main()
