"""Contradictions: recordings that cannot be of the same object, in the same grasp, as
the others.

Least squares of each recording, with intervals for all errors except those that one
sensor makes alike in all, is compared with that of all others. The recording that
differs most is named and left out, until the rest agree, so that a wrong one does not
make others look wrong.
"""

from collections.abc import Mapping
from dataclasses import astuple, dataclass, replace

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Message, error
from hefting.core.sensor_accuracy import TYPICAL, SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators import OLS
from hefting.estimators.quadratic import Quadratic
from hefting.identification.agreement import QUANTITIES, Agreement, limit_of
from hefting.identification.estimator import known_of, state_of
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import JointIngested, together

OTHERS = "the others"
MILLIMETRES = 1e3
FEW = 8
"""Number of recordings up to which each is compared with the rest; of more, those that
a closed form suspects."""
MOST_SUSPECTS = 4
"""Number of suspects. In 40 sets of 9 to 20 simulated recordings, up to three of them
of an object 1 to 30 % lighter or heavier, the worst was always the first suspect."""
SHIFTED = ("mass", "center_of_mass")
"""Intervals by which suspects are found."""


@dataclass(frozen=True)
class Contradiction:
    """A recording that contradicts others."""

    name: str
    others: str
    """What it contradicts: the name of another recording, or `OTHERS`."""
    agreement: Agreement
    """Of the two estimates."""

    @property
    def message(self) -> Message:
        """The message on it."""
        largest = self.agreement.largest
        at, values = largest.quantity, ""
        if at < 4:  # moments along common axes are not in the agreement
            own, theirs = (
                _shown(self.agreement, name, at) for name in (self.name, self.others)
            )
            values = f" {own} against {theirs},"
        what = (
            f"{self.name} contradicts {self.others}: {largest.name}{values} "
            f"{largest.deviations:.0f} standard deviations apart (another object or "
            "grasp, or a sensor that changed?): identify it alone"
        )
        found = error("recordings-contradict", what)
        names = [name for name in (self.name, self.others) if name != OTHERS]
        return Message(found.code, what, found.severity, None, names)


class _SameSensor(SensorAccuracy):
    """An accuracy without the gain of all channels, the same in all recordings."""

    @property
    def gain_std(self) -> float:
        """Zero."""
        return 0.0


def with_contradictions(
    found: Ingested, accuracy: SensorAccuracy | str | None = None
) -> Ingested:
    """The recordings with a message on each that contradicts the others, for a sensor's
    `accuracy`.

    Raises `InputError` for two with the same samples.
    """
    if not isinstance(found, JointIngested):
        return found
    seen: dict[bytes, str] = {}
    for name, part in zip(found.names, found.parts, strict=True):
        first = seen.setdefault(part.condensed.counted.factor.tobytes(), name)
        if first != name:
            what = f"holds the same samples as {first}"
            raise InputError(what, name, "give each recording once")
    messages = tuple(each.message for each in contradictions(found, accuracy))
    return replace(found, warnings=(*messages, *found.warnings))


def contradictions(
    found: JointIngested, accuracy: SensorAccuracy | str | None = None
) -> list[Contradiction]:
    """Recordings that contradict the others, the worst first."""
    left = dict(zip(found.names, found.parts, strict=True))
    of_sensor = SensorAccuracy.of(accuracy) or TYPICAL
    alone = {name: least_squares_of(part, of_sensor) for name, part in left.items()}
    named: list[Contradiction] = []
    while len(left) > 1:
        worst = _worst(left, alone, of_sensor)
        pairs = 1 if len(left) == 2 else len(left)
        if worst.agreement.largest.deviations <= limit_of(pairs):
            break
        named.append(worst)
        del left[worst.name]
    return named


