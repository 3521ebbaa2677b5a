"""Conditioning: its linear model and drift against what they stand for, its laws, and
inputs with nothing in them."""

from dataclasses import replace
from functools import partial
from importlib import import_module

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from disturbances import GRAVITY, NOISE, body, disturbed, with_wrench
from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import angle_between
from hefting.ingest import condition as condition_and_look_for_changes
from hefting.ingest.blocks import Blocks
from hefting.ingest.drift import Drift, HatFunctions, candidates
from hefting.ingest.fit import Start, gauss_newton, motion_weights
from hefting.ingest.ingest import ingest
from hefting.ingest.model import Model, Problem, solve, tangents_of
from hefting.ingest.path import path_of
from hefting.ingest.uncertainty import estimate_uncertainty
from hefting.logs import read_log
from hefting.motion import measure, sample_weights, smooth_poses
from hefting.simulation import UR5, random_smooth, simulate, stop_and_go, wield
from recordings import DATA, TOOL_FOLDERS, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")
condition = partial(condition_and_look_for_changes, changes=False)
"""Looking for changes of the object alters nothing else: see `test_changes.py`."""

# what it is made of


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_hats_are_what_interpolation_says(n):
    rng = np.random.default_rng(n)
    time = np.sort(rng.uniform(0.0, 30.0, 200))
    time = time[(time < 10.0) | (time > 16.0)]  # an interval may be empty
    hats = HatFunctions.over(time, n)
    values = rng.normal(size=(n, 2))
    dense = np.column_stack([np.interp(time, hats.knots, unit) for unit in np.eye(n)])
    rows, weights = rng.normal(size=(len(time), 3)), rng.random(len(time))
    for found, expected in (
        (hats.combine(values), dense @ values),
        (hats.project(rows), dense.T @ rows),
        (hats.gram(weights), dense.T @ (dense * weights[:, None])),
        (hats.part(slice(30, 120)).combine(values), (dense @ values)[30:120]),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-12)  # rounding


def test_drift_between_and_beyond_its_knots():
    drift = Drift(
        np.array([1.0, 3.0]),
        np.array([np.zeros(6), np.full(6, 4.0)]),
        np.ones((2, 6)),
        np.full(6, 2.0),
    )
    np.testing.assert_allclose(drift(np.array([0.0, 2.0, 9.0]))[:, 0], (0.0, 2.0, 4.0))
    np.testing.assert_allclose(drift.change(np.array([2.5]))[0], 1.0)
    assert drift.kind == "linear"
    np.testing.assert_array_equal(drift.range, 4.0)


def test_numbers_of_knots_to_try():
    assert candidates(5.0, 0.0) == (1,)
    assert candidates(10.0, 0.0) == (1, 2)
    assert candidates(180.0, 0.0) == (1, 2, 3, 5, 9, 16)
    # of two at most, a bias as slow as can be leaves as many
    assert candidates(23.9, 0.0) == candidates(23.9, 1e6) == (1, 2)
    assert candidates(180.0, 60.0) == (1, 2, 3, 4)  # 180 s in three lines, no more
    for duration, numbers in (
        (7.8, (1,)),
        (7.995, (1, 2)),  # 8 s at 200 Hz
        (8.0, (1, 2)),
        (12.0, (1, 2)),
        (24.0, (1, 2, 3)),
        (36.0, (1, 2, 3, 4)),
    ):
        # of 12 s and more each, once the drift may bend
        assert candidates(duration, 0.0) == numbers
    assert candidates(48.0, 0.0) == (1, 2, 3, 5)
    assert candidates(1e5, 0.0) == (1, 2, 3, 5, 9, 17, 33, 65, 81)


def problem(seed=0, **changes):
    d = disturbed("clean", 1.5, seed)
    wrench = d.recording["wrench"]
    settings = {"free_offset": True, "free_gravity": True, "knots": (1,)} | changes
    return d, Problem(
        path_of(d.recording), Blocks.of(wrench.time, wrench.values), **settings
    )


