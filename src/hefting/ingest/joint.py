"""Several recordings of one object, ingested as one, each with its own clock, sign and
bias.

The object, its grasp, the sensor and its frame are assumed to be the same in all. Each
recording is ingested by itself (`hefting.ingest.ingest`), except that whether there is
a bias, and the wrench's sign, are taken from the recordings that determine them.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.messages import Message
from hefting.core.recording import Recording
from hefting.core.spatial import Array, immutable
from hefting.estimators.joint_state import State, as_one, join_all
from hefting.ingest.condensed import Excitation
from hefting.ingest.free_fit import free_fit
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.ingest.systematic import common_errors

Log = Recording | str | Path

MOST_NAMED = 3
"""Number of recordings that an error names one by one."""
UNEQUAL_NOISE = 1.5
"""Ratio of the noise variances of recordings above which they are weighted by them."""
PAUSE = 1.0
"""[s] Time between the last sample of a recording and the first of the next, where they
are concatenated."""
LARGEST_WEIGHT = 100.0
"""Largest weight of a recording: the residuals of noise-free ones are rounding errors."""


@immutable
class JointIngested(Ingested):
    """Several recordings as estimators take them. Attributes of `Ingested` hold for all
    recordings together; times are on the clock of each."""

    parts: tuple[Ingested, ...] = ()
    names: tuple[str, ...] = ()
    """of the recordings, as in messages"""

    @property
    def recordings(self) -> tuple[Ingested, ...]:
        """Each recording."""
        return self.parts

    @property
    def notes(self) -> tuple[Message, ...]:
        """Notes of all, each with the names of its recordings."""
        return _merged_messages([part.notes for part in self.parts], self.names)

    @property
    def weighted_by_count(self) -> Measurements:
        """Measurements of all recordings, concatenated, see `Ingested`."""
        return _concatenated([part.weighted_by_count for part in self.parts])

    @property
    def has_samples(self) -> bool:
        """Whether every recording has its measurements."""
        return all(part.has_samples for part in self.parts)

    @property
    def rows(self) -> int:
        """Number of measurements of all."""
        return sum(part.rows for part in self.parts)

    @property
    def samples(self) -> float:
        """Number of samples of all."""
        return sum(part.samples for part in self.parts)

    @property
    def motion_noise(self) -> MotionNoise | None:
        """Root mean square over recordings; None if one is unknown."""
        return _mean_noise([part.motion_noise for part in self.parts])

    @property
    def wrench_rms(self) -> Array:
        """(2,) root mean square of one axis of force [N] and torque [N m], over all."""
        squares = [part.condensed.wrench_square for part in self.parts]
        return np.sqrt(np.sum(squares, axis=0) / (3.0 * max(self.rows, 1)))

    @property
    def excitation(self) -> Excitation:
        """Excitation by the motions of all recordings."""
        each = [part.excitation for part in self.parts]
        return Excitation.of_all(each, as_one(self.state).full)

    @cached_property
    def state(self) -> State:
        """The full model's moments of each recording, with a time record."""
        return join_all([part.state for part in self.parts])

    def residual(self, vector: Array, bias: Array | None) -> Array:
        """As `Ingested.residual`; `bias` is (n, 6), one for each recording."""
        own = [None] * len(self.parts) if bias is None else bias
        each = [p.residual(vector, b) for p, b in zip(self.parts, own, strict=True)]
        counts = np.array([part.samples for part in self.parts])
        return np.sqrt(counts @ np.square(each) / counts.sum())

    @property
    def provenance(self) -> dict[str, Any]:
        """What was read and assumed for all; under ``"recordings"`` for each."""
        own = [part.provenance for part in self.parts]
        outliers = [each["outliers"] for each in own]
        return (
            own[0]
            | {
                "log": self.log,
                "wrench": ", ".join(dict.fromkeys(each["wrench"] for each in own)),
                "motion": ", ".join(dict.fromkeys(each["motion"] for each in own)),
                "noise": {"force": self.noise.force, "torque": self.noise.torque},
                "clock_offset": None,
                "outliers": {k: sum(each[k] for each in outliers) for k in outliers[0]},
                "stretches": [],
                "notes": list(self.notes),
            }
            | {"recordings": self._each()}
        )

    def _each(self) -> list[dict[str, Any]]:
        kept = ("log", "gravity", "wrench", "noise", "motion", "clock_offset")
        return [
            {key: part.provenance[key] for key in (*kept, "outliers", "stretches")}
            | {
                "name": name,
                "samples": round(part.samples),
                "rows": part.rows,
                "duration": None if part.static else part.condensed.span,
            }
            for name, part in zip(self.names, self.parts, strict=True)
        ]


