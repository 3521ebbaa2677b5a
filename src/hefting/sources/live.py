"""`hefting.live`: live estimates from a source, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.online.identifier import LiveIdentifier
from hefting.online.live_estimate import LiveEstimate
from hefting.online.samples import EndOfSource, Samples, Source
from hefting.sources.played_log import PlayedLog
from hefting.sources.pump import Pump
from hefting.sources.registry import Request, source_of

LONGEST_STEP = 0.5
"""[s] Longest wait for an estimate before it is looked whether the source has ended."""


def live(
    source: Recording | Source | str | Path,
    shape: Any = None,
    *,
    speed: float = 1.0,
    tap: Callable[[Samples], None] | None = None,
    **options: Any,
) -> Iterator[LiveEstimate]:
    """Live estimates of what a robot holds, from a source of its streams.

    Parameters
    ----------
    source : Recording, Source, text or path
        A recording, or the path of a log, which is played at its own speed; the address
        of a live source, as ``hefting live`` takes it; or a `Source`.
    shape : path, str, mesh, points or Shape, optional
        Where the object may have mass, as for `hefting.identify`.
    speed : float
        Times its own speed at which a recording is played; infinite: as fast as it
        goes, with the estimates that there would be at its own speed.
    tap : callable, optional
        Is given all samples as they come, as a recorder.
    **options
        As for `hefting.LiveIdentifier`: ``until``, ``rate``, ``gravity`` and so on.

    Yields
    ------
    LiveEstimate
        The last one, where the source ends, is that of `hefting.identify` on all of the
        stream, see `hefting.LiveIdentifier.close`.

    Raises
    ------
    InputError
        For a source that cannot be opened, or gives nothing.

    Examples
    --------
    >>> for now in hefting.live("demo/log.csv", speed=float("inf")):
    ...     last = now
    >>> last.state, round(last.estimate.mass, 2)
    ('identified', 0.67)
    """
    opened = _source(source, speed)
    if isinstance(opened, PlayedLog) and np.isinf(speed):
        yield from _as_fast_as_it_goes(opened, shape, tap, options)
        return
    with LiveIdentifier(shape, **options) as identifier:

        def deliver(samples: Samples) -> None:
            if tap is not None:
                tap(samples)
            identifier.add(samples)

        with Pump(opened, deliver, identifier.say) as pump:
            while not pump.wait(0.0):
                now = identifier.wait(LONGEST_STEP)
                if now is not None:
                    yield _with_skipped(now, opened)
        if pump.error is not None:
            raise pump.error
        last = identifier.close()
        if last is not None:
            yield _with_skipped(last, opened)


def _as_fast_as_it_goes(
    played: PlayedLog,
    shape: Any,
    tap: Callable[[Samples], None] | None,
    options: dict[str, Any],
) -> Iterator[LiveEstimate]:
    """What would be known at each time of the stream at which it would be told."""
    identifier = LiveIdentifier(shape, in_process=False, **options)
    played.open()
    for message in played.chosen:
        identifier.say(message)
    due = -np.inf
    for samples in _samples(played):
        begins = float(samples.time[0])
        due = begins + identifier.period if np.isinf(due) else due
        if begins > due:
            now = identifier.step()
            due = max(due + identifier.period, begins)
            if now is not None:
                yield now
        identifier.add(samples)
        if tap is not None:
            tap(samples)
    identifier.step()
    last = identifier.close()
    if last is not None:
        yield last


def _samples(played: PlayedLog) -> Iterator[Samples]:
    try:
        while True:
            yield from played.read(0.0)
    except EndOfSource:
        return


def _with_skipped(now: LiveEstimate, source: Source) -> LiveEstimate:
    """With the bad messages that the source left out."""
    skipped = now.counts.get("skipped", {}) + source.skipped
    return replace(now, counts={**now.counts, "skipped": skipped})


def _source(source: Any, speed: float) -> Source:
    if isinstance(source, Recording):
        return PlayedLog(source.source, Request(speed=speed), source)
    if isinstance(source, str | Path):
        return source_of(str(source), Request(speed=speed))
    if isinstance(source, Source):
        return source
    what = f"a {type(source).__name__} is no source"
    raise InputError(what, "live", "give a path, an address, a recording or a Source")