def test_columns_are_the_derivatives_of_the_prediction():
    d, p = problem()
    phi, h = d.body.vector, 1e-4

    fixed = replace(p, free_offset=False, free_gravity=False)

    def predicted(offset, gravity):
        return Model.at(fixed, offset, gravity).predict(phi)

    model = Model.at(p, 0.02, GRAVITY)
    inside = slice(20, -20)  # whole stencils
    columns = model.columns(phi)[inside]
    by_offset = (predicted(0.02 + h, GRAVITY) - predicted(0.02 - h, GRAVITY)) / (2 * h)
    # two steps, 0.1 and 2 ms, of signals up to 10 rad/s: (0.002 * 10)² / 6
    np.testing.assert_allclose(
        columns[:, :, 10], by_offset[inside], atol=2e-4 * np.abs(by_offset).max()
    )
    for i, tangent in enumerate(tangents_of(GRAVITY)):
        change = (
            predicted(0.02, GRAVITY + h * tangent)
            - predicted(0.02, GRAVITY - h * tangent)
        ) / (2 * h)
        # linear
        np.testing.assert_allclose(columns[:, :, 11 + i], change[inside], atol=1e-9)


def test_normal_equations_against_dense_least_squares():
    d, p = problem()
    phi, rng = d.body.vector, np.random.default_rng(0)
    model = Model.at(p, 0.0, GRAVITY)
    columns = model.columns(phi)
    assert columns.shape[2] == 13  # parameters, offset, two of gravity's direction
    weights = rng.random(len(p.time))
    levels = np.array((0.1, 0.01))
    hats = HatFunctions.over(p.time, 3)
    found, scale = solve(model, phi, weights, levels, hats), np.repeat(levels, 3)
    bias = np.einsum("kn,cd->kcnd", hats.combine(np.eye(3)), np.eye(6)).reshape(
        len(p.time), 6, 18
    )
    root = np.sqrt(weights)[:, None] / scale
    A = (np.concatenate((columns, bias), axis=2) * root[:, :, None]).reshape(-1, 31)
    expected, *_ = np.linalg.lstsq(A, (p.wrench * root).ravel(), rcond=None)
    np.testing.assert_allclose(
        np.concatenate((found.core, found.bias.ravel())), expected, rtol=1e-7, atol=1e-9
    )
    np.testing.assert_allclose(found.inverse @ (A.T @ A), np.eye(31), atol=1e-6)
    assert not found.undetermined.any()


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_covariance_is_that_of_the_noises_colour(correlation):
    """Against B G B' of the noise's own covariance, averaged over realisations of it on
    one motion."""
    from scipy.linalg import toeplitz
    from scipy.signal import lfilter

    d, p = problem(free_gravity=False)
    exact = path_of(
        simulate(UR5.motion(random_smooth(10.4, 100.0, 1.0, 0)), d.body, exact=True)
    )
    assert exact is not None
    # no errors of the motion
    p, found = replace(p, path=replace(exact, bandwidth=np.inf)), []
    clean = wield(UR5.motion(random_smooth(10.4, 100.0, 1.0, 0)), d.body).wrench
    start = Start(
        d.body.vector,
        0.0,
        GRAVITY,
        np.array((0.1, 0.005)),
        p.time[:1],
        np.zeros((1, 6)),
    )
    for seed in range(6):
        white = np.random.default_rng(seed).normal(size=clean.shape)
        noise = lfilter(
            [np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white, axis=0
        )
        blocks = replace(p.blocks, wrench=clean + np.repeat((0.1, 0.005), 3) * noise)
        fit = gauss_newton(replace(p, blocks=blocks), start, 1, steps=3)
        found.append(estimate_uncertainty(fit).covariance.diagonal()[:11])
    G = toeplitz(correlation ** np.arange(len(p.time)))
    bias = np.broadcast_to(np.eye(6), (len(p.time), 6, 6))
    B = (
        np.concatenate((fit.columns, bias), axis=2)
        / np.repeat((0.1, 0.005), 3)[:, None]
    )
    H = np.linalg.inv(np.einsum("kcp,kcq->pq", B, B))
    expected = (H @ sum(B[:, c].T @ G @ B[:, c] for c in range(6)) @ H).diagonal()[:11]
    ratio = np.mean(found, axis=0) / expected
    # from a few dozen independent powers, six times
    assert np.all((ratio > 0.7) & (ratio < 1.3))


def test_weights_are_those_of_the_estimators():
    """On average one; the largest residuals are expected where the motion is least
    certain."""
    d, p = problem()
    seen = p.path.at(p.time)
    motion = smooth_poses(d.recording).poses.at(p.time)
    weights, spread = motion_weights(
        d.body.vector, seen, p.path.bandwidth, p.time, np.array((0.1, 0.005))
    )
    expected = sample_weights(d.body.vector, motion, 0.1, 0.005)
    np.testing.assert_allclose(weights, expected / expected.mean(), rtol=1e-9)
    assert np.ptp(weights) > 0.1
    assert np.argmax(spread) == np.argmin(weights)


# laws


@pytest.fixture(scope="module")
def late():
    d = disturbed("all", 1.5, 1)
    return d, condition(d.recording, tilt=True)


def test_it_finds_what_was_done(late):
    d, found = late
    assert abs(found.offset - d.offset) < 1e-3
    assert not found.sign.on_object
    assert found.sign.certain
    angle = np.arccos(found.gravity @ d.gravity / (GRAVITY @ GRAVITY))
    assert angle < np.radians(0.3)
    assert found.bias.kind == "linear"
    assert np.mean(found.rejected[d.bad]) > 0.97
    assert np.mean(found.rejected[~d.bad]) < 0.2
    assert found.reasons["contact"] > 200
    assert found.reasons["spike"] > 20
    assert found.noise.force == pytest.approx(NOISE.force, rel=0.2)
    assert found.noise.torque == pytest.approx(NOISE.torque, rel=0.2)
    said = " ".join(found.findings)
    for word in ("late", "on-sensor", "drifts", "gravity", "contact", "spikes"):
        assert word in said


def test_corrected_is_what_was_found(late):
    d, found = late
    wrench, corrected = d.recording["wrench"], found.corrected(d.recording)["wrench"]
    kept = ~found.rejected
    np.testing.assert_allclose(corrected.time, wrench.time[kept] - found.offset)
    drift = found.bias(wrench.time) - found.bias.mean
    np.testing.assert_allclose(corrected.values, (wrench.values - drift)[kept])
    np.testing.assert_array_equal(corrected.rows, wrench.rows[kept])
    assert found.corrected(d.recording)["position"] is d.recording["position"]


def test_shifts_signs_and_biases_pass_through():
    """The wrench 50 ms later, of the other sign, and with another bias: the same
    object, all else moved along."""
    d = disturbed("clean", 1.5, 2)
    time = d.recording["wrench"].time
    values = d.recording["wrench"].values
    bias = np.array((7, -3, 2, 0.1, 0.2, -0.3))
    one = condition(with_wrench(d.recording, time + 0.03, values))
    other = condition(with_wrench(d.recording, time + 0.08, bias - values))
    # five samples fewer, of a thousand
    assert other.offset - one.offset == pytest.approx(0.05, abs=one.offset_std)
    assert one.sign.on_object
    assert not other.sign.on_object
    assert np.all(np.abs(other.parameters - one.parameters) < one.std)
    np.testing.assert_allclose(other.bias.mean, bias - one.bias.mean, atol=0.05)


@pytest.mark.parametrize("late", [0.5, -0.7])
def test_an_offset_may_be_large(late):
    wrench = CLEAN["wrench"]
    found = condition(with_wrench(CLEAN, wrench.time + late, wrench.values))
    assert found.offset == pytest.approx(late, abs=1e-3)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)


