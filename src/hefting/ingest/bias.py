"""A bias of the wrench that is known: measured while nothing was held, or kept in a
file."""

from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import read_json
from hefting.core.recording import Recording
from hefting.core.spatial import Array


def tare(recording: Recording, start: float, end: float) -> Array:
    """Mean wrench (6,), as recorded, between two times [s] counted from the first
    sample, when nothing was held.

    Raises `InputError` when no wrench was measured then.
    """
    wrench = recording["wrench"]
    chosen = (wrench.time >= recording.start + start) & (
        wrench.time <= recording.start + end
    )
    if not chosen.any():
        raise InputError(
            f"no wrench between {start:g} and {end:g} s to tare with",
            where=recording.source,
        )
    return wrench.values[chosen].mean(axis=0)


def load_bias(path: str | Path) -> Array:
    """Bias (6,) [N, N m] of a JSON file: its ``bias`` key, as in an estimate, or six
    numbers."""
    data = read_json(path)
    try:
        values = np.asarray(
            data["bias"] if isinstance(data, dict) else data, dtype=float
        )
        if (
            isinstance(data, dict)
            and (data.get("provenance") or {}).get("wrench") == "on-sensor"
        ):
            # an estimate holds it in the project's sign, a log in the sensor's
            values = -values
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(
            f"holds no bias ({str(error)[:80]})",
            where=path,
            fix='write {"bias": [fx,fy,fz,tx,ty,tz]}',
        ) from error
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError("a bias is six finite numbers [N, N m]", where=path)
    return values
