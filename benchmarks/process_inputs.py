"""What whole processes are given: a recording with a shape, and two boxes that are moved
alike."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.parties import HERE

GRAVITY = "0,0,-9.80665"
LIGHT, HEAVY = "60 g", "1 kg"
MASSES = {LIGHT: 0.06, HEAVY: 1.0}
"""Objects of the same shape, moved alike [kg]."""


@dataclass(frozen=True)
class Shaped:
    """A recording and the shape of its object, as the command takes them."""

    log: str
    shape: str
    unit: str = "-"
    pose: str = "-"
    gravity: str = GRAVITY

    @property
    def command(self) -> tuple[str, ...]:
        """One identification."""
        more = (
            ("--unit", self.unit),
            ("--object-pose", self.pose),
            ("--gravity", self.gravity),
        )
        given = (word for pair in more if pair[1] != "-" for word in pair)
        return ("-m", "hefting", "identify", self.log, "--shape", self.shape, *given)

    @property
    def twice(self) -> tuple[str, ...]:
        """Two in one process."""
        return (
            str(HERE / "second.py"),
            self.log,
            self.shape,
            self.unit,
            self.pose,
            self.gravity,
        )


def box_recordings(folder: Path) -> str:
    """Write the logs of a light and a heavy box, and say where the box is."""
    from hefting.core.inertia import InertialParameters
    from hefting.core.measurements import NOISE_LEVELS
    from hefting.logs import write_log
    from hefting.simulation import UR5, random_smooth, simulate

    motion = UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=5))
    square = np.square((0.1, 0.06, 0.12))
    for name, mass in MASSES.items():
        inertia = np.diag(mass / 12.0 * (square.sum() - square))
        body = InertialParameters.from_com(mass, (0.0, 0.01, 0.08), inertia)
        write_log(
            simulate(motion, body, noise=NOISE_LEVELS["moderate"], seed=6),
            folder / f"{name}.csv",
        )
    return "box:-0.05,0.05,-0.02,0.04,0.02,0.14"