def test_time_begins_anywhere():
    d = disturbed("offset", 1.5, 3)
    moved = replace(
        d.recording,
        streams={
            n: Stream(s.time + 5e8, s.values) for n, s in d.recording.streams.items()
        },
    )
    one, other = condition(d.recording), condition(moved)
    # such times are known to 0.1 µs
    assert other.offset == pytest.approx(one.offset, abs=1e-5)
    np.testing.assert_allclose(
        other.parameters, one.parameters, atol=1e-3 * one.parameters[0]
    )


@pytest.mark.parametrize(
    ("kind", "degrees"), [("clean", 0.0), ("contact", 0.0), ("tilt", 15.0)]
)
def test_gravity_is_estimated_for_information(kind, degrees):
    """What touches the object is left out, and the rest explained."""
    recording = disturbed(kind, 1.5, 1).recording
    assert condition(recording).tilted is None
    found = condition(recording, hint=True)
    assert (found.rejected.mean() > 0.1) == (kind == "contact")
    assert found.tilted is not None
    # a thousand samples of 0.1 N, at 15 N: a hundredth of a degree, and the poses'
    # errors
    angle = angle_between(np.array(GRAVITY), found.tilted.gravity)
    assert np.degrees(angle) == pytest.approx(degrees, abs=0.1)


TURNED_WORLDS = [
    (90.0, 0.0, 0.0),
    (-90.0, 0.0, 0.0),
    (0.0, 180.0, 0.0),
    (78.0, 104.0, 0.0),
]


