"""An MCAP file for Foxglove: what independent readers find in it is what the library
says."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from commands import refused
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import skew
from hefting.dashboards import foxglove, replay_of, write_dashboard
from hefting.identification import identify
from hefting.logs import read_log, write_log
from hefting.prediction import predict
from hefting.scene import headline_of
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids

pytest.importorskip("foxglove")
pytest.importorskip("rosbags")
mcap = pytest.importorskip("mcap.reader")
mcap_protobuf = pytest.importorskip("mcap_protobuf.decoder")

POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
START = 1_000_000_000
"""Time of a recording's first sample in the file [ns]."""


def held():
    """A log of a hammer with bias, what was found from it, and the hammer's shape."""
    tool = hammer()
    log = simulate(
        UR5.motion(sinusoids(5.0, 100.0, 1.5)),
        tool.parameters.moved(POSE),
        bias=(3.0, -2.0, 5.0, 0.1, 0.2, -0.1),
        pose_noise=(1e-4, 3.5e-4),
        seed=3,
    )
    shape = Shape.from_mesh(tool.mesh(), pose=POSE)
    return log, identify(log, shape).estimate, shape


def read(path):
    """Schema names by topic, and (time [ns], message) of each topic in Foxglove's own
    schemas."""
    with open(path, "rb") as file:
        reader = mcap.make_reader(
            file, decoder_factories=[mcap_protobuf.DecoderFactory()]
        )
        summary = reader.get_summary()
        names = {
            c.topic: summary.schemas[c.schema_id].name
            for c in summary.channels.values()
        }
        own = [topic for topic, name in names.items() if name.startswith("foxglove.")]
        found = {topic: [] for topic in own}
        for _, channel, raw, message in reader.iter_decoded_messages(topics=own):
            found[channel.topic].append((raw.log_time, message))
        whole = summary.statistics
    return SimpleNamespace(names=names, topics=found, statistics=whole)


def numbers(values, names="xyz"):
    return np.array([getattr(values, name) for name in names])


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The hammer's log with what was found, as a file and as read again."""
    log, estimate, shape = held()
    replay = replay_of(log, estimate, shape)
    path = tmp_path_factory.mktemp("foxglove") / "out.mcap"
    assert write_dashboard(replay, path) == ()
    return SimpleNamespace(log=log, replay=replay, path=path, found=read(path))


def test_schemas_are_foxgloves_and_the_logs_are_those_of_ros(written):
    assert written.found.names == {
        "/wrench": "geometry_msgs/msg/WrenchStamped",
        "/pose": "geometry_msgs/msg/PoseStamped",
        "/tf": "foxglove.FrameTransforms",
        "/object/shape": "foxglove.SceneUpdate",
        "/object/com": "foxglove.SceneUpdate",
        "/object/inertia": "foxglove.SceneUpdate",
        "/object/measured_force": "foxglove.SceneUpdate",
        "/object/predicted_force": "foxglove.SceneUpdate",
        "/log": "foxglove.Log",
        **{
            f"/{name}/{part}": "foxglove.Vector3"
            for name in ("measured", "predicted", "residual")
            for part in ("force", "torque")
        },
    }


def test_the_bag_reader_gives_the_recording_back(written):
    again = read_log(written.path)
    assert set(again.streams) == set(written.log.streams)
    for name, stream in written.log.streams.items():
        np.testing.assert_array_equal(again[name].values, stream.values)
        # times are whole nanoseconds
        np.testing.assert_allclose(again[name].time, stream.time, rtol=0, atol=1e-9)


def test_wrenches_are_those_of_the_library(written):
    """Each sample at its own time, bit by bit."""
    estimate = written.replay.estimate
    prediction = predict(estimate, written.log, gravity=estimate.provenance["gravity"])
    agreed = prediction.agreement
    for name, time, wrench in (
        ("predicted", prediction.time, prediction.wrench),
        ("measured", agreed.time, agreed.wrench),
        ("residual", agreed.time, agreed.difference),
    ):
        for part, columns in (("force", slice(0, 3)), ("torque", slice(3, 6))):
            sent = written.found.topics[f"/{name}/{part}"]
            values = np.array([numbers(message) for _, message in sent])
            np.testing.assert_array_equal(values, wrench[:, columns])
            stamps = 1e-9 * (np.array([stamp for stamp, _ in sent]) - START)
            np.testing.assert_allclose(
                stamps, time - written.log.start, rtol=0, atol=1e-9
            )
    # the bias is 5 N: nothing of it is left
    assert np.abs(agreed.difference.mean(axis=0)).max() < 0.1


