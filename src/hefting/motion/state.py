"""Motion: the kinematic state of the sensor at a set of times, with the standard
deviations of its errors; their effect on the wrench, and the weights of samples by it.

Errors of the linear and angular acceleration, of covariance S_k, make errors E S_k E'
of the predicted wrench,

    E = d(f, tau)/d(a, alpha) = [[m I, -[mc]x], [[mc]x, J]].

They are correlated in time: of the fs T samples of T seconds about wc T are
independent. So a sample counts as if its covariance were S_w + (fs/wc) E S_k E', S_w
being that of the wrench itself.
"""

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements, MotionNoise
from hefting.core.spatial import (
    Array,
    Mask,
    freeze,
    frozen,
    immutable,
    in_sensor_axes,
    interpolated,
    median,
    own,
    rotation_matrices,
    skew,
    vector_to_tensor,
)

NEXT, BEFORE = np.array((1, 2, 0)), np.array((2, 0, 1))
"""Indices of the next axis, and of the one before."""
UNLIKE_AT_JUMPS = 0.25
"""Share of the variance at jumps that the errors of linear and angular acceleration do not
have in common: ((r - 1) / (r + 1))² if one is rounded over r = 3 times as long."""


@immutable
class Motion:
    """Pose, velocity and acceleration of the sensor frame; vectors in sensor axes, SI
    units.

    Samples at which the motion is not known (inside a long gap) hold NaN, and an
    infinite standard deviation. Where the position was not measured, everything linear
    is None.
    """

    time: Array
    """(K,) s, increasing."""
    orientation: Array
    """(K, 4) unit quaternions xyzw, sensor in world: v_world = R(q) v_sensor."""
    angular_velocity: Array
    """(K, 3) rad/s."""
    angular_acceleration: Array
    """(K, 3) rad/s²."""
    angular_velocity_std: Array
    """(K,) rad/s, standard deviation of the error along each axis."""
    angular_acceleration_std: Array
    """(K,) rad/s²."""
    bandwidth: float
    """rad/s. Errors are correlated in time: about bandwidth * T of them are independent
    in T seconds."""
    position: Array | None = None
    """(K, 3) m, sensor origin in world axes."""
    linear_velocity: Array | None = None
    """(K, 3) m/s, of the sensor origin."""
    linear_acceleration: Array | None = None
    """(K, 3) m/s², classical (d²p/dt²), of the sensor origin, gravity not included."""
    linear_acceleration_std: Array | None = None
    """(K,) m/s²."""
    linear_jump_std: Array | None = None
    """(K,) m/s², the part of `linear_acceleration_std` that is due to jumps of the
    acceleration, which a smooth curve rounds. These errors have opposite signs before
    and after the jump and cancel in an average over it. None for none."""
    angular_jump_std: Array | None = None
    """(K,) rad/s², the same part of `angular_acceleration_std`."""

    def __post_init__(self):
        freeze(self, *self._arrays)

    def __getitem__(self, index: slice | NDArray) -> Self:
        """The samples chosen by a slice, a mask (K,) or an index array."""
        return replace(self, **{k: own[index] for k, own in self._arrays.items()})

    @property
    def known(self) -> Mask:
        """(K,) whether the motion is known: of its position too, where there is one."""
        known = np.isfinite(self.angular_acceleration).all(axis=1)
        if self.linear_acceleration is not None:
            known &= np.isfinite(self.linear_acceleration).all(axis=1)
        return np.asarray(known)

    @property
    def _arrays(self) -> dict[str, Array]:
        each = {field.name: getattr(self, field.name) for field in fields(self)}
        del each["bandwidth"]
        return {name: own for name, own in each.items() if own is not None}

    def measurements(
        self, wrench_time: ArrayLike, wrench: ArrayLike, gravity: ArrayLike
    ) -> Measurements:
        """Samples for an estimator: this motion with a measured wrench.

        The wrench is taken at the instants of the motion, linearly between its samples;
        instants before its first or after its last sample, or with unknown motion, are
        left out. Without a position the sensor origin counts as fixed.

        Parameters
        ----------
        wrench_time : (N,) [s], increasing, on the clock of the motion.
        wrench : (N, 6) force [N] and torque [N m] exerted by the sensor on the object,
            in sensor axes about its origin; a sensor that reports what the object
            exerts on it is the same with the sign flipped.
        gravity : (3,) in world axes [m/s²], such as (0, 0, -9.81).

        Raises `InputError` for arrays of other shapes.
        """
        time = frozen(wrench_time, 1)
        values = frozen(wrench, 2)
        g_world = frozen(gravity)
        if values.shape != (len(time), 6):
            raise InputError(
                f"has shape {values.shape}, expected {(len(time), 6)}", where="wrench"
            )
        if g_world.shape != (3,):
            raise InputError(
                f"has shape {g_world.shape}, expected (3,)", where="gravity"
            )
        first, last = (time[0], time[-1]) if len(time) else (np.inf, -np.inf)
        known = self.known & (self.time >= first) & (self.time <= last)
        motion = self if known.all() else self[known]
        at = motion.time
        aligned = interpolated(at, time, values) if len(at) else np.empty((0, 6))
        zero = np.zeros((len(at), 3))
        return Measurements(
            time=at,
            gravity=in_sensor_axes(motion.orientation, g_world),
            linear_acceleration=zero
            if motion.linear_acceleration is None
            else motion.linear_acceleration,
            angular_velocity=motion.angular_velocity,
            angular_acceleration=motion.angular_acceleration,
            force=aligned[:, :3],
            torque=aligned[:, 3:],
            motion_noise=motion.noise if len(at) else None,
        )

    @property
    def noise(self) -> MotionNoise:
        """Root-mean-square errors of the accelerations, less those at jumps that both
        have in common, and their correlation time."""
        both = lasting_variances(self), acceleration_variances(self)
        variances = (1.0 - UNLIKE_AT_JUMPS) * both[0] + UNLIKE_AT_JUMPS * both[1]
        linear, angular = np.sqrt(variances.mean(axis=1))
        return MotionNoise(float(linear), float(angular), float(np.pi / self.bandwidth))


