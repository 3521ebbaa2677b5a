"""Contacts: the intervals in which no body explains the wrench, a body of its own in each
of the others.

Beside the bias that all intervals share each body is eliminated from the normal equations
of its interval. What is left of an interval is added where it has a body, so that all
choices of intervals without one are compared at once.
"""

import itertools

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.ingest.changes.bodies import PARAMETERS, JointModel, ridge_of_bias
from hefting.ingest.changes.partition import LARGEST_PARAMETERS

CONTACT_VARIANCE = 16.0
"""Variance of the residuals in a contact, over that where a body explains the wrench
best: a push is four times as large as the noise of a tenth of a second, or more."""
MOST_JOINED = 6
"""Most intervals that are taken for one contact at a time."""


def without_contacts(model: JointModel, reference: float) -> Mask:
    """(L,) whether each interval has a body: where none has, it is a contact, in which
    none explains the wrench beside the bias of the others.

    One run of intervals after the other is taken for a contact, that which lowers the
    cost most. `reference` is the variance of residuals where a body explains the
    wrench.
    """
    alone = SeparateBodies(model)
    held = np.ones(len(model.intervals), dtype=bool)
    cost = float(alone.costs(held[None], reference)[0])
    while True:
        others = _with_a_contact(held)
        if not len(others):
            return held
        costs = alone.costs(others, reference)
        if not costs.min() < cost:
            return held
        cost = float(costs.min())
        held = others[np.argmin(costs)]


def _with_a_contact(held: Mask) -> Mask:
    """(N, L) the same with each run of intervals taken for a contact, but for one
    interval at least."""
    L = len(held)
    runs = itertools.combinations(range(L + 1), 2)
    others = []
    for begin, end in runs:
        other = held.copy()
        other[begin:end] = False
        if end - begin <= MOST_JOINED and other.any() and held[begin:end].any():
            others.append(other)
    return np.array(others).reshape(-1, L)


class SeparateBodies:
    """Least squares of a body in each of some intervals, beside one bias."""

    def __init__(self, model: JointModel) -> None:
        self.lengths = model.lengths
        """(L,) cells of the intervals"""
        p, each = PARAMETERS, model.grams
        both = each.sum(axis=1)
        own = both[:, :p, :p] + np.diag(LARGEST_PARAMETERS**-2.0)
        # the bodies by the bias and one: what they are without it in the last column
        bodies = np.linalg.solve(own, both[:, :p, p:])
        L, _, D = bodies.shape
        residual = np.zeros((L, p + D, D))
        residual[:, :p] = bodies
        residual[:, p:] = -np.eye(D)
        residual[:, :, -1] *= -1.0
        self.grams = np.swapaxes(residual, 1, 2)[:, None] @ each @ residual[:, None]
        """(L, 2, D, D) of the residuals of force and torque, by the bias and one"""
        left = both[:, p:, p:] - np.swapaxes(both[:, :p, p:], 1, 2) @ bodies
        self.normal, self.right = left[:, :-1, :-1], left[:, :-1, -1]
        """what each interval adds to the normal equations of the bias"""
        self.spent = np.trace(np.linalg.solve(own, both[:, :p, :p]), axis1=1, axis2=2)
        """(L,) equations that the bodies' own unknowns take, of force and torque"""
        self.ridge = np.diag(ridge_of_bias(model.drift))

    def costs(self, held: Mask, reference: float) -> Array:
        """(N,) minus twice the log-likelihood of each choice `held` (N, L) of intervals
        with a body: each interval with a variance of its own, that of contacts with
        `CONTACT_VARIANCE` times the `reference`."""
        N, L = held.shape
        D = self.normal.shape[1]
        chosen = held.astype(float)
        normal = (chosen @ self.normal.reshape(L, -1)).reshape(N, D, D) + self.ridge
        inverse = np.linalg.inv(normal)
        bias = (inverse @ (chosen @ self.right)[:, :, None])[:, :, 0]
        x = np.column_stack((bias, np.ones(N)))
        squares = np.einsum("ni,lgij,nj->nlg", x, self.grams, x, optimize=True)
        shared = self.grams.sum(axis=1)[:, :-1, :-1].reshape(L, -1)
        spent = self.spent + inverse.reshape(N, -1) @ shared.T
        equations = 3.0 * self.lengths - 0.5 * spent
        variances = np.maximum(squares, 0.0) / np.maximum(equations, 1.0)[:, :, None]
        logs = np.log(np.maximum(variances / reference, 1.0)).sum(axis=2)
        contact = 6.0 * self.lengths * np.log(CONTACT_VARIANCE)
        return np.asarray(np.where(held, equations * logs, contact).sum(axis=1))
