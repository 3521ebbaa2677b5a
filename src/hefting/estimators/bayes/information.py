"""Whether samples determine anything."""

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.joint_state import State, states_of
from hefting.estimators.whitened_state import WhitenedState


def require_information(samples: Samples, state: State, free_bias: bool) -> None:
    """`NotIdentifiableError` where the regressor without its mean, beside a free bias,
    is zero up to rounding."""
    if isinstance(state, WhitenedState):
        size = float(np.abs(state.factor[:, :10]).max())
        size = max(size, np.finfo(float).tiny)
    else:
        size = max(float(np.abs(each.full.full).max()) for each in states_of(state))
    if float(np.abs(samples.A).max()) <= 1e-9 * size:
        beside = " beside a bias" if free_bias else ""
        raise NotIdentifiableError(
            f"the samples determine nothing{beside}", fix="record other orientations"
        )
