"""Agreement: whether estimates can be of the same object, by their intervals.

Mass, centre of mass and principal moments of inertia are compared. Two estimates differ
by d = |a - b| / sqrt(std_a² + std_b²), where 1.96 std is the half of each interval that
faces the other.

Noise separates the principal moments of a nearly symmetric body. So tensors a and b are
compared by the moments v'J v along common axes v, the principal ones of their mean
weighted by precision. Errors that two estimates share, such as those of one sensor or
shape, make d smaller than it would be: contradictions hold in spite of them. The
estimates must be in the same frame: of one grasp the sensor's, of several the object's
(`hefting.in_frame`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from hefting import __version__
from hefting.core.errors import InputError
from hefting.core.estimate import Answered, Estimate, estimate_given
from hefting.core.estimate_json import json_ready
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.messages import Verdict
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import Array, immutable, vector_to_tensor
from hefting.core.summary import Shown
from hefting.core.undetermined import mapped

QUANTITIES = (
    ("mass", "kg"),
    *((f"COM {axis}", "m") for axis in "xyz"),
    *((f"moment {i}", "kg m²") for i in (1, 2, 3)),
)
"""Quantities compared, with units; moments are the principal ones about the COM, in
rising order."""
AGREEMENT_SCHEMA = "hefting.agreement/1"
"""Name and version of the JSON form, under the key ``schema``."""
FALSE_ALARM = 0.001
"""Probability that estimates of the same object contradict one another, over all
quantities and pairs together."""


@dataclass(frozen=True)
class Difference:
    """The two estimates that differ most, and the quantity."""

    first: str
    second: str
    quantity: int
    """Index of `QUANTITIES`."""
    deviations: float
    """Difference in standard deviations."""

    @property
    def name(self) -> str:
        """Name of the quantity, for a sentence."""
        own = QUANTITIES[self.quantity][0]
        return "moment about a common axis" if "moment" in own else own


@immutable
class Agreement(Shown):
    """Differences between several estimates of the same object."""

    values: dict[str, Array]
    """(7,) `QUANTITIES` of each estimate"""
    intervals: dict[str, Array]
    """(2, 7) ends of their 95 % intervals; infinite if open"""
    apart: dict[tuple[str, str], Array]
    """(7,) differences of each pair in standard deviations; 0 where one leaves the
    quantity open"""
    verdicts: dict[str, Verdict]
    """of each estimate"""
    frame: str = "sensor"
    """of all"""

    @classmethod
    def of(cls, estimates: Mapping[str, Estimate]) -> "Agreement":
        """Of two or more estimates by name. Raises `InputError` for fewer, and for those
        in different frames."""
        if len(estimates) < 2:
            raise InputError("two estimates or more are compared", fix="give another")
        frames = sorted({e.frame for e in estimates.values()})
        if len(frames) > 1:
            what = f"the estimates are in different frames: {', '.join(frames)}"
            raise InputError(what, fix="give all in one, see hefting.in_frame")
        values = {name: _values(e.parameters) for name, e in estimates.items()}
        intervals = {name: _intervals(e) for name, e in estimates.items()}
        apart = {
            (a, b): np.concatenate(
                (
                    _apart(values[a], intervals[a], values[b], intervals[b])[:4],
                    _moments_apart(estimates[a], estimates[b]),
                )
            )
            for a, b in combinations(estimates, 2)
        }
        verdicts = {name: e.verdict for name, e in estimates.items()}
        return cls(values, intervals, apart, verdicts, *frames)

    def __repr__(self) -> str:
        name = f"Agreement of {len(self.values)} estimates: "
        if not self.tested:
            return name + "nothing to compare by"
        most = self.largest
        how = "they agree" if self.agree else "they contradict one another"
        what = f"{most.first} and {most.second} differ most, in {most.name}"
        return f"{name}{how}; {what} by {most.deviations:.1f} standard deviations (limit {self.limit:.1f})"

    @property
    def doubted(self) -> dict[str, Verdict]:
        """Verdicts that are not good: such an estimate may agree only because its
        intervals are wide, or by mistake."""
        return {n: v for n, v in self.verdicts.items() if v.level != "good"}

    @property
    def limit(self) -> float:
        """Standard deviations apart above which two estimates contradict each other."""
        return limit_of(len(self.apart))

    @property
    def largest(self) -> Difference:
        """The largest difference."""
        (first, second), apart = max(self.apart.items(), key=lambda pair: pair[1].max())
        at = int(np.argmax(apart))
        return Difference(first, second, at, float(apart[at]))

    @property
    def agree(self) -> bool:
        """Whether all may be of the same object."""
        return self.largest.deviations <= self.limit

    @property
    def tested(self) -> bool:
        """Whether two estimates determine the same quantity, and can be compared."""
        known = [np.isfinite(ends).all(axis=0) for ends in self.intervals.values()]
        return bool((np.sum(known, axis=0) > 1).any())

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values; null where an interval has no end."""
        names = [name for name, _ in QUANTITIES]
        return json_ready(
            {
                "schema": AGREEMENT_SCHEMA,
                "version": __version__,
                "quantities": names,
                "units": [unit for _, unit in QUANTITIES],
                "estimates": [
                    {
                        "name": n,
                        "values": v,
                        "intervals": self.intervals[n],
                        "verdict": self.verdicts[n].level,
                        "reasons": self.verdicts[n].reasons,
                    }
                    for n, v in self.values.items()
                ],
                "differences": [
                    {"between": list(pair), "deviations": apart}
                    for pair, apart in self.apart.items()
                ],
                "largest": {
                    "between": [self.largest.first, self.largest.second],
                    "quantity": QUANTITIES[self.largest.quantity][0],
                    "deviations": self.largest.deviations,
                },
                "limit": self.limit,
                "tested": self.tested,
                "agree": self.agree,
            }
        )


