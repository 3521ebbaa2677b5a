"""Final: the last answer of a stream is that of `hefting.identify` on all of it; an
accuracy that was asked for leaves nothing of it out."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.messages import note
from hefting.core.recording import Recording
from hefting.estimators import Estimator
from hefting.identification.estimator import shape_of
from hefting.identification.identify import identify_understood
from hefting.identification.run import understand
from hefting.logs.given import as_recording
from hefting.online.live_estimate import LiveEstimate
from hefting.online.understanding import Settings


def final_estimate(
    last: LiveEstimate,
    recordings: Sequence[Recording | str | Path] | None,
    settings: Settings,
    since: float | None,
) -> LiveEstimate:
    """The last live estimate with that of the whole stream.

    Parameters
    ----------
    last : LiveEstimate
        What was known at the end.
    recordings : of each clock of the stream that has wrench and poses; None where it was
        too long to be kept.
    settings : as the stream was identified with.
    since : [s] Stamp since when the last object is held; None where it is the first.

    Returns
    -------
    LiveEstimate
        `last` where the whole cannot be identified, or is not there.
    """
    if recordings is None:
        what = (
            "the stream is too long to be kept: the final answer is the last live one"
        )
        return replace(last, messages=(*last.messages, note("live-not-kept", what)))
    if not recordings:
        return last
    start = 0.0
    shape, hyperparameters = settings.shape, dict(settings.hyperparameters)
    try:
        logs = [as_recording(each) for each in recordings]
        if since is not None:  # an object is held in one clock: the last
            logs = logs[-1:]
            start = max(since - logs[0].start, 0.0)
        whole = logs[0] if len(logs) == 1 else logs
        if isinstance(settings.method, Estimator):
            shape = shape_of(settings.method, shape, hyperparameters)
        understood = understand(whole, start=start, **settings.reading)
        found = identify_understood(
            understood, shape, settings.method, hyperparameters, stop=False
        )
    except InputError as error:
        said = note("live-little-motion", f"no final answer: {error}")
        return replace(last, messages=(*last.messages, said))
    messages = last.messages
    if since is not None:
        what = f"the final answer is of what is held from {start:.3f} s on: `start`"
        messages = (*messages, note("live-part-used", what, "start"))
    estimate = found.estimate
    state = "sufficient" if estimate.sufficient else "identified"
    return replace(last, estimate=estimate, state=state, messages=messages)
