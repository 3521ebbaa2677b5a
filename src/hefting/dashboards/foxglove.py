"""Foxglove: an MCAP file in Foxglove's own schemas, with the recording as ROS 2 messages.
Needs foxglove-sdk and rosbags."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from heapq import merge
from importlib import import_module
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from hefting import __version__
from hefting.core.errors import needing
from hefting.core.files import replacing
from hefting.core.messages import Message
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, interpolated
from hefting.dashboards import Dashboard, Replay
from hefting.logs.ros.writing import McapOutput, channel_of, serialise
from hefting.scene import headline_of

if TYPE_CHECKING:
    from foxglove import Context

    from hefting.dashboards.foxglove_scene import Entities
    from hefting.logs.ros.writing import Messages

ARROW_RATE = 30.0
"""[Hz] Largest rate of arrows: a screen shows no more."""
BLOCK = 10_000
"""Messages of a topic that are serialised at once."""
PARTS = {"force": slice(0, 3), "torque": slice(3, 6)}
LEVELS = {"note": "Info", "warning": "Warning", "error": "Error"}
"""Foxglove's log level of each severity."""
VERDICTS = {"good": "Info", "usable with care": "Warning", "do not use": "Error"}

Say = Callable[[str], str]
Line = tuple[int, Callable[..., None], Any]
"""A message: its time [ns], the function that sends it, and its content."""


def check() -> None:
    """`MissingDependencyError` unless the libraries that write the file are installed."""
    for module, name in (("foxglove", "foxglove-sdk"), ("rosbags", "rosbags")):
        with needing(name, "live"):
            import_module(module)


def write(replay: Replay, path: str | Path, say: Say) -> tuple[str, ...]:
    """Write a replay as an MCAP file, whole or not at all.

    Times are those of `hefting.logs.ros.writing`: the recording begins at 1 s. Messages
    are made one by one in the order of their times. Returns the names of the recording's
    streams that no message holds.
    """
    from hefting.logs.ros.writing import messages_of, streams_of

    logged = list(messages_of(replay.recording))
    with replacing(path) as stream, _writer(stream) as context:
        sources = [
            *_recorded_lines(logged, context),
            _frame_lines(replay.recording, context),
            _scene_lines(replay, context),
            *_arrow_lines(replay, context),
            _log_lines(replay, context, say),
            *_curve_lines(replay, context),
        ]
        for stamp, send, message in merge(*sources, key=itemgetter(0)):
            send(message, log_time=stamp)
    # /tf holds positions even if no ROS message of the recording does
    written = {"position", *(name for group in logged for name in streams_of(group))}
    return tuple(name for name in replay.recording.streams if name not in written)


@contextmanager
def _writer(stream: BinaryIO) -> "Iterator[Context]":
    """A context whose channels are written to a stream; `OSError` if that fails."""
    from foxglove import Context, open_mcap
    from foxglove.mcap import MCAPWriteOptions

    context, output = Context(), McapOutput(stream)
    options = MCAPWriteOptions(compression_threads=0)
    with open_mcap(output, context=context, writer_options=options) as writer:
        yield context
        writer.write_metadata("hefting", {"version": __version__})
    if output.error is not None:
        raise output.error


def _stamps(recording: Recording, time: Array) -> NDArray[np.int64]:
    from hefting.logs.ros.writing import EPOCH

    stamps = EPOCH + np.rint((time - recording.start) * 1e9).astype(np.int64)
    return np.maximum(stamps, 0)


def _recorded_lines(
    groups: "list[Messages]", context: "Context"
) -> list[Iterator[Line]]:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    channels: dict[str, Any] = {}
    for group in groups:
        if group.topic not in channels:
            channels[group.topic] = channel_of(group, store, context)
    return [_rows(group, store, channels[group.topic].log) for group in groups]


def _rows(group: "Messages", store: Any, send: Callable[..., None]) -> Iterator[Line]:
    for first in range(0, len(group.time), BLOCK):
        part = slice(first, first + BLOCK)
        fields = {name: values[part] for name, values in group.fields.items()}
        block = replace(group, time=group.time[part], fields=fields)
        rows = serialise(block, store, "cdr")
        for stamp, row in zip(block.time.tolist(), rows, strict=True):
            yield stamp, send, row.tobytes()