def compare(
    *estimates: Estimate | Answered | str | Path,
    **named: Estimate | Answered | str | Path,
) -> Agreement:
    """Tell whether estimates can be of the same object, in the same frame: the sensor's,
    or of objects grasped in different ways that of the object (`hefting.in_frame`).

    Parameters
    ----------
    *estimates
        Estimates, what `hefting.identify` returned, or paths of saved ones. A path is
        its own name; others are called by their number, from 1.
    **named
        The same, each by its name.

    Returns
    -------
    Agreement
        With `agree`, whether they can; `largest`, which two differ most and in what; and
        `apart`, all differences in standard deviations.

    Raises
    ------
    InputError
        For fewer than two, two of the same name, or a value that is no estimate.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv")
    >>> hefting.compare(found, found).agree
    True
    """
    found: dict[str, Estimate] = {}
    for i, each in enumerate(estimates, 1):
        name = str(each if isinstance(each, str | Path) else i)
        if name in found or name in named:
            raise InputError("is given twice", name, "give two different estimates")
        found[name] = estimate_given(each, any_frame=True)
    found |= {
        name: estimate_given(each, any_frame=True) for name, each in named.items()
    }
    return Agreement.of(found)


def limit_of(pairs: int) -> float:
    """Difference in standard deviations that one quantity of `pairs` pairs of estimates
    exceeds by chance with the probability `FALSE_ALARM`."""
    from statistics import NormalDist

    comparisons = pairs * len(QUANTITIES)
    return NormalDist().inv_cdf(1.0 - 0.5 * FALSE_ALARM / comparisons)


def _values(body: InertialParameters) -> Array:
    moments = np.linalg.eigvalsh(body.inertia_at_com)
    return np.array((body.mass, *body.center_of_mass, *moments))


def _intervals(estimate: Estimate) -> Array:
    """(2, 7) ends of the intervals; of principal moments to first order."""
    values, ends = _values(estimate.parameters), np.full((2, 7), np.inf)
    ends[0] = -np.inf
    std = estimate.std
    if estimate.intervals is not None:
        ends[:, 0] = estimate.intervals["mass"]
        ends[:, 1:4] = estimate.intervals["center_of_mass"]
    elif std is not None:
        own = np.array((std["mass"], *std["center_of_mass"]))
        ends[:, :4] = values[:4] + Z95 * np.outer((-1.0, 1.0), own)
    axes = np.linalg.eigh(estimate.parameters.inertia_at_com)[1]
    ends[:, 4:] = values[4:] + np.outer((-Z95, Z95), _std_of_moments(estimate, axes))
    # an open number has an interval by a prior, which does not count
    ends[:, :4][:, estimate.undetermined.ten[:4]] = np.nan
    return np.where(np.isnan(ends), np.array(((-np.inf,), (np.inf,))), ends)


def _std_of_moments(estimate: Estimate, axes: Array) -> Array:
    """(3,) standard deviations of the moments v'J v about the COM along each column v
    of `axes` (3, 3); infinite if they are open or unknown."""
    if estimate.covariance is None:
        return np.full(3, np.inf)
    along = np.einsum("ia,sij,ja->as", axes, vector_to_tensor(np.eye(6)), axes)
    J = along @ com_jacobian(estimate.parameters)[4:]
    found = np.sqrt(np.maximum(mapped(estimate.covariance, J).diagonal(), 0.0))
    open_ = estimate.undetermined.ten[4:]
    found[(np.abs(along[:, open_]) > 1e-12).any(axis=1)] = np.inf
    return found


def _moments_apart(a: Estimate, b: Estimate) -> Array:
    """(3,) differences of moments along common axes in standard deviations."""
    J_a, J_b = a.parameters.inertia_at_com, b.parameters.inertia_at_com
    squares = [np.sum(_std_of_moments(e, np.eye(3)) ** 2) for e in (a, b)]
    known = np.isfinite(squares).all()
    share = squares[1] / max(squares[0] + squares[1], 1e-300) if known else 0.5
    axes = np.linalg.eigh(share * J_a + (1.0 - share) * J_b)[1]
    ends: list[Array] = []
    values = [np.einsum("ia,ij,ja->a", axes, J, axes) for J in (J_a, J_b)]
    for e, own in zip((a, b), values, strict=True):
        half = Z95 * _std_of_moments(e, axes)
        ends.append(np.stack((own - half, own + half)))
    return _apart(values[0], ends[0], values[1], ends[1])


def _apart(a: Array, of_a: Array, b: Array, of_b: Array) -> Array:
    """(k,) differences of a and b (k,) with intervals (2, k) in standard deviations."""
    a_is_less = a <= b
    std_a = np.where(a_is_less, of_a[1] - a, a - of_a[0]) / Z95
    std_b = np.where(a_is_less, b - of_b[0], of_b[1] - b) / Z95
    std = np.hypot(std_a, std_b)
    known = np.isfinite(of_a).all(axis=0) & np.isfinite(of_b).all(axis=0)
    # estimates without noise differ by rounding
    least = 1e-9 * np.maximum(np.abs(a), np.abs(b))
    return np.where(
        known, np.abs(a - b) / np.maximum(np.maximum(std, least), 1e-300), 0
    )
