"""Identification from joint torques in place of a wrench."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Noise
from hefting.core.messages import Message, error, warning
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.estimators import OLS, default_method, method_named
from hefting.estimators.base import Known
from hefting.estimators.state_likelihood import StateSamples
from hefting.estimators.whitened_state import WhitenedState
from hefting.identification.estimator import estimator_for, estimator_knowing, known_of
from hefting.identification.run import understand
from hefting.shapes import Shape
from hefting.torques.dynamics import JointDynamics
from hefting.torques.noise import TorqueFit
from hefting.torques.runs import EmptyRuns, LoadedRuns, load_arm
from hefting.torques.samples import samples_of, still_joints

PUBLISHED_ARM_STD = np.repeat((0.1, 0.015, 0.01), (1, 3, 6))
"""(10,) standard deviations of what a published arm is taken for in the payload [kg,
kg m, kg m²]: of a Franka Panda's, on real torques, 57 to 100 g and 5 to 15 mm of
1 kg."""
LARGEST_MISFIT = 2.0
"""Slow residual of any joint by empty and loaded runs together over that of each alone,
from which on they are not of the same arm: of the same simulated robot it was at most
1.03, of others of its kind at least 4.7."""
LEAST_LOAD = 2.0
"""Mass over its standard deviation below which no load is seen."""


def _check_distinct(recordings: Sequence[Recording]) -> None:
    """`InputError` for the same recording twice, of whatever names."""
    for i, one in enumerate(recordings):
        for other in recordings[:i]:
            if _is_same(one, other):
                raise InputError(
                    "is given twice, with the payload or without it",
                    one.source,
                    "give each recording once: it counts once",
                )


def _is_same(one: Recording, other: Recording) -> bool:
    """Whether two recordings hold the same joint positions."""
    if not (one.has("joint_positions") and other.has("joint_positions")):
        return False
    first, second = one["joint_positions"], other["joint_positions"]
    return np.array_equal(first.time, second.time) and np.array_equal(
        first.values, second.values
    )


@dataclass(frozen=True, eq=False)
class ByTorques:
    """What joint torques tell of a payload, for any method."""

    dynamics: JointDynamics
    fit: TorqueFit
    messages: tuple[Message, ...]
    arm_known: bool
    samples: int
    """of the runs with the payload"""
    duration: float
    """[s] of those runs, one after the other"""

    @property
    def state(self) -> WhitenedState:
        """The payload's equations, of unit noise."""
        return self.fit.state

    @classmethod
    def of(
        cls,
        recordings: Sequence[Recording],
        urdf: str | Path,
        sensor_frame: str,
        *,
        empty: Sequence[Recording] = (),
        arm: str | Path | None = None,
        torque_gains: Array | None = None,
        gravity: ArrayLike = STANDARD_GRAVITY,
    ) -> ByTorques:
        """Of recordings with the payload, and of the arm without it.

        Parameters
        ----------
        recordings : with joint positions and torques, of one object in one grasp.
        urdf : the robot.
        sensor_frame : link that holds the object; results are in its axes.
        empty : recordings of the same arm without the object, of any motion.
        arm : file that `hefting calibrate --torques` wrote.
        torque_gains : (n,) or one number [N m/A], where currents were recorded.
        gravity : (3,) in the axes of the URDF's root [m/s²].

        Raises `InputError` for a recording that is given twice, and as
        `JointDynamics.from_urdf`, `samples_of` and `load_arm`.
        """
        _check_distinct((*recordings, *empty))
        dynamics = JointDynamics.from_urdf(urdf, sensor_frame, gravity)
        loaded = [samples_of(log, dynamics, torque_gains) for log in recordings]
        bare = [samples_of(log, dynamics, torque_gains) for log in empty]
        calibration = None if arm is None else load_arm(arm, dynamics)
        runs = LoadedRuns(dynamics, tuple(loaded), tuple(bare), calibration)
        found = runs.fit()
        messages = [
            message
            for log, samples in zip(recordings, loaded, strict=True)
            for message in (*log.warnings, *still_joints(samples, dynamics, log.source))
            if isinstance(message, Message)
        ]
        messages += _of_arm(runs, found)
        return cls(
            dynamics,
            found,
            tuple(messages),
            runs.arm_known,
            sum(len(samples.time) for samples in loaded),
            sum(float(np.ptp(samples.time)) for samples in loaded),
        )

    def estimate(
        self,
        shape: Shape | None = None,
        method: str | None = None,
        wrench: WhitenedState | None = None,
        **settings: Any,
    ) -> Estimate:
        """The object by a method; of a `wrench` too, as `wrench_equations` gives it.

        Raises `InputError` as `hefting.identify`, and
        `NotIdentifiableError` where no positive mass explains the torques."""
        kind, own = method_named(method or default_method(shape is not None))
        known = Known(
            bias="none",
            noise=Noise(1.0, 1.0),
            motion_noise=None,
            smoothed=False,
            systematic=np.diag(PUBLISHED_ARM_STD**2) if self.arm_known else None,
            carried=None,
            shape=shape,
        )
        estimator = estimator_knowing(kind, known, own | settings)
        state = self.state if wrench is None else self.state.stacked(wrench)
        estimate = estimator.estimate(state)
        messages = (*self.messages, *_of_load(estimate))
        if not estimate.mass > 0.0:
            raise NotIdentifiableError(
                "no positive mass explains the torques",
                fix="does the controller subtract a payload, is the sign that of the "
                "motors' torques?",
            )
        return replace(
            estimate,
            samples=self.samples + (0 if wrench is None else wrench.samples),
            duration=max(self.duration, 0.0 if wrench is None else wrench.duration),
            warnings=(*messages, *estimate.warnings),
            provenance=estimator.provenance | estimate.provenance | self.provenance,
        )

    @property
    def provenance(self) -> dict[str, Any]:
        """How the torques were understood."""
        return {
            "source": "joint torques",
            "sensor_frame": self.dynamics.robot.sensor_frame,
            "arm": "published" if self.arm_known else "empty runs",
            "torque_noise": tuple(float(value) for value in self.fit.std),
        }


