"""Wielding: the wrench of a moving body, by Newton's and Euler's equations or,
independently, by MuJoCo; and the log that a robot would write of it."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, needing
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.progress import report
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    check_pose,
    frozen,
    immutable,
    rotation_matrices,
)
from hefting.robots.joint_motion import require_its_joints
from hefting.simulation.arm import Arm, JointMotion, SensorMotion

POSE_NOISE = (1e-4, 3.5e-4)
"""Standard deviations, per axis, of a cobot's poses: position [m] and orientation [rad]
(0.02°)."""


def wield(
    motion: SensorMotion,
    body: InertialParameters,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> Measurements:
    """Exact measurements, in sensor axes, of a `body` in the sensor frame that follows
    `motion`.

    The wrench is by Newton's and Euler's equations at the centre of mass, moved to the
    sensor's origin: f = m (a_c - g), tau = J_c alpha + w x J_c w + c x f, without the
    regressors of `hefting.core.regressor`. `gravity` (3,) is in world axes [m/s²].
    Raises `InputError` for a body without mass.
    """
    if not body.mass > 0.0:
        raise InputError(
            f"the mass of a body to wield must be positive, not {body.mass} kg"
        )
    g = np.broadcast_to(np.asarray(gravity, dtype=float), (len(motion.time), 3))
    world = (
        g,
        motion.linear_acceleration,
        motion.angular_velocity,
        motion.angular_acceleration,
    )
    g, a, w, alpha = (np.einsum("kji,kj->ki", motion.rotation, v) for v in world)
    c, J = body.center_of_mass, body.inertia_at_com
    force = body.mass * (a + np.cross(alpha, c) + np.cross(w, np.cross(w, c)) - g)
    torque = alpha @ J.T + np.cross(w, w @ J.T) + np.cross(c, force)
    return Measurements(motion.time, g, a, w, alpha, force, torque)


def simulate(
    motion: SensorMotion,
    body: InertialParameters,
    gravity: ArrayLike = STANDARD_GRAVITY,
    noise: Noise = Noise(),  # noqa: B008 (immutable)
    pose_noise: tuple[float, float] = POSE_NOISE,
    bias: ArrayLike | None = None,
    on_sensor: bool = False,
    seed: int = 0,
    exact: bool = False,
) -> Recording:
    """The log of a robot that wields `body` (in the sensor frame) along `motion`.

    Pose and wrench are recorded at the times of `motion` with seeded Gaussian noise:
    `noise` on the wrench, `pose_noise` on position [m] and orientation [rad], along
    each axis. With `on_sensor` the wrench is that exerted on the sensor, the opposite of
    the project's sign; then `bias` (6,) [N, N m] is added. With `exact` the log has also
    velocities, without noise, and accelerations, with their levels of `noise`.
    """
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    K = len(motion.time)

    def noisy(values: Array, *levels: float) -> Array:
        return values + np.repeat(levels, 3) * rng.normal(size=values.shape)

    wrench = wield(motion, body, gravity).wrench * (-1.0 if on_sensor else 1.0)
    if bias is not None:
        wrench = wrench + np.asarray(bias, dtype=float)
    turn = Rotation.from_rotvec(noisy(np.zeros((K, 3)), pose_noise[1]))
    streams = {
        "position": noisy(motion.position, pose_noise[0]),
        "orientation": (Rotation.from_matrix(motion.rotation) * turn).as_quat(),
        "wrench": noisy(wrench, noise.force, noise.torque),
    }
    if exact:
        streams |= {
            "linear_velocity": motion.linear_velocity,
            "angular_velocity": motion.angular_velocity,
            "linear_acceleration": noisy(
                motion.linear_acceleration, noise.linear_acceleration
            ),
            "angular_acceleration": noisy(
                motion.angular_acceleration, noise.angular_acceleration
            ),
        }
    return Recording(
        {name: Stream(motion.time, values) for name, values in streams.items()},
        source="simulation",
    )


def truth(
    body: InertialParameters,
    extents: ArrayLike,
    pose_object_in_sensor: ArrayLike,
    gravity: ArrayLike = STANDARD_GRAVITY,
    mesh_unit: str = "m",
    on_sensor: bool = False,
    name: str = "object",
) -> dict[str, Any]:
    """The truth, ready for JSON: `body` in the sensor frame, and conventions of log and
    mesh. `extents` (3,) are the sides [m] of the shape's bounding box along the axes of
    its own file."""
    return {
        "name": name,
        "gravity_world": np.asarray(gravity, dtype=float).tolist(),
        "wrench": "on-sensor" if on_sensor else "on-object",
        "mesh_unit": mesh_unit,
        "object_pose_in_sensor": check_pose(pose_object_in_sensor).tolist(),
        "mass": body.mass,
        "center_of_mass_sensor": body.center_of_mass.tolist(),
        "inertia_at_com_sensor_axes": body.inertia_at_com.tolist(),
        "inertia_at_sensor": body.inertia_at_origin.tolist(),
        "mesh_extents_m": np.asarray(extents, dtype=float).tolist(),
    }


MOTION = (
    "framepos",
    "framequat",
    "framelinvel",
    "frameangvel",
    "framelinacc",
    "frameangacc",
)
"""MuJoCo's sensors of the motion of a frame."""

