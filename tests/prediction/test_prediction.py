"""Predicted wrenches against MuJoCo, their bands against draws and truth, and what a
measured wrench says of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hefting import OLS, Estimate, InputError, Prediction, predict
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.core.quantity import wrench_text
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import full_regressor
from hefting.core.sensor_accuracy import Z95
from hefting.core.undetermined import Covariance
from hefting.prediction import predict as module_function
from hefting.prediction.predict import MOST
from hefting.simulation import (
    UR5,
    JointMotion,
    random_smooth,
    simulate,
    sinusoids,
    stop_and_go,
    wield,
)

pytestmark = pytest.mark.usefixtures("same_recordings")

BODY = InertialParameters.from_com(
    1.7,
    (0.05, -0.11, 0.08),
    ((0.020, 0.003, -0.002), (0.003, 0.030, 0.004), (-0.002, 0.004, 0.015)),
)
NOISE = Noise(force=0.1, torque=0.005)
PLANNED = UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=3))
OTHER = UR5.motion(sinusoids(5.0, 100.0, 1.5))


def poses(motion, **streams) -> Recording:
    """A planned motion: poses alone, without noise, and whatever else is given."""
    values = {"position": motion.position, "orientation": motion.orientation, **streams}
    return Recording(
        {name: Stream(motion.time, value) for name, value in values.items()},
        source="plan",
    )


def columns(motion) -> Recording:
    """A planned motion with its twist and acceleration."""
    names = (
        "linear_velocity",
        "angular_velocity",
        "linear_acceleration",
        "angular_acceleration",
    )
    return poses(motion, **{name: getattr(motion, name) for name in names})


def estimate_of(body=BODY, **more) -> Estimate:
    return Estimate("OLS", body, samples=100, **more)


def covariance(seed=0) -> np.ndarray:
    """Some covariance of the ten parameters, their scales apart as those of masses and
    inertias are."""
    root = (
        np.random.default_rng(seed).normal(size=(10, 10))
        * np.repeat((1e-2, 1e-3, 1e-4), (1, 3, 6))[:, None]
    )
    return root @ root.T


def slide_and_turn(axis: int) -> Recording:
    """Two seconds of sliding, then two of turning about an axis of the sensor."""
    from scipy.spatial.transform import Rotation

    time = np.arange(400) / 100.0
    angle = np.where(time > 2.0, 1.0 - np.cos(np.pi * (time - 2.0)), 0.0)
    rate = np.where(time > 2.0, np.pi * np.sin(np.pi * (time - 2.0)), 0.0)
    turning = np.where(time > 2.0, np.pi**2 * np.cos(np.pi * (time - 2.0)), 0.0)
    unit = np.eye(3)[axis]
    streams = {
        "position": 0.1 * np.sin(3.0 * time)[:, None] * np.ones(3),
        "orientation": Rotation.from_rotvec(angle[:, None] * unit).as_quat(),
        "linear_acceleration": -0.9 * np.sin(3.0 * time)[:, None] * np.ones(3),
        # about an axis that sensor and world share
        "angular_velocity": rate[:, None] * unit,
        "angular_acceleration": turning[:, None] * unit,
    }
    return Recording({name: Stream(time, values) for name, values in streams.items()})


# the wrench


def test_the_wrench_is_mujocos():
    """With its accelerations to rounding; from its poses alone, smoothed, to 1e-4 of
    the wrench."""
    pytest.importorskip(
        "mujoco", reason="MuJoCo is not installed (pip install 'hefting[sim]')"
    )
    from hefting.simulation import wield_in_mujoco

    shown = wield_in_mujoco(UR5, random_smooth(10.0, 100.0, 1.0, seed=3), BODY)
    exact = predict(estimate_of(), columns(shown.motion))
    assert exact.source == "columns"
    np.testing.assert_array_equal(exact.time, shown.motion.time)
    # rounding of 20 N
    np.testing.assert_allclose(exact.wrench, shown.measurements.wrench, atol=1e-11)
    smoothed = predict(estimate_of(), poses(shown.motion))
    assert smoothed.source == "smooth"
    off = np.abs(smoothed.wrench - shown.measurements.wrench).max(axis=0)
    # measured 7e-5 N and 1.2e-5 N m at the ends of the motion, of 20 N and 2.6 N m
    assert off[:3].max() < 5e-4
    assert off[3:].max() < 1e-4
    for name, part in (("force", slice(0, 3)), ("torque", slice(3, 6))):
        size = np.linalg.norm(shown.measurements.wrench[:, part], axis=1)
        assert exact.peaks[name].value == pytest.approx(size.max(), rel=1e-11)
        assert exact.peaks[name].time == shown.motion.time[size.argmax()]


@pytest.mark.parametrize("rate", [50.0, 250.0])
def test_smoothing_hardly_changes_planned_motion(rate):
    """Moves between rests, jerk jumping at their ends: off by a thousandth of the
    wrench (rms) at 50 Hz."""
    motion = UR5.motion(stop_and_go(10.0, rate, seed=4))
    true = wield(motion, BODY).wrench
    off = predict(estimate_of(), poses(motion)).wrench - true
    for part in (slice(0, 3), slice(3, 6)):
        # measured 3.1e-4 and 8.5e-4 at 50 Hz, 2.7e-5 and 7.5e-5 at 250 Hz
        assert (
            np.sqrt(np.mean(off[:, part] ** 2))
            < (2e-3 if rate < 100.0 else 2e-4) * np.abs(true[:, part]).max()
        )


def test_accelerations_that_jump_keep_the_peaks():
    """Trapezoidal speeds: an acceleration of 0.4 s, a cruise, and back to rest; peaks
    are within 1 %."""
    time = np.arange(600) / 100.0
    since, rise, cruise = np.clip(time - 1.0, 0.0, 2.0), 0.4, 1.2
    ddq = np.where(since < rise, 1.0, np.where(since < rise + cruise, 0.0, -1.0)) / (
        rise * (rise + cruise)
    )
    ddq = np.where((time >= 1.0) & (time < 3.0), ddq, 0.0)
    fall = 2.0 - since
    q = np.where(since < rise, since**2, 2.0 * rise * since - rise**2) / (
        2.0 * rise * (rise + cruise)
    )
    q = np.where(
        since > rise + cruise, 1.0 - fall**2 / (2.0 * rise * (rise + cruise)), q
    )
    dq = np.minimum(np.minimum(since, fall) / rise, 1.0) / (rise + cruise)
    step = np.array((0.5, -0.4, 0.3, 1.0, 0.8, -0.9))
    joints = JointMotion(
        time, UR5.start + q[:, None] * step, dq[:, None] * step, ddq[:, None] * step
    )
    motion = UR5.motion(joints)
    true, found = wield(motion, BODY), predict(estimate_of(), poses(motion))
    for name in ("force", "torque"):
        size = np.linalg.norm(getattr(true, name), axis=1).max()
        # measured 0.3 %
        assert found.peaks[name].value == pytest.approx(size, rel=0.01)


def test_gravity_and_part_of_the_motion():
    gravity = (3.0, -1.0, 8.0)
    found = predict(
        estimate_of(), columns(OTHER), gravity=gravity, start=1.0, duration=2.0
    )
    inside = (OTHER.time >= 1.0) & (OTHER.time < 3.0)
    np.testing.assert_array_equal(found.time, OTHER.time[inside])
    # the simulation's own equations at the centre of mass
    np.testing.assert_allclose(
        found.wrench, wield(OTHER, BODY, gravity).wrench[inside], atol=1e-11
    )


def test_static_poses_feel_gravity_alone():
    chosen = OTHER.orientation[::50]
    static = Recording({"orientation": Stream(np.arange(10.0), chosen)}, static=True)
    found = predict(estimate_of(covariance=covariance()), static)
    weight = BODY.mass * 9.80665
    np.testing.assert_allclose(
        np.linalg.norm(found.wrench[:, :3], axis=1), weight, rtol=1e-14
    )
    np.testing.assert_allclose(
        found.wrench[:, 3:],
        np.cross(BODY.center_of_mass, found.wrench[:, :3]),
        rtol=0.0,
        atol=1e-13,
    )
    assert (found.static, found.source, found.motion_std) == (True, "static", None)
    assert b"time" not in found.csv()


# the band


def test_the_band_is_that_of_draws():
    C = covariance()
    found = predict(estimate_of(covariance=C), columns(OTHER))
    draws = np.random.default_rng(1).multivariate_normal(BODY.vector, C, size=4000)
    z = wield(OTHER, BODY)
    wrenches = np.einsum("kip,dp->dki", full_regressor(z)[::50], draws)
    assert found.std is not None
    # the deviation of 4,000 draws is itself off by 1.1 % (one deviation); 60 numbers,
    # correlated: five deviations
    np.testing.assert_allclose(found.std[::50], wrenches.std(axis=0), rtol=0.056)
    np.testing.assert_allclose(
        (found.high - found.low) / 2.0, Z95 * found.std, rtol=1e-12
    )
    k = int(np.argmax(np.linalg.norm(found.wrench[:, 3:], axis=1)))
    sizes = np.linalg.norm(
        np.einsum("ip,dp->di", full_regressor(z[k : k + 1])[0, 3:], draws), axis=1
    )
    # the same, and first order
    assert found.peaks["torque"].std == pytest.approx(sizes.std(), rel=0.06)


def test_the_band_holds_the_truth():
    """Identified along one motion by least squares, predicted along another: errors
    over their deviations."""
    squares, inside = [], []
    measured = wield(OTHER, BODY)[:150]
    true = wield(PLANNED, BODY).wrench
    for seed in range(30):
        estimate = OLS(noise=NOISE).fit(measured.with_noise(NOISE, seed))
        found = predict(estimate, columns(PLANNED))
        uncertain = found.std > 1e-6  # at rest fx is zero whatever the object
        z = ((found.wrench - true) / found.std)[uncertain]
        squares.append(np.mean(z**2))
        inside.append(np.mean(np.abs(z) <= Z95))
    # from seed to seed the mean square varies by 0.7, the share by 0.09: four
    # deviations of means over 30
    assert abs(np.mean(squares) - 1.0) < 0.52
    assert abs(np.mean(inside) - 0.95) < 0.07


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_open_parameter_opens_what_it_touches(axis):
    """Jxx, Jxy and Jxz open: turning about x needs all three, about y and z what torque
    Jxy and Jxz there make."""
    C = covariance()
    C[4:7], C[:, 4:7] = 0.0, 0.0
    C[range(4, 7), range(4, 7)] = np.inf
    found = predict(estimate_of(covariance=C), slide_and_turn(axis))
    assert found.std is not None
    infinite = np.isinf(found.std)
    slides = found.time < 2.0
    assert not infinite[slides].any()
    assert not infinite[:, :3].any()
    # J alpha + w x J w, of the entries xx, xy, xz: alpha and w² along x touch all of tx
    # (xx, alpha), ty and tz
    touched = {0: [True, True, True], 1: [True, False, True], 2: [True, True, False]}[
        axis
    ]
    np.testing.assert_array_equal(infinite[~slides, 3:].any(axis=0), touched)
    assert "leaves Jxx, Jxy, Jxz open: no band for t" in " ".join(found.warnings)
    said = found.to_dict()
    assert said["low"][-1][:3] == pytest.approx(found.low[-1, :3].tolist())
    assert (None in said["high"][-1]) == infinite[-1].any()
    header, *_, last = found.csv().decode().splitlines()
    blank = [
        name
        for name, cell in zip(header.split(","), last.split(","), strict=True)
        if not cell
    ]
    assert blank == [
        f"{n}_{end}"
        for n, open_ in zip(("tx", "ty", "tz"), touched, strict=True)
        if open_
        for end in ("low", "high")
    ]


def test_without_a_covariance_there_is_no_band():
    found = predict(estimate_of(), columns(OTHER))
    assert (found.std, found.low, found.high, found.peaks["force"].std) == (None,) * 4
    assert any("has no covariance" in line for line in found.warnings)
    assert found.csv().startswith(b"time,fx,fy,fz,tx,ty,tz\n")


@pytest.mark.parametrize(
    "fault", ["negative", "indefinite", "lopsided", "infinite beside"]
)
def test_what_is_no_covariance_is_refused(fault):
    C = covariance()
    if fault == "negative":
        C[3, 3] = -1e-9
    elif fault == "indefinite":
        C[0, 1] = C[1, 0] = 1.1 * np.sqrt(C[0, 0] * C[1, 1])
    elif fault == "lopsided":
        C[0, 1] += 0.1 * np.sqrt(C[0, 0] * C[1, 1])
    else:
        C[0, 1] = C[1, 0] = np.inf
    with pytest.raises(InputError, match="covariance"):
        Covariance.of(C)


def test_the_root_of_a_covariance_gives_it_back():
    C = covariance(3)
    root = Covariance.of(C).root
    # an eigendecomposition's rounding
    np.testing.assert_allclose(root @ root.T, C, rtol=1e-9, atol=1e-12 * C.max())


# a measured wrench


def recorded(seed=0, body=BODY, bias=None, late=0.0, on_sensor=False) -> Recording:
    """A recording of another motion, with noise on everything."""
    log = simulate(
        PLANNED, body, noise=NOISE, bias=bias, on_sensor=on_sensor, seed=seed
    )
    wrench = log["wrench"]
    return replace(
        log, streams={**log.streams, "wrench": replace(wrench, time=wrench.time + late)}
    )


def test_a_right_estimate_agrees_but_for_noise():
    found = predict(estimate_of(covariance=1e-6 * covariance()), recorded())
    a = found.agreement
    assert a is not None
    # 1000 samples of 3 axes: 1.3 % is a deviation; smoothed noisy poses add 0.02 N and
    # 0.002 N m at most
    np.testing.assert_allclose(a.rms, (NOISE.force, NOISE.torque), rtol=0.1)
    np.testing.assert_allclose(a.own, a.rms, rtol=0.02)
    assert abs(a.within - 0.95).max() < 0.015  # a deviation of 0.004
    assert (a.sign.on_object, a.warnings) == (True, ())
    assert len(found) == len(PLANNED.time)
    assert found.motion_std is not None
    off = (found.wrench - wield(PLANNED, BODY).wrench).reshape(-1, 2, 3)
    # the poses' noise: some 30 independent errors, measured 0.7 to 1.25 times what
    # smoothing says in six recordings
    np.testing.assert_allclose(
        np.sqrt(np.mean(off**2, axis=(0, 2))), found.motion_std, rtol=0.45
    )


def test_sign_bias_and_delay_are_put_right():
    # as recorded; an estimate holds it in the project's sign
    bias = np.array((4.0, -7.0, 12.0, 0.2, -0.3, 0.1))
    estimate = estimate_of(covariance=1e-6 * covariance(), bias=-bias)
    log = recorded(bias=bias, late=0.03, on_sensor=True)
    found = predict(estimate, log)
    a = found.agreement
    assert a is not None
    np.testing.assert_allclose(a.rms, (NOISE.force, NOISE.torque), rtol=0.1)
    assert not a.sign.on_object
    assert any("late" in line for line in a.notes)
    # the same poses
    np.testing.assert_allclose(
        found.wrench, predict(estimate, recorded()).wrench, atol=1e-12
    )
    # 4.5 deviations and 2
    np.testing.assert_allclose(
        a.wrench, wield(PLANNED, BODY).wrench[: len(a.time)], atol=1.0
    )
    wrong = predict(replace(estimate, bias=None), log).agreement
    assert wrong is not None
    # what is left is the bias with the project's sign, and what does not vary is the
    # noise alone
    np.testing.assert_allclose(wrong.difference.mean(axis=0), -bias, atol=0.05)
    np.testing.assert_allclose(wrong.varying, a.rms, rtol=0.02)
    assert any("a bias other than the estimate's" in line for line in wrong.warnings)


@pytest.mark.parametrize(
    ("ratio", "level"), [(1.05, "usable with care"), (1.2, "do not use")]
)
def test_a_wrong_estimate_shows(ratio, level):
    heavy = InertialParameters(BODY.vector * ratio)
    found = predict(estimate_of(heavy, covariance=1e-6 * covariance()), recorded())
    assert found.verdict.level == level
    a = found.agreement
    assert a is not None
    assert a.own is not None
    assert a.rms[0] > 3.0 * a.own[0]  # 5 % of 17 N
    assert a.within is not None
    assert a.within[0] < 0.6
    assert "another-object" in codes(a.warnings)


def test_a_tool_that_the_sensor_bears_as_well():
    """An estimate made beside a tool predicts the recording of both with the tool, and
    without it the tool is named."""
    share = 0.3  # of a body that both have: their sum is it
    tool = estimate_of(InertialParameters(BODY.vector * share), covariance=covariance())
    alone = estimate_of(
        InertialParameters(BODY.vector * (1.0 - share)),
        covariance=1e-6 * covariance(),
        provenance={"tool": list(tool.parameters.vector)},
    )
    without = predict(alone, recorded())
    assert without.verdict.level == "do not use"
    assert any("give `tool`" in reason for reason in without.verdict.reasons)
    found = predict(alone, recorded(), tool=tool)
    assert found.verdict.level == "good"
    assert "tool-subtracted" not in codes(found.warnings)
    whole = predict(estimate_of(covariance=covariance()), recorded())
    np.testing.assert_allclose(found.wrench, whole.wrench, atol=1e-9)  # [N], rounding
    assert found.std is not None
    np.testing.assert_allclose(found.std, whole.std, rtol=1e-5)  # 1e-6 of variance
    assert found.method == "OLS with the tool of 0.51 kg"


def test_another_bias_is_no_other_object():
    """The share within the band is of what varies."""
    recording = recorded()
    wrench = recording["wrench"]
    bias = np.array((5.0, -3.0, 2.0, 0.3, 0.1, -0.2))
    moved = Stream(wrench.time, wrench.values + bias)
    streams = {**recording.streams, "wrench": moved}
    estimate = estimate_of(BODY, covariance=1e-6 * covariance())
    a = predict(estimate, replace(recording, streams=streams)).agreement
    assert a is not None
    assert a.within is not None
    assert codes(a.warnings) == {"constant-difference"}
    shown = wrench_text(a.difference.mean(axis=0))
    assert f"is constant, {shown}: a bias" in str(a.warnings[0])
    assert (a.within > 0.9).all()


def test_of_several_biases_that_of_the_recording_is_subtracted():
    """An estimate of several recordings has a bias of each."""
    biases = np.array(
        ((4.0, -7.0, 12.0, 0.2, -0.3, 0.1), (1.0, 2.0, 3.0, 0.0, 0.1, 0.2))
    )
    estimate = estimate_of(covariance=1e-6 * covariance(), bias=biases)
    for bias, right in ((biases[0], True), (biases[1], True), (-biases[1], False)):
        a = predict(estimate, recorded(bias=bias)).agreement
        assert a is not None
        assert ("constant-difference" not in codes(a.warnings)) is right


def test_a_wrench_that_cannot_be_compared_is_said_or_left():
    zeros = poses(OTHER, wrench=np.zeros((len(OTHER.time), 6)))
    assert predict(estimate_of(), zeros).agreement is None
    late = poses(OTHER)
    elsewhen = Stream(OTHER.time + 100.0, np.ones((len(OTHER.time), 6)))
    found = predict(
        estimate_of(), replace(late, streams={**late.streams, "wrench": elsewhen})
    )
    assert found.agreement is None
    assert any("not compared" in line for line in found.warnings)


# what is assumed, and what cannot be


def test_what_the_estimate_was_made_with_is_said():
    made = {
        "tool": [0.8, *[0.01] * 9],
        "gravity": [0.0, 1.0, -9.75],
        "wrench": "on-object",
    }
    said = " ".join(predict(estimate_of(provenance=made), columns(OTHER)).warnings)
    assert "a tool of 0.8 kg" in said
    assert "made with gravity (0, 1, -9.75)" in said
    for nonsense in ("x", [1, 2], {"a": 1}, [None] * 10, [float("nan")] * 3, 10**400):
        found = predict(
            estimate_of(provenance={"tool": nonsense, "gravity": nonsense}),
            columns(OTHER),
        )
        assert len(found.warnings) == 1, "only that there is no band"
    assert "no body has" in " ".join(
        predict(estimate_of(InertialParameters(-BODY.vector)), columns(OTHER)).warnings
    )


def test_columns_that_cover_a_part():
    log = columns(OTHER)
    short = log["linear_acceleration"][50:200]
    found = predict(
        estimate_of(),
        replace(log, streams={**log.streams, "linear_acceleration": short}),
    )
    np.testing.assert_array_equal(found.time, OTHER.time[50:200])
    apart = replace(short, time=short.time + 100.0)
    with pytest.raises(InputError, match="no time in common"):
        predict(
            estimate_of(),
            replace(log, streams={**log.streams, "linear_acceleration": apart}),
        )


def test_motions_that_cannot_be():
    with pytest.raises(InputError, match="has no orientation"):
        predict(
            estimate_of(),
            Recording({"joint_positions": Stream(OTHER.time, OTHER.position)}),
        )
    with pytest.raises(InputError, match="too few"):
        predict(estimate_of(), poses(OTHER).slice(0.0, 0.05))
    with pytest.raises(InputError, match="three numbers"):
        predict(estimate_of(), poses(OTHER), gravity=(0.0, 0.0))
    with pytest.raises(InputError, match="columns"):
        predict(estimate_of(), poses(OTHER), motion="columns")
    with pytest.raises(InputError, match="not finite"):
        predict(estimate_of(InertialParameters(np.full(10, 1e308))), poses(OTHER))
    many = np.arange(MOST + 1.0)
    still = Recording(
        {"orientation": Stream(many, np.tile((0.0, 0.0, 0.0, 1.0), (len(many), 1)))}
    )
    with pytest.raises(InputError, match="`duration`"):
        predict(estimate_of(), still)


def test_a_held_pose_and_one_pose():
    held = Recording(
        {
            "orientation": Stream(
                np.arange(20.0) / 10.0, np.tile((0.0, 0.0, 0.0, 1.0), (20, 1))
            )
        }
    )
    found = predict(estimate_of(), held)
    assert found.source == "static"
    np.testing.assert_allclose(
        found.wrench[:, :3], [[0.0, 0.0, 9.80665 * 1.7]] * 20, atol=1e-14
    )
    one = predict(
        estimate_of(),
        Recording({"orientation": Stream([0.0], [[0.0, 0.0, 0.0, 1.0]])}, static=True),
    )
    assert len(one) == 1


def test_the_result_is_frozen_and_public(tmp_path):
    found = predict(estimate_of(covariance=covariance()), columns(OTHER))
    assert isinstance(found, Prediction)
    assert predict is module_function
    for array in (found.time, found.wrench, found.std):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    estimate_of(covariance=covariance()).save(tmp_path / "e.json")
    again = predict(tmp_path / "e.json", columns(OTHER))
    np.testing.assert_array_equal(again.wrench, found.wrench)  # JSON keeps every digit
    held = SimpleNamespace(estimate=estimate_of(covariance=covariance()))  # an answer
    np.testing.assert_array_equal(predict(held, columns(OTHER)).wrench, found.wrench)
    assert repr(found).startswith("Prediction by OLS, verdict: good\n  largest force")
    assert len(repr(found)) < 1000
    for name, (lowest, highest) in found.extremes.items():
        column = found.wrench[:, ("fx", "fy", "fz", "tx", "ty", "tz").index(name)]
        assert (lowest.value, highest.value) == (column.min(), column.max())
        assert lowest.time == found.time[column.argmin()]
