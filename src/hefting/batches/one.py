"""One recording of a batch: from its path and options to its row, in any process.

After a fault of the machine, which may pass, it is tried again; after one of the input
it is not.
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

from hefting.batches.columns import STAGES, Row, Signature, filled, hash_of, signature
from hefting.batches.recordings import Entry
from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import json_ready
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
    request_of,
)
from hefting.request.settings import (
    hyperparameters_of,
    placed,
    reading_of,
    recording_of,
    require_shape,
    shape_of,
)
from hefting.shapes import Shape

T = TypeVar("T")

OF_SHAPES = ("shape", "unit", "object_pose", "box", "hull", "points", "points_per_cm3")
"""Options by which a shape is given."""
SHAPES = 8
"""Number of shapes that a process keeps, as recordings of one object follow one
another."""

PAUSES = (0.5, 2.0)
"""[s] Waits before the second and the third attempt, for a busy server to answer."""

TRANSIENT = frozenset(
    getattr(errno, name)
    for name in (
        *("EIO", "EAGAIN", "ENOMEM", "EMFILE", "ENFILE", "EBUSY", "EINTR", "ESTALE"),
        *("ETIMEDOUT", "ENOTCONN", "EHOSTDOWN", "EHOSTUNREACH", "ENETUNREACH"),
        *("ECONNRESET", "ECONNABORTED", "EREMOTEIO"),
    )
    if hasattr(errno, name)
)
"""Numbers of system errors that may not occur again."""


def row_of(task: tuple[Entry, str | None]) -> Row | None:
    """The row of a recording, with the estimate or with the error.

    `task` is the recording and the hash of its row of an earlier run, if any. None
    where that hash is the recording's, so that the earlier row is kept.
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
    """The row of a recording before its identification."""
    return {
        "recording": entry.recording,
        "name": entry.name,
        "object": entry.object,
        "error": None,
        "error_text": None,
        "options": json.dumps(json_ready(dict(entry.options)), sort_keys=True),
        "hash": None,
    }


def failure(error: BaseException) -> Row:
    """The columns of an error; the hash is None where the error may pass, so that the
    next run tries again."""
    text = " ".join(str(error).split())
    if not isinstance(error, HeftingError | ChangedError | MemoryError | OSError):
        text = f"unexpected, please report it: {text}"
    if isinstance(error, MemoryError):
        text = "there is not enough memory; use fewer --jobs, or a shorter recording"
    failed = {"error": type(error).__name__, "error_text": text}
    return failed | ({"hash": None} if is_of_machine(error) else {})


def lost(result: Lost) -> Row:
    """The columns of the error of a recording at which every worker died."""
    text = f"{result.reason}; is it too large? try fewer --jobs"
    return {"error": "WorkerDied", "error_text": text, "hash": None}


def read_unchanged(entry: Entry, do: Callable[[str], T]) -> T:
    """What `do` returns for a recording, called with the hash of its content.

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
    """The estimate, and the hash in the `row`; None where that equals `kept`."""

    def do(key: str) -> Estimate | None:
        row["hash"] = key
        if key == kept:
            return None
        request = request_of(entry.options)
        return estimate_of(request, entry.recording, shape_once(request))

    return read_unchanged(entry, do)


def content_of(entry: Entry) -> str:
    """Hash of a recording's content and options. `InputError` where its row of the
    manifest is wrong, or it cannot be read."""
    if entry.problem is not None:
        raise InputError(entry.problem)
    try:
        return hash_of(entry.recording, entry.options)
    except OSError as error:
        what = f"cannot be read ({error.strerror or error})"
        raise InputError(what, entry.recording) from error


def shape_once(request: SimpleNamespace) -> Shape | None:
    """The shape of a request, cached by its options and by the signatures of their
    files. `InputError` as `shape_of`, and for options of a shape without one."""
    require_shape(request)
    given = {name: getattr(request, name) for name in OF_SHAPES}
    files = {name: signature(file) for name, file in files_of(given).items()}
    return _shape(tuple(given.items()), tuple(files.items()))


@lru_cache(maxsize=SHAPES)
def _shape(
    given: tuple[tuple[str, object], ...],
    _signatures: tuple[tuple[str, Signature], ...],
) -> Shape | None:
    return shape_of(SimpleNamespace(**dict(given)))


class ChangedError(Exception):
    """A recording changed while it was read."""


def is_of_machine(error: BaseException) -> bool:
    """Whether an error, or one of its causes, is a fault of the machine."""
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
    """What a call returns. After a fault of the machine it is called again after each
    of `PAUSES`. Raises what the last attempt raised."""
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
"""Stage by the progress that is reported; all others are conditioning."""


class Stopwatch:
    """Time by stage; reading lasts until the first report."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._stage, self._since = "reading", perf_counter()

    def __call__(self, reported: str, share: float | None = None) -> None:
        """Begin or continue the stage of the progress that is `reported`."""
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
    """A stopwatch that listens to progress within the block; Python's warnings are not
    shown there."""
    watch = Stopwatch()
    with listening(watch), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy's; relevant ones are messages
        yield watch


def is_in_windows(request: SimpleNamespace, log: str) -> bool:
    """Whether a log is read window by window: where it is large, all of it is used, and
    its bias is not from a tare window."""
    is_whole = not request.start and request.duration is None
    has_tare = request.bias.startswith("tare:")
    return is_whole and not has_tare and needs_windows(log)


def estimate_of(request: SimpleNamespace, log: str, shape: Shape | None) -> Estimate:
    """The estimate of the object in a log, in windows where it is large. Errors as for
    `hefting.identify`."""
    if not is_in_windows(request, log):
        return identify_requested(request, log, shape).estimate
    parts = _together(parts_of(request, log, shape))
    from_others = what_others_tell(parts)
    if any(from_others):
        parts = _together(parts_of(request, log, shape, from_others))
    return estimate_of_parts(request, parts, shape)


def _together(parts: Iterable[Ingested]) -> list[Ingested]:
    """All parts as a list; each is pickled meanwhile, which halves its memory."""
    packed = deque(pickle.dumps(part) for part in parts)
    return [pickle.loads(packed.popleft()) for _ in range(len(packed))]


def parts_of(
    request: SimpleNamespace,
    log: str,
    shape: Shape | None,
    from_others: Sequence[Mapping[str, Any]] = (),
) -> Iterator[Ingested]:
    """A recording, or each window of it, condensed. `from_others` has for each
    arguments of `hefting.identify` that follow from the other parts."""
    for k, recording in enumerate(_recordings(request, log)):
        reading = reading_of(request)
        yield condense(
            recording,
            shape,
            method=request.method,
            hyperparameters=hyperparameters_of(request),
            **(reading | dict(from_others[k] if k < len(from_others) else {})),
        )


def estimate_of_parts(
    request: SimpleNamespace, parts: Sequence[Ingested], shape: Shape | None
) -> Estimate:
    """The estimate of one object from all parts."""
    return identify_parts(
        parts, shape, method=request.method, hyperparameters=hyperparameters_of(request)
    ).estimate


def _recordings(request: SimpleNamespace, log: str) -> Iterator[Recording]:
    """The recording, or its windows."""
    if is_in_windows(request, log):
        for window in windows(log, request.map):
            yield placed(request, window, log)
    else:
        yield recording_of(request, log)
