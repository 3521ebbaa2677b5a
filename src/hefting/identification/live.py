"""Live: poses and wrenches as a robot gives them -> an estimate at any time.

Poses go through a fixed-lag filter, which is tuned on the first motion; its motion,
with the wrenches of the same instants, goes into an estimator. The cost of a sample
does not grow with their number.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.spatial import STANDARD_GRAVITY, check_gravity
from hefting.estimators import METHODS, Bayes, Estimator
from hefting.estimators.sample_state import SampleState
from hefting.identification.waiting import NO_POSES, Pairing, Poses
from hefting.motion import Motion
from hefting.motion.kalman import PoseFilter, State
from hefting.shapes import Shape, as_shape

FEWEST_SAMPLES = 50
"""Number of samples for a first estimate: half a second at 100 Hz. In fewer the noise
is not separated from the motion."""
FEWEST_POSES = 20
"""Least number of poses on which the filter is tuned. On the demo's, whose bandwidth is
16 rad/s by 100 poses, 10 give 70 rad/s and 30 give 25."""
SIGNS = {"on-object": 1.0, "on-sensor": -1.0}
"""Sign of the wrench in the project's convention, by the body that it acts on."""


@dataclass(frozen=True, eq=False)
class LiveState:
    """State of a `Live` identification between samples.

    Examples
    --------
    >>> live = hefting.Live()
    >>> state = live.update(live.start(), wrench_time=0.0, wrench=[0, 0, -9.8, 0, 0, 0])
    >>> state.samples.samples  # it waits for poses
    0
    """

    samples: SampleState
    """State of the estimator."""
    poses: Poses = NO_POSES
    """Poses that wait for the filter to be tuned."""
    pose_filter: PoseFilter | None = None
    """None until it is tuned."""
    filtered: State | None = None
    """The filter's own state."""
    pairing: Pairing = field(default_factory=Pairing)
    """Motions and wrenches that wait for each other."""