def test_frames_are_the_poses(written):
    sent = written.found.topics["/tf"]
    frames = [message.transforms[0] for _, message in sent]
    assert {(f.parent_frame_id, f.child_frame_id) for f in frames} == {
        ("world", "sensor")
    }
    for f, k in zip(frames, range(len(frames)), strict=True):
        np.testing.assert_array_equal(
            numbers(f.translation), written.log["position"].values[k]
        )
        np.testing.assert_array_equal(
            numbers(f.rotation, "xyzw"), written.log["orientation"].values[k]
        )
    assert all(
        f.timestamp.ToNanoseconds() == t for f, (t, _) in zip(frames, sent, strict=True)
    )


def rotation(q):
    """Rotation matrix of a quaternion, w last, by Rodrigues' formula."""
    x, y, z, w = q
    u = skew(np.array((x, y, z)))
    return np.eye(3) + 2.0 * (w * u + u @ u)


def entities(written, topic):
    ((stamp, message),) = written.found.topics[topic]
    assert stamp == START
    assert all(e.frame_id == "sensor" and e.frame_locked for e in message.entities)
    return {e.id: e for e in message.entities}


def on_surface(sphere, points):
    """Distance of points (n, 3) from an ellipsoid's center over that of its surface."""
    turn = rotation(numbers(sphere.pose.orientation, "xyzw"))
    own = (points - numbers(sphere.pose.position)) @ turn
    return np.linalg.norm(own / (0.5 * numbers(sphere.size)), axis=1)


def test_ellipsoids_are_those_of_the_scene(written):
    (body,) = written.replay.scene.bodies
    u = np.random.default_rng(1).normal(size=(200, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    parts = entities(written, "/object/com") | entities(written, "/object/inertia")
    for name, ellipsoid in (
        ("95 % region of the COM", body.region),
        ("uniform ellipsoid of equal inertia", body.ellipsoid),
    ):
        (sphere,) = parts[name].spheres
        points = ellipsoid.center + u @ ellipsoid.half_axes.T
        np.testing.assert_allclose(on_surface(sphere, points), 1.0, rtol=1e-9)
    (mark,) = parts["COM"].spheres
    np.testing.assert_array_equal(numbers(mark.pose.position), body.center)
    lines = headline_of(written.replay.estimate).numbers
    facts = {pair.key: pair.value for pair in parts["COM"].metadata}
    assert facts == {
        "verdict": written.replay.estimate.verdict.level,
        **dict(zip(("mass", "COM", "inertia"), lines, strict=True)),
    }


def test_the_mesh_is_that_of_the_scene(written):
    (triangles,) = entities(written, "/object/shape")["shape"].triangles
    surface = written.replay.scene.surface
    points = np.array([numbers(point) for point in triangles.points])
    np.testing.assert_array_equal(points, surface.vertices)
    np.testing.assert_array_equal(np.reshape(triangles.indices, (-1, 3)), surface.faces)


def test_arrows_point_along_the_force_at_a_rate_for_eyes(written):
    a = written.replay.prediction.agreement
    sent = written.found.topics["/object/measured_force"]
    assert len(sent) <= 30 * 5.0 + 1
    scales = []
    for stamp, message in sent:
        (arrow,) = message.entities[0].arrows
        k = int(np.argmin(np.abs(a.time - written.log.start - 1e-9 * (stamp - START))))
        turn = rotation(numbers(arrow.pose.orientation, "xyzw"))
        length = np.linalg.norm(a.wrench[k, :3])
        np.testing.assert_allclose(turn[:, 0], a.wrench[k, :3] / length, atol=1e-9)
        scales.append((arrow.shaft_length + arrow.head_length) / length)
    np.testing.assert_allclose(scales, scales[0], rtol=1e-9)


@pytest.mark.parametrize(
    "direction", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, -2), (-1, 1e-12, 0)]
)
def test_an_arrow_in_any_direction(direction):
    from hefting.dashboards.foxglove_scene import _turn_to

    direction = np.array(direction, dtype=float)
    turn = rotation(_turn_to(direction))
    np.testing.assert_allclose(
        turn[:, 0], direction / np.linalg.norm(direction), atol=1e-9
    )
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)


