"""`python -m benchmarks.torques [--real N] [--simulated N] [--together N] [--live]`: what
joint torques tell in place of a wrench.

- `--real`: N random bodies added to real torques of a bare arm, in four splits (needs
  the folder that HEFTING_TORQUES names);
- `--simulated`: N objects on each of three arms, an empty run of another motion;
- `--together`: N objects, a wrench and torques of the same recording;
- `--live`: what folding one sample costs, and how large the moments are.

Without any of them `--real 20 --simulated 40`, some ten minutes.
"""

import argparse
import os
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def main() -> None:
    """Print the tables that are asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.torques", description=main.__doc__
    )
    parser.add_argument("--real", type=int, metavar="N", help="20 say")
    parser.add_argument("--simulated", type=int, metavar="N", help="40 say")
    parser.add_argument("--together", type=int, metavar="N", help="20 say")
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if not (given.real or given.simulated or given.together or given.live):
        given.real, given.simulated = 20, 40
    if given.real:
        _real(given.real, given.seed)
    if given.simulated:
        _simulated(given.simulated, given.seed)
    if given.together:
        from benchmarks.torques_together import compare

        _print("together", compare(given.together, given.seed))
    if given.live:
        from benchmarks.torques_live import costs

        _print("live", costs())


def _real(bodies: int, seed: int) -> None:
    from benchmarks.torques_real import BareArm, identified, random_bodies, summary

    bare = BareArm.read(Path(os.environ["HEFTING_TORQUES"]))
    found = {}
    for known in (False, True):
        for name, loaded in bare.splits().items():
            errors = [
                identified(bare, body, loaded, known)
                for body in random_bodies(bodies if not known else 3, seed)
            ]
            found.setdefault(known, []).extend(errors)
            if not known:
                _print(name, summary(errors))
    _print("all", summary(found[False]))
    _print("published arm", summary(found[True]))


def _simulated(objects: int, seed: int) -> None:
    from benchmarks.torques_simulated import cases, summary
    from hefting.simulation.torque_scenario import TORQUE_ARMS

    every = []
    for name in TORQUE_ARMS:
        own = cases(name, objects, seed)
        every += own
        _print(name, summary(own))
    _print("all", summary(every))


def _print(name: str, figures: dict[str, float]) -> None:
    line = ", ".join(f"{key} {value:.3g}" for key, value in figures.items())
    print(f"{name}: {line}", flush=True)


if __name__ == "__main__":
    main()
