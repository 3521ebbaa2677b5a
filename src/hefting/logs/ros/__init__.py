"""ROS 1 bags, ROS 2 bags and MCAP files as recordings: topics are found by the type of
their messages."""

from pathlib import Path

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording, Stream
from hefting.logs.ros.containers import Contents, read_messages
from hefting.logs.ros.frames import list_names
from hefting.logs.ros.messages import Collector, Gathered, same_name, without_slashes
from hefting.logs.ros.streams import Streams

__all__ = ["read_bag"]


def read_bag(
    path: str | Path,
    wrench_topic: str | None = None,
    pose_topic: str | None = None,
    twist_topic: str | None = None,
    joint_topic: str | None = None,
    imu_topic: str | None = None,
    world_frame: str | None = None,
    sensor_frame: str | None = None,
    *,
    wrench_needed: bool = True,
) -> Recording:
    """Recording in a ROS 1 bag (.bag), a ROS 2 bag (folder or .db3) or an MCAP file
    with ROS messages.

    Read are WrenchStamped and Wrench; PoseStamped, PoseWithCovarianceStamped,
    TransformStamped, QuaternionStamped, Odometry and tf; TwistStamped; JointState; Imu.
    The sensor frame is by default the one the wrench names, the world frame the root of
    the tf tree above it; without tf a pose topic gives both. A topic option names a
    topic, also one of another type that holds the same fields and whose definition is
    in the bag, or is "none" to leave that role out. Times are the messages' stamps,
    shifted to start at 0; rows are messages of a topic from 1.

    What was chosen is in `Recording.notes`, what is doubtful in `Recording.warnings`:
    also that a truncated file was read as far as it goes. Raises `InputError` for what
    cannot be read without guessing, such as two candidates for one role or a frame that
    changes, and `MissingDependencyError` without rosbags.
    """
    path = Path(path)
    roles = ("wrench", "pose", "twist", "joint", "imu")
    topics = (wrench_topic, pose_topic, twist_topic, joint_topic, imu_topic)
    named = {role: name for role, name in zip(roles, topics, strict=True) if name}
    contents = Contents(path)
    collector = _collect(contents, named)
    gathered = list(collector.finish().values())
    if contents.cuts and not collector.span:
        what = f"{', '.join(contents.cuts)}: nothing can be read"
        raise InputError(what, path, "record it again, or repair it")
    _check_named(contents, named)
    frames = without_slashes(world_frame), without_slashes(sensor_frame)
    streams = Streams(path, gathered, named, *frames)
    # what is not finite in the end is refused by name
    with np.errstate(over="ignore", invalid="ignore"):
        streams.build()
    warnings = _warn_about_unreadable(gathered)
    silent = [
        f"topic {topic.topic.name} has no messages"
        for topic in gathered
        if not topic.messages
    ]
    _check_streams(
        streams, contents, (*contents.cuts, *warnings, *silent), wrench_needed
    )
    if contents.cuts:
        whole = f" of {contents.expected:.2f} s" if contents.expected else ""
        first, last = collector.span or (0, 0)
        lasts = (last - first) / 1e9
        what = f"{', '.join(contents.cuts)}: read up to {lasts:.2f} s{whole}"
        warnings.insert(0, warning("bag-truncated", what))
    return _build_recording(streams, warnings)


def _collect(contents: Contents, named: dict[str, str]) -> Collector:
    collector = Collector(contents.path, named)
    try:
        for topic, logged, data in read_messages(contents, collector.wants):
            collector.add(topic, logged, data)
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror or error})", where=contents.path
        ) from error
    return collector


def _check_named(contents: Contents, named: dict[str, str]) -> None:
    present = [topic.name for topic in contents.topics]
    for role, name in named.items():
        if name != "none" and not any(same_name(name, other) for other in present):
            what = f"there is no topic '{name}'{nearest(name, present)}"
            fix = f"give `{role}_topic` one of {_list_topics(contents)}"
            raise InputError(what, where=contents.path, fix=fix)


def _warn_about_unreadable(gathered: list[Gathered]) -> list[Message]:
    """A warning for each topic some messages of which could not be read."""
    return [
        warning(
            "messages-unreadable",
            f"{each.unreadable} of {each.messages} messages of {each.topic.name} do not "
            "fit their definition: left out",
        )
        for each in gathered
        if each.unreadable
    ]


def _check_streams(
    streams: Streams, contents: Contents, reasons: tuple[str, ...], wrench_needed: bool
) -> None:
    """`InputError`, with possible `reasons`, where a required stream is absent."""
    cut = "".join(f"{reason}, and " for reason in reasons)
    if wrench_needed and "wrench" not in streams.series:
        what = f"{cut}holds no wrench, only {_list_topics(contents)}"
        fix = "name its topic with `wrench_topic`, or export messages of other types to CSV"
        raise InputError(what, contents.path, fix)
    if not {"orientation", "joint_positions"} & set(streams.series):
        fix = streams.hint or (
            "name the topic of a pose with `pose_topic`, or record tf, PoseStamped or "
            "JointState along with it"
        )
        what = f"{cut}holds no orientation and no joint positions, only {_list_topics(contents)}"
        raise InputError(what, contents.path, fix)


def _list_topics(contents: Contents) -> str:
    return list_names([str(topic) for topic in contents.topics]) or "no topics"


def _build_recording(streams: Streams, warnings: list[Message]) -> Recording:
    """The recording of the streams that overlap the wrench, if any, in time; others are
    left out with a warning, except that poses and joints are an error."""
    series = streams.series
    wrench = series.get("wrench")
    for name in list(series):
        own = series[name]
        if wrench is None or (
            own.time[0] <= wrench.time[-1] and wrench.time[0] <= own.time[-1]
        ):
            continue
        stamps = f"stamps {_describe_span(own)} and {_describe_span(wrench)}"
        apart = f"{name.replace('_', ' ')} and wrench have no time in common ({stamps})"
        if name in ("orientation", "joint_positions"):
            raise InputError(apart, streams.path, "stamp both with one clock")
        streams.warnings.append(warning("stream-left-out", f"{apart}: left out"))
        del series[name]
    start = min(own.time[0] for own in series.values())
    return Recording(
        {
            name: Stream((own.time - start) / 1e9, own.values, own.rows)
            for name, own in series.items()
        },
        source=str(streams.path),
        warnings=(*warnings, *streams.warnings),
        notes=tuple(streams.notes),
        joint_names=streams.joint_names
        if any("joint" in name for name in series)
        else (),
    )


def _describe_span(series) -> str:
    return f"{series.time[0] * 1e-9:.3f} to {series.time[-1] * 1e-9:.3f} s"
