"""Joint torques against Pinocchio and MuJoCo, and their moments by time scale."""

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.torques_live import LiveTorques

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.estimators import OLS
from hefting.identification.torque_checks import of_arm, of_joints, of_unit
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS
from hefting.simulation.wield import inverse_dynamics
from hefting.torques import equations
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OFFSET_CHANGE, OWN, Rows, TorqueScales
from hefting.torques.noise import fit
from hefting.torques.rivals import better_rival
from hefting.torques.runs import EmptyRuns, LoadedRuns, drifting
from hefting.torques.samples import TorqueSamples, averages
from torque_runs import BODY, dynamics, fitted, runs


@pytest.mark.parametrize("name", list(TORQUE_ARMS))
def test_columns_are_those_of_mujoco(name):
    massive, own = TORQUE_ARMS[name], dynamics(name)
    joints = wide_smooth(2.0, 50.0, 3, massive.arm)
    W = own.regressor(joints.position, joints.velocity, joints.acceleration)
    bare = inverse_dynamics(massive.arm, joints, massive.links, None)
    held = inverse_dynamics(massive.arm, joints, massive.links, BODY)
    # rounding of some tens of N m
    np.testing.assert_allclose(W @ own.arm, bare, atol=1e-11)
    payload = W[..., -10:] @ own.payload @ BODY.vector
    np.testing.assert_allclose(payload, held - bare, atol=1e-11)


def test_base_columns_span_all_and_no_fewer_do():
    """Their number is that known of a Panda, and of a UR arm."""
    own = dynamics("panda")
    assert len(own.base) == 43
    assert len(dynamics("ur5e").base) == 36
    rng = np.random.default_rng(9)
    q, dq, ddq = rng.uniform(-2.0, 2.0, (3, 30, 7))
    W = own.regressor(q, dq, ddq).reshape(-1, 70)
    left = W - W[:, own.base] @ np.linalg.lstsq(W[:, own.base], W, rcond=None)[0]
    # rounding, as the constant that makes the choice
    assert np.abs(left).max() < 1e-7
    torque = W[:, own.base] @ own.links @ own.arm
    np.testing.assert_allclose(torque, W @ own.arm, atol=1e-8)


def rows(count: int, seed: int = 0) -> Rows:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((count, 7, len(OWN) + 11))
    return Rows(values, np.arange(count) / 100.0, rng.random((count, 7)) < 0.9)


def test_time_scales_together_are_all_rows():
    part = rows(1000)
    scales = TorqueScales.empty(7, len(OWN)).fold(part)
    whole = scales.whole.factors
    A = part.values * part.used[:, :, None]
    for j in range(7):
        # the transform is orthonormal
        np.testing.assert_allclose(
            whole[j].T @ whole[j], A[:, j].T @ A[:, j], atol=1e-9
        )
    np.testing.assert_allclose(scales.counts.sum(axis=0), part.used.sum(axis=0))
    assert scales.samples == 1000


def test_without_scales_the_least_squares_are_the_same():
    """As of the fits that only tell the torques by which friction grows."""
    part, empty = rows(1000, seed=2), TorqueScales.empty(7, len(OWN))
    found, want = (
        fit(TorqueScales(empty.levels[:levels]).fold(part), drifting)
        for levels in (1, 4)
    )
    assert len(found.scales.levels) == 1
    np.testing.assert_allclose(found.std, want.std, rtol=1e-9)
    np.testing.assert_allclose(found.common, want.common, atol=1e-9)


def test_live_rows_are_those_of_a_recording():
    part = rows(300, seed=1)
    live = LiveTorques.empty(7, len(OWN))
    size = live.size
    for value, time, used in zip(part.values, part.time, part.used, strict=True):
        live.add(value, time, used)
    want = TorqueScales.empty(7, len(OWN)).fold(part)
    for one, other in zip(live.scales.levels, want.levels, strict=True):
        square = one.factors.transpose(0, 2, 1) @ one.factors
        expected = other.factors.transpose(0, 2, 1) @ other.factors
        # 300 rows are two whole blocks and a part of one: the same pairs
        np.testing.assert_allclose(square, expected, atol=1e-9)
    assert live.size == size
    assert live.scales.samples == 300


