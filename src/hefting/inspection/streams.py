"""Streams of a log as they arrived: rate, gaps, jitter, lost and repeated samples."""

from dataclasses import dataclass

import numpy as np

from hefting.core.recording import Stream

GAP = 3.0
"""Steps longer than so many usual ones are gaps."""


@dataclass(frozen=True)
class StreamFacts:
    """How one stream was sampled. Of static poses only `samples` and `repeated` mean
    something; the rest is 0."""

    samples: int
    rate: float
    """Hz: one over the usual step, the median of those without a lost sample; 0 of one
    sample"""
    start: float
    """s"""
    end: float
    """s"""
    gaps: int
    """steps longer than `GAP` usual ones"""
    longest_gap: float
    """s; 0 without gaps"""
    gap_time: float
    """s in gaps altogether"""
    missing: float
    """share of the samples that the rate promises and that are not there; gaps
    included"""
    jitter: float
    """s: root-mean-square deviation of the step from the nearest multiple of the usual
    one, gaps left out"""
    jitter_share: float
    """the same over the usual step"""
    repeated: float
    """share of the samples that equal the one before in every column: held values of a
    slower source, or rest"""


def stream_facts(stream: Stream, static: bool) -> StreamFacts:
    """Facts of a stream; `static`: its times are only row numbers."""
    n = len(stream)
    repeated = (
        float((np.diff(stream.values, axis=0) == 0.0).all(axis=1).mean())
        if n > 1
        else 0.0
    )
    if static or n < 2:
        start = 0.0 if static else float(stream.time[0])
        return StreamFacts(n, 0.0, start, start, 0, 0.0, 0.0, 0.0, 0.0, 0.0, repeated)
    steps = np.diff(stream.time)
    usual = float(np.median(steps))
    usual = float(np.median(steps[steps < 1.5 * usual]))
    gap = steps > GAP * usual
    rest = steps[~gap]
    off = rest - usual * np.maximum(np.round(rest / usual), 1.0)
    jitter = float(np.sqrt(np.mean(off**2)))
    promised = round(float(stream.time[-1] - stream.time[0]) / usual) + 1
    return StreamFacts(
        samples=n,
        rate=1.0 / usual,
        start=float(stream.time[0]),
        end=float(stream.time[-1]),
        gaps=int(gap.sum()),
        longest_gap=float(steps[gap].max()) if gap.any() else 0.0,
        gap_time=float(steps[gap].sum()),
        missing=max(1.0 - n / promised, 0.0),
        jitter=jitter,
        jitter_share=jitter / usual,
        repeated=repeated,
    )
