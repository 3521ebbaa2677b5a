"""Assignment: which intervals hold the same body, and which are contacts, in which no body
explains the wrench.

To find contacts, every interval has a body of its own, which is eliminated from its normal
equations. Those of bias and lag, which all intervals share, are then sums over the intervals
with a body, so that all choices of contacts are compared at once.
"""

import itertools
from typing import NamedTuple

import numpy as np

from hefting.core.spatial import Array, Mask, immutable
from hefting.ingest.changes.bodies import (
    PARAMETERS,
    JointFit,
    JointModel,
    autocorrelation,
    log_ratio,
    ridge_of_shared,
)
from hefting.ingest.changes.cells import (
    LARGEST_PARAMETERS,
    LONGEST_TRANSITION,
    Cells,
    Interval,
    partition,
)

NO_BODY = -1
"""Label of an interval without a body: a contact."""
MOST_INTERVALS, SHORTEST_MEAN = 9, 3.0
"""Largest number of intervals that is examined, and their mean duration [s] from which
on there may be more, as of an object that is placed again and again; shorter ones are of
something that is wrong all the time."""
FEWEST_CELLS_OF_REFERENCE = 15
"""Least number of cells of the interval whose residuals are the reference; a body
explains any wrench in shorter ones."""
DIFFERENT_BODIES = 150.0
"""Twice the log likelihood ratio of two bodies to one, over the autocorrelation time,
from which on they differ. Errors of sensors that follow the wrench reach 115 in 18 s of
a capacitive one and 85 in 6 s of a strain-gauge one; turned or flipped axes, a tilted
base and wrong units reach 84."""
EXPLAINED_CELL = 60.0
"""Sum of the squared residuals of a cell's six channels, over their variance, up to
which a body explains the cell."""
CONTACT_VARIANCE = 16.0
"""Variance of the residuals in a contact over the reference: a push is at least four
times the noise of a tenth of a second."""
MOST_JOINED = 6
"""Largest number of successive intervals that are one contact."""


class Part(NamedTuple):
    """Consecutive cells in which one body explains the wrench."""

    begin: int
    end: int
    """cell after the last"""
    label: int


@immutable
class Assignment:
    """Bodies by interval, and how well they explain the wrench."""

    cells: Cells
    model: JointModel
    labels: list[int]
    """of the model's intervals; `NO_BODY` where none explains the wrench"""
    fit: JointFit
    tau: float
    """[cells] autocorrelation time of the residuals"""

    @property
    def variance(self) -> float:
        """Variance of the residuals of force or torque, whichever is larger, over that of
        the noise."""
        return float(self.fit.variance.max())

    @property
    def stretches(self) -> list[Part]:
        """The stretches of one body each, in order, extended as long as the body explains
        the cells."""
        gap = max(1, round(LONGEST_TRANSITION / self.cells.interval))
        found: list[Part] = []
        for i, label in enumerate(self.labels):
            if label == NO_BODY:
                continue
            begin, end = self._extended(i, found[-1].end if found else 0)
            if found and found[-1].label == label and begin - found[-1].end <= gap:
                found[-1] = Part(found[-1].begin, end, label)
            else:
                found.append(Part(begin, end, label))
        return found

    def _extended(self, i: int, lowest: int) -> Interval:
        """Interval i extended by the cells that its body explains, up to the next interval
        with a body and down to the cell `lowest`."""
        begin, end = self.model.intervals[i]
        later = zip(self.model.intervals[i + 1 :], self.labels[i + 1 :], strict=True)
        others = (first for (first, _), label in later if label != NO_BODY)
        highest = next(others, len(self.cells))
        explained = self._explained(i)
        while end < highest and explained[end]:
            end += 1
        while begin > lowest and explained[begin - 1]:
            begin -= 1
        return begin, end

    def _explained(self, i: int) -> Array:
        """(M,) whether the body of interval i explains each cell."""
        x = self.fit.combinations[i]
        assert x is not None
        square = np.sum((self.model.rows @ x) ** 2, axis=1)
        return square < EXPLAINED_CELL * max(self.variance, 1.0)


def assign(cells: Cells) -> Assignment | None:
    """The intervals of the cells with the fewest bodies that explain the wrench; None for
    more intervals than events may cause.

    Contacts are left out first; then the two most similar bodies are merged, again and
    again, until their difference is significant.
    """
    intervals = partition(cells)
    if len(intervals) > max(MOST_INTERVALS, np.ptp(cells.time) / SHORTEST_MEAN):
        return None
    model = JointModel(cells, intervals)
    constant, places = JointModel(cells, intervals, drift=1), range(len(intervals))
    each = [[0 if k == i else NO_BODY for k in places] for i in places]
    variances = np.array([constant.fit(labels).variance for labels in each])
    long = model.lengths >= FEWEST_CELLS_OF_REFERENCE
    least = variances.max(axis=1)[long].min() if long.any() else 1.0
    reference = max(float(least), 1.0)
    ratios = np.maximum(variances / reference, 1.0)
    alone = ratios.prod(axis=1) < CONTACT_VARIANCE**2
    held = without_contacts(model, reference, alone)
    labels = [i if held[i] else NO_BODY for i in range(len(intervals))]
    while True:
        fit = model.fit(labels)
        tau = autocorrelation(model.residuals(fit))
        merged = _merged(fit, labels)
        if merged is None or log_ratio(model.fit(merged), fit) / tau > DIFFERENT_BODIES:
            return Assignment(cells, model, labels, fit, tau)
        labels = merged


