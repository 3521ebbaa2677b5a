"""Whole simulated motions against MuJoCo, which has its own kinematics and dynamics.

The UR5 of this file is made from its maker's table, link by link; that of the library
from its screws at rest.
"""

import numpy as np
import pytest

from arms import mounted
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.inertia import InertialParameters
from hefting.core.regressor import predict_wrench
from hefting.simulation import (
    MODULAR,
    UR5,
    XARM7,
    Arm,
    modular,
    random_smooth,
    sinusoids,
    stop_and_go,
    wield,
    wield_analytically,
    wield_in_mujoco,
)
from hefting.simulation.modular import grasp

mujoco = pytest.importorskip(
    "mujoco", reason="MuJoCo is not installed (pip install 'hefting[sim]')"
)

BODIES = {
    "compact": InertialParameters.from_com(
        0.6, (0.001, -0.002, 0.03), np.diag((2e-4, 3e-4, 4e-4))
    ),
    "offset": InertialParameters.from_com(
        1.7, (0.12, -0.21, 0.08), np.diag((2e-2, 3e-2, 1.5e-2))
    ),
    "full tensor": InertialParameters.from_com(
        4.2,
        (-0.05, 0.07, 0.15),
        ((0.050, 0.008, -0.011), (0.008, 0.061, 0.006), (-0.011, 0.006, 0.043)),
    ),
    "rod": InertialParameters.from_points(
        ((0.0, 0.1, 0.3), (0.01, 0.1, -0.4), (0.0, 0.11, 0.1)), (0.2, 0.3, 0.1)
    ),
}
MOTIONS = {
    "sinusoids 1 rad/s": lambda: sinusoids(5.0, 20.0, 1.0),
    "sinusoids 4 rad/s": lambda: sinusoids(5.0, 20.0, 4.0),
    "all joints 2 rad/s": lambda: random_smooth(5.0, 20.0, 2.0, seed=3),
    "stop and go": lambda: stop_and_go(6.0, 20.0, seed=4),
}
LENGTHS = (0.0, -0.425, -0.39225, 0.0, 0.0, 0.0)
TWISTS = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
OFFSETS = (0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823)
GRAVITIES = ((0.0, 0.0, -9.80665), (3.0, -1.0, 8.0))


def numbers(*values) -> str:
    return " ".join(repr(float(value)) for value in values)


def place(link: int) -> str:
    """Pose of the frame after a link at joint angle zero: Tz(d) Tx(a) Rx(alpha)."""
    half = 0.5 * TWISTS[link]
    return f'pos="{numbers(LENGTHS[link], 0, OFFSETS[link])}" quat="{numbers(np.cos(half), np.sin(half), 0, 0)}"'