def _frame_lines(recording: Recording, context: "Context") -> Iterator[Line]:
    """The sensor's frame in the world, at its origin if no position is recorded."""
    from foxglove.channels import FrameTransformsChannel
    from foxglove.messages import FrameTransform, FrameTransforms

    from hefting.dashboards.foxglove_scene import quaternion, timestamp, vector3
    from hefting.logs.ros.streams import SENSOR, WORLD

    channel = FrameTransformsChannel("/tf", context=context)
    turned = recording["orientation"]
    at = np.zeros((len(turned), 3))
    if recording.has("position"):
        place = recording["position"]
        at = interpolated(turned.time, place.time, place.values)
    for k, stamp in enumerate(_stamps(recording, turned.time).tolist()):
        frame = FrameTransform(
            timestamp=timestamp(stamp),
            parent_frame_id=WORLD,
            child_frame_id=SENSOR,
            translation=vector3(at[k]),
            rotation=quaternion(turned.values[k]),
        )
        yield stamp, channel.log, FrameTransforms(transforms=[frame])


def _scene_lines(replay: Replay, context: "Context") -> Iterator[Line]:
    """The object, once, in the moving frame of the sensor."""
    from foxglove.channels import PointCloudChannel, SceneUpdateChannel

    entities = _entities(replay)
    start = _start(replay.recording)
    for topic, kind, message in (
        ("/object/shape", SceneUpdateChannel, entities.shape(start)),
        ("/object/points", PointCloudChannel, entities.points(start)),
        ("/object/com", SceneUpdateChannel, entities.center(start)),
        ("/object/inertia", SceneUpdateChannel, entities.inertia(start)),
    ):
        if message is not None:
            yield start, kind(topic, context=context).log, message


def _arrow_lines(replay: Replay, context: "Context") -> list[Iterator[Line]]:
    """Arrows of the forces, at most at `ARROW_RATE`."""
    from foxglove.channels import SceneUpdateChannel

    from hefting.dashboards.foxglove_scene import COLOURS

    entities = _entities(replay)
    curves = {name: c for name, c in replay.curves.items() if name in COLOURS}
    largest = max(
        float(np.linalg.norm(curve.values[:, :3], axis=1).max())
        for curve in curves.values()
    )

    def lines(name: str, curve: Stream, channel: Any) -> Iterator[Line]:
        tick = np.floor((curve.time - curve.time[0]) * ARROW_RATE)
        _, shown = np.unique(tick, return_index=True)
        stamps = _stamps(replay.recording, curve.time[shown]).tolist()
        for k, stamp in zip(shown.tolist(), stamps, strict=True):
            force = curve.values[k, :3]
            yield stamp, channel.log, entities.force(stamp, name, force, largest)

    return [
        lines(name, own, SceneUpdateChannel(f"/object/{name}_force", context=context))
        for name, own in curves.items()
    ]


def _curve_lines(replay: Replay, context: "Context") -> list[Iterator[Line]]:
    from foxglove.channels import Vector3Channel

    from hefting.dashboards.foxglove_scene import vector3

    def lines(curve: Stream, topic: str, part: slice) -> Iterator[Line]:
        send = Vector3Channel(topic, context=context).log
        stamps = _stamps(replay.recording, curve.time).tolist()
        for stamp, row in zip(stamps, curve.values[:, part], strict=True):
            yield stamp, send, vector3(row)

    return [
        lines(curve, f"/{name}/{part}", columns)
        for name, curve in replay.curves.items()
        for part, columns in PARTS.items()
    ]


def _log_lines(replay: Replay, context: "Context", say: Say) -> Iterator[Line]:
    from foxglove.channels import LogChannel
    from foxglove.messages import Log, LogLevel

    from hefting.dashboards.foxglove_scene import timestamp

    start, verdict = _start(replay.recording), replay.estimate.verdict
    send = LogChannel("/log", context=context).log
    headline = headline_of(replay.estimate)
    entries = [(VERDICTS[verdict.level], "verdict", headline.verdict)]
    entries += [("Info", "estimate", text) for text in headline.numbers]
    for text in replay.warnings:
        code = text.code if isinstance(text, Message) else "warning"
        severity = text.severity if isinstance(text, Message) else "warning"
        entries.append((LEVELS[severity], code, say(text)))
    for level, name, text in entries:
        message = Log(
            timestamp=timestamp(start),
            level=getattr(LogLevel, level),
            name=name,
            message=text,
        )
        yield start, send, message


def _entities(replay: Replay) -> "Entities":
    from hefting.dashboards.foxglove_scene import Entities
    from hefting.logs.ros.streams import SENSOR

    headline = headline_of(replay.estimate)
    facts = [("verdict", str(replay.estimate.verdict))]
    facts += zip(("mass", "COM", "inertia"), headline.numbers, strict=True)
    return Entities(replay.scene, SENSOR, facts)


def _start(recording: Recording) -> int:
    return int(_stamps(recording, np.array((recording.start,)))[0])


DASHBOARD = Dashboard(name="Foxglove", suffixes=(".mcap",), check=check, write=write)
"""For Foxglove, and other programs that read its schemas."""
