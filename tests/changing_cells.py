"""Cells of a recording without a motion behind them: random features, a body, a bias,
noise of one."""

from dataclasses import replace

import numpy as np

from hefting.ingest.changes.cells import Cells


def body(mass: float, *center: float) -> np.ndarray:
    first = mass * np.array(center or (0.0, 0.0, 0.1))
    return np.concatenate(([mass], first, np.full(6, 1e-3)))


def random_cells(rng: np.random.Generator, M: int, change: int | None = None) -> Cells:
    """Cells of unit noise with a body, from a cell on another one, and a bias."""
    time = 0.1 * np.arange(M)
    speed, phase = rng.uniform(0.5, 4.0, 12), rng.uniform(0.0, 6.0, 12)
    size = np.repeat((5.0, 2.0, 1.0), (3, 3, 6))
    features = size * np.sin(speed * time[:, None] + phase)
    none = np.zeros((M, 9))
    cells = Cells(time, time, time, features, none, none[:, :6], np.ones(2))
    wrench = cells.regressor @ body(20.0) + rng.normal(size=(M, 6)) + 3.0
    if change is not None:
        wrench[change:] += cells.regressor[change:] @ body(5.0, 0.1, 0.2, 0.3)
    return replace(cells, wrench=wrench)
