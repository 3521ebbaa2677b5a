"""A known bias of the wrench: measured while nothing was held, or read from a file."""

from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import read_json
from hefting.core.magnitudes import LARGEST, check_magnitude
from hefting.core.recording import Recording
from hefting.core.spatial import Array


def tare(recording: Recording, start: float, end: float) -> Array:
    """Mean wrench while nothing was held.

    Parameters
    ----------
    recording : Recording
        The recording.
    start, end : float
        [s] since the first sample of the recording.

    Returns
    -------
    Array
        (6,) [N, N m], with the sign of the recording.

    Raises
    ------
    InputError
        If there are no wrench samples between the two times.
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
    """Read a bias (6,) [N, N m] from a JSON file, with the sign of the recording.

    The file holds six numbers, or a key ``bias``, as an estimate does. Raises
    `InputError` if it holds no six finite numbers.
    """
    data = read_json(path)
    try:
        values = np.asarray(
            data["bias"] if isinstance(data, dict) else data, dtype=float
        )
        if (
            isinstance(data, dict)
            and (data.get("provenance") or {}).get("wrench") == "on-sensor"
        ):
            # an estimate has the sign of the wrench on the object, the log that on the
            # sensor
            values = -values
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(
            f"holds no bias ({str(error)[:80]})",
            where=path,
            fix='write {"bias": [fx,fy,fz,tx,ty,tz]}',
        ) from error
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError("a bias is six finite numbers [N, N m]", where=path)
    check_magnitude(values, LARGEST["wrench"], "a bias", path)
    return values
