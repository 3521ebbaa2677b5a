"""Several logs of one object, read and ingested as in `hefting.ingest.joint`."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import joint

Log = Recording | str | Path


def ingest_all(recordings: Log | Sequence[Log], **reading: Any) -> Ingested:
    """One recording, or several of the same object, as estimators take them.

    Parameters
    ----------
    recordings : a recording, the path of a log or a table in memory, or a list or
        tuple of these.
    reading : as for `hefting.ingest.ingest.ingest`, of all alike; a ``bias`` may also
        be (n, 6), one for each of n recordings.

    Raises `InputError` as that does, for an empty list, and for a path given twice.
    """
    if not isinstance(recordings, list | tuple):
        return ingest(recordings, **reading)  # type: ignore[arg-type]
    logs = list(recordings)
    _check(logs)
    biases = _biases(reading.pop("bias", "auto"), len(logs))
    own = [reading | {"bias": bias} for bias in biases]
    parts = [ingest(log, **how) for log, how in zip(logs, own, strict=True)]
    for i, again in enumerate(what_others_tell(parts)):
        if again:
            parts[i] = ingest(logs[i], **(own[i] | again))
    return joint(parts, names_of([part.log for part in parts]))


def names_of(logs: Sequence[str]) -> list[str]:
    """Names of the logs: file names if these differ, else whole paths or sources; with
    numbers if those are the same too."""
    names = [Path(log).name or log for log in logs]
    names = [
        n if names.count(n) == 1 else log for n, log in zip(names, logs, strict=True)
    ]
    return [
        n if names.count(n) == 1 else f"{n} ({i})" for i, n in enumerate(names, start=1)
    ]


def what_others_tell(parts: Sequence[Ingested]) -> list[dict[str, Any]]:
    """Arguments of `ingest` for each recording that follow from the others: a bias
    where another has one, and the sign where its own is uncertain."""
    again: list[dict[str, Any]] = [{} for _ in parts]
    biased = any(part.bias == "estimate" for part in parts)
    sure = [part.sign.name for part in parts if part.sign.certain]
    for part, how in zip(parts, again, strict=True):
        if biased and part.bias == "none" and part.given_bias is None:
            how["bias"] = "estimate"
        if part.sign_found and not part.sign.certain and len(set(sure)) == 1:
            how["wrench"] = sure[0]
    return again


def _check(logs: Sequence[Log]) -> None:
    if not logs:
        raise InputError("no recording is given", fix="give at least one")
    paths = [os.path.realpath(log) for log in logs if isinstance(log, str | Path)]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError("is given twice", path, "give each recording once")


def _biases(bias: Any, n: int) -> list[Any]:
    if isinstance(bias, str) or np.ndim(bias) != 2:
        return [bias] * n
    if len(bias) != n:
        what = f"there are {len(bias)} biases for {n} recordings"
        raise InputError(what, fix="give `bias` once for all, or one for each")
    return list(bias)