def joint(parts: Sequence[Ingested], names: Sequence[str]) -> Ingested:
    """Ingested recordings as one, each weighted by its noise; a single one as it is. It
    has samples only if all of them do."""
    if len(parts) == 1:
        return parts[0]
    return with_samples(together(_weighed(parts), names))


def with_samples(found: Ingested) -> Ingested:
    """Joint recordings with the samples of all, if all still have them."""
    if not (isinstance(found, JointIngested) and found.has_samples):
        return found
    return replace(
        found,
        measurements=_concatenated([part.measurements for part in found.parts]),
        counts=np.concatenate([part.counts for part in found.parts]),
    )


def together(parts: Sequence[Ingested], names: Sequence[str]) -> Ingested:
    """Ingested recordings as one, with their present weights and without samples; a single
    one as it is."""
    if len(parts) == 1:
        return parts[0]
    state = join_all([part.state for part in parts])
    counts = np.array([part.samples for part in parts])
    inflation = counts @ [part.fit.inflation for part in parts] / counts.sum()
    free_bias = parts[0].bias == "estimate"
    fit = free_fit(state, free_bias, inflation)
    tool = parts[0].tool
    if tool is not None:
        fit = fit.less(np.zeros(10), tool.covariance)
    systematic, gravity_error = common_errors(parts, fit.noise, tool)
    doubts = [part.doubt for part in parts if part.doubt is not None]
    squares = np.array([(part.noise.force, part.noise.torque) for part in parts]) ** 2
    level = np.sqrt(counts @ squares / counts.sum())
    first = max(parts, key=lambda part: float(part.conditioned.tilt_std or 0.0))
    return JointIngested(
        log=_all_named(names),
        static=all(part.static for part in parts),
        measurements=parts[0].measurements[:0],
        counts=parts[0].counts[:0],
        motion=None,
        source=max(parts, key=lambda part: part.rows).source,
        sign=min((part.sign for part in parts), key=lambda sign: abs(sign.t)),
        sign_found=parts[0].sign_found,
        bias=parts[0].bias,
        bias_found=parts[0].bias_found,
        given_bias=parts[0].given_bias,
        conditioned=first.conditioned,
        tool=tool,
        fit=fit,
        beside_bias=fit,
        alone=fit,
        noise=Noise(float(level[0]), float(level[1])),
        within=np.tensordot(counts, [part.within for part in parts], 1) / counts.sum(),
        systematic=systematic,
        clock_error=None,
        doubt=min(doubts, key=lambda doubt: not doubt.is_fatal, default=None),
        gravity_std=parts[0].gravity_std,
        gravity_error=gravity_error,
        warnings=_merged_messages([part.warnings for part in parts], names),
        read_notes=(),
        parts=tuple(parts),
        names=tuple(names),
    )


def _weighed(parts: Sequence[Ingested]) -> list[Ingested]:
    """The recordings weighted by the inverse of their noise variance, relative to the
    pooled one, if these are unequal; the mean weight of a row is one."""
    rows = np.array([float(part.rows) for part in parts])
    own = np.array([(p.fit.noise.force, p.fit.noise.torque) for p in parts]) ** 2
    pooled = np.maximum(rows @ own / rows.sum(), 1e-300)
    variance = np.maximum((own / pooled).mean(axis=1), 1.0 / LARGEST_WEIGHT)
    if variance.max() <= UNEQUAL_NOISE * variance.min():
        return list(parts)
    weights = 1.0 / variance
    weights *= rows.sum() / (rows @ weights)
    return [
        part.weighed(float(weight)) for part, weight in zip(parts, weights, strict=True)
    ]


def _concatenated(each: Sequence[Measurements]) -> Measurements:
    """The samples of all recordings in turn, `PAUSE` apart."""

    def rows(name: str) -> Array:
        return np.concatenate([getattr(z, name) for z in each])

    weights = [np.ones(len(z)) if z.weights is None else z.weights for z in each]
    times: list[Array] = []
    for z in each:
        start = times[-1][-1] + PAUSE if times else 0.0
        times.append(z.time - z.time[0] + start)
    return Measurements(
        np.concatenate(times),
        rows("gravity"),
        rows("linear_acceleration"),
        rows("angular_velocity"),
        rows("angular_acceleration"),
        rows("force"),
        rows("torque"),
        weights=np.concatenate(weights),
        motion_noise=_mean_noise([z.motion_noise for z in each]),
    )


