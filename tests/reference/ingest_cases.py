"""Cases of `hefting.ingest`: recordings with all kinds of faults, understood."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from benchmarks.mistaken import mistakes
from scipy.spatial.transform import Rotation

from hefting.core.estimate import Estimate
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.identification import calibrate
from hefting.ingest import condition
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import ingest_all
from hefting.ingest.plausibility import com_warnings
from hefting.ingest.sign_and_bias import tare
from hefting.ingest.systematic import offset_error
from hefting.ingest.unmeasured import without_faulty_poses
from hefting.shapes import Shape
from hefting.simulation import WRENCH_NOISE, Faults, Rates
from reference.recorded import (
    FAULTS,
    OBJECT,
    accelerated,
    changed,
    changing,
    fast,
    given,
    long,
    medium,
    only,
    other,
    recorded,
    short,
    stamped_late,
    static_poses,
    stopping,
    tilted,
    with_columns,
    with_imu,
)

BOX = Shape.from_box(-0.2, -0.1, -0.1, 0.1, -0.1, 0.1)
"""Where the object is not."""
LOW_NOISE = Faults(wrench_noise=WRENCH_NOISE["low"])
TOLD = (
    *("motion", "conditioned", "parts", "kept", "tool", "state"),
    *("beside_bias", "condensed"),
)
"""Fields that are told otherwise, or are the same as others."""


def understood(recording: Callable[[], Recording], **reading: Any) -> dict[str, Any]:
    """All that is found of a recording."""
    return of_ingested(ingest(recording(), **reading))


def of_ingested(found: Ingested) -> dict[str, Any]:
    """What was found, and what follows from it."""
    fit = found.fit
    excitation = found.excitation
    biases = {} if fit.bias is None or fit.bias.ndim > 1 else {"bias t": fit.bias_t}
    return {
        **{name: value for name, value in vars(found).items() if name not in TOLD},
        **biases,
        "conditioned": found.conditioned.without_samples(),
        "rejected": found.conditioned.rejected,
        "notes": found.notes,
        "moments": found.condensed.counted,
        "parts": [part.fit for part in found.recordings[1:]],
        "duration": found.duration,
        "samples": found.samples,
        "rms": found.wrench_rms,
        "residual": found.residual(fit.vector, fit.bias),
        "common errors": found.common_errors,
        "weighted by count": found.weighted_by_count.weights,
        "weighed": found.weighed(0.5).measurements.weights,
        "without samples": found.without_samples().residual(fit.vector, fit.bias),
        "open": fit.open_parameters(0.2),
        "mass t": fit.mass_t,
        "offset error": offset_error(found.conditioned),
        "autocorrelation": found.conditioned.autocorrelation,
        "outside": com_warnings(fit, BOX),
        "gravity direction": excitation.directions_about(mean=True),
        "angular": excitation.angular_acceleration,
        "felt": (excitation.force, excitation.gravity, excitation.angular_noise),
    }


def conditioned(recording: Callable[[], Recording], **asked: Any) -> Any:
    """What conditioning alone finds, and the recording as it corrects it."""
    found = condition(recording(), **asked)
    return {
        "found": found.without_samples(),
        "kept": found.kept,
        "left": found.rejected.nonzero()[0][:12].astype(float),
        "corrected": found.corrected(recording())["wrench"],
    }


def faulty(**faults: Any) -> Recording:
    """9 s with one more fault."""
    return recorded(medium, replace(FAULTS, **faults))


def late(seconds: float) -> Recording:
    """4 s with a wrench that is late."""
    return recorded(short, replace(FAULTS, wrench_delay=seconds))


def turned_over() -> Recording:
    """The other sign, without a bias."""
    return recorded(short, replace(FAULTS, on_sensor=True, bias=(0.0,) * 6))


def in_steps() -> Recording:
    """A wrench in steps of 0.5 N and 0.02 N m."""
    steps = np.repeat((0.5, 0.02), 3)
    return changed(recorded(), "wrench", lambda _, w: np.round(w / steps) * steps)


def orientations() -> Recording:
    """Orientations alone."""
    return only(recorded(stopping), "wrench", "orientation")


def faster() -> Recording:
    """A wrench at 500 Hz beside poses at 100 Hz, with spikes."""
    return recorded(
        fast, replace(FAULTS, spikes=0.01, wrench_delay=0.008), Rates(pose=100.0)
    )


def jumping() -> Recording:
    """Positions in another frame from 2 s on, and orientations from 3 s on."""
    found = changed(recorded(), "position", lambda t, p: p + 0.4 * (t > 2.0)[:, None])
    turn = Rotation.from_rotvec((0.0, 0.0, 0.6))

    def turned(t: Array, q: Array) -> Array:
        other = (turn * Rotation.from_quat(q)).as_quat()
        return np.where((t > 3.0)[:, None], other, q)

    return changed(found, "orientation", turned)


def few() -> Recording:
    """Ten samples."""
    return recorded().slice(1.0, 0.1)


def everything() -> Recording:
    """Many faults at once."""
    return faulty(
        drift=(0.5, -0.3, 0.4, 0.02, 0.01, -0.02),
        drift_kind="exponential",
        spikes=0.02,
        contacts=0.1,
        dropped=0.05,
        wrench_delay=0.04,
        on_sensor=True,
        noise_correlation=0.7,
        saturation=(16.0, 2.0),
    )


def tool() -> Estimate:
    """A tool, from a recording of its own that leaves some of it open."""
    found = calibrate(recorded(other, thing=OBJECT.moved(np.eye(4)), seed=12))
    assert found.covariance is not None
    C = np.array(found.covariance)
    C[9, :] = C[:, 9] = 0.0
    C[9, 9] = np.inf
    return replace(
        found,
        parameters=replace(found.parameters, vector=0.3 * OBJECT.vector),
        covariance=C,
    )


def beside_a_tool() -> Any:
    """A tool subtracted."""
    return understood(recorded, tool=tool())


def several(**reading: Any) -> Any:
    """Two recordings as one, with a noise and a bias of each."""
    loud = replace(FAULTS, wrench_noise=(0.3, 0.3, 0.3, 0.02, 0.02, 0.02))
    found = ingest_all([recorded(), recorded(other, loud)], **reading)
    return of_ingested(found)


def tared() -> Any:
    """The mean wrench of a part."""
    return tare(recorded(stopping), 0.5, 1.5)


def begun_later(recording: Recording, seconds: float = 12.34) -> Recording:
    """The same on a clock that does not begin at zero."""
    streams = {
        name: Stream(np.array(stream.time) + seconds, stream.values, stream.rows)
        for name, stream in recording.streams.items()
    }
    return replace(recording, streams=streams)


def mistaken(mistake: str) -> Recording:
    """A mistake of the benchmark, in a recording that begins at 12.34 s."""
    (found,) = (m for m in mistakes() if f"{m.name}, {m.strength}" == mistake)
    wrong = found.make(given(), np.random.default_rng(90)).recording
    return begun_later(wrong)


def drifting_briefly() -> Recording:
    """4 s in which the bias drifts by 2 N."""
    drift = np.array((0.5, -0.3, 0.4, 0.02, 0.01, -0.02))
    return begun_later(
        changed(recorded(), "wrench", lambda t, w: w + np.outer(t, drift))
    )


MISTAKEN = (
    "axes of position, swapped",
    "time, half as fast",
    "late clock, 300 ms",
    "pose clock fast, 1.0%",
    "base tilted, 15°",
    "position glitches, 10 m",
    "quantised, 2 N",
    "saturated, 60%",
    "play, 3%",
    "vibration, 12 Hz",
    "leaks, 40%",
    "soft grip, 20 mm",
    "turned about z, 30°",
    "inverse pose, orientation",
    "axis flipped, mirrored",
    "columns swapped, force and torque",
    "unit of position, in",
    "axes of position, mirrored",
    "unit of torque, lbf in",
    "in contact, 55%",
    "gains of all axes, 3.0%",
    "low-passed, 0.7 Hz",
    "torque about the TCP, 150 mm",
    "starts with the identity, 10",
    "frozen poses, 1 s",
    "cable, 20 N/m",
    "vibration, 5 Hz",
    "creeps in the gripper, 60 mm",
)
"""Mistakes of the benchmark that are ingested whole."""

CASES: dict[str, Callable[[], Any]] = {
    "clean": partial(understood, recorded),
    "stopping": partial(understood, partial(recorded, stopping)),
    "medium": partial(understood, partial(recorded, medium), hint=True),
    "drift": partial(
        understood, partial(faulty, drift=(0.5, -0.3, 0.4, 0.02, 0.01, -0.02))
    ),
    "settling": partial(
        understood,
        partial(
            faulty,
            drift=(0.5, -0.3, 0.4, 0.02, 0.01, -0.02),
            drift_kind="exponential",
        ),
    ),
    "wandering": partial(
        understood,
        partial(
            recorded,
            long,
            replace(
                FAULTS,
                drift=(3.0, -2.0, 1.0, 0.1, 0.05, -0.1),
                drift_kind="exponential",
            ),
        ),
    ),
    "late": partial(understood, partial(late, 0.03)),
    "slightly late": partial(understood, partial(late, 0.002)),
    "very early": partial(conditioned, partial(late, -0.25)),
    "late, no clock": partial(conditioned, partial(late, 0.03), clock=False),
    "late in columns": partial(
        conditioned,
        lambda: stamped_late(with_columns(), 0.05),
    ),
    "turned over": partial(understood, turned_over),
    "spikes": partial(understood, partial(faulty, spikes=0.03)),
    "contacts": partial(understood, partial(faulty, contacts=0.2)),
    "dropped": partial(understood, partial(faulty, dropped=0.1)),
    "saturated": partial(understood, partial(faulty, saturation=(15.0, 1.2))),
    "coloured": partial(understood, partial(faulty, noise_correlation=0.9)),
    "glitches": partial(understood, partial(faulty, pose_glitches=0.01)),
    "stalls": partial(understood, partial(faulty, pose_stalls=0.05)),
    "jumping": partial(understood, jumping),
    "implausible": lambda: without_faulty_poses(
        faulty(pose_glitches=0.7, pose_glitch_size=(9.0, 3.0))
    ),
    "many glitches": lambda: without_faulty_poses(
        faulty(pose_glitches=0.1, pose_glitch_size=(9.0, 3.0))
    ),
    "startup": partial(
        understood, partial(faulty, pose_startup=0.3, pose_shutdown=0.2)
    ),
    "everything": partial(understood, everything, hint=True),
    "faster": partial(understood, faster),
    "in steps": partial(understood, in_steps),
    "imu": partial(understood, with_imu),
    "accelerometer": partial(understood, accelerated),
    "accelerometer and gravity": partial(understood, accelerated, gravity="estimate"),
    "orientations": lambda: {**understood(orientations), "common errors": None},
    "columns": partial(understood, with_columns),
    "few": partial(understood, few),
    "static": partial(understood, static_poses),
    "static, gravity": partial(understood, static_poses, gravity="estimate"),
    "tilted": partial(understood, partial(tilted, 6.0), gravity="estimate"),
    "tilted, hint": partial(conditioned, partial(tilted, 6.0), hint=True),
    "tilted columns": partial(conditioned, with_columns, tilt=True),
    "no bias": partial(understood, turned_over, bias="none"),
    "bias given": partial(understood, recorded, bias=FAULTS.bias),
    "bias left": partial(understood, recorded, bias="none"),
    "sign given": partial(understood, recorded, wrench="on-sensor"),
    "estimated bias": partial(understood, turned_over, bias="estimate"),
    "part": partial(understood, partial(recorded, stopping), start=1.2, duration=5.0),
    "smooth": partial(understood, recorded, motion="smooth"),
    "tool": beside_a_tool,
    "several": several,
    "several biases": partial(several, bias=np.array((FAULTS.bias, np.zeros(6)))),
    "tare": tared,
    **{
        f"{kind}": partial(understood, partial(changing, kind))
        for kind in ("swapped", "put-down", "picked-up", "slipped", "touched")
    },
    "swapped, part": partial(
        understood, partial(changing, "swapped"), start=0.5, duration=8.0
    ),
    "given": partial(understood, lambda: given().recording),
    **{
        f"{name}, later": partial(understood, partial(mistaken, name))
        for name in MISTAKEN
    },
    "drift in short": partial(understood, drifting_briefly),
    "low noise": partial(conditioned, partial(recorded, short, LOW_NOISE)),
}
"""By name."""
SMALLEST = {"orientations": 1e-2}
"""Size up to which numbers are rounding: inertia is none there, and is not told."""
