"""Identification from joint torques in place of a wrench."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import EMPTY_RUNS
from hefting.core.measurements import Noise
from hefting.core.messages import Message
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array, immutable
from hefting.core.torque_moments import pseudo_inverse_half
from hefting.estimators import OLS, default_method, method_named
from hefting.estimators.base import Known
from hefting.estimators.joint_state import WhitenedState
from hefting.estimators.state_likelihood import StateSamples
from hefting.identification.estimator import estimator_for, estimator_knowing, known_of
from hefting.identification.run import understand
from hefting.identification.torque_checks import (
    cause_of_no_load,
    link_errors,
    of_arm,
    of_gains,
    of_joints,
    of_load,
    of_rivals,
    of_torques,
    of_unit,
    require_arms_torques,
)
from hefting.identification.torque_suspects import (
    of_delays,
    of_empty_runs,
    of_suspect,
    refined,
    without_explained,
)
from hefting.ingest.mended_times import with_mended_times
from hefting.logs.given import as_recording
from hefting.shapes import Shape
from hefting.torques.dynamics import JointDynamics
from hefting.torques.noise import GAIN_STD, TorqueFit
from hefting.torques.runs import EmptyRuns, LoadedRuns, load_arm
from hefting.torques.samples import (
    TorqueSamples,
    samples_of,
    still_joints,
    without_held,
    without_spikes,
)
from hefting.torques.suspects import Suspects, without_delay

PUBLISHED_ERROR = 1.5
"""Factor on `link_errors` for a published arm. With it 78 % of the intervals of mass
hold the truth for three simulated arms, and 95 % for six others by another simulator;
errors of a Franka Panda on real torques are 0.4 of the standard deviations."""


@immutable
class ByTorques:
    """A payload's equations from joint torques, for any method."""

    dynamics: JointDynamics
    fit: TorqueFit
    messages: tuple[Message, ...]
    arm_known: bool
    samples: int
    """of the runs with the payload"""
    duration: float
    """[s] of those runs in total"""
    links: Array | None = None
    """(10 n, 10) change of the payload's parameters by one standard deviation of each
    link parameter, if the arm is that of the URDF"""
    gains: tuple[float, ...] | None = None
    """[N m/A] by which the recorded currents were multiplied"""

    @property
    def state(self) -> WhitenedState:
        """The payload's equations of unit noise."""
        return self.fit.state

    @classmethod
    def of(
        cls,
        recordings: Sequence[Recording | str | Path],
        urdf: str | Path,
        sensor_frame: str,
        *,
        empty: Sequence[Recording | str | Path] = (),
        arm: str | Path | None = None,
        torque_gains: ArrayLike | None = None,
        gravity: ArrayLike = STANDARD_GRAVITY,
    ) -> ByTorques:
        """Of recordings with the payload, and of the arm without it.

        Parameters
        ----------
        recordings : recordings or paths, with joint positions and torques, of one object
            in one grasp.
        urdf : the robot.
        sensor_frame : link that holds the object; results are in its axes.
        empty : recordings of the same arm without the object, of any motion.
        arm : file that `hefting calibrate --torques` wrote.
        torque_gains : (n,) or one number [N m/A], where currents were recorded.
        gravity : (3,) in the axes of the URDF's root [m/s²].

        Raises `InputError` for a recording that is given twice, for torques that cannot
        be those of the arm (`require_arms_torques`), and as `JointDynamics.from_urdf`,
        `samples_of` and `load_arm`.
        """
        recordings, empty = (
            [_cleaned(as_recording(log, wrench_needed=False)) for log in logs]
            for logs in (recordings, empty)
        )
        dynamics = JointDynamics.from_urdf(urdf, sensor_frame, gravity)
        loaded = [samples_of(log, dynamics, torque_gains) for log in recordings]
        bare = [samples_of(log, dynamics, torque_gains) for log in empty]
        calibration = None if arm is None else load_arm(arm, dynamics)
        known = () if calibration is None else calibration.digests
        _check_runs(dynamics, (*recordings, *empty), (*loaded, *bare), known)
        runs, found, delays, suspect = without_delay(
            LoadedRuns(dynamics, tuple(loaded), tuple(bare), calibration)
        )
        messages = _log_messages((*recordings, *empty))
        for log, samples in zip(recordings, loaded, strict=True):
            messages += still_joints(samples, dynamics, log.source)
            messages += of_gains(log, torque_gains)
        links = None
        if runs.arm_known:
            errors = PUBLISHED_ERROR * link_errors(dynamics)
            links = Suspects(runs, found).by_links(errors)
        each = runs.alone()
        gains = _errors_of_gains(found)
        half = 1.96 * np.sqrt(np.diag(found.covariance + gains.T @ gains))
        sources = [log.source for log in recordings]
        suspect = refined(runs, suspect)
        named = of_suspect(dynamics, suspect, half, sources, calibration is not None)
        messages += (
            *of_delays(delays, bool(empty)),
            *(of_unit(dynamics, each) or of_joints(dynamics, each[1:])),
            *of_rivals(dynamics, runs.loaded),
            *named,
            *of_arm(runs, found, each),
        )
        return cls(
            dynamics,
            found,
            tuple(messages),
            runs.arm_known,
            sum(len(samples.time) for samples in loaded),
            sum(float(np.ptp(samples.time)) for samples in loaded),
            links,
            None if torque_gains is None else tuple(np.ravel(torque_gains).tolist()),
        )

    def estimate(
        self,
        shape: Shape | None = None,
        method: str | None = None,
        wrench: WhitenedState | None = None,
        **settings: Any,
    ) -> Estimate:
        """The object by a method, also from a `wrench` of `wrench_equations` if given.

        Raises `InputError` as `hefting.identify`, and
        `NotIdentifiableError` if no positive mass explains the torques."""
        kind, own = method_named(method or default_method(shape is not None))
        known = Known(
            bias="none",
            noise=Noise(1.0, 1.0),
            motion_noise=None,
            smoothed=False,
            systematic=self._systematic(wrench),
            carried=None,
            shape=shape,
        )
        estimator = estimator_knowing(kind, known, own | settings)
        state = self.state if wrench is None else self.state.stacked(wrench)
        estimate = estimator.estimate(state)
        if not estimate.mass > 0.0:
            raise NotIdentifiableError(
                "no positive mass explains the torques", fix=cause_of_no_load(self.fit)
            )
        own = [of_torques(message, self.fit) for message in estimate.warnings]
        load = of_load(estimate, self.fit)
        messages = tuple(without_explained((*self.messages, *load, *own)))
        return replace(
            estimate,
            samples=self.samples + (0 if wrench is None else wrench.samples),
            duration=max(self.duration, 0.0 if wrench is None else wrench.duration),
            warnings=messages,
            provenance=estimator.provenance | estimate.provenance | self.provenance,
        )

    def _systematic(self, wrench: WhitenedState | None) -> Array:
        """(10, 10) covariance of the parameters by the joints' gains and the links of a
        published arm, with a `wrench` multiplied by the torques' share of the
        information."""
        errors = _errors_of_gains(self.fit)
        if self.links is not None:
            errors = np.vstack((errors, self.links))
        if wrench is not None:
            own = self.state.factor[:, :10]
            half = pseudo_inverse_half(np.vstack((own, wrench.factor[:, :10])))
            errors = errors @ own.T @ own @ half @ half.T
        return errors.T @ errors

    @property
    def provenance(self) -> dict[str, Any]:
        """Sources and assumptions."""
        return {
            "source": "joint torques",
            "sensor_frame": self.dynamics.robot.sensor_frame,
            "arm": "published" if self.arm_known else EMPTY_RUNS,
            "gravity": tuple(self.dynamics.gravity.tolist()),
            "torque_gains": self.gains,
            "torque_gain_std": GAIN_STD,
            "torque_noise": tuple(float(value) for value in self.fit.std),
        }