def _worst(
    parts: dict[str, Ingested], alone: dict[str, Estimate], of_sensor: SensorAccuracy
) -> Contradiction:
    """The recording that differs most from the rest; of more than `FEW`, the worst of
    `MOST_SUSPECTS`."""
    suspects = dict.fromkeys(parts, np.inf)
    if len(parts) > FEW:
        ranked = deviations_from_rest(parts, alone, of_sensor)
        suspects = dict(list(ranked.items())[:MOST_SUSPECTS])
    worst, largest = None, -1.0
    for name, expected in suspects.items():
        if largest >= expected:
            break
        each = _against_the_rest(name, parts, alone, of_sensor)
        if each.agreement.largest.deviations > largest:
            worst, largest = each, each.agreement.largest.deviations
    assert worst is not None
    return worst


def _against_the_rest(
    name: str,
    parts: dict[str, Ingested],
    alone: dict[str, Estimate],
    of_sensor: SensorAccuracy,
) -> Contradiction:
    rest = [other for other in parts if other != name]
    others = rest[0] if len(rest) == 1 else OTHERS
    theirs = alone.get(rest[0]) if len(rest) == 1 else None
    if theirs is None:
        found = together([parts[other] for other in rest], rest)
        theirs = least_squares_of(found, of_sensor)
    agreement = Agreement.of({name: alone[name], others: theirs})
    return Contradiction(name, others, agreement)


def _shown(agreement: Agreement, name: str, at: int) -> str:
    unit = QUANTITIES[at][1]
    scale, unit = (MILLIMETRES, "mm") if unit == "m" else (1.0, unit)
    low, high = scale * agreement.intervals[name][:, at]
    return f"{scale * agreement.values[name][at]:.4g} ± {0.5 * (high - low):.2g} {unit}"


def least_squares_of(found: Ingested, of_sensor: SensorAccuracy) -> Estimate:
    """Unconstrained least squares with intervals for all errors that may differ between
    recordings."""
    own = replace(found, gravity_error=None)
    differing = _SameSensor(*astuple(of_sensor))
    estimator = OLS(**OLS.settings(known_of(own, None)), sensor_accuracy=differing)
    states = [state_of(estimator, part) for part in found.recordings]
    state = estimator.merge_all(states)
    estimate = replace(estimator, intervals=False).estimate(state)
    intervals, covariance = estimator.uncertainty(estimate.parameters, state)
    return replace(estimate, intervals=intervals, covariance=covariance)


def deviations_from_rest(
    parts: Mapping[str, Ingested],
    alone: Mapping[str, Estimate],
    of_sensor: SensorAccuracy,
) -> dict[str, float]:
    """Approximate difference of each recording from all others in standard deviations,
    in falling order; `alone` is the least squares of each."""
    found = together(list(parts.values()), list(parts))
    whole = least_squares_of(found, of_sensor)
    phi, free_bias = whole.parameters.vector, found.bias == "estimate"
    each = {
        name: Quadratic.of(part.state, found.fit.noise, free_bias)
        for name, part in parts.items()
    }
    G = np.sum([own.A.T @ own.A for own in each.values()], axis=0)
    apart: dict[str, float] = {}
    for name, own in each.items():
        gradient = own.A.T @ (own.A @ phi - own.b)
        moved = phi + _solved(G - own.A.T @ own.A, gradient)
        rest = _moved(whole, InertialParameters(moved))
        agreement = Agreement.of({"own": alone[name], "rest": rest})
        apart[name] = agreement.largest.deviations
    return dict(sorted(apart.items(), key=lambda item: -item[1]))


def _solved(G: Array, gradient: Array) -> Array:
    """G^-1 gradient (10,); the smallest solution in scaled unknowns if G (10, 10) is
    singular."""
    scale = np.sqrt(np.maximum(G.diagonal(), 1e-300))
    scaled = G / np.outer(scale, scale)
    return np.linalg.lstsq(scaled, gradient / scale, rcond=1e-12)[0] / scale


def _moved(estimate: Estimate, body: InertialParameters) -> Estimate:
    """The estimate with the parameters of `body` and intervals of the same widths."""
    intervals = dict(estimate.intervals or {})
    for name in SHIFTED:
        own = getattr(estimate.parameters, name)
        intervals[name] = intervals[name] + (np.asarray(getattr(body, name)) - own)
    return replace(estimate, parameters=body, intervals=intervals)
