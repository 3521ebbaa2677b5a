"""One object in many recordings: workers condense each recording, and the object is
identified from all of its recordings together.

The estimate is that from all samples, with a bias, clock offset and drift for each
recording, and no average of estimates. Recordings that fail, or are faulty where others
of the object are not, are left out and named.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from typing import Any

from hefting.batches.columns import STAGES, Kept, Row, filled, hash_of
from hefting.batches.one import (
    OF_SHAPES,
    attempted,
    estimate_of_parts,
    failure,
    lost,
    parts_of,
    read_unchanged,
    shape_once,
    start_row,
    stopwatch,
)
from hefting.batches.recordings import Entry, Recordings
from hefting.core.errors import InputError
from hefting.core.messages import warning
from hefting.identification.partials import what_others_tell
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import mistake_in
from hefting.jobs import Jobs, Lost
from hefting.request.request import request_of

WAVE = 200
"""Number of recordings that are condensed before their objects are identified, which
take some 30 MB; an object with more is not divided."""
SHARED = (
    *OF_SHAPES,
    *("method", "mass", "tool", "pose_std", "shape_std", "sensor_accuracy"),
)
"""Options that describe an object, and so are the same for all its recordings."""


FromOthers = Sequence[dict[str, Any]]
"""For each part of a recording arguments of `hefting.identify` that follow from the
other recordings of its object."""
Task = tuple[Entry, FromOthers]
"""A recording to condense."""


@dataclass(frozen=True)
class Condensed:
    """A recording of an object, condensed, or the error for which it is left out."""

    entry: Entry
    parts: Sequence[Ingested] = ()
    """one for the recording, or one for each window where it is read in windows"""
    error: Row = field(default_factory=dict)
    """`error` and `error_text`, where it failed"""
    hash: str | None = None
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(STAGES, 0.0)
    )


def rows_of_objects(
    entries: Recordings, kept: Kept, workers: Jobs
) -> Iterator[tuple[int, Row | None]]:
    """For each object the number of its recordings and its row, or None where that is
    unchanged according to the hashes `kept` of an earlier run."""
    for wave in _waves(entries.in_groups()):
        groups = [_with_shared_options([entries[row] for row in rows]) for rows in wave]
        known = _hashes([g for g in groups if kept.get(g[0].row_name)], workers)
        changed = []
        for group in groups:
            before = kept.get(group[0].row_name)
            if before and before == known.get(group[0].row_name):
                yield len(group), None
            else:
                changed.append(group)
        condensed = _condensed(changed, workers)
        for number, row in workers.run(_row_of_object, condensed, window=1):
            group = changed[number]
            yield (
                len(group),
                _start(group) | lost(row) if isinstance(row, Lost) else row,
            )


def _with_shared_options(group: list[Entry]) -> list[Entry]:
    """The recordings of an object, each with the `SHARED` options of all of them."""
    shared = {
        name: value
        for entry in group
        for name, value in entry.options.items()
        if name in SHARED
    }
    return [replace(each, options={**shared, **each.options}) for each in group]


def _waves(groups: Iterable[list[int]]) -> Iterator[list[list[int]]]:
    """The groups in lists that have at least `WAVE` recordings, except the last."""
    wave: list[list[int]] = []
    for group in groups:
        wave.append(group)
        if sum(map(len, wave)) >= WAVE:
            yield wave
            wave = []
    if wave:
        yield wave


def _hashes(groups: Sequence[Sequence[Entry]], workers: Jobs) -> dict[str, str]:
    """Joint hash of each object's recordings, by object; empty if one is unreadable."""
    entries = [entry for group in groups for entry in group]
    found = {entries[k].identity: h for k, h in workers.run(_hash, entries)}
    return {
        group[0].row_name: _joint_hash([found[entry.identity] for entry in group])
        for group in groups
    }


def _hash(entry: Entry) -> str | None:
    try:
        return hash_of(entry.recording, entry.options)
    except (OSError, InputError):
        return None


def _joint_hash(hashes: Sequence[object]) -> str:
    """Hash of several recordings; empty where one has none."""
    if not all(isinstance(each, str) for each in hashes):
        return ""
    return blake2b("".join(map(str, hashes)).encode(), digest_size=16).hexdigest()