def test_verdict_numbers_and_warnings_are_logged(written):
    said = [message for _, message in written.found.topics["/log"]]
    estimate = written.replay.estimate
    assert (said[0].name, said[0].message) == (
        "verdict",
        headline_of(estimate).verdict,
    )
    assert [m.message for m in said[1:4]] == list(headline_of(estimate).numbers)
    assert [m.message for m in said[4:]] == list(written.replay.warnings)


def test_what_is_open_is_not_drawn_and_errors_are_errors(tmp_path):
    """The COM along one axis, and a message that makes the answer wrong."""
    log, estimate, _ = held()
    intervals = {k: np.array(v) for k, v in estimate.intervals.items()}
    intervals["center_of_mass"][:, 2] = -np.inf, np.inf
    intervals["inertia_at_com"][0], intervals["inertia_at_com"][1] = -np.inf, np.inf
    wrong = Message("no-object", "nothing is held: see `tool`", "error", "tool")
    doubtful = Estimate(
        method="LMI",
        parameters=estimate.parameters,
        samples=3,
        intervals=intervals,
        warnings=(wrong,),
    )
    box = Shape.from_box(-0.1, 0.1, -0.2, 0.2, 0.0, 0.1)
    replay = replay_of(log, doubtful, box)
    write_dashboard(replay, tmp_path / "a.mcap", lambda text: text.replace("`", "*"))
    found = read(tmp_path / "a.mcap")
    assert not {"/object/com", "/object/inertia"} & set(found.names)
    ((_, shape),) = found.topics["/object/shape"]
    (cube,) = shape.entities[0].cubes
    np.testing.assert_allclose(numbers(cube.size), (0.2, 0.4, 0.1), rtol=1e-12)
    np.testing.assert_allclose(numbers(cube.pose.position), (0, 0, 0.05), atol=1e-15)
    said = [m for _, m in found.topics["/log"]]
    assert said[0].level == 4  # foxglove.Log: ERROR
    (own,) = [m for m in said if m.name == "no-object"]
    assert (own.level, own.message) == (4, "nothing is held: see *tool*")


