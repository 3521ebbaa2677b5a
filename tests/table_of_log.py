"""A table of canonical columns, as a data frame."""

import numpy as np
import pandas as pd

HEADER = ("time", "px", "py", "pz", "qx", "qy", "qz", "qw")
HEADER += ("fx", "fy", "fz", "tx", "ty", "tz")
WRENCH = HEADER[-6:]


def table(count: int = 30) -> pd.DataFrame:
    """Canonical columns."""
    rng = np.random.default_rng(1)
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    parts = (0.01 * np.arange(count)[:, None], rng.normal(size=(count, 3)), q)
    return pd.DataFrame(
        np.hstack((*parts, rng.normal(size=(count, 6)))), columns=list(HEADER)
    )