def _condensed(
    groups: Sequence[Sequence[Entry]], workers: Jobs
) -> list[list[Condensed]]:
    """The condensed recordings of each object; those are condensed twice for which
    arguments follow from the others."""
    tasks: list[Task] = [(entry, []) for group in groups for entry in group]
    parts = _run(tasks, workers)
    for group in groups:
        parts |= _left_out([parts[entry.identity] for entry in group])
    again = [
        (each.entry, from_others)
        for group in groups
        for each, from_others in _from_others(
            [parts[entry.identity] for entry in group]
        )
        if any(from_others)
    ]
    parts |= _run(again, workers)
    return [[parts[entry.identity] for entry in group] for group in groups]


def _run(tasks: Sequence[Task], workers: Jobs) -> dict[str, Condensed]:
    found: dict[str, Condensed] = {}
    for number, result in workers.run(condensed, tasks):
        entry = tasks[number][0]
        if isinstance(result, Lost):
            result = Condensed(entry, error=lost(result))
        found[entry.identity] = result
    return found


def _left_out(recordings: Sequence[Condensed]) -> dict[str, Condensed]:
    """The faulty recordings of an object as failed, by identity; none where all usable
    ones are faulty."""
    found = {}
    for each in recordings:
        mistake = next(filter(None, map(mistake_in, each.parts)), None)
        if mistake is not None:
            failed = replace(each, parts=(), error=failure(mistake))
            found[each.entry.identity] = failed
    usable = [each for each in recordings if each.parts]
    return found if len(found) < len(usable) else {}


def _from_others(
    recordings: Sequence[Condensed],
) -> Iterator[tuple[Condensed, FromOthers]]:
    """Each usable recording, with the arguments for its parts that follow from the
    others."""
    usable = [each for each in recordings if each.parts]
    arguments = iter(what_others_tell([part for each in usable for part in each.parts]))
    for each in usable:
        yield each, [next(arguments) for _ in each.parts]


def condensed(task: Task) -> Condensed:
    """A condensed recording; an exception becomes its error."""
    entry, from_others = task
    with stopwatch() as watch:
        try:
            key, parts = attempted(lambda: _condense(entry, from_others))
        except Exception as error:
            return Condensed(entry, error=failure(error), seconds=watch.seconds)
    return Condensed(entry, parts, hash=key, seconds=watch.seconds)


def _condense(entry: Entry, from_others: FromOthers) -> tuple[str, list[Ingested]]:
    """The recording's hash, and its condensed parts."""

    def do(key: str) -> tuple[str, list[Ingested]]:
        request = request_of(entry.options)
        shape = shape_once(request)
        return key, list(parts_of(request, entry.recording, shape, from_others))

    return read_unchanged(entry, do)


def _row_of_object(parts: Sequence[Condensed]) -> Row:
    """The row of an object; an exception becomes its error."""
    group = [each.entry for each in parts]
    usable = [each for each in parts if each.parts]
    failed = [each for each in parts if not each.parts]
    row = _start(group) | {
        "recordings": [each.entry.recording for each in usable],
        "left_out": [
            {"recording": each.entry.recording}
            | {key: each.error.get(key) for key in ("error", "error_text")}
            for each in failed
        ],
        "hash": _joint_hash([each.hash for each in parts]) or None,
    }
    with stopwatch() as watch:
        try:
            row = _identified(row, usable, failed)
        except Exception as error:
            row |= failure(error)
    spent = [*(each.seconds for each in parts), watch.seconds]
    return row | {"seconds": {s: sum(each[s] for each in spent) for s in STAGES}}


def _start(group: Sequence[Entry]) -> Row:
    """The row of an object before its identification."""
    first = group[0]
    return start_row(first) | (
        {"recording": None, "name": None} if first.object else {}
    )


def _identified(row: Row, usable: list[Condensed], failed: list[Condensed]) -> Row:
    """The row with the estimate, or with the errors where no recording is usable.
    `InputError` where `SHARED` options differ between recordings."""
    if not usable:
        first = failed[0].error
        if len(failed) == 1:
            return row | first
        text = f"none of {len(failed)} recordings can be used: {first['error_text']}"
        return row | first | {"error_text": text}
    own = [each.entry.options for each in usable]
    for name in SHARED:
        values = list(dict.fromkeys(options.get(name) for options in own))
        if len(values) > 1:
            what = f"recordings of one object say different {name}: {values[0]}, {values[1]}"
            raise InputError(what, usable[0].entry.object)
    request = request_of(own[0])
    parts = [part for each in usable for part in each.parts]
    estimate = estimate_of_parts(request, parts, shape_once(request))
    left_out = tuple(
        warning("recording-left-out", f"left out: {each.error['error_text']}")
        for each in failed
    )
    return filled(row, replace(estimate, warnings=(*left_out, *estimate.warnings)))
