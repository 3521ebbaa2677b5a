"""Contradictions: recordings that cannot be of the same object, held in the same way,
as the others.

Each recording's least squares, with all that may be wrong in its interval, is compared
with that of all others. The one that differs most is named and left out, until the rest
agree: one that is wrong does not make the others look wrong.
"""

from dataclasses import dataclass, replace

from hefting.core.estimate import Estimate
from hefting.core.messages import Message, error
from hefting.estimators import OLS
from hefting.identification.agreement import QUANTITIES, Agreement, limit_of
from hefting.identification.known import known_of
from hefting.identification.seen import state_of
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import JointIngested, together

OTHERS = "the others"
MILLIMETRES = 1e3


@dataclass(frozen=True)
class Contradiction:
    """A recording that contradicts others."""

    name: str
    others: str
    """What it contradicts: the name of another, or `OTHERS`."""
    agreement: Agreement
    """Of the two estimates."""

    @property
    def message(self) -> Message:
        """What is said of it."""
        largest = self.agreement.largest
        at = largest.quantity
        own, theirs = (
            _shown(self.agreement, name, at) for name in (self.name, self.others)
        )
        what = (
            f"{self.name} contradicts {self.others}: {largest.name} {own} against "
            f"{theirs}, {largest.deviations:.0f} standard deviations apart (another "
            "object or grasp, or a sensor that changed?): identify it alone"
        )
        found = error("recordings-contradict", what)
        names = [name for name in (self.name, self.others) if name != OTHERS]
        return Message(found.code, what, found.severity, None, names)


def with_contradictions(found: Ingested) -> Ingested:
    """Recordings as they are, with a message for each that contradicts the others."""
    if not isinstance(found, JointIngested):
        return found
    messages = tuple(each.message for each in contradictions(found))
    return replace(found, warnings=(*messages, *found.warnings))


def contradictions(found: JointIngested) -> list[Contradiction]:
    """Recordings that contradict the others, the worst first."""
    left = dict(zip(found.names, found.parts, strict=True))
    alone = {name: _least_squares(part) for name, part in left.items()}
    named: list[Contradiction] = []
    while len(left) > 1:
        worst = max(
            (_against_the_rest(name, left, alone) for name in left),
            key=lambda each: each.agreement.largest.deviations,
        )
        if worst.agreement.largest.deviations <= limit_of(
            1 if len(left) == 2 else len(left)
        ):
            break
        named.append(worst)
        del left[worst.name]
    return named


def _against_the_rest(
    name: str, parts: dict[str, Ingested], alone: dict[str, Estimate]
) -> Contradiction:
    """How a recording agrees with the rest of `parts`."""
    rest = [other for other in parts if other != name]
    others = rest[0] if len(rest) == 1 else OTHERS
    theirs = (
        alone[others]
        if len(rest) == 1
        else _least_squares(together([parts[other] for other in rest], rest))
    )
    return Contradiction(
        name, others, Agreement.of({name: alone[name], others: theirs})
    )


def _least_squares(found: Ingested) -> Estimate:
    """Unconstrained least squares with the intervals of all errors that are allowed
    for."""
    estimator = OLS(**OLS.settings(known_of(found, None)))
    states = [state_of(estimator, part) for part in found.recordings]
    state = estimator.merge_all(states)
    estimate = estimator.estimate(state)
    intervals, covariance = estimator.uncertainty(estimate.parameters, state)
    return replace(estimate, intervals=intervals, covariance=covariance)


def _shown(agreement: Agreement, name: str, at: int) -> str:
    """A quantity with its half interval and unit, as a reader takes it in."""
    unit = QUANTITIES[at][1]
    scale, unit = (MILLIMETRES, "mm") if unit == "m" else (1.0, unit)
    low, high = scale * agreement.intervals[name][:, at]
    return f"{scale * agreement.values[name][at]:.4g} ± {0.5 * (high - low):.2g} {unit}"
