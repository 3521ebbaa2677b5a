"""Pipeline: from samples of a live stream to live estimates, driven by the stream's own
clock."""

from collections import deque
from dataclasses import replace

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.online.expected import Watch
from hefting.online.folding import Folded, Follower, folded
from hefting.online.history import History
from hefting.online.live_estimate import LiveEstimate, LiveStateName, state_of
from hefting.online.process import Inline, Remote
from hefting.online.samples import Samples
from hefting.online.series import Stall
from hefting.online.understanding import MOST_PARTS, Task, Understanding, long_enough

EVERY = 1.0
"""[s] of the stream between two understandings of its history."""
REFERENCE_AGE = 1.5
"""[s] Age of the understanding by which a change of the object is judged, as a later
one may include the other object."""
NOTABLE_SHARE = 0.02
"""Share of new samples from which the noise is found again between understandings."""
FOLLOWED = ("smooth", "inertial", "orientation")
"""Sources of motion that a filter of poses replaces between understandings."""
NEEDED = ("wrench", "position", "orientation")
"""Streams that, once they came, are needed for new samples to count."""
SILENT = 2.0
"""[s] Longest silence of one of them while others continue."""
OBSTACLES: dict[str, LiveStateName] = {
    "live-nothing-held": "nothing held",
    "live-mistaken": "mistaken",
}
"""States by the codes of obstacles other than too little motion."""
MOST_MESSAGES = 20
"""Largest number of messages on the stream that are kept."""


