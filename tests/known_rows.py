"""Rows of known values under names that other programs give, and what a reading of them is
to be."""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import hefting

ROWS = 40
RNG = np.random.default_rng(11)
TIME = 0.01 * np.arange(ROWS)
POSITION = RNG.uniform(-1.0, 1.0, (ROWS, 3))
TURNS = Rotation.random(ROWS, random_state=5)
QUATERNION = TURNS.as_quat()
WRENCH = RNG.normal(size=(ROWS, 6)) * (5, 5, 5, 0.5, 0.5, 0.5)
CANONICAL = [
    "time",
    "px",
    "py",
    "pz",
    "qx",
    "qy",
    "qz",
    "qw",
    "fx",
    "fy",
    "fz",
    "tx",
    "ty",
    "tz",
]
PLAIN = (TIME, POSITION, QUATERNION, WRENCH)


def frame_of(names: str | list[str], parts: tuple[np.ndarray, ...]) -> pd.DataFrame:
    """The parts side by side under these names."""
    names = names.split() if isinstance(names, str) else names
    return pd.DataFrame(np.column_stack(parts), columns=names)


def same(got: hefting.Recording, turns: Rotation = TURNS) -> bool:
    """Whether a recording holds what was written, apart from when it began."""
    apart = Rotation.from_quat(got["orientation"].values) * turns.inv()
    time = got["wrench"].time - got["wrench"].time[0]
    return (
        # seconds since 1970 resolve 2.4e-7 s; text of 17 digits is exact, and what is
        # converted from millimetres or degrees is rounded again
        np.allclose(time, TIME, atol=5e-7)
        and np.allclose(got["position"].values, POSITION, atol=1e-12)
        and np.allclose(got["wrench"].values, WRENCH, rtol=1e-12)
        and apart.magnitude().max() < 1e-7
    )


def text_of(separator: str = ",", decimal: str = ".") -> list[str]:
    """The canonical log as lines of text."""
    frame = frame_of(CANONICAL, PLAIN)
    return frame.to_csv(index=False, sep=separator, decimal=decimal).splitlines()


LINES = text_of()