def _merged(fit: JointFit, labels: list[int]) -> list[int] | None:
    """The labels with the two most similar bodies merged; None if there is only one."""
    names = sorted({label for label in labels if label != NO_BODY})
    if len(names) < 2:
        return None
    pairs = [(i, j) for j in range(len(names)) for i in range(j)]
    i, j = min(pairs, key=lambda pair: fit.increase(*pair))
    return [names[i] if label == names[j] else label for label in labels]


def without_contacts(model: JointModel, reference: float, alone: Mask) -> Mask:
    """(L,) whether each interval has a body; one that has none is a contact.

    Greedy, from bodies in all intervals, and in those that one explains `alone` (L,), as
    several contacts with bodies mislead what all share: the run of intervals that lowers
    the cost most as a contact, or with bodies again, becomes one, until none lowers it.
    `reference` is the variance of the residuals where a body explains the wrench.
    """
    bodies, starts = SeparateBodies(model), [np.ones_like(alone)]
    if alone.any() and not alone.all():
        starts.append(alone)
    found = [_cheapest_near(bodies, start, reference) for start in starts]
    return min(found, key=lambda each: each[0])[1]


def _cheapest_near(
    bodies: "SeparateBodies", held: Mask, reference: float
) -> tuple[float, Mask]:
    """The least cost that changes of one run after the other lead to, and its choice."""
    cost = float(bodies.costs(held[None], reference)[0])
    while True:
        others = _with_a_run_changed(held)
        if not len(others):
            return cost, held
        costs = bodies.costs(others, reference)
        if not costs.min() < cost:
            return cost, held
        cost = float(costs.min())
        held = others[np.argmin(costs)]


def _with_a_run_changed(held: Mask) -> Mask:
    """(N, L) the choices with one more run of intervals without a body or with bodies; one
    interval at least keeps its body."""
    L = len(held)
    others = []
    for begin, end in itertools.combinations(range(L + 1), 2):
        for with_body in (False, True):
            other = held.copy()
            other[begin:end] = with_body
            changed = (other[begin:end] != held[begin:end]).any()
            if end - begin <= MOST_JOINED and other.any() and changed:
                others.append(other)
    return np.array(others, dtype=bool).reshape(-1, L)


class SeparateBodies:
    """Least squares with a body of its own in each of L intervals, and a common bias
    and lag."""

    def __init__(self, model: JointModel) -> None:
        self.lengths = model.lengths
        """(L,) cells of the intervals"""
        p, each = PARAMETERS, model.grams
        both = each.sum(axis=1)
        own = both[:, :p, :p] + np.diag(LARGEST_PARAMETERS**-2.0)
        # the bodies by bias, lag and one: what they are without them in the last column
        bodies = np.linalg.solve(own, both[:, :p, p:])
        L, _, D = bodies.shape
        residual = np.zeros((L, p + D, D))
        residual[:, :p] = bodies
        residual[:, p:] = -np.eye(D)
        residual[:, :, -1] *= -1.0
        self.grams = np.swapaxes(residual, 1, 2)[:, None] @ each @ residual[:, None]
        """(L, 2, D, D) of the residuals of force and torque, by bias, lag and one"""
        left = both[:, p:, p:] - np.swapaxes(both[:, :p, p:], 1, 2) @ bodies
        self.normal, self.right = left[:, :-1, :-1], left[:, :-1, -1]
        """what each interval adds to the normal equations of bias and lag"""
        self.spent = np.trace(np.linalg.solve(own, both[:, :p, :p]), axis1=1, axis2=2)
        """(L,) equations that the bodies' own unknowns take, of force and torque"""
        self.ridge = np.diag(ridge_of_shared(model.drift))

    def costs(self, held: Mask, reference: float) -> Array:
        """(N,) minus twice the log-likelihood of each choice `held` (N, L) of intervals
        with a body. Each interval has a variance of its own; in contacts it is
        `CONTACT_VARIANCE` times the `reference`."""
        N, L = held.shape
        D = self.normal.shape[1]
        chosen = held.astype(float)
        normal = (chosen @ self.normal.reshape(L, -1)).reshape(N, D, D) + self.ridge
        inverse = np.linalg.inv(normal)
        common = (inverse @ (chosen @ self.right)[:, :, None])[:, :, 0]
        x = np.column_stack((common, np.ones(N)))
        squares = np.einsum("ni,lgij,nj->nlg", x, self.grams, x, optimize=True)
        shared = self.grams.sum(axis=1)[:, :-1, :-1].reshape(L, -1)
        spent = self.spent + inverse.reshape(N, -1) @ shared.T
        equations = 3.0 * self.lengths - 0.5 * spent
        variances = np.maximum(squares, 0.0) / np.maximum(equations, 1.0)[:, :, None]
        logs = np.log(np.maximum(variances / reference, 1.0)).sum(axis=2)
        contact = 6.0 * self.lengths * np.log(CONTACT_VARIANCE)
        return np.asarray(np.where(held, equations * logs, contact).sum(axis=1))
