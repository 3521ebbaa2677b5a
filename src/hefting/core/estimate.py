"""Estimate: what an estimator found, how sure it is, and how it can be checked."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self, get_args

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.files import read_json, write_atomically
from hefting.core.inertia import Consistency, InertialParameters
from hefting.core.messages import Message, Severity
from hefting.core.spatial import Array, frozen, skew, tensor_to_vector, vector_to_tensor

SCHEMA = "hefting.core.estimate/1"
INTERVALS = {"mass": (2,), "center_of_mass": (2, 3), "inertia_at_origin": (2, 3, 3), "inertia_at_com": (2, 3, 3)}
"""Shapes of the lower and upper ends that an estimate may have."""


@dataclass(frozen=True)
class Certificate:
    """Evidence, independent of the solver, of how close an estimate is to the optimum of its own problem.

    For every admissible answer the objective is at least ``bound``; so ``gap`` = objective - bound limits
    what a perfect solver could still gain.
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


@dataclass(frozen=True, eq=False)
class Estimate:
    """Inertial parameters found from measurements, in sensor axes about the sensor origin."""

    method: str
    """Name of the estimator."""
    parameters: InertialParameters
    """The ten parameters."""
    samples: int
    """Samples used."""
    duration: float | None = None
    """Time spanned by the samples [s]; None for static poses without time."""
    covariance: Array | None = None
    """(10, 10) covariance of ``parameters.vector``; None where the method has none."""
    intervals: dict[str, Array] | None = None
    """Lower and upper ends between which each quantity lies with 95 % probability: ``mass`` (2,) [kg],
    ``center_of_mass`` (2, 3) [m], ``inertia_at_origin`` and ``inertia_at_com`` (2, 3, 3) [kg m²]; None where the
    method has none."""
    accuracy: Accuracy | None = None
    """What the errors do not exceed, each with 95 % probability; None unless an accuracy was asked for."""
    sufficient: bool | None = None
    """Whether that is what was asked for."""
    certificate: Certificate | None = None
    """How close to the method's optimum."""
    bias: Array | None = None
    """(6,) wrench bias [N, N m] found with it, with the sign of `hefting.core.spatial` (that of an on-sensor log is the
    opposite); None when it was not estimated."""
    point_masses: Array | None = None
    """(n,) masses [kg] of the shape's points, for methods that find them."""
    residual: Array | None = None
    """(2,) root-mean-square force [N] and torque [N m] residual of the full model."""
    hull_margin: float | None = None
    """Depth of the COM in the shape's convex hull over its largest side; None where no shape is known."""
    warnings: tuple[str, ...] = ()
    """What the user should know before trusting it."""
    provenance: dict[str, Any] = field(default_factory=dict)
    """What was read and assumed: log, gravity, wrench sign, bias, motion, hyperparameters."""

    def __post_init__(self):
        for name in ("covariance", "bias", "point_masses", "residual"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def consistency(self) -> Consistency:
        """Margins of every condition of physical consistency, the COM's place in the shape included."""
        return self.parameters.consistency(self.hull_margin)

    @property
    def physically_consistent(self) -> bool:
        """Whether a body with these parameters, and this shape if it is known, can exist."""
        return self.consistency.is_consistent

    @property
    def std(self) -> dict[str, Array] | None:
        """Standard deviations of mass [kg] (), COM [m] (3,) and inertia at the COM [kg m²] (3, 3), to first order."""
        if self.covariance is None:
            return None
        J = com_jacobian(self.parameters)
        open_ = np.isinf(self.covariance.diagonal())
        variance = np.einsum("ij,jk,ik->i", J, np.where(np.isinf(self.covariance), 0.0, self.covariance), J)
        variance[(J[:, open_] != 0.0).any(axis=1)] = np.inf
        std = np.sqrt(np.where(variance >= 0, variance, np.nan))
        return {"mass": std[0], "center_of_mass": std[1:4], "inertia_at_com": vector_to_tensor(std[4:])}

    def to_dict(self) -> dict[str, Any]:
        """The estimate as JSON-ready values; keys as documented for ``hefting identify --json``."""
        p = self.parameters
        std = self.std
        certificate = None if self.certificate is None else asdict(self.certificate) | {"gap": self.certificate.gap}
        return json_ready(
            {
                "schema": SCHEMA,
                "version": _version(),
                "method": self.method,
                "frame": "sensor",
                "mass": p.mass,
                "center_of_mass": p.center_of_mass,
                "inertia_at_com": p.inertia_at_com,
                "inertia_at_origin": p.inertia_at_origin,
                "vector": p.vector,
                "covariance": self.covariance,
                "intervals": self.intervals,
                "accuracy": None if self.accuracy is None else asdict(self.accuracy),
                "sufficient": self.sufficient,
                "std": std if std else {"mass": None, "center_of_mass": None, "inertia_at_com": None},
                "physically_consistent": self.physically_consistent,
                "consistency": {"margins": self.consistency.margins, "violated": self.consistency.violated},
                "certificate": certificate,
                "bias": self.bias,
                "residual": self.residual,
                "point_masses": self.point_masses,
                "samples": self.samples,
                "duration": self.duration,
                "warnings": list(self.warnings),
                "messages": [coded(message).to_dict() for message in (*self.warnings, *self._notes)],
                "provenance": self.provenance,
            }
        )

    @property
    def _notes(self) -> tuple[Message, ...]:
        return tuple(note for note in self.provenance.get("notes", ()) if isinstance(note, Message))

    def save(self, path: str | Path) -> None:
        """Write as JSON that `load` reads back; the file appears whole or not at all."""
        write_atomically(path, json.dumps(self.to_dict(), indent=1) + "\n")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read an estimate written by `save` or ``hefting identify --json``.

        Raises `InputError` when the file cannot be read, is no estimate, or holds numbers that do not fit.
        """
        data = read_json(path)
        if not isinstance(data, dict) or data.get("schema") != SCHEMA:
            raise InputError(
                f"is not an estimate of schema {SCHEMA}",
                where=path,
                fix="write one with hefting identify --output FILE.json",
            )
        try:
            return cls._from_dict(data)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            raise InputError(f"is not a whole estimate ({type(error).__name__}: {error})", where=path) from error

    @classmethod
    def _from_dict(cls, data: dict[str, Any]) -> Self:
        def array(name: str, *shape: int | None) -> Array | None:
            if data.get(name) is None:
                return None
            values = np.array(data[name], dtype=float)
            if len(values.shape) != len(shape) or any(
                n not in (None, m) for n, m in zip(shape, values.shape, strict=True)
            ):
                raise ValueError(f"{name} has shape {values.shape}")
            if name == "covariance":  # JSON has no infinity: null on the diagonal is an undetermined variance
                undetermined = [i for i in range(10) if data[name][i][i] is None]
                values[undetermined, undetermined] = np.inf
            if np.isnan(values).any() or (name != "covariance" and np.isinf(values).any()):
                raise ValueError(f"{name} holds what is no number")
            return values

        vector = array("vector", 10)
        if vector is None or not np.isfinite(vector).all():
            raise ValueError("vector is not ten finite numbers")
        certificate = data.get("certificate")
        if certificate is not None:
            certificate = Certificate(
                float(certificate["objective"]),
                float(certificate["bound"]),
                int(certificate["iterations"]),
                bool(certificate["converged"]),
            )
        intervals = None
        if data.get("intervals") is not None:
            intervals = {str(name): frozen(ends) for name, ends in data["intervals"].items()}
            if {name: ends.shape for name, ends in intervals.items()} != INTERVALS:
                raise ValueError("the intervals are not those of mass, COM and inertia")
            if any(np.isnan(ends).any() or (ends[0] > ends[1]).any() for ends in intervals.values()):
                raise ValueError("an interval has no lower and upper end")
        accuracy = data.get("accuracy")
        if accuracy is not None:
            limits = [accuracy[name] for name in ("mass", "center_of_mass", "inertia")]
            if not all(limit is None or (type(limit) in (int, float) and 0.0 < limit < np.inf) for limit in limits):
                raise ValueError("an accuracy is not a positive number")
            accuracy = Accuracy(*(np.inf if limit is None else float(limit) for limit in limits))  # null: open
        sufficient = data.get("sufficient")
        if sufficient is not None and type(sufficient) is not bool:
            raise ValueError("sufficient is neither true nor false")
        hull = ((data.get("consistency") or {}).get("margins") or {}).get("hull")
        if hull is not None and not (type(hull) in (int, float) and np.isfinite(hull)):
            raise ValueError("the margin of the hull is not a finite number")
        known: dict[str, Message] = {message: message for message in map(_message, data.get("messages") or ())}
        provenance = dict(data.get("provenance", {}))
        if isinstance(provenance.get("notes"), list):
            provenance["notes"] = [known.get(text, text) for text in provenance["notes"]]
        return cls(
            method=str(data["method"]),
            parameters=InertialParameters(vector),
            samples=int(data["samples"]),
            duration=None if data.get("duration") is None else float(data["duration"]),
            covariance=array("covariance", 10, 10),
            intervals=intervals,
            accuracy=accuracy,
            sufficient=sufficient,
            certificate=certificate,
            bias=array("bias", 6),
            point_masses=array("point_masses", None),
            residual=array("residual", 2),
            hull_margin=None if hull is None else float(hull),
            warnings=tuple(known.get(str(text)) or coded(str(text)) for text in data.get("warnings", ())),
            provenance=provenance,
        )


def coded(text: str) -> Message:
    """A message as it is; a text that has no code gets ``unknown``."""
    return text if isinstance(text, Message) else Message("unknown", text)


def _message(data: Mapping[str, Any]) -> Message:
    """The message of its JSON; ValueError when it is none."""
    severity, argument = data["severity"], data.get("argument")
    texts = (data["code"], data["text"], *(() if argument is None else (argument,)))
    if severity not in get_args(Severity) or not all(isinstance(text, str) for text in texts):
        raise ValueError("a message is not made of texts")
    return Message(data["code"], data["text"], severity, argument)


def com_jacobian(parameters: InertialParameters) -> Array:
    """Derivative (10, 10) of mass, COM and inertia at the COM (xx, xy, xz, yy, yz, zz) by the parameter vector."""
    m, c = parameters.mass, parameters.center_of_mass
    J = np.zeros((10, 10))
    J[0, 0] = 1.0
    J[1:4, 0], J[1:4, 1:4] = -c / m, np.eye(3) / m
    J[4:, 4:] = np.eye(6)
    # inertia at COM = inertia at origin + m [c]x[c]x = J_o + [mc]x[mc]x / m
    J[4:, 0] = -tensor_to_vector(skew(c) @ skew(c))
    for i, unit in enumerate(np.eye(3)):
        J[4:, 1 + i] = tensor_to_vector(skew(unit) @ skew(c) + skew(c) @ skew(unit))
    return J


def json_ready(value: Any) -> Any:
    """Arrays to lists and non-finite numbers to None, through dicts and lists."""
    if isinstance(value, dict):
        return {str(k): json_ready(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_ready(v) for v in value]
    if isinstance(value, np.ndarray):
        return json_ready(value.tolist())
    if isinstance(value, np.generic):
        return json_ready(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _version() -> str:
    from hefting import __version__

    return __version__
