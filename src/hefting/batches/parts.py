"""A recording without its samples, for identification with others of its object; one too
large for memory window by window."""

import pickle
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

from hefting.core.estimate import Estimate
from hefting.core.recording import Recording
from hefting.identification.partials import condense, identify_parts, what_others_tell
from hefting.ingest.ingested import Ingested
from hefting.logs.windows import needs_windows, windows
from hefting.request.request import identify_requested, reading_of_one
from hefting.request.settings import hyperparameters_of, placed, recording_of
from hefting.shapes import Shape


def is_in_windows(request: SimpleNamespace, log: str) -> bool:
    """Whether a log is read window by window: it is large, and all of it is wanted."""
    is_whole = not request.start and request.duration is None
    has_tare = request.bias.startswith("tare:")
    return is_whole and not has_tare and needs_windows(log)


def estimate_of(request: SimpleNamespace, log: str, shape: Shape | None) -> Estimate:
    """The estimate of the object in a log, in windows where it is large. Errors as for
    `hefting.identify`."""
    if not is_in_windows(request, log):
        return identify_requested(request, log, shape).estimate
    parts = _together(parts_of(request, log, shape))
    told = what_others_tell(parts)
    if any(told):
        parts = _together(parts_of(request, log, shape, told))
    return estimate_of_parts(request, parts, shape)


def _together(parts: Iterable[Ingested]) -> list[Ingested]:
    """All parts, none of which takes more than its bytes while others are made: half of
    what it takes when it is used."""
    packed = deque(pickle.dumps(part) for part in parts)
    return [pickle.loads(packed.popleft()) for _ in range(len(packed))]


def parts_of(
    request: SimpleNamespace,
    log: str,
    shape: Shape | None,
    told: Sequence[Mapping[str, Any]] = (),
) -> Iterator[Ingested]:
    """A recording, or each window of it, condensed; where others tell something of
    them, that is `told` of each."""
    for k, recording in enumerate(_recordings(request, log)):
        reading = reading_of_one(request, recording)
        yield condense(
            recording,
            shape,
            method=request.method,
            hyperparameters=hyperparameters_of(request),
            **(reading | dict(told[k] if k < len(told) else {})),
        )


def estimate_of_parts(
    request: SimpleNamespace, parts: Sequence[Ingested], shape: Shape | None
) -> Estimate:
    """The estimate of the object of which all parts are."""
    return identify_parts(
        parts,
        shape,
        method=request.method,
        hyperparameters=hyperparameters_of(request),
    ).estimate


def _recordings(request: SimpleNamespace, log: str) -> Iterator[Recording]:
    """The recording, or its windows."""
    if is_in_windows(request, log):
        for window in windows(log, request.map):
            yield placed(request, window, log)
    else:
        yield recording_of(request, log)
