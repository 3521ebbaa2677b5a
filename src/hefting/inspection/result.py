"""Inspection: the findings about one recording."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from hefting import __version__
from hefting.core.estimate_json import json_ready
from hefting.core.messages import Message, Verdict, error, verdict_of
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.ingest import Conditioned, WrenchSign
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.identifiability import Identifiability
from hefting.ingest.ingested import Ingested
from hefting.inspection.facts import Movement, StreamFacts, WrenchFacts

SCHEMA = "hefting.inspection/1"
"""Name and version of the JSON form, under the key ``schema``."""


@dataclass(frozen=True)
class GravityHint:
    """Direction of gravity by the data; only a hint, as an imperfect sensor changes it
    by some degrees."""

    angle: float
    """rad from the one assumed"""
    std: float
    """rad, about each axis"""
    direction: tuple[float, float, float]
    """unit vector in world axes"""
    adopted: bool
    """whether it was asked for and used for all other findings; the angle is then that
    from straight down"""

    @property
    def serious(self) -> bool:
        """Whether the assumed direction is in doubt."""
        return not self.adopted and self.angle > max(np.radians(5.0), 5.0 * self.std)


@dataclass(frozen=True, eq=False, repr=False)
class Inspection:
    """Findings about a recording: its content, and the findings from it, or None with the
    reason in `missing`.

    The keys of `to_dict` are those of ``hefting inspect --json``, in docs/json.md.

    Examples
    --------
    >>> hefting.inspect("demo/log.csv").advice
    ('ready: hefting identify demo/log.csv --shape MESH',)
    """

    log: str
    duration: float
    """s; poses, when static"""
    static: bool
    streams: dict[str, StreamFacts]
    notes: tuple[str, ...]
    """of reader and smoother"""
    gravity: Array
    """(3,) assumed, in world axes [m/s²]"""
    quick_mass: float | None
    """mean |f| / |g| [kg], which ignores bias and motion; None without a wrench"""
    movement: Movement | None
    conditioned: Conditioned | None
    """clocks, drift, outliers"""
    gravity_hint: GravityHint | None
    sign: WrenchSign | None
    facts: WrenchFacts | None
    """bias, noise, SNR, and the object by least squares"""
    identifiability: Identifiability | None
    """parameters that the motion determines for an object of `TYPICAL_SIZE`, and reasons
    for the others"""
    missing: dict[str, str]
    """reasons for missing ``motion``, ``conditioning`` or ``object``"""
    advice: tuple[str, ...]
    """next steps, in sentences"""
    warnings: tuple[str, ...]
    changes: Changes | None = None
    """changes of the object; all findings are of the stretch chosen"""
    ingested: Ingested | None = field(default=None, repr=False)
    """the recording as an identification would take it; None if it cannot"""

    def __repr__(self) -> str:
        """The verdict, its reasons, findings and advice, a line each."""
        lines = (*self.verdict.reasons, *self.findings, *self.advice)
        return "\n- ".join((f"{self.log}: {self.verdict}", *lines))

    @property
    def verdict(self) -> Verdict:
        """Whether to trust an identification from it, and why not."""
        if self.facts is None:
            reasons = "; ".join(dict.fromkeys(self.missing.values()))
            return Verdict("do not use", (error("nothing-found", reasons),))
        return verdict_of(self.warnings)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters the motion leaves open for an object of `TYPICAL_SIZE`."""
        return () if self.identifiability is None else tuple(self.identifiability.open)

    @property
    def findings(self) -> tuple[str, ...]:
        """Findings of conditioning, which it corrects."""
        return () if self.conditioned is None else self.conditioned.findings

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values in SI units, by the keys in docs/json.md."""
        names = "log duration static notes gravity quick_mass missing advice warnings"
        out: dict[str, Any] = {"schema": SCHEMA, "version": __version__}
        out |= {name: getattr(self, name) for name in names.split()}
        out["verdict"] = self.verdict.level
        out["reasons"] = list(self.verdict.reasons)
        out["streams"] = {name: asdict(facts) for name, facts in self.streams.items()}
        own = self.identifiability
        out["undetermined"] = own and self.undetermined
        out["identifiability"] = own and own.to_dict()
        out["wrench"] = self.sign and self.sign.name
        out["stretches"] = [] if self.changes is None else self.changes.to_dicts()
        out["wrench_t"] = self.sign and self.sign.t
        lines = (*self.notes, *self.findings, *self.warnings)
        out["messages"] = [x.to_dict() for x in lines if isinstance(x, Message)]
        return json_ready(out | self._movement() | self._conditioned() | self._facts())

    def _movement(self) -> dict[str, Any]:
        """Speeds, turn and dynamism of the motion, and how the speed limit is kept; None
        for each without a motion."""
        m = self.movement
        names = ("linear_speed", "angular_speed", "turn", "dynamism")
        out = {
            "motion": m and m.source,
            **{name: m and getattr(m, name) for name in names},
            "speed_limit": None,
        }
        if m is not None and m.above_limit is not None:
            out["speed_limit"] = {
                "limit": SPEED_LIMIT,
                "kept": m.keeps_limit,
                "above": m.above_limit,
            }
        return out

    def _conditioned(self) -> dict[str, Any]:
        """Clock offset, drift, outliers and autocorrelation, each None if nothing was
        conditioned; the findings; and the direction of gravity by the data."""
        c, hint = self.conditioned, self.gravity_hint
        out: dict[str, Any] = {
            "gravity_preferred": None if hint is None else asdict(hint),
            "findings": self.findings,
        }
        if c is None:
            return out | dict.fromkeys(
                ("clock_offset", "drift", "outliers", "autocorrelation")
            )
        offset = None
        if c.offset_std is not None:
            offset = {"offset": c.offset, "std": c.offset_std}
        return out | {
            "clock_offset": offset,
            "drift": {key: getattr(c.bias, key) for key in ("kind", "knots", "range")},
            "outliers": {**c.reasons, "share": float(np.mean(c.rejected))},
            "autocorrelation": c.autocorrelation,
        }

    def _facts(self) -> dict[str, Any]:
        """The object by least squares, bias, noise and signal-to-noise ratio of each
        channel; None for each where they are unknown."""
        f = self.facts
        names = "mass mass_std quick_mass_less_bias bias bias_t noise gravity_dominance"
        out = {name: f and getattr(f, name) for name in names.split()}
        channels = f and {
            name: {key: getattr(c, key) for key in ("unit", "signal", "noise", "snr")}
            for name, c in f.channels.items()
        }
        return out | {"signal_to_noise": channels}