def _mean_noise(each: Sequence[MotionNoise | None]) -> MotionNoise | None:
    """Root mean square over recordings; None if one is unknown."""
    noises = [noise for noise in each if noise is not None]
    if len(noises) < len(each):
        return None
    linear, angular = (
        float(np.sqrt(np.mean([getattr(noise, name) ** 2 for noise in noises])))
        for name in ("linear", "angular")
    )
    return MotionNoise(linear, angular, float(np.mean([n.memory for n in noises])))


def _all_named(names: Sequence[str]) -> str:
    if len(names) <= MOST_NAMED:
        return ", ".join(names)
    return f"{names[0]} and {len(names) - 1} more"


def _merged_messages(
    each: Sequence[Sequence[Message]], names: Sequence[str]
) -> tuple[Message, ...]:
    """Distinct messages of the recordings, each with the names of its recordings unless
    all have it."""
    about: dict[tuple[str, str], list[str]] = {}
    first: dict[tuple[str, str], Message] = {}
    for messages, name in zip(each, names, strict=True):
        for message in messages:
            key = (message.code, str(message))
            first.setdefault(key, message)
            about.setdefault(key, [])
            if name not in about[key]:
                about[key].append(name)
    return tuple(
        m if len(about[key]) == len(names) else m.about(about[key])
        for key, m in first.items()
    )


def ingest_all(recordings: Log | Sequence[Log], **reading: Any) -> Ingested:
    """One recording, or several of the same object, as estimators take them.

    Parameters
    ----------
    recordings : a recording, the path of a log or a table in memory, or a list or
        tuple of these.
    reading : as for `hefting.ingest.ingest.ingest`, of all alike; a ``bias`` may also
        be (n, 6), one for each of n recordings.

    Raises `InputError` as that does, for an empty list, and for a path given twice.
    """
    if not isinstance(recordings, list | tuple):
        return ingest(recordings, **reading)  # type: ignore[arg-type]
    logs = list(recordings)
    _check(logs)
    biases = _biases(reading.pop("bias", "auto"), len(logs))
    own = [reading | {"bias": bias} for bias in biases]
    parts = [ingest(log, **how) for log, how in zip(logs, own, strict=True)]
    for i, again in enumerate(what_others_tell(parts)):
        if again:
            parts[i] = ingest(logs[i], **(own[i] | again))
    return joint(parts, names_of([part.log for part in parts]))


def names_of(logs: Sequence[str]) -> list[str]:
    """Names of the logs: file names if these differ, else whole paths or sources; with
    numbers if those are the same too."""
    names = [Path(log).name or log for log in logs]
    names = [
        n if names.count(n) == 1 else log for n, log in zip(names, logs, strict=True)
    ]
    return [
        n if names.count(n) == 1 else f"{n} ({i})" for i, n in enumerate(names, start=1)
    ]


def what_others_tell(parts: Sequence[Ingested]) -> list[dict[str, Any]]:
    """Arguments of `ingest` for each recording that follow from the others: a bias
    where another has one, and the sign where its own is uncertain."""
    again: list[dict[str, Any]] = [{} for _ in parts]
    biased = any(part.bias == "estimate" for part in parts)
    sure = [part.sign.name for part in parts if part.sign.certain]
    for part, how in zip(parts, again, strict=True):
        if biased and part.bias == "none" and part.given_bias is None:
            how["bias"] = "estimate"
        if part.sign_found and not part.sign.certain and len(set(sure)) == 1:
            how["wrench"] = sure[0]
    return again


def _check(logs: Sequence[Log]) -> None:
    if not logs:
        raise InputError("no recording is given", fix="give at least one")
    paths = [os.path.realpath(log) for log in logs if isinstance(log, str | Path)]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError("is given twice", path, "give each recording once")


def _biases(bias: Any, n: int) -> list[Any]:
    if isinstance(bias, str) or np.ndim(bias) != 2:
        return [bias] * n
    if len(bias) != n:
        what = f"there are {len(bias)} biases for {n} recordings"
        raise InputError(what, fix="give `bias` once for all, or one for each")
    return list(bias)