def chain(body: InertialParameters, gravity) -> str:
    """MJCF of the UR5 as nested bodies, with `body` at its end.

    In MuJoCo a hinge turns its own body: body i stands where link i - 1 ends at q = 0
    and turns about its z. MuJoCo diagonalises the tensor itself; the links have an
    arbitrary mass, which must not matter.
    """
    J = body.inertia_at_com
    tensor = numbers(J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    inertial = f'mass="{body.mass!r}" pos="{numbers(*body.center_of_mass)}" fullinertia="{tensor}"'
    bodies = f'<body {place(5)}><site name="sensor"/><inertial {inertial}/></body>'
    for i in reversed(range(6)):
        link = '<joint type="hinge" axis="0 0 1"/><inertial mass="3" pos="0.1 0 0" diaginertia="0.1 0.1 0.1"/>'
        bodies = f"<body {place(i - 1) if i else ''}>{link}{bodies}</body>"
    frame = (
        "framepos",
        "framequat",
        "framelinvel",
        "frameangvel",
        "framelinacc",
        "frameangacc",
    )
    shown = "".join(f'<{name} objtype="site" objname="sensor"/>' for name in frame)
    return (
        f'<mujoco><option gravity="{numbers(*gravity)}"/><worldbody>{bodies}</worldbody>'
        f'<sensor><force site="sensor"/><torque site="sensor"/>{shown}</sensor></mujoco>'
    )


def sensors(body, joints, gravity) -> np.ndarray:
    """(K, 25) MuJoCo's sensors in inverse dynamics with prescribed joint motion."""
    model = mujoco.MjModel.from_xml_string(chain(body, gravity))
    data = mujoco.MjData(model)
    out = np.empty((len(joints.time), model.nsensordata))
    for k in range(len(out)):
        data.qpos[:] = joints.position[k]
        data.qvel[:] = joints.velocity[k]
        data.qacc[:] = joints.acceleration[k]
        mujoco.mj_inverse(model, data)
        out[k] = data.sensordata
    return out


def test_sign_of_mujocos_force_sensor():
    """At rest MuJoCo shows m g, upward: what the parent exerts on the child, the
    project's own sign."""
    body, joints = BODIES["offset"], stop_and_go(0.1, 10.0)
    assert not joints.velocity.any()
    force = sensors(body, joints, GRAVITIES[0])[0, :3]
    upward = UR5.motion(joints).rotation[0] @ force
    # rounding of 17 N
    np.testing.assert_allclose(upward, (0.0, 0.0, body.mass * 9.80665), atol=1e-12)


@pytest.mark.parametrize("gravity", GRAVITIES, ids=("upright", "tilted"))
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", BODIES)
def test_wrench_of_whole_motions(name, motion, gravity):
    body, joints = BODIES[name], MOTIONS[motion]()
    expected = sensors(body, joints, gravity)
    measurements = wield(UR5.motion(joints), body, gravity)
    for wrench in (measurements.wrench, predict_wrench(measurements, body.vector)):
        for part in (slice(0, 3), slice(3, 6)):
            error = np.abs(wrench[:, part] - expected[:, part]).max()
            # 1e-6 asked for; both are exact formulas in double precision over a chain
            # of six
            assert error < 1e-10 * np.abs(expected[:, part]).max()


@pytest.mark.parametrize("motion", MOTIONS)
def test_arm_motion(motion):
    """Pose, velocities and accelerations of the sensor, MuJoCo's linear acceleration
    being a - g."""
    joints = MOTIONS[motion]()
    ours = UR5.motion(joints)
    theirs = sensors(BODIES["compact"], joints, GRAVITIES[0])
    wxyz = ours.orientation[:, [3, 0, 1, 2]]
    same = np.abs(np.einsum("ki,ki->k", wxyz, theirs[:, 9:13]))
    np.testing.assert_allclose(same, 1.0, atol=1e-12)  # rounding over six rotations
    pairs = (
        (ours.position, theirs[:, 6:9]),
        (ours.linear_velocity, theirs[:, 13:16]),
        (ours.angular_velocity, theirs[:, 16:19]),
        (ours.linear_acceleration - GRAVITIES[0], theirs[:, 19:22]),
        (ours.angular_acceleration, theirs[:, 22:25]),
    )
    for mine, other in pairs:
        np.testing.assert_allclose(
            mine, other, atol=1e-11 * max(1.0, np.abs(other).max())
        )


def test_a_wrong_parameter_shows():
    """The comparison can fail: a promille more of any of the ten parameters is far
    above its tolerance."""
    body, joints = BODIES["full tensor"], MOTIONS["sinusoids 1 rad/s"]()
    expected = sensors(body, joints, GRAVITIES[0])[:, :6]
    measurements = wield(UR5.motion(joints), body)
    for i in range(10):
        vector = body.vector.copy()
        vector[i] *= 1.001
        error = np.abs(predict_wrench(measurements, vector) - expected).max()
        assert error > 1e-6 * np.abs(expected[:, 3:]).max()


# the library's own use of MuJoCo

SLIDER = """<robot name="gantry">
  <link name="base"/><link name="carriage"/><link name="elbow"/><link name="hand"/><link name="sensor"/>
  <joint name="rail" type="prismatic"><parent link="base"/><child link="carriage"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.1"/><axis xyz="1 2 0"/></joint>
  <joint name="turn" type="continuous"><parent link="carriage"/><child link="elbow"/>
    <origin xyz="0 0.1 0.4" rpy="0.5 0 1"/><axis xyz="0 1 1"/></joint>
  <joint name="follower" type="revolute"><parent link="elbow"/><child link="hand"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/>
    <mimic joint="turn" multiplier="-0.7" offset="0.2"/></joint>
  <joint name="mount" type="fixed"><parent link="hand"/><child link="sensor"/>
    <origin xyz="0.02 0.03 0.1" rpy="0.1 0.2 0.3"/></joint>
</robot>"""
FIELDS = (
    "position",
    "rotation",
    "linear_velocity",
    "angular_velocity",
    "linear_acceleration",
    "angular_acceleration",
)


def relative_errors(measurements, parameters):
    """Of the regressor's force and torque, over the largest of each."""
    predicted = predict_wrench(measurements, parameters.vector)
    for part, shown in (
        (predicted[:, :3], measurements.force),
        (predicted[:, 3:], measurements.torque),
    ):
        yield np.abs(part - shown).max() / np.abs(shown).max()


def test_the_librarys_chain_is_the_one_made_link_by_link():
    body, joints = BODIES["full tensor"], random_smooth(5.0, 20.0, 2.0, seed=3)
    expected = sensors(body, joints, GRAVITIES[1])
    found = wield_in_mujoco(UR5, joints, body, GRAVITIES[1])
    # rounding of 40 N
    np.testing.assert_allclose(found.measurements.wrench, expected[:, :6], atol=1e-12)
    np.testing.assert_allclose(found.motion.position, expected[:, 6:9], atol=1e-14)
    np.testing.assert_allclose(
        found.motion.linear_acceleration - GRAVITIES[1], expected[:, 19:22], atol=1e-12
    )


@pytest.mark.parametrize(
    "arm",
    [UR5, XARM7, mounted(XARM7, 0.115)],
    ids=("ur5", "xarm7", "xarm7, sensor further out"),
)
@pytest.mark.parametrize("speed", [1.0, 1.5, 2.0, 3.0, 4.0])
def test_simulator_and_model_check_each_other(arm, speed):
    """All objects, speeds and arms: the regressor predicts what MuJoCo's sensors
    show."""
    joints = sinusoids(5.0, 50.0, speed, arm)
    for name in MODULAR:
        body = modular(name).parameters.moved(grasp())
        found = wield_in_mujoco(arm, joints, body)
        # 1e-6 asked for; both are exact formulas in double precision over a chain of
        # seven
        assert max(relative_errors(found.measurements, body)) < 1e-11
    ours = wield_analytically(arm, joints, body)
    for field in FIELDS:
        theirs, mine = getattr(found.motion, field), getattr(ours.motion, field)
        np.testing.assert_allclose(
            mine, theirs, atol=1e-12 * max(1.0, np.abs(theirs).max())
        )
    np.testing.assert_allclose(
        ours.measurements.wrench, found.measurements.wrench, atol=1e-11
    )


def test_joints_that_slide_and_mimic(tmp_path):
    """A URDF with a rail, a joint that follows another, and fixed joints."""
    (tmp_path / "gantry.urdf").write_text(SLIDER)
    arm = Arm.from_urdf(tmp_path / "gantry.urdf", "sensor")
    rng, time = np.random.default_rng(5), np.arange(0.0, 3.0, 0.05)
    frequency, amplitude = rng.uniform(1.0, 4.0, 2), np.array((0.3, 1.0))
    angle = time[:, None] * frequency
    from hefting.simulation.arm import JointMotion

    q = np.sin(angle)
    dq = frequency * np.cos(angle)
    ddq = -(frequency**2) * np.sin(angle)
    joints = JointMotion(time, amplitude * q, amplitude * dq, amplitude * ddq)
    body = BODIES["full tensor"]
    found, ours = wield_in_mujoco(arm, joints, body, GRAVITIES[1]), arm.motion(joints)
    position, orientation = arm.robot.poses(joints.position)
    np.testing.assert_allclose(ours.position, position, atol=1e-14)
    np.testing.assert_allclose(
        np.abs((ours.orientation * orientation).sum(axis=1)), 1.0, atol=1e-14
    )
    for field in FIELDS:
        theirs, mine = getattr(found.motion, field), getattr(ours, field)
        np.testing.assert_allclose(
            mine, theirs, atol=1e-12 * max(1.0, np.abs(theirs).max())
        )
    assert max(relative_errors(found.measurements, body)) < 1e-11


def test_wielding_costs_as_much_more_as_there_are_instants():
    import time

    def cost(rate: float) -> float:
        joints, best = sinusoids(35.0, rate, 1.0), np.inf
        for _ in range(3):
            begin = time.process_time()
            wield_in_mujoco(UR5, joints, body)
            best = min(best, time.process_time() - begin)
        return best

    body = modular("hammer").parameters
    wield_in_mujoco(UR5, sinusoids(1.0, 10.0, 1.0), body)
    # ten times the instants: linear in them, with room for noise
    assert cost(400.0) < 40 * cost(40.0)


def test_bodies_mujoco_cannot_hold_and_no_mujoco(monkeypatch):
    joints = stop_and_go(0.5, 10.0)
    impossible = InertialParameters.from_com(
        1.0, (0.0, 0.0, 0.1), np.diag((1e-3, 1e-3, 5e-3))
    )
    with pytest.raises(InputError, match="triangle inequality"):
        wield_in_mujoco(UR5, joints, impossible)
    with pytest.raises(InputError, match="6 joints, but the arm has 7"):
        wield_in_mujoco(XARM7, joints, BODIES["compact"])
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    with pytest.raises(MissingDependencyError, match=r"hefting\[sim\]"):
        wield_in_mujoco(UR5, joints, BODIES["compact"])
