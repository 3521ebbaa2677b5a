"""One object in many recordings: each is condensed where its data lie, and all of an
object are identified together.

An answer is that of all samples, with a bias, a clock and a drift of each recording's
own; it is no average of estimates. A recording that fails, or is wrong alone where
others are not, is left out, and named.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from typing import Any

from hefting.batches.columns import STAGES, Row, filled
from hefting.batches.content import Kept, hash_of
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
"""Recordings that are condensed before their objects are identified: some 30 MB, unless
one object has more."""
SHARED = (
    *OF_SHAPES,
    *("method", "mass", "tool", "pose_std", "shape_std", "sensor_accuracy"),
)
"""Options that are said of an object, and so the same of all its recordings."""


Told = Sequence[dict[str, Any]]
"""What others tell of each part of a recording: arguments of `hefting.identify`."""
Task = tuple[Entry, Told]
"""A recording to condense."""


@dataclass(frozen=True)
class Condensed:
    """A recording of an object, condensed, or why it is left out."""

    entry: Entry
    parts: Sequence[Ingested] = ()
    """One; of a recording that is read in windows, each of them."""
    error: Row = field(default_factory=dict)
    """`error` and `error_text`, where it failed"""
    hash: str | None = None
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(STAGES, 0.0)
    )


def rows_of_objects(
    entries: Recordings, kept: Kept, workers: Jobs
) -> Iterator[tuple[int, Row | None]]:
    """For each object how many of the recordings, grouped by it, it has, and its row;
    None where that is unchanged by the hashes `kept` of rows that are there."""
    for wave in _waves(entries.in_groups()):
        groups = [_sharing([entries[row] for row in rows]) for rows in wave]
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


def _sharing(group: list[Entry]) -> list[Entry]:
    """The recordings of an object, each with what others say of the object."""
    shared = {
        name: value
        for entry in group
        for name, value in entry.options.items()
        if name in SHARED
    }
    return [replace(each, options={**shared, **each.options}) for each in group]


def _waves(groups: Iterable[list[int]]) -> Iterator[list[list[int]]]:
    """Groups, so many at a time that they have some `WAVE` recordings."""
    wave: list[list[int]] = []
    for group in groups:
        wave.append(group)
        if sum(map(len, wave)) >= WAVE:
            yield wave
            wave = []
    if wave:
        yield wave


def _hashes(groups: Sequence[Sequence[Entry]], workers: Jobs) -> dict[str, str]:
    """Hash of each object by its recordings; empty where one cannot be read."""
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
    """The recordings of each object, those again of which others tell something."""
    tasks: list[Task] = [(entry, []) for group in groups for entry in group]
    parts = _run(tasks, workers)
    for group in groups:
        parts |= _left_out([parts[entry.identity] for entry in group])
    again = [
        (each.entry, told)
        for group in groups
        for each, told in _told([parts[entry.identity] for entry in group])
        if any(told)
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
    """Those that are wrong alone, as failed, where others are right."""
    found = {}
    for each in recordings:
        mistake = next(filter(None, map(mistake_in, each.parts)), None)
        if mistake is not None:
            failed = replace(each, parts=(), error=failure(mistake))
            found[each.entry.identity] = failed
    usable = [each for each in recordings if each.parts]
    return found if len(found) < len(usable) else {}


def _told(recordings: Sequence[Condensed]) -> Iterator[tuple[Condensed, Told]]:
    """What to read again of the parts of each recording, as the others tell it."""
    usable = [each for each in recordings if each.parts]
    told = iter(what_others_tell([part for each in usable for part in each.parts]))
    for each in usable:
        yield each, [next(told) for _ in each.parts]


def condensed(task: Task) -> Condensed:
    """A recording without its samples; raises nothing of an input."""
    entry, told = task
    with stopwatch() as watch:
        try:
            key, parts = attempted(lambda: _condense(entry, told))
        except Exception as error:
            return Condensed(entry, error=failure(error), seconds=watch.seconds)
    return Condensed(entry, parts, hash=key, seconds=watch.seconds)


def _condense(entry: Entry, told: Told) -> tuple[str, list[Ingested]]:
    def do(key: str) -> tuple[str, list[Ingested]]:
        request = request_of(entry.options)
        shape = shape_once(request)
        return key, list(parts_of(request, entry.recording, shape, told))

    return read_unchanged(entry, do)


def _row_of_object(parts: Sequence[Condensed]) -> Row:
    """The row of an object; raises nothing of an input."""
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
    """What the row of an object has whatever comes of it."""
    first = group[0]
    return start_row(first) | (
        {"recording": None, "name": None} if first.object else {}
    )


def _identified(row: Row, usable: list[Condensed], failed: list[Condensed]) -> Row:
    """The row with the estimate. `InputError` where there is no recording to go by, and
    where they say different things of the object."""
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
    told = tuple(
        warning("recording-left-out", f"left out: {each.error['error_text']}")
        for each in failed
    )
    return filled(row, replace(estimate, warnings=(*told, *estimate.warnings)))
