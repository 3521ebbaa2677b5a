"""Injection: a body of known parameters added to a real recording.

The wrench is linear in the parameters. The wrench of a random body along the motion of
a real recording, added to the measured one, is what the sensor would have measured with
that body as well; its noise, drift and errors are the real ones, and the body's
parameters are known exactly. The object that was really held is taken out as a tool, as
found in another recording or in another part of the same one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.bodies import FILLINGS, Body, random_body
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.identification.identify import calibrate
from hefting.ingest.ingest import ingest
from hefting.logs import read_log
from hefting.motion import measure

LIGHTEST, HEAVIEST = 0.1, 2.0
"""[kg] Range of the added masses, which are evenly spread over their logarithm."""
WINDOWS = (4.0, 6.0, 9.0)
"""[s] Lengths of the parts of a recording that are identified, besides the whole."""


@dataclass(frozen=True)
class Source:
    """A recording that bodies are added to."""

    set: str
    """data set"""
    log: str
    """path in the folder of the data"""
    gravity: tuple[float, float, float]
    """world axes [m/s²]"""
    tool: str | None
    """recording of the same object alone; None: the other half of this one"""


SOURCES = (
    Source(
        "panda",
        "panda-optoforce/run1.csv",
        (0.0, 0.0, -9.81),
        "panda-optoforce/run3.csv",
    ),
    Source(
        "panda",
        "panda-optoforce/run3.csv",
        (0.0, 0.0, -9.81),
        "panda-optoforce/run1.csv",
    ),
    Source(
        "kuka",
        "kuka-ati/baseline.csv",
        (0.0, 0.0, -9.82085),
        "kuka-ati/static_poses.csv",
    ),
    Source(
        "kuka",
        "kuka-ati/vibrations.csv",
        (0.0, 0.0, -9.82085),
        "kuka-ati/static_poses.csv",
    ),
    Source("axia", "axia80/dwells.csv", (0.0, 0.0, -9.81), None),
)


@dataclass(frozen=True, eq=False)
class Host:
    """A part of a recording, ready to take a body."""

    set: str
    recording: Recording
    gravity: tuple[float, float, float]
    tool: Estimate
    """the object really held"""
    motion: Array
    """(K, 6, 10) regressor at the samples of the wrench, in the sign of the record"""

    def with_body(self, body: InertialParameters) -> Recording:
        """The recording with the wrench of a body added."""
        wrench = self.recording["wrench"]
        values = wrench.values + self.motion @ body.vector
        return replace(
            self.recording,
            streams={
                **self.recording.streams,
                "wrench": Stream(wrench.time, values, wrench.rows),
            },
        )


@dataclass(frozen=True, eq=False)
class Case:
    """A body in a part of a recording."""

    host: Host
    window: float | None
    """length [s]; None: all of it"""
    body: Body
    recording: Recording

    @property
    def name(self) -> str:
        """Length, as the table has it."""
        return "whole" if self.window is None else f"{self.window:g} s"


def hosts(data: Path, sources: Sequence[Source] = SOURCES) -> list[Host]:
    """Recordings with their tools; of one without a recording of its tool, halves that
    serve each other."""
    found: list[Host] = []
    for source in sources:
        recording = read_log(data / source.log)
        if source.tool is None:
            half = 0.5 * recording.duration
            parts = (recording.slice(0.0, half), recording.slice(half))
            others = parts[::-1]
        else:
            parts, others = (recording,), (read_log(data / source.tool),)
        for part, other in zip(parts, others, strict=True):
            tool = calibrate(other, gravity=source.gravity)
            found.append(_host(source, part, tool))
    return found


def _host(source: Source, recording: Recording, tool: Estimate) -> Host:
    """With the motion at the instants that the wrench's samples belong to; samples
    before the first or after the last pose are left out."""
    found = ingest(recording, gravity=source.gravity)
    wrench = recording["wrench"]
    synchronous = Stream(
        wrench.time - found.conditioned.offset, wrench.values, wrench.rows
    )
    measured = measure(
        replace(recording, streams={**recording.streams, "wrench": synchronous}),
        source.gravity,
    )
    assert measured.rows is not None
    sign = 1.0 if found.sign.on_object else -1.0
    A = np.stack(
        [predict_wrench(measured.measurements, unit) for unit in np.eye(10)], axis=2
    )
    kept = wrench[np.isin(wrench.rows, measured.rows)]
    recording = replace(recording, streams={**recording.streams, "wrench": kept})
    return Host(source.set, recording, source.gravity, tool, sign * A)


def cases(every: list[Host], bodies: int, seed: int) -> Iterator[Case]:
    """Each of so many random bodies in a random recording of each set, as a whole and
    in a random part of each length that is shorter."""
    sets = list(dict.fromkeys(host.set for host in every))
    kinds = list(FILLINGS)
    for index in range(bodies):
        rng = np.random.default_rng([seed, index])
        body = _with_mass(random_body(kinds[index % len(kinds)], 7000 + index), rng)
        for name in sets:
            own = [host for host in every if host.set == name]
            host = own[rng.integers(len(own))]
            recording = host.with_body(body.parameters)
            for window in (None, *WINDOWS):
                if window is None:
                    yield Case(host, None, body, recording)
                elif window < recording.duration:
                    start = float(rng.uniform(0.0, recording.duration - window))
                    yield Case(host, window, body, recording.slice(start, window))


def _with_mass(body: Body, rng: np.random.Generator) -> Body:
    mass = float(np.exp(rng.uniform(np.log(LIGHTEST), np.log(HEAVIEST))))
    scaled = InertialParameters(body.parameters.vector * mass / body.parameters.mass)
    return replace(body, parameters=scaled)
