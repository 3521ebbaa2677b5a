"""Effect of the motion's errors on the wrench, and the weights of samples by it.

Errors of the linear and angular acceleration, of covariance S_k, make errors E S_k E'
of the predicted wrench,

    E = d(f, tau)/d(a, alpha) = [[m I, -[mc]x], [[mc]x, J]].

They are correlated in time: of the fs T samples of T seconds about wc T are
independent. So a sample counts as if its covariance were S_w + (fs/wc) E S_k E', S_w
being that of the wrench itself.
"""

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, median, skew, vector_to_tensor
from hefting.motion.state import Motion, lasting_variances


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