@pytest.mark.parametrize("degrees", TURNED_WORLDS)
def test_gravity_is_found_however_the_world_is_turned(degrees):
    """From the default, 90, 180 and 130° off: the opposite direction with the other sign
    of the wrench differs by what accelerations show alone."""
    recording = disturbed("clean", 1.5, 1).recording
    turn = Rotation.from_rotvec(np.radians(degrees))
    q = (turn * Rotation.from_quat(np.array(recording["orientation"].values))).as_quat()
    p = turn.apply(np.array(recording["position"].values))
    streams = {
        **recording.streams,
        "orientation": replace(recording["orientation"], values=q),
        "position": replace(recording["position"], values=p),
    }
    found = condition(replace(recording, streams=streams), tilt=True)
    right = condition(recording, tilt=True)
    # of some tenth of a degree by noise; both start and end elsewhere within it
    np.testing.assert_allclose(
        found.gravity, turn.apply(np.array(right.gravity)), atol=0.01
    )
    assert found.parameters[0] == pytest.approx(right.parameters[0], rel=1e-3)
    assert found.sign.on_object == right.sign.on_object


# motion from other sources


def exact_recording(late_by=0.0):
    motion = UR5.motion(stop_and_go(10.0, 100.0, seed=2))
    recording = simulate(motion, body(1.5), pose_noise=(0.0, 0.0), exact=True)
    return with_wrench(recording, motion.time + late_by, recording["wrench"].values)


def test_what_is_right_is_left_alone():
    recording = exact_recording()
    found = condition(recording)
    assert found.offset == 0.0
    assert not found.rejected.any()
    assert found.bias.kind == "constant"
    assert found.corrected(recording) is recording
    np.testing.assert_allclose(found.parameters, body(1.5).vector, atol=1e-8)


def test_no_drift_is_no_drift():
    assert (
        condition(disturbed("clean", 1.5, 0, duration=30.0).recording).bias.kind
        == "constant"
    )


@pytest.mark.parametrize(("seconds", "kind"), [(7.8, "constant"), (7.99, "linear")])
def test_a_drift_takes_eight_seconds_to_tell(seconds, kind):
    recording = disturbed("drift", 1.5, 0, duration=seconds + 0.01).recording
    assert np.ptp(recording["wrench"].time) == pytest.approx(seconds)
    assert condition(recording).bias.kind == kind


def test_a_drift_that_is_too_short_to_be_removed_is_told():
    """A bias that drifts by 3 N in 5 s, in a line, or bending as that of a sensor that
    warms up; what swings at 1 Hz is not taken for it."""
    clean = disturbed("clean", 0.3, 0, duration=5.0).recording
    wrench = clean["wrench"]
    past = (wrench.time - wrench.time[0])[:, None]
    drift = past / 5.0 * (2.0, -1.5, 2.0, 0.1, 0.05, -0.1)
    warming = drift[-1] * (1.0 - np.exp(-past / 1.5))
    swinging = drift[-1] * np.sin(2.0 * np.pi * past)
    for added, told in ((drift, True), (warming, True), (swinging, False)):
        doubt = ingest(with_wrench(clean, wrench.time, wrench.values + added)).doubt
        assert doubt is not None
        assert (doubt.message.code == "drift-in-short") == told


def test_columns_may_be_late_too():
    found = condition(exact_recording(0.0237))
    # cubic interpolation of 100 Hz
    assert found.offset == pytest.approx(0.0237, abs=1e-5)


def test_orientation_alone_shows_a_late_wrench_when_slow():
    motion = UR5.motion(stop_and_go(60.0, 50.0, dwell=4.0, move=4.0, seed=1))
    recording = simulate(motion, body(1.5), noise=NOISE)
    streams = {"orientation": recording["orientation"], "wrench": recording["wrench"]}
    found = condition(
        with_wrench(
            replace(recording, streams=streams),
            motion.time + 0.5,
            recording["wrench"].values,
        )
    )
    assert found.offset == pytest.approx(0.5, abs=0.01)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)
    np.testing.assert_array_equal(np.isinf(found.std[4:]), True)


@pytest.mark.parametrize("seed", range(3))
def test_rests_alone_tell_no_clock(seed):
    """Rests cut together, with gaps between them: nothing moves while anything is
    measured, so that no clock is looked for, and accelerations are none."""
    motion = UR5.motion(stop_and_go(40.0, 125.0, dwell=0.8, move=0.8, seed=seed))
    whole = simulate(motion, body(1.5), noise=NOISE, seed=seed)
    speed = np.abs(np.gradient(motion.orientation, motion.time, axis=0)).max(axis=1)
    rests = np.flatnonzero(speed == 0.0)
    streams = {name: stream[rests] for name, stream in whole.streams.items()}
    recording = replace(whole, streams=streams)
    found = condition(recording)
    assert found.offset_std is None
    assert not found.warnings
    assert not measure(recording).measurements.linear_acceleration.any()
    # four of its standard deviations
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]