LINK = '<inertial mass="1" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>'
"""Inertial of links without masses: MuJoCo needs one for every moving body; those before
the sensor do not affect its wrench."""


@immutable
class Wielding:
    """An arm that wields a body: exact motion and exact wrench at K instants."""

    arm: Arm
    joints: JointMotion
    body: InertialParameters
    """in the sensor frame"""
    motion: SensorMotion
    """of the sensor frame, in world axes"""
    measurements: Measurements
    """motion, gravity and the wrench of the sensor on the body, in sensor axes"""
    gravity: Array
    """(3,) in world axes [m/s²]"""


def wield_in_mujoco(
    arm: Arm,
    joints: JointMotion,
    body: InertialParameters,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> Wielding:
    """MuJoCo's inverse dynamics of an `arm` that holds `body` (in the sensor frame) and
    follows a motion of its joints.

    Motion and wrench are read from MuJoCo's sensors at the sensor frame. `gravity` (3,)
    is in world axes [m/s²]. Raises `MissingDependencyError` without MuJoCo, `InputError`
    for an impossible body.
    """
    mujoco = _mujoco()
    require_its_joints(arm.robot, joints)
    consistency = body.consistency()
    if not consistency.is_consistent:
        raise InputError(f"MuJoCo cannot hold the body: {consistency}")
    g = np.asarray(gravity, dtype=float)
    with _model(mujoco, mjcf(arm, body, g)) as model:
        return _wield(mujoco, model, arm, joints, body, g)


@contextmanager
def _model(mujoco: Any, text: str) -> Iterator[Any]:
    """MuJoCo's model of an MJCF text. Raises `InputError` for its errors and warnings; by
    default it prints warnings and writes them to a file in the working folder."""
    warned: list[str] = []
    mujoco.set_mju_user_warning(warned.append)
    try:
        try:
            model = mujoco.MjModel.from_xml_string(text)
        except ValueError as error:
            what = f"MuJoCo cannot hold the body ({str(error)[:120]})"
            raise InputError(what) from error
        yield model
    finally:
        mujoco.set_mju_user_warning(None)
    if warned:
        raise InputError(f"MuJoCo cannot move this arm and body ({warned[0][:120]})")


def _wield(
    mujoco: Any,
    model: Any,
    arm: Arm,
    joints: JointMotion,
    body: InertialParameters,
    g: Array,
) -> Wielding:
    data = mujoco.MjData(model)
    columns = [screw.column for screw in arm.robot.screws]
    multiplier = np.array([screw.multiplier for screw in arm.robot.screws])
    offset = np.array([screw.offset for screw in arm.robot.screws])
    position = multiplier * joints.position[:, columns] + offset
    velocity = multiplier * joints.velocity[:, columns]
    acceleration = multiplier * joints.acceleration[:, columns]
    read = np.empty((len(joints.time), model.nsensordata))
    qpos, qvel, qacc, sensors = data.qpos, data.qvel, data.qacc, data.sensordata
    for k in range(len(read)):
        if k % 1000 == 0:
            report("simulating", k / len(read))
        qpos[:], qvel[:], qacc[:] = position[k], velocity[k], acceleration[k]
        mujoco.mj_inverse(model, data)
        read[k] = sensors
    force, torque, place, wxyz, v, w, acc, alpha = np.split(
        read, (3, 6, 9, 13, 16, 19, 22), axis=1
    )
    rotation = rotation_matrices(wxyz[:, [1, 2, 3, 0]])
    # MuJoCo's acceleration is less gravity
    motion = SensorMotion(joints.time, place, rotation, v, w, acc + g, alpha)
    world = (np.broadcast_to(g, w.shape), motion.linear_acceleration, w, alpha)
    down, a, spin, change = (
        np.einsum("kji,kj->ki", rotation, vectors) for vectors in world
    )
    measurements = Measurements(joints.time, down, a, spin, change, force, torque)
    return Wielding(arm, joints, body, motion, measurements, frozen(g))


def mujoco_version() -> str:
    """Version of the installed MuJoCo; `MissingDependencyError` without."""
    return _mujoco().__version__


def wield_analytically(
    arm: Arm,
    joints: JointMotion,
    body: InertialParameters,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> Wielding:
    """As `wield_in_mujoco`, by `Arm.motion` and `wield`, without a simulator."""
    motion = arm.motion(joints)
    return Wielding(
        arm, joints, body, motion, wield(motion, body, gravity), frozen(gravity)
    )


def mjcf(
    arm: Arm,
    body: InertialParameters | None,
    gravity: ArrayLike = STANDARD_GRAVITY,
    links: Sequence[InertialParameters] = (),
) -> str:
    """MJCF of the arm and the held body, if any, with sensors of motion and wrench.

    Bodies are in base axes with all screws at zero, about a point on the screw's axis,
    as are `links`, one per screw, if given. The last is the held body, in the sensor
    frame.
    """
    robot = arm.robot
    inertial = "" if body is None else _inertial(body)
    masses = [_inertial(link) for link in links] or [LINK] * len(robot.screws)
    x, y, z, w = robot.home_orientation
    places = np.diff(
        [np.zeros(3), *(screw.point for screw in robot.screws), robot.home_position],
        axis=0,
    )
    chain = f'<body pos="{numbers(places[-1])}" quat="{numbers((w, x, y, z))}"><site name="sensor"/>{inertial}</body>'
    for screw, place, own in zip(
        reversed(robot.screws), places[-2::-1], reversed(masses), strict=True
    ):
        joint = f'<joint type="{"slide" if screw.slides else "hinge"}" axis="{numbers(screw.axis)}"/>'
        chain = f'<body pos="{numbers(place)}">{joint}{own}{chain}</body>'
    sensors = "".join(f'<{name} objtype="site" objname="sensor"/>' for name in MOTION)
    return (
        f'<mujoco><option gravity="{numbers(np.asarray(gravity, dtype=float))}"/><worldbody>{chain}</worldbody>'
        f'<sensor><force site="sensor"/><torque site="sensor"/>{sensors}</sensor></mujoco>'
    )


def _inertial(body: InertialParameters) -> str:
    J = body.inertia_at_com
    tensor = numbers(J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
    return (
        f'<inertial mass="{body.mass!r}" pos="{numbers(body.center_of_mass)}" '
        f'fullinertia="{tensor}"/>'
    )


def inverse_dynamics(
    arm: Arm,
    joints: JointMotion,
    links: Sequence[InertialParameters],
    body: InertialParameters | None,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> Array:
    """(K, n) torques [N m] of the motors of an arm with `links`, as in `mjcf`, that holds
    `body` (in the sensor frame), if any.

    Raises `MissingDependencyError` without MuJoCo, `InputError` for an impossible body,
    and for joints that mimic others.
    """
    mujoco = _mujoco()
    screws = arm.robot.screws
    if any(
        s.multiplier != 1.0 or s.offset or s.column != i for i, s in enumerate(screws)
    ):
        raise InputError("a joint that mimics another has no torque of its own")
    with _model(mujoco, mjcf(arm, body, gravity, links)) as model:
        data = mujoco.MjData(model)
        torques = np.empty_like(joints.position)
        for k in range(len(torques)):
            data.qpos[:] = joints.position[k]
            data.qvel[:] = joints.velocity[k]
            data.qacc[:] = joints.acceleration[k]
            mujoco.mj_inverse(model, data)
            torques[k] = data.qfrc_inverse
    return torques


def _mujoco() -> Any:
    with needing("mujoco", "sim"):
        return import_module("mujoco")


def numbers(values: Iterable[float]) -> str:
    """Values as text, separated by blanks, that is read as the same doubles."""
    return " ".join(repr(float(value)) for value in values)