def test_points_of_a_cloud(tmp_path):
    log, estimate, _ = held()
    points = np.random.default_rng(2).uniform(-0.1, 0.1, (50, 3))
    replay = replay_of(log, estimate, Shape(points))
    write_dashboard(replay, tmp_path / "a.mcap")
    ((_, cloud),) = read(tmp_path / "a.mcap").topics["/object/points"]
    sent = np.frombuffer(cloud.data, "<f4").reshape(-1, cloud.point_stride // 4)
    np.testing.assert_array_equal(sent, points.astype("<f4"))


def test_orientation_alone_and_streams_without_a_message(tmp_path):
    log, estimate, _ = held()
    streams = dict(log.streams)
    time = streams.pop("position").time
    streams["linear_accelerometer"] = Stream(time, np.zeros((len(time), 3)))
    log = Recording(streams)
    replay = replay_of(log, estimate)
    lost = write_dashboard(replay, tmp_path / "a.mcap")
    assert lost == ("linear_accelerometer",)
    again = read_log(tmp_path / "a.mcap")
    np.testing.assert_array_equal(
        again["orientation"].values, log["orientation"].values
    )


def test_a_motion_without_a_wrench_has_what_is_predicted(tmp_path):
    log, estimate, _ = held()
    plan = Recording({n: s for n, s in log.streams.items() if n != "wrench"})
    write_dashboard(replay_of(plan, estimate), tmp_path / "a.mcap")
    names = read(tmp_path / "a.mcap").names
    assert "/predicted/force" in names
    assert not {"/wrench", "/measured/force", "/residual/force"} & set(names)


def test_whole_or_not_at_all(written, tmp_path, monkeypatch, capfd):
    """A disk that fills leaves what was there, and one line."""
    path = tmp_path / "a.mcap"
    path.write_bytes(b"old")

    class Full(foxglove._Output):
        def __init__(self, stream):
            super().__init__(stream)
            self._stream = self

        def write(self, data):
            if self.error is None:
                self.error = OSError(28, "No space left on device")
            return len(data)

        def seek(self, offset, whence=0):
            return 0

    monkeypatch.setattr(foxglove, "_Output", Full)
    with pytest.raises(InputError, match="cannot be written") as caught:
        write_dashboard(written.replay, path)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap"]
    assert capfd.readouterr().err == ""


def test_errors_of_the_file_are_kept_and_not_repeated():
    class Stream:
        writes = 0

        def write(self, data):
            self.writes += 1
            raise OSError(28, "No space left on device")

    stream = Stream()
    output = foxglove._Output(stream)
    assert [output.write(b"abc"), output.write(b"ab")] == [3, 2]
    assert stream.writes == 1
    assert output.error.errno == 28


def test_without_the_library_one_line_says_what_to_install(
    written, tmp_path, monkeypatch
):
    for module in ("foxglove", "rosbags"):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, module, None)
            with pytest.raises(MissingDependencyError, match=r"hefting\[live\]"):
                write_dashboard(written.replay, tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())


def test_static_poses_are_refused():
    log, estimate, _ = held()
    few = {
        name: Stream(np.arange(5.0), log[name].values[:5])
        for name in ("orientation", "wrench")
    }
    with pytest.raises(InputError, match="static poses have no times"):
        replay_of(Recording(few, static=True), estimate)


def test_gravity_is_that_of_the_estimate(written):
    """And any nonsense in an estimate's file is passed over."""
    from dataclasses import replace

    gravity = np.array((0.5, 0.0, -9.7))
    estimate = written.replay.estimate
    for said, used in (
        (gravity.tolist(), gravity),
        ("down", (0.0, 0.0, -9.80665)),
        ([0.0, 0.0, 0.0], (0.0, 0.0, -9.80665)),
        ({"x": 1}, (0.0, 0.0, -9.80665)),
    ):
        provenance = {**estimate.provenance, "gravity": said}
        changed = replace(estimate, provenance=provenance)
        found = replay_of(written.log, changed).prediction.gravity
        np.testing.assert_array_equal(found, used)


def test_the_command(run, tmp_path):
    log, estimate, _ = held()
    write_log(log, tmp_path / "log.csv")
    estimate.save(tmp_path / "hammer.json")
    box = "box:-0.05,0.05,-0.1,0.3,0,0.15"
    words = ["convert", tmp_path / "log.csv", tmp_path / "out.mcap"]
    status, out, err = run(
        *words, "--with", tmp_path / "hammer.json", "--shape", box, "--start", "1"
    )
    assert (status, err) == (0, "")
    assert f"verdict of {tmp_path / 'hammer.json'}: good" in out
    assert out.splitlines()[-1] == f"wrote {tmp_path / 'out.mcap'}"
    found = read(tmp_path / "out.mcap")
    assert found.topics["/object/shape"]
    assert len(found.topics["/tf"]) == len(log.slice(1.0)["orientation"])
    assert refused(run(*words, "--shape", box), "--shape: is for --with")
    assert refused(
        run(*words[:2], tmp_path / "out.csv", "--with", tmp_path / "hammer.json"),
        "'.csv' cannot hold an estimate",
        "use .mcap",
    )
    assert refused(
        run(*words[:2], tmp_path / "log.mcap", "--with", tmp_path / "log.csv"),
        "is not JSON",
    )
    assert refused(run("convert", "-", "a.mcap", "--with", "-"), "--with -")