def acceleration_variances(motion: Motion) -> Array:
    """Variances (2, K) of linear and angular acceleration per axis; zero for a linear
    one that is not modelled."""
    angular = np.square(motion.angular_acceleration_std)
    linear = motion.linear_acceleration_std
    return np.stack(
        (np.zeros_like(angular) if linear is None else np.square(linear), angular)
    )


def lasting_variances(motion: Motion) -> Array:
    """`acceleration_variances` without the part of jumps.

    The errors of a smooth curve before and after a jump are opposite and cancel in sums
    over the samples. Weights by the full variance would suppress one side or the other:
    on trapezoids at 500 Hz they double the inertia's error.
    """
    variances = acceleration_variances(motion)
    for row, jump in enumerate((motion.linear_jump_std, motion.angular_jump_std)):
        if jump is not None:
            known = np.isfinite(variances[row])
            variances[row, known] -= np.square(jump[known])
    return np.maximum(variances, 0.0)


def motion_from_pieces(time: Array, pieces: Iterable[Motion]) -> Motion:
    """One Motion at `time` (K,) from consecutive ones, each released once copied."""
    arrays: dict[str, Array] = {}
    begin, bandwidth = 0, 0.0
    for piece in pieces:
        end, bandwidth = begin + len(piece.time), piece.bandwidth
        for name, values in piece._arrays.items():
            if name not in arrays:
                arrays[name] = np.empty((len(time), *values.shape[1:]))
            arrays[name][begin:end] = values
        begin = end
    arrays = {name: own(whole) for name, whole in arrays.items()} | {"time": time}
    return Motion(bandwidth=bandwidth, **arrays)  # type: ignore[arg-type]


def motion_from_channels(time, position, quaternion, bandwidth) -> Motion:
    """Turn smoothed channels and their derivatives into a Motion.

    position:   None, or (p, dp, ddp, std of ddp): (K, 3) arrays in world axes and (K,)
    quaternion: (q, dq, ddq, std of dq, std of ddq): (K, 4) arrays xyzw, not necessarily of unit
                length, and (K,) standard deviations of one component
    Both may end with the standard deviation (K,) that jumps add to that of ddp or ddq.

    A component's error counts twice because a rotation by theta moves q by theta/2.
    """
    q, dq, ddq, dq_std, ddq_std, *q_jump = quaternion
    q_jump_std = q_jump[0] if q_jump else None
    w, alpha = (x.T for x in angular_motion(q.T, dq.T, ddq.T))
    q = q / np.sqrt(np.einsum("kj,kj->k", q, q))[:, None]
    linear = {}
    if position is not None:
        p, dp, ddp, ddp_std, *p_jump = position
        p_jump_std = p_jump[0] if p_jump else None
        into_sensor = np.swapaxes(rotation_matrices(q), 1, 2)
        linear = {
            "position": p,
            "linear_velocity": np.einsum("kij,kj->ki", into_sensor, dp),
            "linear_acceleration": np.einsum("kij,kj->ki", into_sensor, ddp),
            "linear_acceleration_std": _with_jumps(ddp_std, p_jump_std),
            "linear_jump_std": p_jump_std,
        }
    return Motion(
        time=time,
        orientation=q,
        angular_velocity=w,
        angular_acceleration=alpha,
        angular_velocity_std=2.0 * dq_std,
        angular_acceleration_std=2.0 * _with_jumps(ddq_std, q_jump_std),
        angular_jump_std=None if q_jump_std is None else 2.0 * q_jump_std,
        bandwidth=float(bandwidth),
        **linear,
    )


