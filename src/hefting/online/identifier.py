"""Live identifier: takes samples from a robot's own loop without waiting, and gives
estimates at any time."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.accuracy import Accuracy
from hefting.core.errors import HeftingError, InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, Gravity, GravityLike
from hefting.core.measurements import Noise
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.estimators import Estimator, default_method, method_named, methods_with
from hefting.estimators.base import Known
from hefting.identification.estimator import estimator_knowing, shape_of
from hefting.identification.front import sensor_pose_of
from hefting.ingest.sign_and_bias import TARE, bias_of
from hefting.ingest.tool import load_tool
from hefting.online.live_estimate import LiveEstimate, final_estimate
from hefting.online.pipeline import Pipeline
from hefting.online.process import Inline, Remote
from hefting.online.samples import Samples, checked, is_apart, joined, poses_of
from hefting.online.understanding import Settings
from hefting.robots import Robot
from hefting.shapes import as_shape

QUEUE = 20_000
"""Largest number of batches of samples in the queue; beyond, the oldest are dropped and
counted."""
FOLLOWED_EVERY = 0.1
"""[s] Time between two looks at new samples before the next estimate is due, so that
little is left to be filtered then."""
LONGEST_WAIT = 0.02
"""[s] Longest wait for the next samples when an estimate is due, so that it includes
the newest ones."""
SHORT_PERIOD = 0.06
"""[s] Time between estimates above which each is made from samples of just before, and
is followed by `SHOWING`."""
SHOWING = 0.005
"""[s] Pause after an estimate in which other threads can show it."""
RATES = (0.1, 100.0)
"""[Hz] Lowest and highest rate of estimates."""


class LiveIdentifier:
    """Identification of what a robot holds, while it moves it.

    ``add`` takes samples of one stream, from any thread, and never waits; ``latest`` is
    the last `LiveEstimate`. Sign, clock offset, drift, contacts and spikes are found as by
    `hefting.identify`, anew each second, in a process of its own.

    Parameters
    ----------
    shape : path, str, mesh, points or Shape, optional
        Where the object may have mass, as for `hefting.identify`.
    until : str or Accuracy, optional
        Sufficient accuracy, as in ``mass=1%,com=2mm``.
    rate : float
        Largest rate of estimates, in time of the stream [Hz].
    gravity, sign, bias, tool, method, sensor_pose_in_log, sensor_turned
        As for `hefting.identify`; one method.
    robot : Robot, optional
        Turns ``joint_positions`` into poses of the sensor.
    in_process : bool
        Whether the process is used; False ingests in the thread of ``step``, for streams
        that are played as fast as possible.
    **hyperparameters
        Fields of the estimator.

    Raises
    ------
    InputError
        For invalid arguments.

    Examples
    --------
    >>> import numpy as np
    >>> with hefting.LiveIdentifier("box:-0.1,0.1,-0.3,0.3,0,0.3") as live:
    ...     live.add("wrench", time=0.0, values=np.zeros(6))  # in the control loop
    ...     now = live.wait(2.0)
    >>> now.state
    'waiting'
    """

    def __init__(
        self,
        shape: Any = None,
        *,
        until: Accuracy | str | None = None,
        rate: float = 10.0,
        gravity: GravityLike = ON_EARTH,
        sign: Literal["auto", "on-object", "on-sensor"] = "auto",
        bias: str | Path | ArrayLike = "auto",
        tool: Estimate | str | Path | None = None,
        method: str | type[Estimator] | Estimator | None = None,
        robot: Robot | None = None,
        sensor_pose_in_log: ArrayLike | str | Path | None = None,
        sensor_turned: str | None = None,
        in_process: bool = True,
        **hyperparameters: Any,
    ):
        if not RATES[0] <= rate <= RATES[1]:
            low, high = RATES
            raise InputError(f"rate is {rate}, not {low:g} to {high:g} Hz", "live")
        self.settings = replace(
            _settings(shape, until, gravity, sign, bias, tool, method, hyperparameters),
            sensor_pose=(pose := sensor_pose_of(sensor_pose_in_log, sensor_turned)),
        )
        self.period = 1.0 / rate
        self._queue: deque[Samples] = deque()
        self._dropped = 0
        self._asker = (Remote if in_process else Inline)(self.settings)
        self._robot = robot
        self._pipeline = Pipeline(self._asker, prompt=in_process, sensor_pose=pose)
        self._latest: LiveEstimate | None = None
        self._lost = False
        self._number = 0
        self._final = False
        self._changed = threading.Condition()
        self._came = threading.Event()
        """Set whenever samples came"""
        self._stop = threading.Event()
        self._failure: HeftingError | None = None
        self._thread: threading.Thread | None = None
        if in_process:
            self._thread = threading.Thread(
                target=self._run, name="hefting-live-fold", daemon=True
            )
            self._thread.start()

    def add(
        self,
        samples: Samples | str,
        time: ArrayLike | None = None,
        values: ArrayLike | None = None,
    ) -> None:
        """Add samples of one stream; never waits.

        Parameters
        ----------
        samples : Samples or str
            Samples, or the name of their stream, as in `hefting.Recording`.
        time : float or (n,), optional
            [s] Stamps, if a name is given.
        values : (d,) or (n, d), optional
            As in `hefting.Recording`. Arrays must not be changed afterwards.

        Raises
        ------
        InputError
            For an unknown stream, and values of another shape than that of the stream.
        """
        if isinstance(samples, str):
            times = np.atleast_1d(np.asarray(time, dtype=float))
            rows = np.asarray(values, dtype=float)
            rows = rows[None] if rows.ndim == 1 else rows
            samples = checked(Samples(samples, times, rows))
        if len(self._queue) >= QUEUE:
            with suppress(IndexError):  # the queue may be empty by now
                self._dropped += len(self._queue.popleft().time)
        self._queue.append(samples)
        self._came.set()

    @property
    def latest(self) -> LiveEstimate | None:
        """The last live estimate; None before any sample. Raises the error that stopped
        the identification."""
        if self._failure is not None:
            raise self._failure
        return self._latest

    def wait(self, timeout: float | None = None) -> LiveEstimate | None:
        """The next live estimate; None after `timeout` [s], or if closed."""
        with self._changed:
            seen = self._number
            self._changed.wait_for(
                lambda: self._number != seen or self._stop.is_set(), timeout
            )
            if self._failure is not None:
                raise self._failure
            return None if self._number == seen else self._latest

    def say(self, message: Message) -> None:
        """Add a message on the source to the next estimates; with the code
        ``source-lost``, ``source-silent`` or ``source-back`` it also sets their state.
        """
        if message.code in ("source-lost", "source-silent", "source-back"):
            self._lost = message.code != "source-back"
        self._pipeline.say(message)

    def step(self) -> LiveEstimate | None:
        """Take the samples in the queue and publish an estimate, as the thread does by
        itself; for streams that are played. None before any sample."""
        self._pipeline.receive()
        self._step()
        return self._latest

    def _step(self) -> None:
        """As `step`, without waiting for an understanding."""
        self._take()
        if self._pipeline.history.samples == 0 and not self._lost:
            return
        self._publish(self._pipeline.step())
        if self._thread is not None and self.period > SHORT_PERIOD:
            self._stop.wait(SHOWING)
        self._pipeline.look()

    def close(self, log: Recording | str | Path | None = None) -> LiveEstimate | None:
        """End it, and return the final answer.

        That is the estimate of `hefting.identify` from the whole stream: from `log` if
        given, otherwise from the samples as they came if they fit in memory
        (`hefting.online.history`), otherwise the last live answer. Of several objects it
        is that of the last. It uses all samples even if ``until`` is reached earlier.

        Parameters
        ----------
        log : Recording or path, optional
            The recorded stream.

        Returns
        -------
        LiveEstimate or None
            None without samples. An error that stopped live estimates is one of its
            messages.
        """
        self._stop.set()
        self._came.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        if isinstance(self._asker, Remote):
            self._asker.close()
        with self._changed:
            self._changed.notify_all()
        if self._final:
            return self._latest
        self._final = True
        self._take()
        last = self._latest
        if self._pipeline.history.samples:  # with the latest samples and messages
            last = self._pipeline.current()
        if self._failure is not None:
            if last is None:
                raise self._failure
            doubt = warning("live-failed", f"live estimates ended: {self._failure}")
            last = replace(last, messages=(*last.messages, doubt))
        if last is None:
            return None
        recordings: list[Any] | None = [log]
        history = self._pipeline.history
        # a log also holds the samples that a clock that was set back stamped again
        if log is None or (history.set_back and history.kept.whole):
            recordings = history.kept.clocks() if history.kept.whole else None
        since = self._pipeline.object_since
        found = final_estimate(last, recordings, self.settings, since)
        self._publish(self._pipeline.with_clock_doubt(found))
        return self._latest

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        """Publish an estimate each `period`, and filter new samples in between; if it is
        long, most samples are folded in just before the newest."""
        due = time.monotonic()
        try:
            while True:
                left = due - time.monotonic()
                if self._stop.wait(min(max(left, 0.0), FOLLOWED_EVERY)):
                    break
                if left > FOLLOWED_EVERY:
                    self._take()
                    self._pipeline.follow()
                    continue
                if self.period > SHORT_PERIOD:
                    self._wait_for_samples()
                    self._take()
                    self._pipeline.catch_up()
                    self._wait_for_samples()
                elif not self._queue:
                    self._wait_for_samples()
                self._step()
                due = max(due + self.period, time.monotonic())
        except HeftingError as error:
            self._failure = error
        except Exception as error:  # raised to the callers of `latest` and `wait`
            self._failure = HeftingError(f"{type(error).__name__}: {error}")
        finally:
            self._stop.set()
            with self._changed:
                self._changed.notify_all()

    def _wait_for_samples(self) -> None:
        self._came.clear()
        if not self._stop.is_set():
            self._came.wait(LONGEST_WAIT)

    def _take(self) -> None:
        """Pass on the samples in the queue, those of a stream together, and those of
        another clock after all others."""
        waiting: dict[str, list[Samples]] = {}
        for _ in range(len(self._queue)):
            for each in self._with_poses(self._queue.popleft()):
                if is_apart(waiting.get(each.stream, [each])[-1], each):
                    self._pass_on(waiting)
                    waiting = {}
                waiting.setdefault(each.stream, []).append(each)
        self._pass_on(waiting)

    def _pass_on(self, waiting: dict[str, list[Samples]]) -> None:
        for parts in waiting.values():
            for samples in joined(parts):
                self._pipeline.take(samples)

    def _with_poses(self, samples: Samples) -> Sequence[Samples]:
        """The samples; for joint positions the poses of the sensor instead."""
        if samples.stream != "joint_positions" or self._robot is None:
            return (samples,)
        return poses_of(samples, self._robot)

    def _publish(self, found: LiveEstimate) -> None:
        counts = dict(found.counts) | {"dropped": self._dropped}
        state = "lost source" if self._lost else found.state
        with self._changed:
            self._latest = replace(found, state=state, counts=counts)
            self._number += 1
            self._changed.notify_all()


def _settings(
    shape: Any,
    until: Accuracy | str | None,
    gravity: GravityLike,
    sign: str,
    bias: Any,
    tool: Estimate | str | Path | None,
    method: Any,
    hyperparameters: dict[str, Any],
) -> Settings:
    if sign not in ("auto", "on-object", "on-sensor"):
        raise InputError(
            f"unknown sign '{sign}'", "live", "use auto, on-object or on-sensor"
        )
    if isinstance(bias, str) and bias.startswith(TARE):
        fix = "use auto, none, estimate or a JSON file"
        raise InputError(f"'{bias}' is for recordings", "`bias`", fix)
    one = method.__name__ if isinstance(method, type) else method
    asked = dict(hyperparameters)
    if until is not None:
        if isinstance(one, Estimator):
            what = "until is given beside an estimator, which has its own"
            raise InputError(what, "live", "give it to the estimator")
        asked["until"] = until
    known = as_shape(shape)
    if isinstance(one, Estimator):
        shape_of(one, known, asked)
    else:
        name = one or default_method(known is not None)
        kind, own = method_named(name)
        if until is not None and "until" not in kind.hyperparameters():
            others = ", ".join(methods_with("until"))
            raise InputError(
                f"{name} cannot be asked for an accuracy", "live", f"use {others}"
            )
        # wrong settings are refused before any sample
        facts = Known("none", Noise(1.0, 1.0), None, False, None, None, known)
        estimator_knowing(kind, facts, asked | own)
    return Settings(
        known,
        one,
        {
            "gravity": Gravity.of(gravity),
            "wrench": sign,
            "bias": bias_of(bias),
            "tool": None if tool is None else load_tool(tool),
        },
        asked,
    )
