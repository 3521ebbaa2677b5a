"""`python -m benchmarks.robustness [--seeds N] [--masses M ...]`: what each disturbance
of a recording costs.

RMS errors of mass, centre of mass and inertia, over those of the clean recordings by
the same least squares; beside them an oracle's, who knows offset, sign, gravity, drift
and bad samples; and how true the standard deviations are. A minute for eight seeds,
five for forty.
"""

import argparse
import os
import sys
import time
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.robustness", description=main.__doc__
    )
    parser.add_argument("--seeds", type=int, default=40, help="recordings of each kind")
    parser.add_argument(
        "--masses", type=float, nargs="+", default=[0.3, 1.5], help="kg, of the objects"
    )
    arguments = parser.parse_args()

    import numpy as np

    from disturbances import (
        GRAVITY,
        KINDS,
        disturbed,
        errors,
        identified,
        identified_after,
        rms,
    )
    from hefting.ingest import condition

    for mass in arguments.masses:
        seeds = range(arguments.seeds)
        clean = [disturbed("clean", mass, seed) for seed in seeds]
        base = rms([errors(identified(d.recording, GRAVITY)[0], d.body) for d in clean])
        print(f"\n{mass} kg, {arguments.seeds} recordings of 10 s; errors of the clean ones: "
              f"mass {100 * base[0]:.3f} %, COM {1e3 * base[1]:.3f} mm, inertia {base[2]:.2e} kg m²")  # fmt: skip
        print(f"{'':10}{'mass COM inertia':20}{'oracle':18}{'z, conditioning':18}{'z, estimator':18}"
              f"{'offset error, median':22}{'mass error, median':20}{'left out (bad)':18}time")  # fmt: skip
        for kind in KINDS:
            rows = []
            oracle = []
            z = []
            z_after = []
            offset = []
            left_out = []
            bad = []
            seconds = []
            for seed in seeds:
                d = disturbed(kind, mass, seed)
                began = time.perf_counter()
                found = condition(d.recording, tilt=kind in ("tilt", "all"))
                seconds.append(time.perf_counter() - began)
                vector, std = identified_after(found, d.recording)
                rows.append(errors(vector, d.body))
                oracle.append(errors(identified(d.repaired, d.gravity)[0], d.body))
                z.append((found.parameters - d.body.vector) / found.std)
                z_after.append((vector - d.body.vector) / std)
                offset.append(abs(found.offset - d.offset))
                left_out.append(found.rejected.mean())
                bad.append(d.bad.mean())

            def three(values) -> str:
                return "/".join(f"{v:.2f}" for v in values)

            def groups(values) -> str:
                return three(
                    rms(np.ravel(np.array(values)[:, part]))
                    for part in (slice(1), slice(1, 4), slice(4, 10))
                )

            cost, least = three(rms(rows) / base), three(rms(oracle) / base)
            print(f"{kind:10}{cost:20}{least:18}{groups(z):18}{groups(z_after):18}"
                  f"{f'{1e3 * np.median(offset):.2f} ms':22}{f'{100 * np.median(np.array(rows)[:, 0]):.3f} %':20}"
                  f"{f'{100 * np.mean(left_out):.1f} ({100 * np.mean(bad):.1f}) %':18}{np.median(seconds):.3f} s",
                  flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