def _errors_of_gains(fit: TorqueFit) -> Array:
    """(n, 10) change of the parameters by one standard deviation of each gain."""
    return GAIN_STD * fit.by_gain


def wrench_equations(recording: Recording, **reading: Any) -> WhitenedState:
    """Equations of the object by the wrench of a recording, with its estimated bias and
    noise, to combine with those of joint torques in the same grasp.

    They are in sensor axes, which must be those of the torques' frame. For `reading` and
    errors see `hefting.identify`.
    """
    found = understand(recording, **reading)
    estimator = estimator_for(OLS, found, None, {})
    state = estimator.update(estimator.start(), found.measurements)
    carried = known_of(found, None).carried
    samples = StateSamples.of(state, found.bias == "estimate", None, carried, None)
    if samples is None:
        raise NotIdentifiableError("no sample has any weight", recording.source)
    likelihood = samples.of_wrench(found.common_errors)
    noise = float(np.sqrt(likelihood.covariance.diagonal().mean()))
    return WhitenedState.of_information(
        likelihood.precision,
        likelihood.shift,
        round(found.samples),
        found.duration or 0.0,
        noise,
    )


def calibrate_arm(
    recordings: Sequence[Recording],
    urdf: str | Path,
    sensor_frame: str,
    *,
    torque_gains: ArrayLike | None = None,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> tuple[JointDynamics, EmptyRuns, list[Message]]:
    """The arm alone, and messages; arguments and errors as for `ByTorques.of`."""
    dynamics = JointDynamics.from_urdf(urdf, sensor_frame, gravity)
    recordings = [_cleaned(log) for log in recordings]
    samples = [samples_of(log, dynamics, torque_gains) for log in recordings]
    _check_runs(dynamics, recordings, samples)
    runs, _, delays, suspect = without_delay(LoadedRuns(dynamics, (), tuple(samples)))
    digests = tuple(run.digest for run in samples)
    found = replace(EmptyRuns.of(dynamics, runs.empty), digests=digests)
    for doubt in (*of_unit(dynamics, [found.fit]), *of_rivals(dynamics, runs.empty)):
        if doubt.severity == "error":
            raise InputError(str(doubt), recordings[0].source)
    messages = of_empty_runs(dynamics, delays, refined(runs, suspect))
    return dynamics, found, [*_log_messages(recordings), *messages]


def _log_messages(recordings: Sequence[Recording]) -> list[Message]:
    lines = (each for log in recordings for each in (*log.warnings, *log.notes))
    return [each for each in dict.fromkeys(lines) if isinstance(each, Message)]


def _cleaned(recording: Recording) -> Recording:
    """The recording without spikes and repeated rows, with times corrected for bunches
    and lost rows; its notes are on this alone."""
    recording = replace(recording, notes=())
    return without_held(with_mended_times(without_spikes(recording)))


def _check_runs(
    dynamics: JointDynamics,
    recordings: Sequence[Recording],
    samples: Sequence[TorqueSamples],
    known: Sequence[str] = (),
) -> None:
    """`InputError` for a run with the digest of another one, or one of `known`, and as
    `require_arms_torques`."""
    digests = set(known)
    for log, own in zip(recordings, samples, strict=True):
        require_arms_torques(own, dynamics, log.source)
        if own.digest in digests:
            what = "is given twice, with the payload, without it or as the `arm`"
            raise InputError(what, log.source, "give each recording once")
        digests.add(own.digest)