def test_the_covariance_is_that_of_many_draws():
    """Of noise that is slow, by least squares over 200 draws: 10 % is twice the
    standard error of a standard deviation of them; the columns are drawn once."""
    rng = np.random.default_rng(4)
    count, draws = 1024, 200
    x = np.cumsum(rng.standard_normal((count, 4, 10)), axis=0) / 30.0
    values = np.zeros((count, 4, len(OWN) + 11))
    values[..., 0], values[..., -11:-1] = 1.0, x
    used = np.ones((count, 4), dtype=bool)
    found, said = [], []
    for _ in range(draws):
        slow = rng.standard_normal((count // 16, 4)).repeat(16, axis=0)
        values[..., -1] = 0.1 * slow + 0.02 * rng.standard_normal((count, 4))
        part = Rows(values.copy(), np.arange(count) / 100.0, used)
        own = fit(TorqueScales.empty(4, len(OWN)).fold(part), drifting)
        found.append(own.common)
        said.append(np.sqrt(own.covariance.diagonal()))
    ratio = np.median(said, axis=0) / np.std(found, axis=0)
    assert np.abs(np.median(ratio) - 1.0) < 0.15
    assert ratio.min() > 0.7


def test_the_covariance_allows_for_changes_of_the_offsets():
    """By as much as their prior says, between a run without and one with the payload; by
    the noise alone said standard deviations were half of those of the draws."""
    rng = np.random.default_rng(5)
    count, draws = 128, 120
    values = np.zeros((count, 4, len(OWN) + 11))
    values[..., 0], values[count // 2 :, :, OFFSET_CHANGE] = 1.0, 1.0
    x = 0.1 * rng.standard_normal((count // 2, 4, 10))
    values[count // 2 :, :, -11:-1] = x + rng.standard_normal((4, 10))
    used = np.ones((count, 4), dtype=bool)
    found, said = [], []
    for _ in range(draws):
        change = 0.02 * rng.standard_normal(4) * values[..., OFFSET_CHANGE]
        values[..., -1] = change + 0.1 * rng.standard_normal((count, 4))
        part = Rows(values.copy(), np.arange(count) / 100.0, used)
        own = fit(TorqueScales.empty(4, len(OWN)).fold(part), drifting)
        found.append(own.common)
        said.append(np.linalg.eigvalsh(own.covariance))
    want = np.linalg.eigvalsh(np.cov(np.transpose(found)))
    ratio = np.sqrt(np.median(said, axis=0) / want)
    assert np.abs(np.median(ratio) - 1.0) < 0.15
    assert ratio.min() > 0.7


def test_an_empty_run_of_another_motion_tells_the_arm():
    """One of the 120 simulated objects of the benchmark; its motion, frictions, rotors,
    offsets and warm-up are not those of the fit."""
    case = runs("ur5e")
    found = OLS().estimate(fitted("ur5e").state)
    # three times what 90 % of them keep to
    assert abs(found.mass - 0.8) < 0.012
    assert np.linalg.norm(found.center_of_mass - BODY.center_of_mass) < 6e-3
    known = OLS().estimate(replace(case, empty=()).fit().state)
    assert abs(known.mass - 0.8) > abs(found.mass - 0.8)


@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_friction_by_load_is_that_of_the_arm_and_payload_found(name):
    """Of 15 % of the torque of 1.6 kg and an arm a tenth heavier than its URDF's. By the
    load of a first fit, of no payload, mass and COM were 0.2 % and 0.4 to 0.8 mm off, and
    the noise of 0.01 N m seemed to be 0.2."""
    case, own = runs(name), dynamics(name)
    rng, body = np.random.default_rng(0), 2.0 * BODY.vector

    def made(run: TorqueSamples, held: bool) -> TorqueSamples:
        W = own.regressor(run.position, run.velocity, run.acceleration)
        rigid = W @ (1.1 * own.arm) + held * (W[..., -10:] @ own.payload @ body)
        friction = (1.0 + 0.15 * np.abs(rigid)) * np.tanh(run.velocity / 0.01)
        torque = rigid + friction + 0.01 * rng.standard_normal(rigid.shape)
        return replace(run, torque=torque)

    loaded = tuple(made(run, held=True) for run in case.loaded)
    empty = tuple(made(run, held=False) for run in case.empty)
    mass, *moment = replace(case, loaded=loaded, empty=empty).fit().common[-10:-6]
    assert mass == pytest.approx(2.0 * BODY.mass, rel=1e-3)
    assert np.linalg.norm(moment / mass - BODY.center_of_mass) < 2e-4


def built_up(run: TorqueSamples, travel: float) -> TorqueSamples:
    """A run whose friction of 1 N m follows the sign of the speed over some `travel`
    [rad]."""
    sign = np.sign(run.velocity)
    share = np.exp(-np.abs(np.diff(run.position, axis=0)) / travel)
    friction = sign.copy()
    for k, left in enumerate(share, 1):
        friction[k] += (friction[k - 1] - sign[k]) * left
    return replace(run, torque=run.torque + friction - sign)


def test_friction_that_builds_up_over_some_travel_changes_nothing():
    """Before, such friction moved this mass by 0.5 standard deviations, and widened
    its interval by 16 %."""
    case = runs("panda")
    loaded, empty = (
        tuple(built_up(run, 0.002) for run in each)
        for each in (case.loaded, case.empty)
    )
    found = replace(case, loaded=loaded, empty=empty).fit()
    std = fitted("panda").covariance[0, 0] ** 0.5
    assert abs(found.common[-10] - fitted("panda").common[-10]) < 0.1 * std
    assert found.covariance[0, 0] ** 0.5 < 1.01 * std


def test_a_joint_slides_some_travel_after_it_was_slow_or_turned():
    """Fast all the time but for a stop; the last joint turns between two samples."""
    moves = np.full((12, 2), 0.004)
    moves[5:, 1], moves[6, 0] = -0.004, 1e-5
    position = 1.0 + np.cumsum(moves, axis=0)
    run = TorqueSamples(
        np.arange(12) / 100, position, 100 * moves, 0 * moves, 0 * moves
    )
    want = np.ones((12, 2), dtype=bool)
    # unknown at first; a second sample is beyond 5 mrad
    want[:2], want[6:8, 0], want[5:7, 1] = False, False, False
    np.testing.assert_array_equal(run.sliding, want)


def test_a_run_in_several_pieces_has_the_rows_of_one(monkeypatch):
    own, run = dynamics("panda"), runs("panda").loaded[0][:400]
    run = replace(run, time=0.2 * run.time)  # two or three samples in each average
    one = Rows.of(own, run, True)
    monkeypatch.setattr(equations, "ROWS_TOGETHER", 30)
    pieces = Rows.of(own, run, True)
    assert len(one.time) < 250
    np.testing.assert_array_equal(pieces.used, one.used)
    np.testing.assert_array_equal(pieces.values, one.values)
    np.testing.assert_array_equal(pieces.time, one.time)


def test_samples_that_are_alone_are_not_averaged():
    """They had been gone through column by column, in a twentieth of the time of fits."""
    values = np.arange(6.0).reshape(3, 2)
    assert averages(values, np.arange(3)) is values
    found = averages(values, np.array([0, 2]))
    np.testing.assert_array_equal(found, [[1.0, 2.0], [4.0, 5.0]])


def test_offsets_that_change_between_the_runs_are_in_the_interval():
    """By five times what is usual, up and down, which put the mass 4 standard deviations
    wrong."""
    case = runs("ur5e")
    (empty,) = case.empty
    shift = 0.3 * np.array((1.0, 1.0, -1.0, 1.0, -1.0, 1.0))
    found = replace(case, empty=(replace(empty, torque=empty.torque + shift),)).fit()
    error = found.common[-10] - BODY.mass
    assert abs(error) < 3.0 * found.covariance[0, 0] ** 0.5
    assert found.prior[-1].min() > 3.0 * fitted("ur5e").prior[-1].min()


def with_torques(
    case: LoadedRuns, change: Callable[[TorqueSamples], Array], both: bool
):
    loaded, empty = (
        tuple(replace(run, torque=change(run)) for run in each)
        for each in (case.loaded, case.empty)
    )
    return replace(case, loaded=loaded, empty=empty if both else case.empty)


@pytest.mark.parametrize(("name", "seed"), [("panda", 3), ("ur5e", 6)])
def test_gains_that_data_sheets_allow_are_no_change_of_offsets(name, seed):
    """Of 1 %: offsets and friction had changed 4 times as much as is usual."""
    case = runs(name)
    gains = 1.0 + 0.01 * np.random.default_rng(seed).standard_normal(
        case.dynamics.joints
    )
    case = with_torques(case, lambda run: gains * run.torque, True)
    assert not of_arm(case, case.fit(), case.alone())


def test_viscous_friction_that_changes_between_the_runs_contradicts_nothing():
    """By 0.2 N m s/rad, of grease that warms up: the empty run had been another arm's."""
    case = with_torques(
        runs("ur5e"), lambda run: run.torque + 0.2 * run.velocity, False
    )
    found = case.fit()
    (said,) = of_arm(case, found, case.alone())
    assert (said.code, said.severity) == ("joints-changed", "warning")
    assert found.common[-10] == pytest.approx(BODY.mass, rel=2e-3)


def test_a_joint_that_hardly_moves_is_no_rival():
    """Nor is one whose torque has less noise: here every other joint stands still, with
    a tenth of the noise of those that move."""
    own = dynamics("ur5e")
    run = runs("ur5e").loaded[0]
    still = np.arange(6) % 2 == 1
    stopped = replace(
        run,
        position=np.where(still, run.position[:1], run.position),
        velocity=np.where(still, 0.0, run.velocity),
        acceleration=np.where(still, 0.0, run.acceleration),
    )
    W = own.regressor(stopped.position, stopped.velocity, stopped.acceleration)
    noise = np.random.default_rng(2).normal(size=run.torque.shape)
    noise = noise * np.where(still, 0.1, 1.0)
    stopped = replace(stopped, torque=W @ own.arm + noise)
    assert better_rival(own, [stopped]) is None


@pytest.mark.parametrize("gain", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("name", list(TORQUE_ARMS))
def test_a_unit_is_told(name, gain):
    own = dynamics(name)
    run = runs(name).loaded[0]
    scaled = replace(run, torque=gain * run.torque)
    said = [m.code for m in of_unit(own, [EmptyRuns.of(own, [scaled]).fit])]
    assert said == ["torque-unit"] * (gain != 1.0)


def test_no_unit_is_told_by_chance(tmp_path):
    """Of a SCARA, whose joints bear no weight, in noise alone: at times they had been
    torques some hundred times too large."""
    parts = ['<robot name="scara"><link name="link0"/>']
    for j in range(3):
        parts.append(
            f'<joint name="j{j}" type="continuous"><parent link="link{j}"/>'
            f'<child link="link{j + 1}"/><origin xyz="{0.3 * (j > 0)} 0 0"/>'
            f'<axis xyz="0 0 1"/></joint><link name="link{j + 1}"><inertial>'
            '<origin xyz="0.15 0 0"/><mass value="3"/><inertia ixx="0.02" iyy="0.02" '
            'izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    (tmp_path / "arm.urdf").write_text("".join(parts) + "</robot>")
    own = JointDynamics.from_urdf(tmp_path / "arm.urdf", "link3")
    time = np.linspace(0.0, 10.0, 500)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        phase = 0.4 * time[:, None] * (1.0, 1.3, 1.7) + rng.uniform(0, 6, 3)
        rate = 0.4 * np.array((1.0, 1.3, 1.7))
        q, dq = np.sin(phase), rate * np.cos(phase)
        torque = rng.standard_normal((500, 3))
        run = TorqueSamples(time, q, dq, -(rate**2) * q, torque)
        said = [m.code for m in of_unit(own, [EmptyRuns.of(own, [run]).fit])]
        assert said == ["torque-unit-untold"]


@pytest.mark.parametrize("name", list(TORQUE_ARMS))
def test_no_unit_is_told_where_the_arm_was_taken_out(name):
    """As external torques, which hold the payload and frictions alone."""
    own = dynamics(name)
    run = runs(name).loaded[0]
    arm = own.regressor(run.position, run.velocity, run.acceleration) @ own.arm
    external = replace(run, torque=run.torque - arm)
    said = [m.code for m in of_unit(own, [EmptyRuns.of(own, [external]).fit])]
    assert said == ["torque-unit-untold"]


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_unit_is_told_beside_much_noise(noise):
    """Of 1 N m in each joint, as of a large arm with strain wave gears."""
    own = dynamics("ur5e")
    run = runs("ur5e").loaded[0]
    noisy = run.torque + noise * np.random.default_rng(1).normal(size=run.torque.shape)
    fits = [EmptyRuns.of(own, [replace(run, torque=0.01 * noisy)]).fit]
    assert [m.code for m in of_unit(own, fits)] == ["torque-unit"]


@pytest.mark.parametrize("name", list(TORQUE_ARMS))
def test_a_joint_of_another_gain_is_named(name):
    """Of robots whose links are some percent from the published ones, none is when all
    are right; the second joint moves most of the arm."""
    own = dynamics(name)
    for seed in range(4):
        run = runs(name, seed).empty[0]
        assert not of_joints(own, [EmptyRuns.of(own, [run]).fit])
    run = runs(name, 0).empty[0]
    gains = np.where(np.arange(own.joints) == 1, 1.3, 1.0)
    fits = [EmptyRuns.of(own, [replace(run, torque=run.torque * gains)]).fit]
    (said,) = of_joints(own, fits)
    assert said.code == "torque-gain"
    assert f"{own.names[1]} 1." in said


def test_bad_robots_are_refused(tmp_path):
    text = TORQUE_ARMS["ur5e"].urdf
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.raises(InputError, match="no joint moves"):
        JointDynamics.from_urdf(path, "base")
    with pytest.raises(InputError, match="no frame is named"):
        JointDynamics.from_urdf(path, "hand")
    with pytest.raises(InputError, match="not all zero"):
        JointDynamics.from_urdf(path, "flange", (0.0, 0.0, 0.0))


def test_without_pinocchio_the_error_says_what_to_install(tmp_path, monkeypatch):
    path = tmp_path / "arm.urdf"
    path.write_text(TORQUE_ARMS["ur5e"].urdf)
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(Exception, match=r"pip install 'hefting\[robot\]'"):
        JointDynamics.from_urdf(path, "flange")
