"""A session: its answer is the library's own, by any method and settings, and quick."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError, NeedError
from hefting.identification import identify
from hefting.ingest.ingest import ingest
from hefting.logs import read_log
from hefting.scene import headline_of
from hefting.shapes import Shape
from hefting.viewer import Session, Settings
from recordings import DATA, needs_recordings
from viewing import recorded, shape, viewed

SAME = 1e-9
"""Of the largest parameter: both fold the same samples; what differs is rounding."""
SETTINGS = (
    Settings("Bayes"),
    Settings("Bayes", {"pose_std": (0.01, 0.1)}),
    Settings("Bayes", {"pose_std": (0.0, 0.0)}),
    Settings("PMD"),
    Settings("PMD", {"c1": 40.0}),
    Settings("PMD", {"regularization": 2.0}),
    Settings("GEO"),
    Settings("LMI"),
    Settings("OLS"),
    Settings("RTLS"),
    Settings("PMD-full"),
)


def named(settings):
    chosen = ", ".join(f"{k}={v}" for k, v in settings.hyperparameters.items())
    return f"{settings.method} {chosen}"


@pytest.fixture(scope="module")
def session():
    return viewed()[0]


def same(one, other):
    scale = np.abs(other.parameters.vector).max()
    np.testing.assert_allclose(
        one.parameters.vector, other.parameters.vector, rtol=0.0, atol=SAME * scale
    )
    for key, ends in other.intervals.items():
        known = np.isfinite(ends)
        np.testing.assert_array_equal(np.isfinite(one.intervals[key]), known)
        np.testing.assert_allclose(
            one.intervals[key][known],
            ends[known],
            rtol=0.0,
            atol=SAME * np.abs(ends[known]).max(initial=0.0),
        )


@pytest.mark.parametrize("settings", SETTINGS, ids=named)
def test_the_whole_recording_gives_the_estimate_of_identify(session, settings):
    whole = identify(
        recorded(), shape(), method=settings.method, **settings.hyperparameters
    ).estimate
    answer = session.answer(10.0, settings)
    same(answer.estimate, whole)
    assert answer.headline == headline_of(whole)
    assert answer.estimate.warnings == whole.warnings


@needs_recordings
@pytest.mark.parametrize("log", ["run1", "run3"])
def test_an_instant_of_a_fast_recording_is_the_librarys(log, monkeypatch):
    """Moving time, method, c1, lambda and pose-std on the Panda recordings, which are not
    conditioned again (`benchmarks.viewer` times it)."""
    recording = read_log(DATA / "panda-optoforce" / f"{log}.csv")
    held = Shape.from_box(-0.06, 0.06, -0.06, 0.06, 0.0, 0.2)
    found = ingest(recording)

    def again(*arguments, **options):
        raise AssertionError("conditioned again")

    monkeypatch.setattr("hefting.ingest.ingest.condition", again)
    session = Session(found, held)
    z = found.measurements
    for settings in SETTINGS:
        estimator = session.estimator(settings)
        own = found.weighted_by_count if estimator.depends_on_count else z
        for instant in (z.time[0] + 0.7, z.time[0] + 9.3, z.time[-1]):
            answer = session.answer(instant, settings)
            plain = estimator.fit(own[z.time <= instant])
            same(answer.estimate, plain)


def test_settings_change_the_answer(session):
    """Each hyperparameter that can be set is used."""
    for settings in SETTINGS:
        if settings.hyperparameters:
            plain = session.answer(2.0, Settings(settings.method)).estimate
            other = session.answer(2.0, settings).estimate
            ends = plain.intervals["mass"] - other.intervals["mass"]
            body = plain.parameters.vector - other.parameters.vector
            assert max(np.abs(ends).max(), np.abs(body).max()) > 1e-6, settings


def test_hyperparameters_of_others_are_left_out(session):
    one = session.answer(2.0, Settings("OLS", {"c1": 5.0, "pose_std": (0.1, 0.1)}))
    same(one.estimate, session.answer(2.0, Settings("OLS")).estimate)


def test_methods_are_those_for_which_enough_is_known():
    assert viewed()[0].methods == ("Bayes", "PMD", "GEO", "LMI", "OLS", "RTLS")
    bare = viewed(shape=None)[0]
    assert bare.methods == ("Bayes", "LMI", "OLS", "RTLS")
    with pytest.raises(NeedError, match="PMD needs a shape"):
        bare.estimator(Settings("PMD"))
    with pytest.raises(InputError, match="unknown method"):
        bare.estimator(Settings("OSL"))


def test_an_answer_is_kept(session):
    assert session.answer(3.0, Settings("GEO")) is session.answer(3.0, Settings("GEO"))


def test_why_there_is_none_is_said(session):
    answer = session.answer(-1.0, Settings("Bayes"))
    assert answer.estimate is None
    assert answer.headline is None
    assert "no samples" in answer.refusal
    assert answer.scene.surface is not None
    assert not answer.scene.bodies


def test_an_estimate_that_was_given_is_the_same_at_every_instant():
    own = identify(recorded(), shape(), method="OLS").estimate
    session = viewed(given={"as in a.json": own})[0]
    assert session.methods[0] == "as in a.json"
    assert session.default == Settings("as in a.json")
    for instant in (0.5, 4.0):
        assert session.answer(instant, session.default).estimate is own


def test_masses_are_drawn_where_there_is_one_for_each_point(session):
    answer = session.answer(5.0, Settings("PMD"))
    masses = answer.scene.points.masses
    assert masses.sum() == pytest.approx(answer.estimate.mass)  # M m = phi
    other = viewed(shape=shape(), given={"other": answer.estimate})[0]
    assert other.answer(1.0, Settings("other")).scene.points.masses is masses
    fewer = replace(answer.estimate, point_masses=masses[:-1])
    foreign = viewed(given={"other": fewer})[0]
    assert foreign.answer(1.0, Settings("other")).scene.points is None


def test_noise_is_not_to_be_used_and_torques_in_millimetres_are_refused():
    recording = recorded()
    wrench = recording["wrench"]
    noise = np.random.default_rng(0).normal(size=wrench.values.shape)
    empty = replace(wrench, values=0.1 * noise)
    streams = {**recording.streams, "wrench": empty}
    session = Session(ingest(replace(recording, streams=streams)), shape())
    answer = session.answer(recording.duration, session.default)
    assert answer.estimate is None or answer.estimate.verdict.level == "do not use"
    milli = replace(wrench, values=wrench.values * (1, 1, 1, 1e3, 1e3, 1e3))
    streams = {**recording.streams, "wrench": milli}
    with pytest.raises(InputError):
        Session(ingest(replace(recording, streams=streams)), shape())