def test_orientation_alone_invents_no_offset_when_fast():
    """What accelerations do to the wrench is not modelled, and would look like 66
    ms."""
    found = condition(
        replace(
            CLEAN, streams={name: CLEAN[name] for name in ("orientation", "wrench")}
        )
    )
    assert found.offset == 0.0
    assert any("none assumed" in said for said in found.warnings)


def test_accelerometer_of_another_clock():
    motion = UR5.motion(random_smooth(8.0, 200.0, 2.0, 1))
    recording = simulate(motion, body(1.5), noise=NOISE)
    z = wield(motion, body(1.5))
    felt = (
        z.linear_acceleration
        - z.gravity
        + 0.02 * np.random.default_rng(0).normal(size=z.gravity.shape)
    )
    streams = {"orientation": recording["orientation"], "wrench": recording["wrench"]}
    streams["accelerometer"] = Stream(motion.time + 0.0065, felt)
    streams["orientation"] = Stream(
        motion.time + 0.0065, recording["orientation"].values
    )
    found = condition(replace(recording, streams=streams))
    assert found.offset == pytest.approx(-0.0065, abs=1e-3)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)
    assert any("early" in said for said in found.findings)


def test_static_poses():
    slow = simulate(
        UR5.motion(stop_and_go(60.0, 1.0, dwell=1.0, move=1.0, seed=5)),
        body(1.5),
        noise=NOISE,
        on_sensor=True,
    )
    rows = np.arange(len(slow["wrench"]), dtype=float)
    poses = {
        name: Stream(rows, slow[name].values) for name in ("orientation", "wrench")
    }
    found = condition(Recording(poses, static=True))
    assert not found.sign.on_object
    assert found.offset_std is None
    assert not any("clock" in said for said in found.warnings)


# nothing to condition


def held(noise):
    rng, time = np.random.default_rng(0), np.arange(300) * 0.01
    q = np.array((0.0, 0.0, 0.0, 1.0)) + noise * rng.normal(size=(300, 4))
    streams = {
        "position": Stream(time, noise * rng.normal(size=(300, 3))),
        "orientation": Stream(time, q / np.linalg.norm(q, axis=1, keepdims=True)),
        "wrench": Stream(
            time, (0.0, 0.0, 9.8, 0.0, 0.0, 0.0) + 0.1 * rng.normal(size=(300, 6))
        ),
    }
    return Recording(streams)


CLEAN = disturbed("clean", 1.5, 0).recording
POOR = {
    "three samples": CLEAN.slice(1.0, 0.03),
    "a tenth of a second": CLEAN.slice(1.0, 0.1),
    "half a second": CLEAN.slice(1.0, 0.5),
    "one wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time[:1], CLEAN["wrench"].values[:1]
    ),
    "another time": with_wrench(
        CLEAN, CLEAN["wrench"].time + 100.0, CLEAN["wrench"].values
    ),
    "no wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time, np.zeros((len(CLEAN["wrench"]), 6))
    ),
    "a constant wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time, np.ones((len(CLEAN["wrench"]), 6))
    ),
    "noise": with_wrench(
        CLEAN,
        CLEAN["wrench"].time,
        np.random.default_rng(0).normal(size=(len(CLEAN["wrench"]), 6)),
    ),
    "held exactly": held(0.0),
    "held": held(1e-4),
    "few poses": replace(
        CLEAN,
        streams={n: s if n == "wrench" else s[:5] for n, s in CLEAN.streams.items()},
    ),
}


@pytest.mark.parametrize("tilt", [False, True])
@pytest.mark.parametrize("name", POOR)
def test_what_cannot_be_found_counts_as_absent(name, tilt):
    found = condition(POOR[name], tilt=tilt)
    assert found.offset == 0.0
    assert not found.sign.certain or name == "half a second"
    assert found.warnings
    assert np.isfinite(found.parameters).all()
    assert len(found.rejected) == len(POOR[name]["wrench"])


def test_no_clock_asked_for_none_looked_for():
    d = disturbed("offset", 1.5, 0)
    found = condition(d.recording, clock=False)
    assert found.offset == 0.0
    assert found.offset_std is None


