"""How much each sample is worth when the motion, too, is uncertain.

Errors of the linear and angular acceleration, of covariance S_k, make errors E S_k E' of the predicted
wrench, E = d(f, tau)/d(a, alpha) = [[m I, -[mc]x], [[mc]x, J]]. They are correlated in time: of the fs T
samples of T seconds about wc T are independent. So a sample counts as if its covariance were
S_w + (fs/wc) E S_k E', S_w being that of the wrench itself.
"""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from hefting.errors import InputError
from hefting.spatial import Array, skew, vector_to_tensor


class UncertainMotion(Protocol):
    """What of a `hefting.motion.Motion` the weights depend on."""

    @property
    def time(self) -> Array: ...
    @property
    def linear_acceleration_std(self) -> Array | None: ...
    @property
    def angular_acceleration_std(self) -> Array: ...
    @property
    def bandwidth(self) -> float: ...


def sample_weights(vector: ArrayLike, motion: UncertainMotion, force_std: float, torque_std: float) -> Array:
    """Weights (K,) of the samples' squared residuals, 1 where the motion is exact, 0 where it is unknown.

    vector: (10,) current parameters [m, mc, J] in sensor axes about its origin
    force_std [N], torque_std [N m]: the wrench's noise per axis

    With M = S_w^-1 (fs/wc) E S_k E', the weight is 1/(1 + tr(M)/6): one scalar, so that the weighted samples
    still reduce to 22. Least squares with it is a little better than with det(I + M)^(-1/6), and much better
    than with tr((I + M)^-1)/6; the largest eigenvalue of M serves as well.

    Raises `InputError` for noise levels that are not positive.
    """
    phi = np.asarray(vector, dtype=float)
    if not (force_std > 0 and torque_std > 0):
        raise InputError(
            f"weights need positive noise levels of the wrench, not {force_std} N and {torque_std} N m",
            fix="give Noise(force=, torque=)",
        )
    lever, inertia = skew(phi[1:4]), vector_to_tensor(phi[4:])
    linear = 3.0 * (phi[0] / force_std) ** 2 + np.sum((lever / torque_std) ** 2)
    angular = np.sum((lever / force_std) ** 2) + np.sum((inertia / torque_std) ** 2)
    excess = angular * np.square(motion.angular_acceleration_std)
    if motion.linear_acceleration_std is not None:
        excess = excess + linear * np.square(motion.linear_acceleration_std)
    interval = float(np.median(np.diff(motion.time))) if len(motion.time) > 1 else np.inf
    samples_per_error = max(1.0 / (interval * motion.bandwidth), 1.0)
    return 1.0 / (1.0 + samples_per_error * excess / 6.0)
