"""Exact motions of a sensor, their noisy poses, and the wrench that a rigid body needs
for them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

POSITION_NOISE = 1e-4  # m
ROTATION_NOISE = np.deg2rad(0.02)
GRAVITY = np.array([0.0, 0.0, -9.80665])


@dataclass
class Truth:
    """Positions in world axes; velocities and accelerations (K, 3) in sensor axes."""

    time: np.ndarray
    position: np.ndarray
    rotation: Rotation
    linear_acceleration: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray

    def poses(
        self, rng=None, position_noise=POSITION_NOISE, rotation_noise=ROTATION_NOISE
    ):
        """Positions (K, 3) and quaternions (K, 4), with white noise when a generator is
        given."""
        if rng is None:
            return self.position, self.rotation.as_quat()
        K = len(self.time)
        turn = Rotation.from_rotvec(rotation_noise * rng.normal(size=(K, 3)))
        return self.position + position_noise * rng.normal(size=(K, 3)), (
            self.rotation * turn
        ).as_quat()

    def gravity(self):
        return self.rotation.inv().apply(GRAVITY)


def random_smooth(time, rng, tones=(0.3, 1.2), angular=1.0, linear=0.2) -> Truth:
    """Four sinusoids [Hz] of random phase and size a channel, scaled to rms speeds in
    rad/s and m/s."""

    def channels(speed):
        omega = 2 * np.pi * rng.uniform(*tones, size=(4, 3))
        angle = time[:, None, None] * omega + rng.uniform(0, 2 * np.pi, (4, 3))
        size = rng.normal(size=(4, 3))
        rate = np.sum(size * omega * np.cos(angle), axis=1)
        size *= speed / np.sqrt(np.mean(np.sum(rate**2, axis=1)))
        value = np.sum(size * np.sin(angle), axis=1)
        rate = np.sum(size * omega * np.cos(angle), axis=1)
        return value, rate, np.sum(-size * omega**2 * np.sin(angle), axis=1)

    p, _, ddp = channels(linear)
    e, de, dde = channels(angular)
    rotation = Rotation.random(rng=rng) * Rotation.from_euler("ZYX", e)
    return Truth(
        time, p, rotation, rotation.inv().apply(ddp), *_euler_rates(e, de, dde)
    )


def _euler_rates(e, de, dde):
    """Angular velocity and acceleration in body axes of R = Rz Ry Rx, from the angles'
    derivatives."""
    (_, y, x), (dz, dy, dx), (ddz, ddy, ddx) = e.T, de.T, dde.T
    sx, cx, sy, cy = np.sin(x), np.cos(x), np.sin(y), np.cos(y)
    w = (dx - dz * sy, dy * cx + dz * cy * sx, -dy * sx + dz * cy * cx)
    alpha = (
        ddx - ddz * sy - dz * dy * cy,
        ddy * cx - dy * dx * sx + ddz * cy * sx - dz * dy * sy * sx + dz * dx * cy * cx,
        -ddy * sx
        - dy * dx * cx
        + ddz * cy * cx
        - dz * dy * sy * cx
        - dz * dx * cy * sx,
    )
    return np.transpose(w), np.transpose(alpha)


def stop_and_go(time, rng, move=0.6, rest=0.4, turn=0.6, shift=0.12) -> Truth:
    """Moves of least jerk, `turn` rad about and `shift` m along random directions, with
    rests between."""
    K = len(time)
    start = -rng.uniform(0, move + rest)
    rotation, here = Rotation.random(rng=rng), np.zeros(3)
    quaternion, p = np.zeros((K, 4)), np.zeros((K, 3))
    a, w, alpha = np.zeros((K, 3)), np.zeros((K, 3)), np.zeros((K, 3))
    while start <= time[-1]:
        now = (time >= start) & (time < start + move + rest)
        s = np.clip((time[now, None] - start) / move, 0, 1)
        axis, step = rng.normal(size=(2, 3))
        axis = axis * turn / np.linalg.norm(axis)
        step = step * shift / np.linalg.norm(step)
        path = 10 * s**3 - 15 * s**4 + 6 * s**5
        bend = (60 * s - 180 * s**2 + 120 * s**3) / move**2
        turned = rotation * Rotation.from_rotvec(path * axis)
        quaternion[now], p[now] = turned.as_quat(), here + path * step
        w[now] = (30 * s**2 - 60 * s**3 + 30 * s**4) / move * axis
        alpha[now] = bend * axis
        a[now] = turned.inv().apply(bend * step)
        rotation = rotation * Rotation.from_rotvec(axis)
        here = here + step
        start = start + move + rest
    return Truth(time, p, Rotation.from_quat(quaternion), a, w, alpha)


@dataclass
class Body:
    """A rigid body by its mass [kg], centre of mass [m] and inertia there [kg m²], in
    sensor axes."""

    mass: float
    center: np.ndarray
    inertia: np.ndarray

    def wrench(self, truth: Truth):
        """Force and torque (K, 3) at the sensor origin: f = m (a_c - g), tau = c x f +
        I alpha + w x I w."""
        w, alpha = truth.angular_velocity, truth.angular_acceleration
        a_center = truth.linear_acceleration + np.cross(alpha, self.center)
        a_center += np.cross(w, np.cross(w, self.center))
        force = self.mass * (a_center - truth.gravity())
        spin = alpha @ self.inertia + np.cross(w, w @ self.inertia)
        return force, np.cross(self.center, force) + spin

    def vector(self):
        """[m, mc, J about the sensor origin]."""
        J = self.inertia + self.mass * (
            self.center @ self.center * np.eye(3) - np.outer(self.center, self.center)
        )
        return np.concatenate(
            ([self.mass], self.mass * self.center, J[np.triu_indices(3)])
        )


def box() -> Body:
    """A homogeneous box of 0.7 kg and 12 x 15 x 8 cm, held askew 9 cm from its
    centre."""
    x, y, z, mass = 0.12, 0.15, 0.08, 0.7
    R = Rotation.from_euler("xyz", [0.3, 0.5, 0.2]).as_matrix()
    inertia = mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    return Body(mass, np.array([0.02, -0.03, 0.08]), R @ inertia @ R.T)


def normalised_errors(motion, truth: Truth):
    """Mean squared error over claimed variance, of a, w and alpha, at the samples
    `motion` holds."""
    at = np.searchsorted(truth.time, motion.time - 1e-9)
    means = []
    for name in ("linear_acceleration", "angular_velocity", "angular_acceleration"):
        value, std = getattr(motion, name), getattr(motion, f"{name}_std")
        if value is not None:
            means.append(
                np.nanmean(((value - getattr(truth, name)[at]) / std[:, None]) ** 2)
            )
    return means


def noisy(
    seed, duration=3.0, rate=100.0, make=random_smooth, **options
) -> tuple[Truth, np.ndarray, np.ndarray]:
    """A motion, and positions (K, 3) and quaternions (K, 4) of it with noise."""
    rng = np.random.default_rng(seed)
    truth = make(np.arange(0, duration, 1 / rate), rng, **options)
    return truth, *truth.poses(rng)
