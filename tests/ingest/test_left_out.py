"""What was left out of a log: each span by its cause, where it was made."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import GRAVITY, body, disturbed, with_wrench
from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.ingest.ingest import ingest
from hefting.ingest.left_out import CAUSES, _missing, runs
from hefting.ingest.path import path_of
from hefting.simulation import UR5, random_smooth, simulate


def recording_of(seconds=10.0):
    motion = UR5.motion(random_smooth(seconds, 100.0, 1.0, 3))
    return simulate(motion, body(1.0), noise=Noise(0.1, 0.005), seed=3)


def spans(found, cause):
    return [span for span in found.left_out if span.cause == cause]


def test_of_a_clean_log_nothing_is_left_out():
    assert ingest(recording_of()).left_out == ()


@pytest.mark.parametrize("kind", ["spikes", "contact"])
def test_spans_hold_what_ingest_rejected_and_nothing_else(kind):
    made = disturbed(kind, 1.0, 1)
    found = ingest(made.recording, gravity=GRAVITY)
    reasons = found.conditioned.reasons
    assert max(reasons.values()) > 0
    for cause, count in reasons.items():
        assert sum(span.samples for span in spans(found, cause)) == count
    # each sample of the wrench is in a span, or was used
    time = made.recording["wrench"].time - made.recording.start
    inside = np.zeros(len(time), dtype=bool)
    for span in found.left_out:
        inside |= (time >= span.start - 1e-9) & (time <= span.end + 1e-9)
    assert np.array_equal(inside, found.conditioned.rejected)
    assert found.counts.sum() == len(time) - inside.sum()


@pytest.mark.parametrize("streams", [("position", "orientation"), ("orientation",)])
def test_the_motion_is_known_where_it_can_be_read(streams):
    clean = recording_of()
    there = (clean["position"].time < 4.0) | (clean["position"].time > 5.0)
    poses = {name: clean[name][there] for name in streams}
    path = path_of(Recording({"wrench": clean["wrench"], **poses}))
    assert path is not None
    time = np.linspace(-1.0, 11.0, 2401)
    known = path.known_at(time)
    assert np.array_equal(known, path.at(time).known)
    assert 0.7 < known.mean() < 0.8  # nine seconds of twelve


def test_a_gap_of_the_poses_and_one_of_the_wrench():
    clean = recording_of()
    poses, wrench = clean["position"].time, clean["wrench"].time
    there = (poses < 4.0) | (poses > 5.0)
    streams = {name: clean[name][there] for name in ("position", "orientation")}
    felt = (wrench < 7.0) | (wrench > 7.5)
    log = with_wrench(Recording(streams), wrench[felt], clean["wrench"].values[felt])
    found = ingest(log)
    (gap,) = spans(found, "no-pose")
    # to a sample of 10 ms at either end
    assert (gap.start, gap.end) == pytest.approx((4.0, 5.0), abs=0.015)
    (silence,) = spans(found, "no-wrench")
    assert (silence.start, silence.end) == pytest.approx((7.0, 7.5), abs=0.015)
    assert silence.samples == 0


def test_poses_out_of_reach():
    clean = recording_of()
    values = clean["position"].values.copy()
    values[[300, 301, 600]] += 0.5
    position = replace(clean["position"], values=values)
    log = replace(clean, streams={**clean.streams, "position": position})
    found = [(s.start, s.end, s.samples) for s in spans(ingest(log), "pose")]
    assert found == [(3.0, pytest.approx(3.01), 2), (6.0, 6.0, 1)]


def test_times_are_those_of_the_log_whatever_part_is_used():
    made = disturbed("spikes", 1.0, 1)
    whole = ingest(made.recording, gravity=GRAVITY)
    part = ingest(made.recording, gravity=GRAVITY, start=4.0)
    assert part.log_start == whole.log_start == made.recording.start
    first = part.measurements.time[0] - part.log_start
    assert first == pytest.approx(4.0, abs=0.02)
    later = {s.start for s in spans(whole, "spike") if s.start > 4.5}
    # a spike near the edge of what counts as one may be judged otherwise
    common = later & {s.start for s in spans(part, "spike")}
    assert len(common) > 0.9 * len(later)


def test_runs():
    mask = np.array((1, 0, 1, 1, 0, 0, 1), dtype=bool)
    found = runs("spike", np.arange(7.0), mask)
    assert [(s.start, s.end, s.samples) for s in found] == [
        (0.0, 0.0, 1),
        (2.0, 3.0, 2),
        (6.0, 6.0, 1),
    ]
    assert runs("spike", np.arange(7.0), ~mask | mask)[0].samples == 7
    assert runs("spike", np.arange(0.0), np.zeros(0, dtype=bool)) == []
    assert "spike" in CAUSES


def test_a_step_counts_as_a_gap_beyond_five_of_the_usual_ones():
    for steps, told in ((1.0, 0), (4.0, 0), (7.0, 1), (100.0, 1)):
        time = 0.01 * np.cumsum(np.r_[np.ones(20), steps, np.ones(20)])
        found = _missing(time)
        assert len(found) == told
        for span in found:
            assert span.end - span.start == pytest.approx(0.01 * steps)
            assert (span.cause, span.samples) == ("no-wrench", 0)
