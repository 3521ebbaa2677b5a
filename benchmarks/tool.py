"""`python -m benchmarks.tool [--seeds N]`: an object beside a gripper that was measured
before, and the object alone.

RMS errors of mass, centre of mass and inertia about the sensor, and how often the truth
lies within the standard deviations. Three minutes for two hundred seeds.
"""

import argparse
import os
import sys
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path += [str(TESTS), str(TESTS / "ingest")]


def main() -> None:
    """Print both rows."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.tool", description=main.__doc__
    )
    parser.add_argument(
        "--seeds", type=int, default=200, help="recordings of each kind"
    )
    arguments = parser.parse_args()

    import numpy as np
    from test_tool import OBJECT, beside_a_gripper, errors

    found = [beside_a_gripper(seed) for seed in range(arguments.seeds)]
    root = [
        np.sqrt(
            np.mean(np.square([errors(pair[i].parameters) for pair in found]), axis=0)
        )
        for i in (0, 1)
    ]
    for i, name in enumerate(("alone", "beside a gripper")):
        z = [
            (pair[i].parameters.vector - OBJECT.vector)
            / np.sqrt(pair[i].covariance.diagonal())
            for pair in found
        ]
        inside = [100.0 * np.mean(np.abs(z) < limit) for limit in (1.0, 1.96)]
        groups = "/".join(
            f"{np.sqrt(np.mean(np.square(np.array(z)[:, part]))):.2f}"
            for part in GROUPS
        )
        print(
            f"{name:17} mass {1e3 * root[i][0]:.2f} g, COM {1e3 * root[i][1]:.2f} mm, inertia {root[i][2]:.2e} kg m²; "
            f"rms z (mass/COM/inertia) {groups}; within 1 std {inside[0]:.1f} %, 1.96 std {inside[1]:.1f} %"
        )
    print(f"ratio             {np.round(root[1] / root[0], 2)}")


GROUPS = (slice(1), slice(1, 4), slice(4, 10))

if __name__ == "__main__":
    main()
