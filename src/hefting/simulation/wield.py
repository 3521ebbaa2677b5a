"""Wielding: the wrench a moving body needs, and the log a robot would write of it."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, check_pose
from hefting.simulation.arm import SensorMotion

POSE_NOISE = (1e-4, 3.5e-4)
"""Standard deviations, per axis, of the pose a cobot reports: position [m] and
orientation [rad] (0.02°)."""


def wield(
    motion: SensorMotion,
    body: InertialParameters,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> Measurements:
    """Exact measurements, in sensor axes, of a `body` given in the sensor frame that
    follows `motion`.

    The wrench comes from Newton's and Euler's equations at the centre of mass, moved to
    the sensor origin: f = m (a_c - g), tau = J_c alpha + w x J_c w + c x f. The
    regressors of `hefting.core.regressor` are not used. `gravity` (3,) is in world axes
    [m/s²]. Raises `InputError` for a body without mass.
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
    """The log of a robot that wields `body` (given in the sensor frame) along `motion`.

    Pose and wrench are recorded at the times of `motion` with seeded Gaussian noise:
    `noise` on the wrench, `pose_noise` on position [m] and orientation [rad], along
    each axis. With `on_sensor` the sensor shows the wrench exerted on itself, the
    opposite of the project's sign; `bias` (6,) [N, N m] is added to that. With `exact`
    it records velocities, without noise, and accelerations, with their levels of
    `noise`, as well.
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
    """What is to be found, ready for JSON: `body` in the sensor frame, and how log and
    mesh are to be read. `extents` (3,) are the sides [m] of the shape's bounding box
    along the axes of its own file."""
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
