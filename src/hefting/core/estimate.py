"""Estimate: the result of an estimator, its uncertainty, and checks of it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol, Self, cast

import numpy as np

from hefting import __version__
from hefting.core.accuracy import Accuracy
from hefting.core.accuracy import Certificate as Certificate
from hefting.core.errors import InputError, nearest
from hefting.core.estimate_json import (
    SCHEMA,
    coded,
    fields_of,
    graver_reasons,
    json_ready,
    recommended_of,
)
from hefting.core.files import read_json, write_atomically
from hefting.core.inertia import Consistency, InertialParameters, com_jacobian
from hefting.core.messages import Message, Verdict, error, verdict_of, warning
from hefting.core.spatial import Array, freeze, vector_to_tensor
from hefting.core.summary import Shown, body_lines, samples_told, warning_lines
from hefting.core.undetermined import (
    NOTHING_OPEN,
    Undetermined,
    mapped,
    undetermined_mass,
)

NORMAL_95 = 1.96
"""Half-width of a 95 % interval of a normal variable over its standard deviation."""


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Shown):
    """Inertial parameters found from measurements, in sensor axes about the sensor
    origin.

    Examples
    --------
    >>> estimate = hefting.identify("demo/log.csv").estimate
    >>> estimate.save("found.json")
    >>> again = hefting.Estimate.load("found.json")
    >>> again.mass == estimate.mass, again.center_of_mass.shape, again.inertia.shape
    (True, (3,), (3, 3))
    >>> low, high = again.interval("mass")
    >>> bool(low < again.mass < high)
    True
    """

    method: str
    """Name of the estimator."""
    parameters: InertialParameters
    """The ten parameters."""
    samples: int
    """Samples used."""
    duration: float | None = None
    """Time spanned by the samples [s]; None for static poses."""
    covariance: Array | None = None
    """(10, 10) covariance of ``parameters.vector``; None if the method has none."""
    intervals: dict[str, Array] | None = None
    """Lower and upper ends of the 95 % interval of each quantity: ``mass`` (2,) [kg],
    ``center_of_mass`` (2, 3) [m], ``inertia_at_origin`` and ``inertia_at_com`` (2, 3,
    3) [kg m²]; infinite where the samples leave a quantity open. None if the method has
    none."""
    accuracy: Accuracy | None = None
    """Limits that the errors do not exceed, each with 95 % probability; None unless an
    accuracy was asked for."""
    sufficient: bool | None = None
    """Whether these meet the accuracy that was asked for."""
    certificate: Certificate | None = None
    """Certificate of the distance from the method's optimum."""
    bias: Array | None = None
    """(6,) wrench bias [N, N m] found with it, with the sign of `hefting.core.spatial`
    (that of an on-sensor log is the opposite); (n, 6) of n recordings, one for each;
    None when it was not estimated."""
    point_masses: Array | None = None
    """(n,) masses [kg] at the shape's points, of methods that find them."""
    residual: Array | None = None
    """(2,) root-mean-square force [N] and torque [N m] residual of the full model."""
    hull_margin: float | None = None
    """Depth of the COM in the shape's convex hull over its largest side; None without a
    shape."""
    undetermined: Undetermined = None  # type: ignore[assignment]
    """Numbers that neither the data nor a shape determine, and what their values follow
    from; by default those whose `intervals` have no end."""
    warnings: tuple[str, ...] = ()
    """What the user should know before trusting it."""
    provenance: dict[str, Any] = field(default_factory=dict[str, Any])
    """Read and assumed: log, gravity, wrench sign, bias, motion, hyperparameters."""
    frame: str = "sensor"
    """Frame of the numbers; another after `hefting.in_frame`."""

    def __post_init__(self):
        freeze(self, "covariance", "bias", "point_masses", "residual")
        if self.undetermined is None:
            ends = self._ends()
            found = NOTHING_OPEN if ends is None else Undetermined.without_end(ends)
            object.__setattr__(self, "undetermined", found)

    def _ends(self) -> dict[str, Array] | None:
        """Ends of the intervals; else of an infinite covariance by its deviations."""
        if self.intervals is not None or self.covariance is None:
            return self.intervals
        std = self.std if np.isinf(self.covariance.diagonal()).any() else None
        return None if std is None else {k: v[None] for k, v in std.items()}

    @property
    def half_widths(self) -> dict[str, Array]:
        """Half-widths of the 95 % intervals of ``mass`` (), ``center_of_mass`` (3,) and
        ``inertia_at_com`` (3, 3); infinite without an interval."""
        sizes = {"mass": (), "center_of_mass": (3,), "inertia_at_com": (3, 3)}
        if self.intervals is not None:
            ends = {name: self.intervals[name] for name in sizes}
            return {name: 0.5 * (end[1] - end[0]) for name, end in ends.items()}
        if self.std is not None:
            return {name: NORMAL_95 * self.std[name] for name in sizes}
        return {name: np.full(shape, np.inf) for name, shape in sizes.items()}

    def __repr__(self) -> str:
        return self.summary("Estimate")

    def summary(self, title: str) -> str:
        """The estimate in some ten lines and fewer than 1500 characters."""
        extent = "" if self.duration is None else f", {self.duration:.4g} s"
        return "\n".join(
            (
                f"{title} by {self.method}, verdict: {self.verdict}",
                *body_lines(self.parameters, self.intervals, self.undetermined),
                f"  from           {samples_told(self.samples)}{extent}",
                *warning_lines(self._warnings_and_mass),
            )
        )

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.parameters.mass

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass (3,) [m] in the sensor frame."""
        return self.parameters.center_of_mass

    @property
    def inertia(self) -> Array:
        """Inertia tensor (3, 3) [kg m²] about the centre of mass, in sensor axes."""
        return self.parameters.inertia_at_com

    def interval(self, name: str) -> Array:
        """Lower and upper ends of the 95 % interval of a quantity.

        Parameters
        ----------
        name : str
            ``"mass"``, ``"center_of_mass"``, ``"inertia"`` (about the COM), or another
            key of `intervals`.

        Returns
        -------
        Array
            (2,), (2, 3) or (2, 3, 3); infinite where the quantity is open.

        Raises
        ------
        InputError
            For another name, and where the method has no intervals.
        """
        known = self.intervals
        if known is None:
            fix = "use another method, such as Bayes"
            raise InputError(
                f"this estimate by {self.method} has no intervals", fix=fix
            )
        key = "inertia_at_com" if name == "inertia" else name
        if key not in known:
            names = ("inertia", *known)
            what = f"there is no interval of '{name}'{nearest(str(name), names)}"
            raise InputError(what, fix=f"use {', '.join(names)}")
        return known[key]

    @property
    def verdict(self) -> Verdict:
        """Whether to trust it, and why not: see `hefting.core.messages`."""
        return verdict_of(self._warnings_and_mass)

    @property
    def _warnings_and_mass(self) -> tuple[str, ...]:
        """The warnings, with one of an undetermined mass, not given by estimators."""
        said = undetermined_mass(self.mass, self.intervals)
        if said is None or not verdict_of(self.warnings).usable:
            return self.warnings
        return (said, *self.warnings)

    @property
    def sensed_vector(self) -> Array:
        """(10,) parameters as the sensor measures them, with the error of its gain that
        a scale's reading showed."""
        gain = float(self.provenance.get("sensor_gain", 0.0))
        return (1.0 + gain) * self.parameters.vector

    @property
    def common_bias(self) -> Array | None:
        """(6,) the bias; None also for several recordings with biases of their own."""
        return self.bias if self.bias is not None and self.bias.ndim == 1 else None

    @property
    def consistency(self) -> Consistency:
        """Margins of every condition of physical consistency, the COM's place in the
        shape included."""
        return self.parameters.consistency(self.hull_margin)

    @property
    def physically_consistent(self) -> bool:
        """Whether a body with these parameters, inside a known shape, can exist."""
        return self.consistency.is_consistent

    @property
    def std(self) -> dict[str, Array] | None:
        """Standard deviations of mass [kg] (), COM [m] (3,) and inertia at the COM [kg
        m²] (3, 3), to first order."""
        if self.covariance is None:
            return None
        # a mass of zero leaves the COM open
        with np.errstate(divide="ignore", invalid="ignore"):
            J = com_jacobian(self.parameters)
            variance = mapped(self.covariance, J).diagonal()
        std = np.sqrt(np.where(variance >= 0, variance, np.nan))
        return {
            "mass": std[0],
            "center_of_mass": std[1:4],
            "inertia_at_com": vector_to_tensor(std[4:]),
        }

    def to_dict(self) -> dict[str, Any]:
        """The estimate as JSON-ready values; keys as of ``hefting identify --json``."""
        p, certificate = self.parameters, self.certificate
        notes = (
            note
            for note in self.provenance.get("notes", ())
            if isinstance(note, Message)
        )
        return json_ready(
            {
                "schema": SCHEMA,
                "version": __version__,
                "method": self.method,
                "frame": self.frame,
                "verdict": self.verdict.level,
                "reasons": list(self.verdict.reasons),
                "mass": p.mass,
                "center_of_mass": p.center_of_mass,
                "inertia_at_com": p.inertia_at_com,
                "inertia_at_origin": p.inertia_at_origin,
                "vector": p.vector,
                "covariance": self.covariance,
                "intervals": self.intervals,
                "accuracy": None if self.accuracy is None else asdict(self.accuracy),
                "sufficient": self.sufficient,
                "undetermined": self.undetermined.to_dict(),
                "std": self.std
                or {"mass": None, "center_of_mass": None, "inertia_at_com": None},
                "physically_consistent": self.physically_consistent,
                "consistency": {
                    "margins": self.consistency.margins,
                    "violated": self.consistency.violated,
                },
                "certificate": None
                if certificate is None
                else asdict(certificate) | {"gap": certificate.gap},
                "bias": self.bias,
                "residual": self.residual,
                "point_masses": self.point_masses,
                "samples": self.samples,
                "duration": self.duration,
                "warnings": list(self.warnings),
                "messages": [
                    coded(message).to_dict() for message in (*self.warnings, *notes)
                ],
                "provenance": self.provenance,
            }
        )

    def save(self, path: str | Path) -> None:
        """Write as JSON that `load` reads back; the file appears whole or not at all.

        Raises `InputError` for the name of another kind of file."""
        if Path(path).suffix.lower() not in ("", ".json"):
            what, fix = "an estimate is saved as JSON", "name it .json, or use `export`"
            raise InputError(what, path, fix)
        write_atomically(path, json.dumps(self.to_dict(), indent=1) + "\n")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read an estimate written by `save` or ``hefting identify --json``; of several
        methods, that of the recommended one.

        Raises `InputError` when the file cannot be read, is no estimate, is not in sensor
        axes, or holds numbers that do not fit.
        """
        fix = "write an estimate with hefting identify or calibrate, --output FILE.json"
        content: Any = read_json(path, fix)
        data = cast(dict[str, Any], content) if isinstance(content, dict) else {}
        data = recommended_of(data)
        if "mechanics" in data:
            what, fix = "is of an arm, by its torques", "give it as `arm`"
            raise InputError(what, path, fix)
        if data.get("schema") != SCHEMA:
            raise InputError(f"is not an estimate of schema {SCHEMA}", path, fix)
        if (frame := data.get("frame")) not in (None, "sensor"):
            fix = "give the one in sensor axes from which it was made"
            raise InputError(f"is in {str(frame)[:40]} axes", path, fix)
        try:
            found = cls(**fields_of(data))
            graver = graver_reasons(data, found.verdict)
            others = (text for text in found.warnings if text not in graver)
            return replace(found, warnings=(*others, *graver)) if graver else found
        except (
            KeyError,
            TypeError,
            ValueError,
            AttributeError,
            OverflowError,
        ) as error:
            what = (
                f"is not a whole estimate ({type(error).__name__}: {str(error)[:120]})"
            )
            raise InputError(what, where=path) from error


class Answered(Protocol):
    """A result that holds an estimate, such as that of `hefting.identify`."""

    @property
    def estimate(self) -> Estimate:
        """The estimate."""
        ...


def estimate_of(given: Estimate | Answered) -> Estimate:
    """The estimate itself, or that of a result; `InputError` for anything else."""
    estimate = getattr(given, "estimate", given)
    if not isinstance(estimate, Estimate):
        fix = "give what hefting.identify returns, or hefting.Estimate.load(path)"
        raise InputError(f"{type(given).__name__} is no estimate", fix=fix)
    return estimate


def estimate_given(
    given: Estimate | Answered | str | Path, *, any_frame: bool = False
) -> Estimate:
    """As `estimate_of`, or from the file at a path; `InputError` for one in another frame
    than the sensor's, unless any will do."""
    if isinstance(given, str | Path):
        return Estimate.load(given)
    estimate = estimate_of(given)
    if estimate.frame != "sensor" and not any_frame:
        what = f"the estimate is in the frame {estimate.frame}, not the sensor's"
        raise InputError(what, fix="give that from which it was made")
    return estimate


def doubts_of(estimate: Estimate) -> Iterator[Message]:
    """An estimate's gravest reason, as a warning for what is made from it."""
    if estimate.verdict.reasons:
        first = estimate.verdict.reasons[0]
        say = warning if estimate.verdict.usable else error
        yield say("estimate-doubtful", f"of the estimate: {first}")