def wrench_equations(recording: Recording, **reading: Any) -> WhitenedState:
    """What the wrench of a recording tells of the object, its bias and noise found, as
    equations beside those of the joint torques of the same grasp.

    They are in the axes of the sensor, which must be those of the torques' frame. For
    `reading` and errors see `hefting.identify`.
    """
    found = understand(recording, **reading)
    estimator = estimator_for(OLS, found, None, {})
    state = estimator.update(estimator.start(), found.measurements)
    carried = known_of(found, None).carried
    samples = StateSamples.of(state, found.bias == "estimate", None, carried, None)
    if samples is None:
        raise NotIdentifiableError("no sample has any weight", recording.source)
    likelihood = samples.likelihood(samples.samples.least_squares).likelihood
    if found.common_errors is not None:
        likelihood = likelihood.blurred(found.common_errors)
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
    torque_gains: Array | None = None,
    gravity: ArrayLike = STANDARD_GRAVITY,
) -> tuple[JointDynamics, EmptyRuns]:
    """The arm without a payload; arguments and errors as of `ByTorques.of`."""
    dynamics = JointDynamics.from_urdf(urdf, sensor_frame, gravity)
    samples = [samples_of(log, dynamics, torque_gains) for log in recordings]
    return dynamics, EmptyRuns.of(dynamics, samples)


def _of_arm(runs: LoadedRuns, found: TorqueFit) -> list[Message]:
    if runs.arm_known:
        what = (
            "the URDF's inertias stand for the arm's: a published arm was found to put "
            "the mass of 1 kg wrong by 57 to 100 g and its COM by 5 to 15 mm, and the "
            "intervals allow for that: record an empty run (`empty`)"
        )
        return [warning("arm-published", what, "empty")]
    each = [EmptyRuns.of(runs.dynamics, runs.loaded)]  # with the payload as a link
    if runs.empty:
        each.append(EmptyRuns.of(runs.dynamics, runs.empty))
    if runs.calibration is not None:
        each.append(runs.calibration)
    alone = np.max([one.fit.slow_std for one in each], axis=0)
    ratio = float((found.slow_std / alone).max())
    if not ratio > LARGEST_MISFIT:
        return []
    what = (
        "empty and loaded runs contradict each other: together their slow residuals "
        f"are {ratio:.1f} times those of each alone: are they of the same robot, with "
        "the same tool, and in the same order of joints?"
    )
    return [error("empty-run-contradicts", what, "empty")]


def _of_load(estimate: Estimate) -> list[Message]:
    if estimate.covariance is None:
        return []
    std = float(estimate.covariance[0, 0]) ** 0.5
    if estimate.mass > LEAST_LOAD * std:
        return []
    what = (
        f"the torques show no load ({estimate.mass:.3g} ± {std:.2g} kg): does the "
        "controller compensate the payload already?"
    )
    return [error("no-load-seen", what)]
