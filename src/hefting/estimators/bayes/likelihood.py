"""Likelihood of the ten parameters for samples with noise in the wrench and in the
motion.

Of K samples with regressor A = A0 + sum_q n_q D_q, n the noise of the accelerations (a,
alpha), D_q = dA/d(a, alpha)_q, and wrench b = A0 phi + e, the residual b - A phi = e -
E n has the covariance

    S = S_w + E S_k E',   E = [D_1 phi .. D_6 phi] = d(f, tau)/d(a, alpha)

The noise in A biases A'S^-1 (b - A phi); to first order this takes it away:

    G = sum A'S^-1 A,  h = sum A'S^-1 b,  H = G - K sum_q S_k,qq D_q'S^-1 D_q      so that  E[h - H phi] = 0
    V = G + K sum_qr B_qr B_rq',  B_qr = -D_q'S^-1 E S_k e_r                       = cov(h - H phi)

and the likelihood is a Gaussian of precision H V^-1 H about H^-1 h. For errors that
last H is G, and V hides what of G they make by themselves. A constant bias is eliminated
beforehand by subtracting the samples' mean. See Fuller, *Measurement Error Models*, 1987.
"""

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.lapack import lapack, root_of_inverse
from hefting.core.messages import Message, error
from hefting.core.quantity import MassReading
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.samples import Samples

REGRESSOR_DERIVATIVE = np.ascontiguousarray(FULL_MAP[:6].reshape(6, 6, 10))
"""(6, 6, 10) derivative of the regressor by linear and angular acceleration: D
above."""

NO_ERROR, ERROR = 0.5, 0.75
"""Shares of the information that lasting errors make by themselves, up to which all of it
counts, and from which on next to none."""
LEAST_INFORMATION = 1e-3
"""Share that counts then: with less, what nothing limits would blur the other numbers."""
UNSEEN_MASS = 1e-6
"""Share of the mass in directions without information, in scaled parameters, from which
on the samples leave it open."""


@immutable
class Likelihood:
    """exp(-½ phi' precision phi + shift' phi)"""

    precision: Array
    """Lambda (10, 10)"""
    shift: Array
    """lambda (10,)"""
    covariance: Array
    """S (6, 6) of one sample's residual"""

    def misfit(self, phi: Array) -> float:
        """Squared Mahalanobis distance of parameters phi (10,) from the maximum."""
        off = self.shift - self.precision @ phi
        root = root_of_inverse(self.precision) @ off
        return float(root @ root)

    @property
    def mass(self) -> tuple[float, float]:
        """Mean [kg] and variance [kg²] of the mass; infinite where it is open."""
        root = root_of_inverse(self.precision)
        inverse = root.T @ root
        seen = inverse[0] @ self.precision  # e_0 where all of the mass is seen
        seen[0] -= 1.0
        scale = np.sqrt(np.maximum(self.precision.diagonal(), 0.0))
        unseen = np.abs(seen) * scale[0]
        if scale[0] == 0.0 or float((unseen > UNSEEN_MASS * scale).any()):
            return 0.0, np.inf
        return float(inverse[0] @ self.shift), float(inverse[0, 0])

    def blurred(self, C: Array) -> Self:
        """The likelihood with an additional error, common to all samples, of covariance
        C (10, 10) in the parameters."""
        less = np.linalg.inv(np.eye(10) + self.precision @ C)
        precision = less @ self.precision
        return type(self)(
            0.5 * (precision + precision.T), less @ self.shift, self.covariance
        )


