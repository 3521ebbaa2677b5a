"""One recording of a batch: from what is said of it to its row, in whichever process.

Faults of the machine may pass, and are tried again; those of the input never.
"""

import errno
import json
import pickle
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from time import perf_counter
from types import SimpleNamespace
from typing import Any, TypeVar

from hefting.batches.columns import STAGES, Row, filled
from hefting.batches.content import Signature, hash_of, signature
from hefting.batches.recordings import Entry
from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.progress import listening
from hefting.core.recording import Recording
from hefting.identification.partials import condense, identify_parts, what_others_tell
from hefting.ingest.ingested import Ingested
from hefting.jobs import Lost
from hefting.logs.registry import READING
from hefting.logs.windows import needs_windows, windows
from hefting.request.request import (
    files_of,
    identify_requested,
    reading_of_one,
    request_of,
)
from hefting.request.settings import hyperparameters_of, placed, recording_of, shape_of
from hefting.shapes import Shape

T = TypeVar("T")

OF_SHAPES = ("shape", "unit", "object_pose", "box", "hull", "points", "points_per_cm3")
"""Options by which a shape is given."""
SHAPES = 8
"""Shapes that a process keeps: recordings of one object follow one another."""

PAUSES = (0.5, 2.0)
"""[s] Waited before the second and the third attempt: a server that is busy answers."""

TRANSIENT = frozenset(
    getattr(errno, name)
    for name in (
        *("EIO", "EAGAIN", "ENOMEM", "EMFILE", "ENFILE", "EBUSY", "EINTR", "ESTALE"),
        *("ETIMEDOUT", "ENOTCONN", "EHOSTDOWN", "EHOSTUNREACH", "ENETUNREACH"),
        *("ECONNRESET", "ECONNABORTED", "EREMOTEIO"),
    )
    if hasattr(errno, name)
)
"""Errors of the system that may be gone the next time."""


def row_of(task: tuple[Entry, str | None]) -> Row | None:
    """The row of a recording; of one that fails, why. Raises nothing of an input.

    None where the row that is there already, with the same hash, stays.
    """
    entry, kept = task
    row = start_row(entry)
    with stopwatch() as watch:
        try:
            found = attempted(lambda: _estimate(entry, kept, row))
            row = row if found is None else filled(row, found)
        except Exception as error:
            row |= failure(error)
    if row["error"] is None and "mass" not in row:
        return None
    return row | {"seconds": watch.seconds}


def start_row(entry: Entry) -> Row:
    """What a row has whatever comes of it."""
    return {
        "recording": entry.recording,
        "name": entry.name,
        "object": entry.object,
        "error": None,
        "error_text": None,
        "options": json.dumps(dict(entry.options), sort_keys=True),
        "hash": None,
    }


def failure(error: BaseException) -> Row:
    """What a row says of an error; without a hash where the error may pass, so that it
    is tried again."""
    text = " ".join(str(error).split())
    if not isinstance(error, HeftingError | ChangedError | MemoryError | OSError):
        text = f"unexpected, please report it: {text}"
    if isinstance(error, MemoryError):
        text = "there is not enough memory; use fewer --jobs, or a shorter recording"
    failed = {"error": type(error).__name__, "error_text": text}
    return failed | ({"hash": None} if is_of_machine(error) else {})


def lost(result: Lost) -> Row:
    """What a row says of a recording that no worker survives."""
    text = f"{result.reason}; is it too large? try fewer --jobs"
    return {"error": "WorkerDied", "error_text": text, "hash": None}


def read_unchanged(entry: Entry, do: Callable[[str], T]) -> T:
    """What `do` makes of a recording; it is called with the hash of what that holds.

    Raises `InputError` where its row of the manifest is wrong or it cannot be read,
    `ChangedError` where it changes meanwhile, and what `do` raises.
    """
    before = signature(entry.recording)
    made = do(content_of(entry))
    if signature(entry.recording) != before:
        what = "was written while it was read; `resume` takes it again"
        raise ChangedError(f"{entry.recording}: {what}")
    return made


def _estimate(entry: Entry, kept: str | None, row: Row) -> Estimate | None:
    """The estimate; None where the row that is kept follows from the same."""

    def do(key: str) -> Estimate | None:
        row["hash"] = key
        if key == kept:
            return None
        request = request_of(entry.options)
        return estimate_of(request, entry.recording, shape_once(request))

    return read_unchanged(entry, do)


def content_of(entry: Entry) -> str:
    """Hash of what a recording holds and of what is said of it. `InputError` where its
    row of the manifest is wrong, or it cannot be read."""
    if entry.problem is not None:
        raise InputError(entry.problem)
    try:
        return hash_of(entry.recording, entry.options)
    except OSError as error:
        what = f"cannot be read ({error.strerror or error})"
        raise InputError(what, entry.recording) from error


def shape_once(request: SimpleNamespace) -> Shape | None:
    """The shape that a request means, read once for recordings that follow one
    another."""
    said = {name: getattr(request, name) for name in OF_SHAPES}
    files = {name: signature(file) for name, file in files_of(said).items()}
    return _shape(tuple(said.items()), tuple(files.items()))


@lru_cache(maxsize=SHAPES)
def _shape(
    said: tuple[tuple[str, object], ...],
    _as_they_are: tuple[tuple[str, Signature], ...],
) -> Shape | None:
    return shape_of(SimpleNamespace(**dict(said)))


class ChangedError(Exception):
    """A recording is not what it was when its reading began."""


def is_of_machine(error: BaseException) -> bool:
    """Whether an error, or what caused it, is no fault of the input."""
    causes: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None and cause not in causes:
        causes.append(cause)
        cause = cause.__cause__
    return any(
        isinstance(each, MemoryError | ChangedError | MissingDependencyError)
        or (isinstance(each, OSError) and each.errno in TRANSIENT)
        for each in causes
    )


def attempted(what: Callable[[], T]) -> T:
    """What a call returns; once more after each of `PAUSES` while it fails by a fault
    of the machine. Raises what the last attempt raised."""
    for seconds in PAUSES:
        try:
            return what()
        except Exception as error:
            if not is_of_machine(error) or isinstance(error, MissingDependencyError):
                raise
        time.sleep(seconds)
    return what()


STAGE_OF = {
    READING: "reading",
    "smoothing the motion": "motion",
    "identifying": "solving",
}
"""Stage of what is reported; all else is conditioning."""


class Stopwatch:
    """Time by stage; what comes before the first report is reading."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._stage, self._since = "reading", perf_counter()

    def __call__(self, reported: str, share: float | None = None) -> None:
        """A stage is begun, or goes on."""
        now = perf_counter()
        self._seconds[self._stage] += now - self._since
        self._stage, self._since = STAGE_OF.get(reported, "conditioning"), now

    @property
    def seconds(self) -> dict[str, float]:
        """[s] by stage, up to now."""
        going_on = perf_counter() - self._since
        return self._seconds | {self._stage: self._seconds[self._stage] + going_on}


@contextmanager
def stopwatch() -> Generator[Stopwatch, None, None]:
    """A stopwatch of what is reported meanwhile; warnings are not shown."""
    watch = Stopwatch()
    with listening(watch), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of NumPy: what matters is a message
        yield watch


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
