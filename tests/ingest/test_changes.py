"""Changes of the object within a recording: found, told, and the longest stretch used."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from benchmarks.changing import CLEAN, EVENTS, MISFITS, Case, case, moved

from changing_cells import body
from disturbances import disturbed
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.identification import identify
from hefting.ingest import Conditioned, chosen_part, condition
from hefting.ingest.changes.cells import (
    cells_of,
)
from hefting.ingest.ingest import ingest
from hefting.inspection import inspect
from hefting.logs import read_log
from hefting.simulation import UR5, WRENCH_NOISE, Faults, record, wield_analytically
from recordings import LOGS, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")

WORLD_UPSIDE_DOWN = (0.0, 0.0, 9.81)
"""[m/s²] Gravity of the simulated workshop tools."""


@cache
def sample(kind: str, seed: int) -> Case:
    return case(kind, seed)


@cache
def moving(kind: str) -> Case:
    """The first case of a kind whose sensor moves."""
    return next(
        found for seed in range(20) if (found := sample(kind, seed)).motion != "rest"
    )


@cache
def conditioned(kind: str) -> Conditioned:
    """What is made of that case."""
    return condition(moving(kind).recording)


def later(recording: Recording, seconds: float) -> Recording:
    return replace(
        recording,
        streams={
            name: Stream(s.time + seconds, s.values, s.rows)
            for name, s in recording.streams.items()
        },
    )


# finding


@pytest.mark.parametrize("kind", EVENTS)
def test_an_event_is_found_with_time_and_kind(kind: str):
    """Within half a second, as promised; errors are a tenth of a second in the median."""
    true, found = moving(kind), conditioned(kind).changes
    assert found is not None
    if kind == "touched":
        assert found.touches[0].start == pytest.approx(true.time, abs=0.5)
        assert found.touches[0].end == pytest.approx(true.end, abs=0.5)
        assert [s.event for s in found.stretches] in ([kind], [kind, None])
        return
    before, after = found.stretches
    assert 0.5 * (before.end + after.start) == pytest.approx(true.time, abs=0.5)
    assert before.event == kind
    assert after.event is None
    for stretch, parameters in zip((before, after), true.bodies, strict=True):
        # least squares of a second or more, with a bias that is found, too
        assert stretch.mass == pytest.approx(parameters.mass, rel=0.1, abs=0.02)


OTHERS = {
    "clean": (2, 3),
    "drift": (1, 2),
    "units": (0, 3),
    "tilted": (1, 3),
    "late": (1, 2),
}
"""Seeds of recordings in motion: those at rest take several times as long, and two of
them are left."""


@pytest.mark.parametrize("kind", [*CLEAN, *MISFITS])
def test_nothing_is_told_of_a_recording_without_an_event(kind: str):
    """Whatever else is wrong with it."""
    for seed in OTHERS.get(kind, (0, 1)):
        assert condition(sample(kind, seed).recording).changes is None, seed


@needs_recordings
@pytest.mark.parametrize(
    "log", LOGS, ids=lambda path: f"{path.parent.name}-{path.stem}"
)
def test_nothing_is_told_of_real_recordings(log):
    """Each holds one object from start to end."""
    upside_down = "workshop-tools" in log.parts
    gravity = WORLD_UPSIDE_DOWN if upside_down else (0.0, 0.0, -9.81)
    assert condition(read_log(log), gravity).changes is None


def test_a_contact_of_more_than_half_the_recording_is_said():
    """A push of 4 N along axes that turn with the sensor, from 2 to 7.5 s of 10."""
    d = disturbed("clean", 1.5, 3)
    wrench = d.recording["wrench"]
    inside = (wrench.time > 2.0) & (wrench.time < 7.5)
    swing = 1.0 + 0.3 * np.sin(5.0 * wrench.time)
    push = np.outer(inside * swing, (2.0, 3.0, -1.0, 0.1, -0.2, 0.1))
    touched = replace(
        d.recording,
        streams={
            **d.recording.streams,
            "wrench": replace(wrench, values=wrench.values + push),
        },
    )
    found = ingest(touched)
    assert found.changes is not None
    (touch,) = found.changes.touches
    assert (touch.start, touch.end) == pytest.approx((2.0, 7.5), abs=0.2)
    (said,) = [w for w in found.warnings if w.code == "change-touched"]
    assert "more than half" in said
    # what comes before and after it is used
    time = found.measurements.time
    assert not ((time > 2.1) & (time < 7.4)).any()
    # least squares of 4.5 s: 0.3 % of the mass
    assert found.fit.vector[0] == pytest.approx(1.5, rel=0.02)


def test_times_are_since_the_first_sample_and_start_is_allowed_for():
    """Stamps of another clock change nothing; of a part, times are still those of the
    whole."""
    recording = moving("swapped").recording
    found = conditioned("swapped").changes
    shifted = condition(later(recording, 1024.0)).changes
    assert found is not None
    assert shifted is not None
    for one, other in zip(found.stretches, shifted.stretches, strict=True):
        # rounding may move a sample to the next cell
        assert (one.start, one.end) == pytest.approx((other.start, other.end), abs=0.02)
    part = ingest(recording, start=0.5).changes
    assert part is not None
    ends = found.stretches[0].end, part.stretches[0].end
    # a cell
    assert ends[1] == pytest.approx(ends[0], abs=0.11)
    assert part.stretches[0].start == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("kind", ["swapped", "touched"])
def test_looking_for_them_alters_nothing_else(kind: str):
    found = conditioned(kind)
    other = condition(moving(kind).recording, changes=False)
    assert found.changes is not None
    assert other.changes is None
    assert other.offset == found.offset
    assert other.sign == found.sign
    for name in ("parameters", "std", "rejected"):
        np.testing.assert_array_equal(getattr(other, name), getattr(found, name))


def test_poses_without_time_and_short_recordings_are_left_alone():
    recording = moving("swapped").recording
    assert condition(recording.slice(0.0, 1.5)).changes is None
    rows = slice(None, None, 20)
    poses = Recording(
        {
            name: Stream(np.arange(len(s[rows]), dtype=float), s.values[rows])
            for name, s in recording.streams.items()
        },
        static=True,
    )
    assert condition(poses).changes is None


# what is made of it


def test_identify_takes_the_stretch_as_if_it_had_been_given():
    """Bit for bit, but for what is said."""
    true = moving("swapped")
    found = identify(true.recording, method="OLS").estimate
    assert {"change-point", "change-part-used"} <= codes(found.warnings)
    changes = conditioned("swapped").changes
    assert changes is not None
    part = changes.chosen
    given = identify(
        true.recording, method="OLS", start=part.start, duration=part.duration
    ).estimate
    np.testing.assert_array_equal(found.parameters.vector, given.parameters.vector)
    np.testing.assert_array_equal(found.covariance, given.covariance)
    held = true.bodies[changes.stretches.index(part)]
    assert found.parameters.mass == pytest.approx(held.mass, rel=0.02)
    (kept,) = (s for s in found.provenance["stretches"] if s["start"] == part.start)
    assert kept["mass"] == pytest.approx(held.mass, rel=0.05)


def touched(slip: float) -> Recording:
    """A box moved for 12 s, pushed from 5 to 7 s, that slips [m] in the grip then."""
    held = InertialParameters(body(1.2, 0.03, 0.02, 0.08))
    way = np.eye(4)
    way[0, 3] = slip
    joints = moved("random", 12.0, 3)
    one, other = (wield_analytically(UR5, joints, b) for b in (held, held.moved(way)))
    time = one.motion.time[:, None]
    swing = 1.0 + 0.3 * np.sin(5.0 * time)
    push = ((time > 5.0) & (time < 7.0)) * swing * (3.0, 2.0, -1.0, 0.1, -0.2, 0.1)
    wrench = np.where(time < 6.0, one.measurements.wrench, other.measurements.wrench)
    z = replace(
        one.measurements, force=(wrench + push)[:, :3], torque=(wrench + push)[:, 3:]
    )
    faults = Faults(
        wrench_noise=WRENCH_NOISE["moderate"], bias=(1.0, 2.0, 3.0, 0, 0, 0)
    )
    return record(replace(one, measurements=z), faults, seed=4)


def test_what_a_contact_divides_is_used_together():
    found = identify(touched(0.0))
    changes = found.ingested.changes
    assert changes is not None
    assert changes.used == changes.stretches
    assert len(changes.used) == 2
    (said,) = (w for w in found.warnings if w.code == "change-part-used")
    assert re.search(r"only 0\.00 to 4\.\d+ s and 7\.\d+ to 1[12]\.\d+ s is used", said)
    time = found.ingested.measurements.time
    assert (time.min() < 0.5) & (time.max() > 11.5)
    assert not ((time > 5.1) & (time < 6.9)).any()
    # a gap in the wrench is what was left out, and is told once
    assert [s.cause for s in found.ingested.left_out if s.samples == 0] == ["touched"]
    low, high = found.estimate.interval("mass")
    assert low < 1.2 < high


def test_what_slipped_when_it_was_touched_is_not():
    """By 4 mm."""
    changes = ingest(touched(0.004)).changes
    assert changes is not None
    assert changes.used == (changes.chosen,)


def test_a_part_that_is_given_is_used_as_it_is(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(chosen_part, "doubt_of", lambda *_, **__: None)
    recording = moving("swapped").recording
    whole = identify(recording, method="OLS", duration=1e3).estimate
    assert "change-left-in" in codes(whole.warnings)
    assert "change-part-used" not in codes(whole.warnings)
    assert whole.provenance["stretches"]
    monkeypatch.setitem(condition.__globals__, "find_changes", lambda *_: None)
    blind = identify(recording, method="OLS").estimate
    np.testing.assert_array_equal(whole.parameters.vector, blind.parameters.vector)


def test_a_recording_without_a_change_is_identified_as_if_none_were_looked_for(
    monkeypatch: pytest.MonkeyPatch,
):
    recording = moving("clean").recording
    looked = identify(recording).estimate
    monkeypatch.setitem(condition.__globals__, "find_changes", lambda *_: None)
    blind = identify(recording).estimate
    assert looked.to_dict() == blind.to_dict()
    assert looked.provenance["stretches"] == []


def test_inspect_holds_the_stretches_and_speaks_of_the_one_chosen():
    true = moving("put-down")
    found = inspect(true.recording)
    said = found.to_dict()
    held, bare = said["stretches"]
    assert held["event"] == "put-down"
    assert bare["mass"] < 0.2 * held["mass"]
    assert "change-point" in codes(found.warnings)
    assert said["mass"] == pytest.approx(true.bodies[0].mass, rel=0.05)
    assert inspect(moving("clean").recording).to_dict()["stretches"] == []


# its parts


def test_cells_leave_out_what_the_motion_does_not_tell(monkeypatch):
    """Blocks whose residual is widened to twice the usual one by errors of the motion."""
    seen: list[Any] = []
    keep = lambda samples, found, _: seen.extend((samples, found))  # noqa: E731
    monkeypatch.setitem(condition.__globals__, "find_changes", keep)
    condition(moving("none").recording)
    samples, found = seen
    time = found.problem.time
    braking = (time > 3.0) & (time < 3.5)
    for factor, left in ((1.9, 1), (2.1, 0)):
        fit = replace(found.fit, spread=np.where(braking, factor, 1.0))
        cells = cells_of(samples, found.problem, fit, found.outliers, fit.offset)
        assert cells is not None
        assert ((cells.time > 3.0) & (cells.time < 3.5)).any() == left
