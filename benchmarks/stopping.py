"""`python -m benchmarks.stopping [--streams N] [--until ...]`: whether what the stop
rule promises holds, and how soon.

Random bodies of six kinds (`benchmarks.bodies`) are wielded for ten seconds at 100 Hz,
each in one of nine motions and at one of three noise levels. Every tenth of a second a
new estimate; the first sufficient one is kept. Some minutes.
"""

import argparse
import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def main() -> None:
    """Print the shares of streams in which each promise held, and when they stopped."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.stopping", description=main.__doc__
    )
    parser.add_argument("--streams", type=int, default=500)
    parser.add_argument("--until", default="mass=1%,com=2mm,inertia=20%")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()

    import numpy as np

    from benchmarks.bodies import FILLINGS, random_body
    from benchmarks.stopping_runs import streamed

    kinds = list(FILLINGS)
    stops = []
    for i in range(arguments.streams):
        body = random_body(kinds[i % len(kinds)], arguments.seed * 1000 + i)
        stops.append(streamed(body, arguments.until, (arguments.seed, i)))

    def line(name: str, chosen: list) -> None:
        ended = [stop for stop in chosen if stop.time is not None]
        times = np.array([10.0 if stop.time is None else stop.time for stop in chosen])
        held = (
            100.0 * np.mean([stop.held for stop in ended], axis=0)
            if ended
            else np.full(3, np.nan)
        )
        print(f"{name:14}{len(chosen):8}{len(ended):8}   {np.median(times):6.2f} s   "
              f"{'  '.join(f'{share:5.1f} %' for share in held)}")  # fmt: skip

    print(
        f"until {arguments.until}\n{'':14}{'streams':>8}{'ended':>8}   median     mass     COM      inertia hold"
    )
    line("all", stops)
    for kind in kinds:
        line(kind, [stop for stop in stops if stop.kind == kind])
    for level in ("low", "moderate", "high"):
        line(f"{level} noise", [stop for stop in stops if stop.level == level])
    for motion in ("sinusoids", "random", "stop and go"):
        line(motion, [stop for stop in stops if stop.motion == motion])


if __name__ == "__main__":
    main()