@dataclass(frozen=True, eq=False, repr=False)
class Live:
    """Identification from raw samples while the robot moves.

    ``update`` takes poses and wrenches as they come: one sample or many, together or
    separately. ``estimate`` is that from all samples so far. The state is a value that is
    passed in and returned; nothing else changes.

    Examples
    --------
    >>> log = hefting.read_log("demo/log.csv")  # stands for the robot
    >>> live = hefting.Live("box:-0.1,0.1,-0.3,0.3,0,0.3", until="mass=2%")
    >>> state = live.start()
    >>> state = live.update(
    ...     state,
    ...     time=log["position"].time,
    ...     position=log["position"].values,
    ...     orientation=log["orientation"].values,
    ...     wrench=log["wrench"].values,
    ... )
    >>> live.estimate(state).sufficient
    True
    """

    shape: Any = None
    """Where the object may have mass, as for `hefting.identify`: a `Shape`, a path,
    ``"box:..."``, a mesh or points. None: anywhere near the sensor."""
    until: Accuracy | str | None = None
    """Sufficient accuracy, as in ``mass=1%,com=2mm,inertia=20%``; estimates that reach it
    are `Estimate.sufficient`."""
    gravity: ArrayLike = STANDARD_GRAVITY
    """(3,) in world axes [m/s²]."""
    sign: Literal["on-object", "on-sensor"] = "on-object"
    """Body that the wrench acts on, which must be known here; `hefting.identify` finds it
    from a recording."""
    method: Estimator | None = None
    """The estimator; by default Bayes with the shape, and a bias that is found."""
    poses: PoseFilter | None = None
    """The filter of the poses; by default one tuned on the first motion."""
    tuning: float = 1.0
    """[s] Time from the first motion on in which poses are gathered to tune it."""

    def __post_init__(self):
        object.__setattr__(self, "gravity", check_gravity(self.gravity))
        if self.sign not in SIGNS:
            fix = f"use {' or '.join(SIGNS)}"
            raise InputError(f"unknown sign '{self.sign}'", "Live", fix)
        if not 0.0 < self.tuning < np.inf:
            raise InputError(f"tuning is {self.tuning}, not seconds", "Live")
        shape = as_shape(self.shape)
        if self.method is None:
            where = Shape.unknown() if shape is None else shape
            method = Bayes(where, bias="estimate", until=self.until)
            object.__setattr__(self, "method", method)
        elif not isinstance(self.method, Estimator):
            fix = f"give one of {', '.join(METHODS)}, made with its shape"
            raise InputError("method is not an estimator", "Live", fix)
        elif shape is not None or self.until is not None:
            what = "shape and until are given beside an estimator, which has its own"
            raise InputError(what, "Live", "give them to the estimator")
        object.__setattr__(self, "shape", shape)

    def __repr__(self) -> str:
        until = "" if self.until is None else f", until {self.until}"
        return f"Live by {self.estimator.name}, wrench {self.sign}{until}"

    @property
    def estimator(self) -> Estimator:
        """The estimator that is used."""
        assert self.method is not None
        return self.method

    def start(self) -> LiveState:
        """The state before any sample."""
        tuned = self.poses
        return LiveState(
            self.estimator.start(),
            pose_filter=tuned,
            filtered=None if tuned is None else tuned.start(),
        )

    def update(
        self,
        state: LiveState,
        *,
        time: ArrayLike | None = None,
        position: ArrayLike | None = None,
        orientation: Any = None,
        pose: ArrayLike | None = None,
        wrench: ArrayLike | None = None,
        wrench_time: ArrayLike | None = None,
    ) -> LiveState:
        """The state with poses, wrenches or both added. A sample that is NaN throughout,
        as where a driver lost it, adds nothing.

        Parameters
        ----------
        state : LiveState
            From `start` or the last call.
        time : float or (K,), optional
            [s] Times of the poses, later than all before.
        position : (3,) or (K, 3), optional
            Sensor origin in the world [m]; in every call or in none.
        orientation : (4,), (3, 3) or (K, ...), optional
            Sensor axes in the world: quaternions x, y, z, w, matrices, or a scipy
            ``Rotation``.
        pose : (4, 4), (7,) or (K, ...), optional
            Both at once.
        wrench : (6,) or (N, 6), optional
            Force [N], then torque [N m], in sensor axes about the sensor origin.
        wrench_time : float or (N,), optional
            [s] Times of the wrenches if not `time`, on the same clock.

        Returns
        -------
        LiveState

        Raises
        ------
        InputError
            For arrays that do not fit, are not finite, or are not later.
        """
        pairing = state.pairing
        if wrench is not None:
            at = time if wrench_time is None else wrench_time
            if at is None:
                raise InputError(
                    "a wrench has no time", "Live.update", "give `wrench_time`"
                )
            pairing = pairing.with_wrench(at, wrench, SIGNS[self.sign])
        if any(given is not None for given in (position, orientation, pose)):
            if time is None:
                raise InputError("a pose has no time", "Live.update", "give `time`")
            new = Poses.of(time, position, orientation, pose)
            state, motion = self._moved(state, new)
            if motion is not None:
                pairing = pairing.with_motion(motion)
        pairing, measured = pairing.paired(np.asarray(self.gravity))
        samples = state.samples
        for each in measured:
            samples = self.estimator.update(samples, each)
        return replace(state, pairing=pairing, samples=samples)

    def estimate(
        self, state: LiveState, start: Estimate | None = None
    ) -> Estimate | None:
        """The estimate from the samples so far; None if they do not suffice.

        Parameters
        ----------
        state : LiveState
            From the last `update`.
        start : Estimate, optional
            An earlier one, which saves time.

        Returns
        -------
        Estimate or None
        """
        if state.samples.samples < FEWEST_SAMPLES:
            return None
        try:
            return self.estimator.continued(state.samples, start)[0]
        except NotIdentifiableError:
            return None

    def _moved(self, state: LiveState, new: Poses) -> tuple[LiveState, Motion | None]:
        if state.pose_filter is None:
            poses = state.poses + new
            state, new = self._tuned(state, poses)
        if state.pose_filter is None or state.filtered is None:
            return state, None
        filtered, motion = state.pose_filter.update(
            state.filtered, new.time, new.position, new.orientation
        )
        return replace(state, filtered=filtered), motion

    def _tuned(self, state: LiveState, poses: Poses) -> tuple[LiveState, Poses]:
        """The state with the filter tuned on the poses so far, if these suffice, and
        the poses to be filtered. Poses at rest before the motion are forgotten, as they
        do not show its bandwidth."""
        moved = poses.first_moved
        if moved is None:
            first = np.searchsorted(poses.time, poses.time[-1] - self.tuning)
            return replace(state, poses=poses[int(first) :]), NO_POSES
        early = poses.time[-1] < poses.time[moved] + self.tuning
        if early or len(poses.time) < FEWEST_POSES:
            return replace(state, poses=poses), NO_POSES
        tuned = PoseFilter.tuned(poses.time, poses.position, poses.orientation)
        state = replace(
            state, poses=NO_POSES, pose_filter=tuned, filtered=tuned.start()
        )
        return state, poses