class Pipeline:
    """From samples of a stream to live estimates, for use by one thread. If estimates
    are to be `prompt`, the noise of new samples is found after an estimate, not before.
    """

    def __init__(
        self, asker: Remote | Inline, *, prompt: bool, sensor_pose: Array | None = None
    ):
        self._asker, self._prompt = asker, prompt
        self.history = History(sensor_pose=sensor_pose)
        self.object = 1
        self.object_since: float | None = None
        """[s] Stamp from which on the object is held, where it is not the first."""
        self._previous: Estimate | None = None
        self._messages: deque[Message] = deque(maxlen=MOST_MESSAGES)
        self._start_anew()
        self._older: list[Recording] = []
        self._asked_object = 0
        self._forget = False

    def _start_anew(self) -> None:
        self._known: deque[Understanding] = deque(maxlen=4)
        self._obstacle: Message | None = None
        self._follower: Follower | None = None
        self._watch, self._stall = Watch(), Stall()
        self._last_asked = -np.inf
        self._estimate: Estimate | None = None
        self._folded = Folded(None)
        self._prepared: tuple[Understanding, int] | None = None
        """Understanding and number of samples by which the noise was found last."""
        self._until: tuple[Understanding, float] | None = None
        """Understanding and last sample [s] of the estimate."""

    def take(self, samples: Samples) -> None:
        """Take samples of one stream."""
        checked = self.history.checked(samples)
        if checked is None:
            return
        jumped = self.history.add(checked)
        if jumped is not None:
            self._messages.append(jumped)
            older = self.history.take_all()
            self._older += [] if older is None else [older]
            before = self._estimate
            self._start_anew()
            self._estimate = before
            self.history.add(checked)

    def say(self, message: Message) -> None:
        """Add a message on the stream to the next estimates."""
        self._messages.append(message)

    def step(self) -> LiveEstimate:
        """The current estimate; `look` is to follow once it is published."""
        self._filter()
        self._stall = self._stall.after(self.history.series.get("wrench"))
        return self.current()

    def look(self) -> None:
        """Do what can wait until an estimate is published: look for another object,
        have the history understood when it is time, and prepare the next estimate."""
        self.receive()
        self._look_for_change()
        self._ask()
        if self._prompt and self._is_prepared:
            self._prepare()

    def _ask(self) -> None:
        """Have the history understood, if it is time and nothing is wrong with it."""
        older = self.history.overflow()
        self._older += [] if older is None else [older]
        self._older = self._older[-MOST_PARTS:]
        if self._asker.busy or self._watch.onset is not None or self._stall.lasts:
            return
        if self._silent:
            return
        if not self.history.latest - self._last_asked >= EVERY:
            return
        recording = self.history.recording()
        if recording is None or not long_enough(recording):
            recording = None
            if not (self._older or self._forget):
                return
        self._asker.ask(Task(recording, tuple(self._older), self._forget))
        self._older, self._forget = [], False
        self._last_asked, self._asked_object = self.history.latest, self.object

    def receive(self) -> None:
        """Take a new understanding, unless it is of an earlier object."""
        found = self._asker.answer()
        if found is None or self._asked_object != self.object:
            return
        self._obstacle = found.obstacle
        if found.changed is not None:
            # the last estimate may be of samples of both objects
            if (before := self._understood_by(found.changed)) is not None:
                self._estimate = before.estimate
            self._begin_object(found.changed)
            return
        if found.found is None:
            return
        self._known.append(found)
        tuned, now = found.pose_filter, self._follower
        if tuned is None or found.found.source not in FOLLOWED:
            pass
        elif now is None or now.is_too_slow(tuned):
            self._follower = Follower.of(tuned)
            self._filter()
        if self._prompt:
            self._fold()

    def follow(self) -> None:
        """Take a new understanding, and filter the new poses."""
        self.receive()
        self._filter()

    def catch_up(self) -> None:
        """Find the estimate with all samples so far, for a quick next one."""
        self.follow()
        self._fold()

    def _filter(self) -> None:
        if self._follower is None:
            return
        found = {name: self._stream(name) for name in ("position", "orientation")}
        poses = {name: each for name, each in found.items() if each is not None}
        if self.history.sensor_pose is not None and poses:
            poses = self.history.placed(poses).streams
        if "orientation" in poses:
            self._follower = self._follower.with_poses(
                poses.get("position"), poses["orientation"]
            )

    def _look_for_change(self) -> None:
        # old enough not to include another object
        reference = self._understood_by(self.history.latest - REFERENCE_AGE)
        if reference is None or reference.expected is None:
            return
        z = self._new_samples(reference)
        if z is None:
            return
        self._watch = self._watch.looked(reference.expected, z)
        if self._watch.changed:
            self._estimate = reference.estimate
            onset = self._watch.onset
            self._begin_object(float(z.time[-1]) if onset is None else onset)

    def _begin_object(self, since: float) -> None:
        """Start anew with the samples from `since` [s] on, of another object."""
        self._previous, before = self._estimate, self.object
        self.object += 1
        self.object_since = since
        self._forget, self._older = True, []
        follower = self._follower
        self._start_anew()
        self._follower = follower
        self.history.cut(since)
        was = "" if self._previous is None else f" ({self._previous.mass:.4g} kg)"
        what = f"the wrench is no longer that of object {before}{was}"
        text = f"{what}: object {self.object} since {since:.2f} s"
        self._messages.append(warning("new-object", text))

    @property
    def _silent(self) -> dict[str, float]:
        """Needed streams that stopped, and their silence [s]."""
        silence = self.history.silence
        return {n: silence[n] for n in NEEDED if silence.get(n, 0.0) > SILENT}

    def _understood_by(self, end: float) -> Understanding | None:
        """The last understanding whose samples end by `end` [s]."""
        known = [each for each in self._known if each.end <= end]
        return known[-1] if known else None

    def _new_samples(self, known: Understanding) -> Measurements | None:
        """Samples since an understanding, corrected by it."""
        wrench = self._stream("wrench", known.end - 1.0)
        if self._follower is None or wrench is None:
            return None
        wrench = self._stall.without(wrench)
        return self._follower.samples(known, wrench, known.end) if len(wrench) else None

    def _stream(self, name: str, begin: float = -np.inf) -> Stream | None:
        series = self.history.series.get(name)
        return None if series is None else series.stream(begin, np.inf)

    def current(self) -> LiveEstimate:
        """The current live estimate."""
        z = self._fold()
        messages: list[Message] = list(self._messages)
        state = self._state(messages)
        found = LiveEstimate(
            float(self.history.latest),
            state,
            self._estimate,
            self.object,
            self._previous,
            z,
            tuple(messages),
            {"samples": self.history.samples, "skipped": self.history.skipped.copy()},
        )
        return self.with_clock_doubt(found)

    def with_clock_doubt(self, found: LiveEstimate) -> LiveEstimate:
        """The estimate with a warning, if a clock was set back."""
        doubt, estimate = self.history.set_back, found.estimate
        if doubt is None or estimate is None:
            return found
        warnings = (*estimate.warnings, doubt)
        return replace(found, estimate=replace(estimate, warnings=warnings))

    def _fold(self) -> Measurements | None:
        """Update the estimate with the samples since the last time; returns these."""
        if not self._known:
            return None
        known = self._known[-1]
        z = self._new_samples(known)
        until = self._watch.trusted_until
        if z is not None and until is not None:
            z = z[: int(np.searchsorted(z.time, until))]
        if self._note_end(known, z):
            prompt = self._prompt and self._is_prepared
            self._folded = folded(known, z, self._folded.last, prompt=prompt)
            self._estimate = found = self._folded.estimate
            if not prompt and found is not None and self._folded.state is not None:
                self._prepared = known, found.samples
        return z

    @property
    def _is_prepared(self) -> bool:
        """Whether the noise was found by the last understanding."""
        if not self._known or self._prepared is None or self._folded.last is None:
            return False
        return self._prepared[0] is self._known[-1]

    def _prepare(self) -> None:
        """Find the noise for the next estimates, if there are notably more samples."""
        state, last = self._folded.state, self._folded.last
        if state is None or self._estimate is None or self._prepared is None:
            return
        known, then = self._prepared
        samples, estimator = self._estimate.samples, known.estimator
        more = samples - then
        if estimator is None or 0 <= more < NOTABLE_SHARE * samples:
            return
        try:
            last = estimator.prepared(state, last)
        except (NotIdentifiableError, np.linalg.LinAlgError):
            last = None
        self._folded = replace(self._folded, last=last)
        self._prepared = known, samples

    def _note_end(self, known: Understanding, z: Measurements | None) -> bool:
        """Note the understanding and the last sample of the next estimate; whether they
        differ from those of the present one."""
        until = known.end if z is None or not len(z) else float(z.time[-1])
        before, self._until = self._until, (known, until)
        return before is None or before[0] is not known or before[1] != until

    def _state(self, messages: list[Message]) -> LiveStateName:
        """The state; its message is added to `messages`."""
        if silent := self._silent:
            what = f"no {' and '.join(silent)} for {min(silent.values()):.0f} s"
            messages.append(warning("source-silent", f"{what}: does its driver run?"))
            return "lost source"
        if self._stall.lasts:
            what = f"the wrench stands still since {self._stall.since:.2f} s"
            messages.append(warning("wrench-stalled", f"{what}: does its driver run?"))
            return "lost source"
        if self._watch.onset is not None:
            when = f"since {self._watch.onset:.2f} s"
            why = "touched, slipped or swapped, or was the sensor zeroed?"
            if self._watch.rests:
                when += ", while the poses rest"
                why = "touched, or do the poses repeat?"
            what = f"the wrench is not that of the object {when}: {why}"
            messages.append(warning("live-contradicted", what))
            return "contradicted"
        if self._estimate is not None:
            return state_of(self._estimate)
        absent = [s for s in ("wrench", "orientation") if not self.history.has(s)]
        if absent:
            messages.append(note("live-waiting", f"waits for {' and '.join(absent)}"))
            return "waiting"
        if self._obstacle is None:
            messages.append(note("live-waiting", "waits for a second of samples"))
            return "waiting"
        messages.append(self._obstacle)
        return OBSTACLES.get(self._obstacle.code, "too little motion")
