"""Numbers of a bag's topics -> streams of a recording: by topics, frames and axes."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.messages import Message, note, warning
from hefting.core.recording import JOINT_STREAMS
from hefting.logs.map_groups import about_estimates
from hefting.logs.ros.frames import Link, Tree, checked, compose, list_names, route
from hefting.logs.ros.messages import TYPES, Gathered, Key
from hefting.logs.ros.series import Series, tidy

WORLD, SENSOR = "world", "sensor"
"""Frames in bags that this library writes: of the poses, and of what they are."""

LEVER_ARM = 0.005
"""[m] Largest distance of an accelerometer from the sensor's origin."""


class Streams:
    """Builds a recording's streams from the gathered topics of a bag, role by role.

    `named` maps roles to topics. `build` fills `series` by stream name, `notes`,
    `warnings`, `joint_names`, and `pose_topic` unless tf gives the poses. `live` topics
    are a part of a stream that continues. Methods raise `InputError` where the user must
    choose.
    """

    def __init__(
        self,
        path: Path | str,
        gathered: Sequence[Gathered],
        named: Mapping[str, str],
        world_frame: str | None,
        sensor_frame: str | None,
        live: bool = False,
    ):
        self.path, self.gathered, self.named = path, gathered, named
        self.world, self.sensor, self.live = world_frame, sensor_frame, live
        self.asked_for_sensor = sensor_frame is not None
        self.series: dict[str, Series] = {}
        self.notes: list[Message] = []
        self.warnings: list[Message] = []
        self.joint_names: tuple[str, ...] = ()
        self.pose_topic: Gathered | None = None
        self.hint: str | None = None
        self.tree = Tree(str(path))

    def build(self) -> None:
        """Build all streams, the wrench first, whose frame is the sensor's."""
        self.wrench()
        self.transforms()
        self.pose()
        self.joints()
        self.imu()
        self.twist()

    def wrench(self) -> None:
        """The wrench, and with it the sensor frame."""
        topic = self._topic("wrench")
        if topic is None:
            return
        frame, _, series = self._one_frame(topic, "wrench")
        self._keep("wrench", series, topic)
        self._note("wrench", topic, frame)
        self.warnings += about_estimates(topic.topic.name)
        if self.sensor is None:
            self.sensor = frame
        elif frame and frame != self.sensor:
            what = f"the wrench says it is in frame {frame}; it is taken to be in {self.sensor}, as asked"
            self._warn("wrench-frame", what, "sensor_frame")

    def transforms(self) -> None:
        """The tree of all tf messages."""
        merged: dict[Key, list[tuple[bool, Series]]] = {}
        for topic in self.gathered:
            if topic.role == "tf":
                for key, series in topic.series.items():
                    merged.setdefault(key, []).append(
                        (topic.topic.name.endswith("static"), series)
                    )
        for (_, parent, child), parts in merged.items():
            static = all(is_static for is_static, _ in parts)
            raw = Series.joined(
                [part for is_static, part in parts if is_static == static]
            )
            if parent == child:
                continue
            if static:
                if (raw.values != raw.values[0]).any():
                    what = f"static tf {parent} -> {child} changes in the bag: the last one is taken"
                    self._warn("static-tf-changes", what)
                raw = raw[raw.order()[-1:]]
            self.tree.add(Link(parent, child, raw, static))

    def _chain(self, world: str | None, sensor: str) -> list[tuple[Link, bool]]:
        """Links from `world` to `sensor`, tidied and checked."""
        chain = []
        for raw, downward in self.tree.chain(world, sensor):
            what = f"tf {raw.parent} -> {raw.child}"
            where = f"{self.path}, {what}"
            series, say = raw.series, (self.notes.append, self.warnings.append)
            if not raw.static:
                series = tidy(series, what, where, *say)
            chain.append((checked(raw, series, where, self.live), downward))
        return chain

    def pose(self) -> None:
        """Orientation and position of the sensor: from the named topic, else from tf,
        else from another topic."""
        if self.named.get("pose") is None and self._pose_from_tf():
            return
        topic = self.pose_topic = self._topic("pose")
        if topic is None:
            return
        what = (
            "pose" if any(key[0] == "pose" for key in topic.series) else "orientation"
        )
        frame, child, series = self._one_frame(topic, what)
        series = self._tidy(series, topic)
        if not len(series):
            return
        chain = self._chain_of_poses(frame, child, series) if what == "pose" else []
        if chain:
            series = compose(chain, str(self.path), self.warnings.append)
            self._note("pose", topic, route(chain), "")
            self.world = self.world or frame
        else:
            self._check_world(topic, frame)
            self._note(what, topic, frame)
            self.world = frame
        if not (chain if child else self.asked_for_sensor):
            self._warn_about_pose(topic, frame, child)
        self._split_pose(series)

    def _chain_of_poses(
        self, frame: str, child: str, series: Series
    ) -> list[tuple[Link, bool]]:
        """Links from the world to the sensor after poses became a link of the tree;
        empty where the poses are the sensor's."""
        target = child or self.sensor or SENSOR
        if frame == target:
            return []
        self.tree.replace(Link(frame, target, series, False))
        world = frame if self.world is None else self.world
        if self.sensor and self.sensor in self.tree.frames and world != self.sensor:
            return self._chain(world, self.sensor)
        return []

    def _check_world(self, topic: Gathered, frame: str) -> None:
        """`InputError` for poses in another frame than the named world."""
        if self.world not in (None, frame):
            what = f"poses are in frame '{frame}', not '{self.world}'"
            raise InputError(what, f"{self.path}, {topic.topic.name}")

    def _warn_about_pose(self, topic: Gathered, frame: str, child: str) -> None:
        """Warn that the poses' frame is unknown, except in bags of this library."""
        if (frame, self.sensor) == (WORLD, SENSOR):
            return
        of = f" of {child}" if child else ""
        what = (
            f"nothing shows where the poses{of} of {topic.topic.name} are on the sensor: "
            "they are taken to be the sensor's own: if so give `sensor_frame`, else `sensor_pose_in_log`"
        )
        self._warn("pose-frame-assumed", what, "sensor_frame")

    def _pose_from_tf(self) -> bool:
        if not (frames := self.tree.frames):
            return False
        others = f"give `sensor_frame` one of {list_names(frames - {self.sensor})}"
        if not self.sensor:
            self.hint = others
            return False
        if self.sensor not in frames and not self.asked_for_sensor:
            self.hint = f"tf does not hold its frame {self.sensor}; {others}"
            return False
        chain = self._chain(self.world, self.sensor)
        if all(each.static for each, _ in chain):
            self.hint = self._hint_of_moving(self.sensor)
            return False
        series = compose(chain, str(self.path), self.warnings.append)
        self.world = chain[0][0].parent if chain[0][1] else chain[0][0].child
        self.notes.append(
            note("pose-source", f"orientation and position from tf: {route(chain)}")
        )
        self._split_pose(series)
        return True

    def _hint_of_moving(self, sensor: str) -> str:
        """Advice for an inverted tree, or a wrench in another frame."""
        moving = list_names(self.tree.frames - self.tree.fixed_to(sensor))
        between = f"between {self.world or 'the root'} and {sensor}"
        asked = f"`world_frame` one of {moving}; if not, `sensor_frame` one of them"
        own = f"`world_frame` {sensor} where the wrench is in its axes"
        return f"in tf nothing moves {between}; if it is the sensor, give {asked}, and {own}"

    def _split_pose(self, series: Series) -> None:
        values = series.values
        if values.shape[1] == 7:
            self.series["position"] = series.with_values(values[:, :3])
        self.series["orientation"] = series.with_values(values[:, -4:])

    def joints(self) -> None:
        """Joint positions, velocities and torques of the largest set of joints in one
        message."""
        topic = self._topic("joint")
        if topic is None:
            return
        first = {key: series.rows.min() for key, series in topic.series.items()}
        # the first such message gives the order
        _, *names = max(first, key=lambda key: (len(key), -first[key]))
        if len(set(names)) != len(names):
            what = "a joint has two values in one message"
            raise InputError(what, f"{self.path}, {topic.topic.name}")
        others: set[str] = set()
        parts: dict[str, list[Series]] = {}
        for (what, *own), series in topic.series.items():
            if len(own) == len(names) and set(own) == set(names):
                places = {name: i for i, name in enumerate(own)}
                columns = series.values[:, [places[name] for name in names]]
                parts.setdefault(what, []).append(series.with_values(columns))
            else:
                others |= set(own)
        for what in JOINT_STREAMS:
            if what in parts:
                merged = Series.joined(parts[what])
                merged = merged[np.argsort(merged.rows, kind="stable")]
                self._keep(what, merged, topic, what.replace("_", " "))
        self.joint_names = tuple(names)
        self._note("joints", topic, ", ".join(names), "")
        if others:
            what = f"messages of {topic.topic.name} with other joints left out: {list_names(others)}"
            self.notes.append(note("joints-left-out", what))

    def imu(self) -> None:
        """Gyroscope and accelerometer, turned into sensor axes where tf has the IMU."""
        topic = self._topic("imu")
        if topic is None:
            return
        frame = self._one_frame(topic, next(iter(topic.series))[0])[0]
        mounting = self._mounting_of_imu(topic.topic.name, frame)
        if mounting is None:
            return
        rotation, at_sensor = mounting
        self._note("imu", topic, frame)
        for what in ("gyroscope", "accelerometer") if at_sensor else ("gyroscope",):
            if any(key[0] == what for key in topic.series):
                series = self._one_frame(topic, what)[2]
                if rotation is not None:
                    series = series.with_values(rotation.apply(series.values))
                self._keep(what, series, topic, what)

    def _mounting_of_imu(
        self, name: str, frame: str
    ) -> tuple[Rotation | None, bool] | None:
        """Rotation from an IMU's axes to the sensor's, None for the same axes, and
        whether it is at the origin; None for an IMU that moves against the sensor."""
        if frame and frame == self.sensor:
            return None, True
        chain = []
        if self.sensor and {frame, self.sensor} <= self.tree.frames:
            chain = self._chain(self.sensor, frame)
        if any(not each.static for each, _ in chain):
            what = f"{name} left out: its frame {frame} moves against {self.sensor}"
            self._warn("imu-left-out", what)
            return None
        if not chain:
            what = f"nothing links frame '{frame}' of {name} to the sensor's: taken to be in the sensor's axes"
            self._warn("imu-frame-assumed", what)
            return None, True
        pose = compose(chain, str(self.path), self.warnings.append).values[0]
        distance = float(np.linalg.norm(pose[:3]))
        at_sensor = distance <= LEVER_ARM
        if not at_sensor:
            far = f"{1000 * distance:.0f} mm from the origin of {self.sensor}"
            what = f"accelerometer of {name} left out: it is {far}"
            self._warn("accelerometer-left-out", what)
        return Rotation.from_quat(pose[3:]), at_sensor

    def twist(self) -> None:
        """Velocities in world axes; from sensor axes by the orientation."""
        topic = self._topic("twist")
        if topic is None:
            return
        frame, _, series = self._one_frame(topic, "twist")
        series = self._tidy(series, topic)
        orientation = self.series.get("orientation")
        if (
            frame
            and frame == self.sensor
            and frame != self.world
            and orientation is not None
            and len(orientation) > 1
        ):
            padded = np.pad(orientation.values, ((0, 0), (3, 0)))
            turning = Link("", "", orientation.with_values(padded), False)
            series = series[turning.covers(series.time)]
            if len(series):
                rotation = turning.at(series.time)[1]
                turned = [
                    rotation.apply(series.values[:, part])
                    for part in (slice(0, 3), slice(3, 6))
                ]
                series = series.with_values(np.concatenate(turned, axis=1))
        elif not frame or frame != self.world:
            what = f"velocities of {topic.topic.name} left out: frame '{frame}' is not the world's"
            self._warn("velocities-left-out", what, "world_frame")
            return
        if not len(series):
            return
        self._note("velocities", topic, frame)
        for what, part in (
            ("linear_velocity", slice(0, 3)),
            ("angular_velocity", slice(3, 6)),
        ):
            self.series[what] = series.with_values(series.values[:, part])

    def _topic(self, role: str) -> Gathered | None:
        """The topic of a role (a key of `TYPES`), if any. Raises `InputError` for
        several topics of the role, or a named one without usable samples."""
        candidates = [
            topic for topic in self.gathered if topic.role == role and topic.series
        ]
        if len(candidates) > 1:
            or_none = "" if role == "wrench" else ", or none"
            fix = f"choose one with `{role}_topic`{or_none}"
            names = ", ".join(str(topic.topic) for topic in candidates)
            what = f"{len(candidates)} topics could be the {role}: {names}"
            raise InputError(what, self.path, fix)
        if candidates:
            return candidates[0]
        if self.named.get(role, "none") != "none":
            raise self._error_for_unusable_topic(role)
        return None

    def _error_for_unusable_topic(self, role: str) -> InputError:
        """The error that says why a named topic has no samples for its role."""
        kinds = " or ".join(kind.partition("/msg/")[2] for kind in TYPES[role])
        fix = f"name a topic of {kinds}, or export its numbers to CSV"
        topic = next((topic for topic in self.gathered if topic.role == role), None)
        if topic is None:
            what = f"topic {self.named[role]} cannot be the {role}, as another role has it already"
        elif not topic.messages:
            what = f"topic {topic.topic} has no messages"
        else:
            what = f"no {role} can be read from topic {topic.topic}"
        return InputError(what, self.path, fix)

    def _one_frame(self, topic: Gathered, what: str) -> tuple[str, str, Series]:
        """Frame, child frame and samples of a topic's quantity; `InputError` for several
        frames."""
        keys = sorted(
            (key for key in topic.series if key[0] == what),
            key=lambda key: topic.series[key].rows.min(),
        )
        if len(keys) > 1:
            k = 1 if keys[0][1] != keys[1][1] else 2
            raise InputError(
                f"the messages are in several frames: '{keys[0][k]}', then '{keys[1][k]}'",
                where=f"{self.path}, {topic.topic.name}, message {topic.series[keys[1]].rows.min()}",
                fix="record each frame on a topic of its own, or cut the bag",
            )
        return keys[0][1], keys[0][2], topic.series[keys[0]]

    def _tidy(self, series: Series, topic: Gathered, what: str | None = None) -> Series:
        name = topic.topic.name
        label, where = f"{name} ({what})" if what else name, f"{self.path}, {name}"
        return tidy(series, label, where, self.notes.append, self.warnings.append)

    def _keep(
        self, stream: str, series: Series, topic: Gathered, what: str | None = None
    ) -> None:
        series = self._tidy(series, topic, what)
        if len(series):
            self.series[stream] = series

    def _note(
        self, what: str, topic: Gathered, detail: str, kind: str = "frame "
    ) -> None:
        detail = f", {kind}{detail}" if detail else ""
        source = f"{what} from {topic.topic.name} ({topic.topic.type}{detail})"
        self.notes.append(note(f"{what}-source", source))

    def _warn(self, code: str, text: str, argument: str | None = None) -> None:
        self.warnings.append(warning(code, text, argument))
