"""Live ROS messages -> samples, batch by batch; topics, frames and numbers are found as
in bags."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message
from hefting.core.recording import JOINT_STREAMS
from hefting.logs.ros.frames import list_names
from hefting.logs.ros.layout import UnknownTypeError, definitions_for
from hefting.logs.ros.messages import (
    Collector,
    Gathered,
    Key,
    same_name,
    without_slashes,
)
from hefting.logs.ros.series import FAR_BACK, Series
from hefting.logs.ros.source import Topic
from hefting.logs.ros.streams import Streams
from hefting.online.samples import Samples
from hefting.sources import MAX_MESSAGE, TOO_LARGE, UNREADABLE, Request

RosMessage = tuple[Topic, int, bytes]
"""A message: its topic, the time when it was sent or came [ns], and its bytes."""

POSE_STREAMS = ("position", "orientation")

UNFITTING = "frames or times that do not fit the others"
NOT_FINITE = "values that are not finite"
"""Reasons for which messages are skipped."""

ROLES = ("wrench", "pose", "joint", "imu", "twist")
"""Roles of topics that can be chosen by name."""


class RosDecoder:
    """Chooses topics and frames from the first messages, as the request allows, and
    decodes the later ones; messages call the source `name`.

    `skipped` counts what is left out, by reason. `chosen` has messages on the chosen
    topics once `choose` has succeeded.
    """

    def __init__(self, name: str, request: Request, skipped: Counter[str]):
        self.name, self.skipped = name, skipped
        self.chosen: tuple[Message, ...] = ()
        # velocities follow from the poses
        self._named = {**request.topics, "twist": "none"}
        self._world = without_slashes(request.world_frame)
        self._sensor = without_slashes(request.sensor_frame)
        self._joints: tuple[str, ...] = ()
        self._tf = Transforms()
        self._given = -np.inf

    def wants(self, topic: Topic) -> bool:
        """Whether a topic is wanted; `InputError` if so and it cannot be decoded."""
        if not Collector(self.name, self._named).wants(topic):
            return False
        self._check_schema(topic)
        return True

    def choose(self, messages: Sequence[RosMessage]) -> list[Samples] | None:
        """Choose topics and frames by the first messages, and return their samples; None
        where there is no wrench yet, or neither poses nor joints.

        Raises `InputError` where the user must choose.
        """
        counted: Counter[str] = Counter()
        gathered = self._gather(messages, counted)
        transforms = [each for each in gathered if each.role == "tf"]
        streams = self._build(gathered, self._named)
        found = streams.series
        if "wrench" not in found or not {"orientation", "joint_positions"} & set(found):
            return None
        self.skipped.update(counted)
        self._tf = self._tf.following(transforms)
        self._joints = streams.joint_names
        self._pin(gathered, streams.pose_topic)
        self._sensor, self._world = streams.sensor or self._sensor, streams.world
        self.chosen = (*streams.notes, *streams.warnings)
        return self._give(streams)

    def decode(self, messages: Sequence[RosMessage]) -> list[Samples]:
        """The samples in messages, once `choose` has succeeded.

        A batch with a message that does not fit is halved until that is found and
        skipped.
        """
        try:
            return self._decode(messages)
        except InputError:
            if len(messages) == 1:
                self.skipped[UNFITTING] += 1
                return []
            half = len(messages) // 2
            return self.decode(messages[:half]) + self.decode(messages[half:])

    def missing(
        self, topics: Sequence[Topic], seen: Sequence[RosMessage]
    ) -> InputError:
        """The error that says why no topics could be chosen."""
        sending = {topic for topic, _, _ in seen}
        offered = list_names([str(topic) for topic in topics]) or "no topics"
        probe = Collector(self.name, self._named)
        wanted = {t: probe.gathered[t].role for t in topics if probe.wants(t)}
        for role, name in self._named.items():
            if name != "none" and not any(same_name(name, t.name) for t in topics):
                return InputError(
                    f"there is no topic '{name}'",
                    self.name,
                    f"give `{role}_topic` one of {offered}",
                )
        if "wrench" not in wanted.values():
            return InputError(
                f"offers no wrench, only {offered}",
                self.name,
                "start its publisher, or name its topic with `wrench_topic`",
            )
        if "wrench" not in {wanted.get(topic) for topic in sending}:
            silent = [str(t) for t, role in wanted.items() if role == "wrench"]
            return InputError(
                f"nothing arrives on {list_names(silent)}",
                self.name,
                "check that its publisher runs, and its quality of service",
            )
        return InputError(
            f"no orientation and no joint positions arrive, only {offered}",
            self.name,
            "send tf, PoseStamped or JointState, or give `sensor_frame` a frame of tf",
        )

    def _decode(self, messages: Sequence[RosMessage]) -> list[Samples]:
        counted: Counter[str] = Counter()
        gathered = self._gather(messages, counted)
        transforms = [each for each in gathered if each.role == "tf" and each.series]
        tf = self._tf.following(transforms) if transforms else self._tf
        present = {each.role for each in gathered if each.series}
        named = {role: "none" for role in ROLES if role not in present}
        if transforms and self._named["pose"] == "none":
            del named["pose"]  # tf gives the poses
        elif "pose" in present:
            named["pose"] = self._named["pose"]
        others = [each for each in gathered if each.role != "tf"]
        streams = self._build([*others, *tf.all()], named)
        # only now, as nothing is kept or counted of a batch that failed
        self._tf = tf
        self.skipped.update(counted)
        return self._give(streams)

    def _pin(self, gathered: Sequence[Gathered], pose: Gathered | None) -> None:
        for role in ROLES:
            own = [g.topic.name for g in gathered if g.role == role and g.series]
            self._named[role] = own[0] if own else "none"
        if pose is None:
            self._named["pose"] = "none"
        self._named["twist"] = "none"

    def _gather(
        self, messages: Sequence[RosMessage], counted: Counter[str]
    ) -> list[Gathered]:
        """Finite values of messages, by topic; skipped ones are added to `counted`."""
        collector = Collector(self.name, self._named)
        for topic, logged, data in messages:
            if len(data) > MAX_MESSAGE:
                counted[TOO_LARGE] += 1
            elif collector.wants(topic):
                collector.add(topic, logged, data)
        gathered = list(collector.finish().values())
        for each in gathered:
            if each.unreadable:
                counted[UNREADABLE] += each.unreadable
            finite = {
                key: _finite(series, counted) for key, series in each.series.items()
            }
            each.series = {
                key: series
                for key, series in finite.items()
                if len(series) and self._is_of_the_arm(key)
            }
        return gathered

    def _is_of_the_arm(self, key: tuple[str, ...]) -> bool:
        """Whether a series is of the chosen joints, or of no joints."""
        what, *names = key
        if not self._joints or what not in JOINT_STREAMS:
            return True
        return set(names) == set(self._joints)

    def _build(self, gathered: list[Gathered], named: dict[str, str]) -> Streams:
        streams = Streams(
            self.name, gathered, named, self._world, self._sensor, live=True
        )
        with np.errstate(over="ignore", invalid="ignore"):
            streams.build()
        return streams

    def _give(self, streams: Streams) -> list[Samples]:
        found = dict(streams.series)
        if self._named["pose"] == "none" and "orientation" in found:
            time = found["orientation"].time
            if time[-1] < self._given - FAR_BACK:  # the clock was set back
                self._given = -np.inf
            new = time > self._given
            found |= {name: found[name][new] for name in POSE_STREAMS if name in found}
            self._given = max(self._given, float(time[-1]))
            self._tf.forget(self._given)
        if streams.joint_names:
            # in the order of the first message
            order = [streams.joint_names.index(name) for name in self._joints]
            for name in JOINT_STREAMS:
                if name in found:
                    found[name] = found[name].with_values(found[name].values[:, order])
        return [
            Samples(name, _seconds(series), series.values)
            for name, series in found.items()
            if len(series)
        ]

    def _check_schema(self, topic: Topic) -> None:
        try:
            if topic.encoding in ("cdr", "ros1"):
                definitions_for(topic)
                return
        except UnknownTypeError:
            pass
        raise InputError(
            f"the schema of {topic} is not understood",
            self.name,
            "send it as ROS messages, such as geometry_msgs/msg/WrenchStamped",
        )


def _finite(series: Series, counted: Counter[str]) -> Series:
    good = np.asarray(np.isfinite(series.values).all(axis=1))
    if good.all():
        return series
    counted[NOT_FINITE] += int((~good).sum())
    return series[good]


def _seconds(series: Series) -> np.ndarray:
    """Times [s] of the stamps [ns], rounded only once."""
    whole, part = np.divmod(series.time, 1_000_000_000)
    return whole + part * 1e-9


MAX_LINKS = 2000
"""Largest number of links that are kept: a humanoid with its sensors has some hundred."""

KEPT = 10
"""Number of samples of a link that are kept from before the last given pose."""


class Transforms:
    """The tf messages that are kept from one batch to the next, as a pose needs earlier
    ones of other links in its chain."""

    def __init__(self, kept: Mapping[Topic, Mapping[Key, Series]] | None = None):
        self._kept = {topic: dict(links) for topic, links in (kept or {}).items()}

    def following(self, gathered: Iterable[Gathered]) -> "Transforms":
        """These and the tf messages of a batch."""
        found = Transforms(self._kept)
        for each in gathered:
            kept = found._kept.setdefault(each.topic, {})
            for key, series in each.series.items():
                if key in kept or len(kept) < MAX_LINKS:
                    kept[key] = _following(kept.get(key), series)
        return found

    def all(self) -> list[Gathered]:
        """All kept messages, in the form that `Streams` takes."""
        return [Gathered(topic, "tf", dict(kept)) for topic, kept in self._kept.items()]

    def forget(self, before: float) -> None:
        """Drop what is not needed once poses up to the time `before` [ns] are given."""
        for topic, kept in self._kept.items():
            for key, series in kept.items():
                if topic.name.endswith("static"):
                    kept[key] = series[series.order()[-1:]]
                    continue
                series = series[np.argsort(series.time, kind="stable")]
                first = int(np.searchsorted(series.time, before, side="right"))
                kept[key] = series[max(min(first, len(series) - 1) - KEPT, 0) :]


def _following(kept: Series | None, series: Series) -> Series:
    """Both series joined; only the newer one if the clock was set back between."""
    if kept is None or series.time.min() < kept.time.max() - FAR_BACK:
        return series
    return Series.joined([kept, series])
