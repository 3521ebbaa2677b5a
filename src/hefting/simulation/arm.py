"""A serial arm: from the joints' motion to the exact motion of the sensor frame at its end."""

from dataclasses import dataclass, fields

import numpy as np

from hefting.errors import InputError
from hefting.spatial import Array, frozen, skew


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Motion of n joints at K instants. `InputError` unless the shapes agree."""

    time: Array
    """(K,) [s]"""
    position: Array
    """(K, n) [rad]"""
    velocity: Array
    """(K, n) [rad/s]"""
    acceleration: Array
    """(K, n) [rad/s²]"""

    def __post_init__(self):
        for field in fields(self):
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))
        shape = self.position.shape
        if self.time.shape != shape[:1] or len(shape) != 2 or {self.velocity.shape, self.acceleration.shape} != {shape}:
            raise InputError("time (K,), position, velocity and acceleration (K, n) do not agree", where="JointMotion")


@dataclass(frozen=True, eq=False)
class SensorMotion:
    """Exact motion of the sensor frame at K instants, in world axes."""

    time: Array
    """(K,) [s]"""
    position: Array
    """(K, 3) sensor origin [m]"""
    rotation: Array
    """(K, 3, 3) sensor axes to world axes"""
    linear_velocity: Array
    """(K, 3) of the sensor origin [m/s]"""
    angular_velocity: Array
    """(K, 3) [rad/s]"""
    linear_acceleration: Array
    """(K, 3) classical, of the sensor origin [m/s²]"""
    angular_acceleration: Array
    """(K, 3) [rad/s²]"""

    def __post_init__(self):
        for field in fields(self):
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))

    @property
    def orientation(self) -> Array:
        """(K, 4) unit quaternions x, y, z, w, sensor in world."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_matrix(self.rotation).as_quat()

    @property
    def mean_speeds(self) -> tuple[float, float]:
        """Means over the samples of the angular speed [rad/s] and of the sensor origin's speed [m/s]."""
        angular, linear = (np.linalg.norm(v, axis=1) for v in (self.angular_velocity, self.linear_velocity))
        return float(angular.mean()), float(linear.mean())


@dataclass(frozen=True, eq=False)
class Arm:
    """Revolute joints in standard Denavit-Hartenberg form: link i is Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i).

    The base is the world frame, the last link's frame the sensor's.
    """

    a: Array
    """(n,) link lengths [m]"""
    alpha: Array
    """(n,) link twists [rad]"""
    d: Array
    """(n,) link offsets [m]"""

    def __post_init__(self):
        for field in fields(self):
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))

    def motion(self, joints: JointMotion) -> SensorMotion:
        """Exact motion of the sensor frame, by forward recursion (Siciliano et al., *Robotics*, sec. 7.5.2).

        `InputError` when the number of joints differs from the arm's.
        """
        q, dq, ddq = joints.position, joints.velocity, joints.acceleration
        if q.shape[1] != len(self.a):
            raise InputError(f"there are {q.shape[1]} joints, but the arm has {len(self.a)}", where="JointMotion")
        rotation = np.broadcast_to(np.eye(3), (len(q), 3, 3))
        position, velocity, acceleration, w, dw = (np.zeros((len(q), 3)) for _ in range(5))
        for i, (a, alpha, d) in enumerate(zip(self.a, self.alpha, self.d, strict=True)):
            axis = rotation[:, :, 2]
            spin = axis * dq[:, i, None]
            dw = dw + axis * ddq[:, i, None] + _cross(w, spin)
            w = w + spin
            link, offset = _link(q[:, i], a, alpha, d)
            arm = np.einsum("kij,kj->ki", rotation, offset)
            rotation = rotation @ link
            position = position + arm
            velocity = velocity + _cross(w, arm)
            acceleration = acceleration + _cross(dw, arm) + _cross(w, _cross(w, arm))
        return SensorMotion(joints.time, position, rotation, velocity, w, acceleration, dw)


def _cross(u: Array, v: Array) -> Array:
    return np.einsum("kij,kj->ki", skew(u), v)


def _link(q: Array, a: float, alpha: float, d: float) -> tuple[Array, Array]:
    """Rotation (K, 3, 3) and offset (K, 3) of a link's frame in the one before, at joint angles q (K,)."""
    cos, sin, zero, one = np.cos(q), np.sin(q), np.zeros_like(q), np.ones_like(q)
    ca, sa = np.cos(alpha), np.sin(alpha)
    rows = ((cos, -sin * ca, sin * sa), (sin, cos * ca, -cos * sa), (zero, sa * one, ca * one))
    return np.moveaxis(np.array(rows), -1, 0), np.column_stack((a * cos, a * sin, d * one))


UR5 = Arm(
    a=frozen([0.0, -0.425, -0.39225, 0.0, 0.0, 0.0]),
    alpha=frozen([np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0]),
    d=frozen([0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823]),
)
"""Universal Robots UR5 with the sensor frame at its flange; the maker's nominal values ("DH parameters for
calculations of kinematics and dynamics", Universal Robots support)."""
