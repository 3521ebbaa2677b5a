"""Certificate: how close an estimate is to the optimum of its own problem."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Certificate:
    """Evidence, independent of the solver, of how close an estimate is to the optimum
    of its own problem.

    For every admissible answer the objective is at least ``bound``; so ``gap`` =
    objective - bound limits what a perfect solver could still gain.

    Examples
    --------
    >>> hefting.Certificate(objective=2.5, bound=2.25).gap
    0.25
    """

    objective: float
    """Objective at the estimate, computed anew from the data."""
    bound: float
    """Lower bound on the optimum: a dual-feasible value."""
    iterations: int = 0
    """Linear systems solved."""
    converged: bool = True
    """Whether the gap met the solver's own tolerance."""

    @property
    def gap(self) -> float:
        """Objective minus bound, in the objective's units."""
        return self.objective - self.bound