@immutable
class Equations:
    """Whitened normal equations of all samples: G, h, H and the part of V that is
    quadratic in the noise."""

    whitening: Array
    """(6, 6) W with W'W = S^-1"""
    G: Array
    """(10, 10)"""
    h: Array
    """(10,)"""
    attenuation: Array | None
    """(10, 10) contribution of the motion's white noise to G, per sample; None if there
    is none"""
    H: Array
    """(10, 10)"""
    products: Array
    """(10, 10)"""
    covariance: Array
    """S (6, 6) of one sample's residual"""

    @classmethod
    def of(
        cls,
        samples: Samples,
        phi: Array,
        S: Array,
        S_k: Array | None,
        lasting: bool = False,
    ) -> Self:
        """At about parameters phi (10,). S (6, 6) is the covariance of the whole
        residual, S_k (6,) the variances of the accelerations that contribute to it, or
        None, which are white or `lasting`."""
        factor, failed = lapack.dpotrf(S, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance is not positive definite")
        W = lapack.dtrtri(factor, lower=1)[0]
        A = (W @ samples.by_channel).reshape(-1, 10)
        b = (W @ samples.b.T).ravel()
        G, h = A.T @ A, A.T @ b
        if S_k is None:
            return cls(W, G, h, None, G, np.zeros((10, 10)), S)
        K = samples.K
        WD = W @ REGRESSOR_DERIVATIVE  # (6, 6, 10)
        rows = WD.reshape(36, 10)
        attenuation = (rows * np.repeat(S_k, 6)[:, None]).T @ rows
        if lasting:
            return cls(W, G, h, None, G, _hiding(G, K * attenuation), S)
        WE = (WD @ phi).T
        B = -(WE * S_k).T @ WD  # (q, r, 10): -D_q' S^-1 E S_k e_r
        products = K * B.reshape(36, 10).T @ B.transpose(1, 0, 2).reshape(36, 10)
        return cls(W, G, h, attenuation, G - K * attenuation, products, S)

    def mean_square(self, R: Array) -> float:
        """Mean square of residuals of covariance R (6, 6), once they are whitened."""
        W = self.whitening
        return max(float(((W @ R) * W).sum()) / 6.0, 1e-12)

    def likelihood(self, V: Array) -> Likelihood:
        """Likelihood for a covariance V (10, 10) of the score h - H phi."""
        root = root_of_inverse(V)
        half = root @ self.H
        return Likelihood(half.T @ half, half.T @ (root @ self.h), self.covariance)

    @cached_property
    def inverse(self) -> Array:
        """(10, 10) G^+"""
        root = root_of_inverse(self.G)
        return root.T @ root

    @property
    def least_squares(self) -> Array:
        """(10,) least squares; directions without information are zero."""
        return self.inverse @ self.h

    def white(self, inflation: float = 1.0) -> Likelihood:
        """Likelihood for white noise of `inflation` times the modelled variance."""
        if not self.products.any():
            return Likelihood(self.G / inflation, self.h / inflation, self.covariance)
        return self.likelihood(inflation * (self.G + self.products))


def _hiding(G: Array, errors: Array) -> Array:
    """(10, 10) covariance of the score hiding what `errors` make of information G."""
    root = root_of_inverse(G)
    share, directions = np.linalg.eigh(root @ errors @ root.T)
    seen = np.clip((ERROR - share) / (ERROR - NO_ERROR), LEAST_INFORMATION, 1.0)
    rows = G @ root.T @ directions
    return (rows * (1.0 / seen - 1.0)) @ rows.T


def motion_effect(phi: Array) -> Array:
    """E (6, 6): derivative of the wrench by linear and angular acceleration."""
    return (REGRESSOR_DERIVATIVE @ phi).T


LARGEST_DEVIATION = 4.0
"""Standard deviations between a scale and the wrench that count as a contradiction: by
chance 6 in 100,000 exceed it."""


def with_reading(likelihood: Likelihood, reading: MassReading | None) -> Likelihood:
    """Likelihood of the wrench combined with a scale's reading."""
    if reading is None:
        return likelihood
    precision, shift = likelihood.precision.copy(), likelihood.shift.copy()
    precision[0, 0] += 1.0 / reading.std**2
    shift[0] += reading.mass / reading.std**2
    return replace(likelihood, precision=precision, shift=shift)


def scale_doubts(
    likelihood: Likelihood, reading: MassReading | None, carried: Array | None
) -> tuple[Message, ...]:
    """An error if the scale contradicts the wrench, so that it is not used;
    `likelihood` is of the wrench alone, `carried` (10,) the tool that was subtracted.
    """
    if reading is None:
        return ()
    mass, variance = likelihood.mass
    deviation = (variance + reading.std**2) ** 0.5
    off = (reading.mass - mass) / deviation
    if not abs(off) > LARGEST_DEVIATION:
        return ()
    tool = 0.0 if carried is None else float(carried[0])
    if off > 0.0:
        causes = "does the controller subtract a part of it already"
    elif not tool:
        causes = "does the sensor carry a gripper that was not weighed (`tool`)"
    else:
        causes = "was it weighed without all that the sensor carries beside the tool"
    ask = f"is its unit right, {causes}, and is the force in newtons?"
    if tool and abs(reading.mass - tool - mass) < LARGEST_DEVIATION * deviation:
        ask = f"with the tool of {tool:.4g} kg? give `mass` of the object alone"
    what = (
        f"the scale shows {reading.mass:.4g} kg, the wrench {mass:.4g} ± "
        f"{variance**0.5:.2g} kg, {abs(off):.0f} standard deviations apart, so the "
        f"scale is left out: {ask}"
    )
    return (error("mass-contradicts-wrench", what, "mass"),)


def gain_by_scale(equations: Equations, body: Array, limit: float) -> float:
    """Relative error of the gain, at most `limit`, if the object is `body` (10,)."""
    square = float(body @ equations.H @ body)
    ratio = float(body @ equations.h) / square - 1.0 if square > 0.0 else 0.0
    return min(max(ratio, -limit), limit)