def _with_jumps(std: Array, jump_std: Array | None) -> Array:
    """(K,) root of the sum of both variances."""
    return std if jump_std is None else np.hypot(std, jump_std)


def angular_motion(q: Array, dq: Array, ddq: Array) -> tuple[Array, Array]:
    """Angular velocity and acceleration (3, K) in sensor axes, of a quaternion (4, K)
    xyzw of any length and its derivatives: w = 2 Im(q* dq)/|q|² and, by differentiation,
    alpha = 2 Im(q* ddq)/|q|² - 2 (q.dq) w/|q|²."""
    inverse = q * (2.0 / np.einsum("jk,jk->k", q, q))
    w, alpha = _vector_part(inverse, dq), _vector_part(inverse, ddq)
    alpha -= np.einsum("jk,jk->k", inverse, dq) * w
    return w, alpha


def _vector_part(q: Array, r: Array) -> Array:
    """(3, K) vector part of q* r, of quaternions (4, K) xyzw."""
    v, u = q[:3], r[:3]
    part = q[3] * u
    part -= v * r[3]
    part -= v[NEXT] * u[BEFORE]
    part += v[BEFORE] * u[NEXT]
    return part


def effect_of_acceleration_errors(vector: ArrayLike) -> Array:
    """Traces (2, 2) of the blocks of E E' for parameters (10,): rows force and torque,
    columns linear and angular.

    Times the variances of the two accelerations [m²/s⁴, rad²/s⁴], of one axis each, it
    gives those of force [N²] and torque [N² m²], summed over their three axes.
    """
    phi = np.asarray(vector, dtype=float)
    lever = float(np.sum(skew(phi[1:4]) ** 2))
    inertia = float(np.sum(vector_to_tensor(phi[4:]) ** 2))
    return np.array(((3.0 * float(phi[0]) ** 2, lever), (lever, inertia)))


def samples_per_error(time: Array, bandwidth: float) -> float:
    """Number of samples at `time` (K,) over which an error of the motion of `bandwidth`
    [rad/s] lasts; at least one."""
    if len(time) < 2:
        return 1.0
    return max(1.0 / (median(np.diff(time)) * bandwidth), 1.0)


def sample_weights(
    vector: ArrayLike, motion: Motion, force_std: float, torque_std: float
) -> Array:
    """Weights (K,) of the samples' squared residuals, 1 where the motion is exact, 0
    where it is unknown.

    vector: (10,) current parameters [m, mc, J] in sensor axes about its origin
    force_std [N], torque_std [N m]: the wrench's noise per axis

    With M = S_w^-1 (fs/wc) E S_k E', the weight is 1/(1 + tr(M)/6): one scalar, so that
    the weighted samples still reduce to 22. Least squares with it is a little better
    than with det(I + M)^(-1/6), and much better than with tr((I + M)^-1)/6; the largest
    eigenvalue of M serves as well.

    Raises `InputError` for noise levels that are not positive.
    """
    if not (force_std > 0 and torque_std > 0):
        raise InputError(
            f"weights need positive noise levels of the wrench, not {force_std} N and {torque_std} N m",
            fix="give Noise(force=, torque=)",
        )
    excess = excess_variance(vector, lasting_variances(motion), force_std, torque_std)
    return 1.0 / (1.0 + samples_per_error(motion.time, motion.bandwidth) * excess)


def excess_variance(
    vector: ArrayLike, variances: Array, force_std: float, torque_std: float
) -> Array:
    """(K,) mean over the six channels of the variance that errors of the motion add,
    over that of the noise.

    `variances` (2, K) are those of the accelerations. Infinite where these are.
    """
    share = np.array((force_std, torque_std)) ** -2.0 @ effect_of_acceleration_errors(
        vector
    )
    with np.errstate(invalid="ignore"):
        terms = np.where(share[:, None] > 0.0, share[:, None] * variances, 0.0)
    return np.where(np.isfinite(variances).all(axis=0), terms.sum(axis=0) / 6.0, np.inf)
