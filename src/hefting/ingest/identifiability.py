"""Identifiability: how much of a body a motion can tell, and why not the rest.

Ranks and condition numbers speak of the motion alone; which parameters are open depends
on the noise and on a free bias as well, so that is taken from unconstrained least
squares (`hefting.ingest.free_fit.FreeFit`). The reasons are read off the motion: where
gravity pointed in sensor axes, and about which axes the sensor was accelerated.
"""

from typing import Any, Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate_json import json_ready
from hefting.core.immutable import immutable
from hefting.core.measurements import Measurements
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, Moments
from hefting.core.spatial import Array
from hefting.estimators.joint_state import State, as_one
from hefting.estimators.quadratic import RANK_TOLERANCE
from hefting.ingest.condensed import Excitation
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.reasons import _join_findings, _Reasons, _sentence

RigidModel = Literal["full", "reduced"]
_EQUATIONS = {"full": FULL_EQUATIONS[6:16], "reduced": REDUCED_EQUATIONS[6:10]}


def rank(state: State | Moments, model: RigidModel = "full") -> int:
    """Rank of the stacked regressors of all samples: at most 10, and 4 of the reduced
    (gravity-only) model.

    Singular values below `RANK_TOLERANCE` times the largest count as zero, with columns in
    SI units: those of a body of 1 kg and 1 m. Another frame of the sensor does not
    change it. Noise in the motion can hide a deficiency; `condition_number` then shows
    it. Raises `InputError` for another model.
    """
    singular = np.linalg.svd(_columns(_moments(state), model), compute_uv=False)
    return (
        int(np.sum(singular > RANK_TOLERANCE * singular[0])) if singular[0] > 0.0 else 0
    )


def condition_number(
    moments: Moments, size: float, model: RigidModel = "full"
) -> float:
    """Condition number of the stacked regressors in the units of the body; infinite
    where they are rank-deficient.

    Columns are multiplied by a-priori magnitudes of their parameters (Gautier & Khalil,
    IJRR 11(4), 1992), here those of 1 kg with a radius of gyration of `size` [m]: 1,
    size, size²; torques are counted in force times `size`. So the figure is the same in
    any unit of length, and falls as the rotation comes to weigh as much as gravity: for
    slow motion it is about |g| / (size · angular acceleration).

    This is the reading of "scaled" that comes nearest to Nadeau et al. 2022 (147, 68.4,
    58.0 at 1, 1.5, 2 rad/s, for an object of 0.2 x 0.3 m): their motion over 35 s gives
    258, 106, 59.5 at a size of 0.15 m and 193, 79.3, 44.3 at 0.2 m. Newtons beside
    newton-metres (torques not divided) give 1671, 640, 328 at 0.15 m; columns scaled to
    one length, which hides how little a slow motion excites, 4.3, 3.8, 3.3.

    Raises `InputError` for another model or a size that is not positive.
    """
    if not 0.0 < size < np.inf:
        raise InputError(f"the size of a body must be positive and finite, not {size}")
    if rank(moments, model) < len(_EQUATIONS[model]):
        return np.inf
    return float(np.linalg.cond(_columns(moments, model, size)))


def _moments(state: State | Moments) -> Moments:
    if isinstance(state, Moments):
        return state
    whole = as_one(state)
    return whole.reduced.merge(whole.full, one_bias=True)


def _columns(moments: Moments, model: str, size: float = 1.0) -> Array:
    """Triangular factor of the regressors, in units of 1 kg and `size` [m]."""
    if model not in _EQUATIONS:
        raise InputError(f"unknown model '{model}'", fix=f"use {', '.join(_EQUATIONS)}")
    equations = _EQUATIONS[model] / np.repeat((1.0, size), 3)[:, None]
    return (
        moments.factor_of(equations)
        * np.repeat((1.0, size, size**2), (1, 3, 6))[: len(equations)]
    )


@immutable
class Identifiability:
    """What a motion can tell of a body, beside the noise of its recording."""

    rank_full: int
    """of 10"""
    rank_reduced: int
    """of 4: mass and centre of mass by gravity alone"""
    condition_full: float
    """see `condition_number`; infinite when rank-deficient"""
    condition_reduced: float
    """the same of the reduced model"""
    open: dict[str, str]
    """parameters the data leave open (`hefting.core.spatial.PARAMETERS`), each with one
    sentence why"""
    summary: tuple[str, ...]
    """the same sentences, parameters with one reason joined"""

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values; null for an infinite condition number."""
        return json_ready(
            {
                name: getattr(self, name)
                for name in self.__dataclass_fields__
                if name != "summary"
            }
        )


def identifiability(
    motion: Measurements | Excitation, fit: FreeFit, size: float
) -> Identifiability:
    """What measurements, or the sums over them, can tell of a body of about `size` [m],
    of which `fit` is the unconstrained fit.

    Open are `fit.open_parameters(size)`, beside a bias when the fit has one.
    """
    if isinstance(motion, Measurements):
        motion = Excitation.of(motion)
    moments = motion.moments
    found = _Reasons(motion, fit, size).found()
    return Identifiability(
        rank_full=rank(moments, "full"),
        rank_reduced=rank(moments, "reduced"),
        condition_full=condition_number(moments, size, "full"),
        condition_reduced=condition_number(moments, size, "reduced"),
        open={name: _sentence([finding]) for name, finding in found.items()},
        summary=_join_findings(found.values()),
    )
