"""Assignment: which of the intervals hold the same body, and which hold none."""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array
from hefting.ingest.changes.bodies import (
    JointFit,
    JointModel,
    autocorrelation,
    log_ratio,
)
from hefting.ingest.changes.cells import Cells
from hefting.ingest.changes.contacts import without_contacts
from hefting.ingest.changes.partition import LONGEST_TRANSITION, Interval, partition

NO_BODY = -1
"""Label of an interval in which no body explains the wrench."""
MOST_INTERVALS = 9
"""Most intervals that are looked at: as a drift of the bias or a contact is divided into
several, that is about three events. More are found where something is wrong all the
time."""
FEWEST_CELLS_OF_REFERENCE = 15
"""Fewest cells of the interval in which a body explains the wrench best: in shorter ones
any wrench is explained."""
DIFFERENT_BODIES = 150.0
"""Logarithm of the likelihood ratio of two bodies to one, by the number of independent
residuals, from which on they are different. Errors of sensors that follow the wrench
reach 115 in 18 s of a capacitive one and 85 in 6 s of a strain-gauge one; turned or
flipped axes, a tilted base and wrong units reach 84."""
EXPLAINED_CELL = 60.0
"""Sum of the squared residuals of a cell's six channels, over their variance, up to
which a body explains the cell."""


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
        """The larger one of force and torque, in units of the noise."""
        return float(self.fit.variance.max())

    @property
    def stretches(self) -> list[tuple[int, int, int]]:
        """First cell, cell after the last, and label of each stretch of one body, as
        long as the body explains the cells, in order."""
        good = [i for i, label in enumerate(self.labels) if label != NO_BODY]
        grown: list[tuple[int, int, int]] = []
        for i in good:
            begin, end = self._grown(i, grown[-1][1] if grown else 0)
            if grown and self._continues(grown[-1], begin, self.labels[i]):
                grown[-1] = (grown[-1][0], end, self.labels[i])
            else:
                grown.append((begin, end, self.labels[i]))
        return grown

    def _continues(self, before: tuple[int, int, int], begin: int, label: int) -> bool:
        """Whether a stretch with a label that begins at a cell is the same one as that
        before."""
        most = max(1, round(LONGEST_TRANSITION / self.cells.interval))
        return before[2] == label and begin - before[1] <= most

    def _grown(self, i: int, lowest: int) -> Interval:
        """Interval i with the cells before it, but none before `lowest`, and after it
        that its body explains."""
        begin, end = self.model.intervals[i]
        others = [
            first
            for (first, _), label in zip(self.model.intervals, self.labels, strict=True)
            if label != NO_BODY and first >= end
        ]
        highest = min(others, default=len(self.cells))
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
    """The fewest bodies that explain the wrench, and where none does; None where there
    are too many intervals for that."""
    intervals = partition(cells)
    if len(intervals) > MOST_INTERVALS:
        return None
    model = JointModel(cells, intervals)
    long = [i for i in intervals if i[1] - i[0] >= FEWEST_CELLS_OF_REFERENCE]
    each = [JointModel(cells, [i], drift=1).fit([0]) for i in long]
    reference = min((float(fit.variance.max()) for fit in each), default=1.0)
    held = without_contacts(model, max(reference, 1.0))
    labels = [i if held[i] else NO_BODY for i in range(len(intervals))]
    while True:
        fit = model.fit(labels)
        tau = autocorrelation(model.residuals(fit))
        merged = _merged(fit, labels)
        if merged is None or log_ratio(model.fit(merged), fit) / tau > DIFFERENT_BODIES:
            return Assignment(cells, model, labels, fit, tau)
        labels = merged


def _merged(fit: JointFit, labels: list[int]) -> list[int] | None:
    """The labels with those two bodies the same that differ least; None where there is
    one only."""
    names = sorted({label for label in labels if label != NO_BODY})
    if len(names) < 2:
        return None
    pairs = [(i, j) for j in range(len(names)) for i in range(j)]
    i, j = min(pairs, key=lambda pair: fit.increase(*pair))
    return [names[i] if label == names[j] else label for label in labels]