def test_wrong_gravity_is_refused():
    for gravity in ((0.0, 0.0, 0.0), (0.0, 9.81), (0.0, 0.0, np.nan)):
        with pytest.raises(InputError, match="gravity"):
            condition(CLEAN, gravity)


def test_a_gap_in_the_poses():
    kept = np.ones(len(CLEAN["position"]), dtype=bool)
    kept[300:500] = False
    streams = {n: s if n == "wrench" else s[kept] for n, s in CLEAN.streams.items()}
    found = condition(replace(CLEAN, streams=streams))
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]
    assert not found.rejected.any()


def test_a_sensor_at_its_limit():
    wrench = CLEAN["wrench"].values.copy()
    limit = np.quantile(wrench[:, 2], 0.85)
    clipped = wrench[:, 2] > limit
    wrench[:, 2] = np.minimum(wrench[:, 2], limit)
    found = condition(with_wrench(CLEAN, CLEAN["wrench"].time, wrench))
    assert found.rejected[clipped].all()
    assert found.reasons["saturation"] < 1.5 * clipped.sum()
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]


def test_outliers_of_a_long_recording_are_those_of_all_its_samples(monkeypatch):
    monkeypatch.setattr(
        import_module("hefting.ingest.condition"), "MOST_FITTED_SAMPLES", 800
    )
    monkeypatch.setattr(
        import_module("hefting.ingest.condition"), "MOST_FITTED_BLOCKS", 400
    )
    d = disturbed("contact", 1.5, 0)
    found = condition(d.recording)
    assert len(found.rejected) == len(d.bad)
    assert np.mean(found.rejected[d.bad]) > 0.9
    assert np.mean(found.rejected[~d.bad]) < 0.2
    assert found.parameters[0] == pytest.approx(1.5, rel=0.01)


# recordings nobody here made


@needs_recordings
def test_exact_logs_of_tools_are_left_alone():
    for folder in TOOL_FOLDERS[:4]:
        recording = read_log(folder / "log.csv")
        found = condition(recording, (0.0, 0.0, 9.81))
        assert found.corrected(recording) is recording, folder.name


@needs_recordings
@pytest.mark.parametrize(
    ("log", "g", "offset", "within", "mass"),
    [
        ("panda-optoforce/run1", 9.81, 0.017, 0.001, (1.09, 1.17)),
        ("panda-optoforce/run3", 9.81, 0.017, 0.001, (1.09, 1.17)),
        ("kuka-ati/baseline", 9.82085, -0.0066, 0.0005, (0.9323 * 0.99, 0.9323 * 1.01)),
        (
            "kuka-ati/vibrations",
            9.82085,
            -0.0064,
            0.0005,
            (0.9323 * 0.98, 0.9323 * 1.02),
        ),
        ("axia80/dwells", 9.80665, 0.513, 0.010, (1.14, 1.18)),
        ("kuka-ati/static_poses", 9.82085, 0.0, 0.0, (0.929, 0.936)),
        ("axia80/poses7", 9.80665, 0.0, 0.0, (1.09, 1.11)),
    ],
)
def test_real_recordings(log, g, offset, within, mass):
    recording = read_log(DATA / f"{log}.csv")
    found = condition(recording, (0.0, 0.0, -g))
    print(f"{log}: {1e3 * found.offset:.2f} ms, {found.parameters[0]:.4f} kg")
    assert found.offset == pytest.approx(offset, abs=within)
    assert mass[0] <= found.parameters[0] <= mass[1]
    assert found.sign.certain
    assert found.sign.on_object == log.startswith("panda")
    assert len(
        measure(found.corrected(recording), found.gravity).measurements
    ) > 0.9 * len(recording["wrench"])


@pytest.mark.parametrize("mass", [0.5, 1.5, 5.0])
def test_the_noise_of_the_wrench_is_told_from_that_of_the_motion(mass):
    """The same noise of wrench and poses, whatever the mass: of 5 kg the errors of the
    motion are a third of the force's residuals and half of the torque's. White
    residuals count as such."""
    found = condition(disturbed("clean", mass, 0, duration=6.0).recording, GRAVITY)
    assert found.noise.force == pytest.approx(NOISE.force, rel=0.1)
    assert found.noise.torque == pytest.approx(NOISE.torque, rel=0.25)
    assert 0.4 < found.autocorrelation < 1.5  # smoothed motion takes some of it
