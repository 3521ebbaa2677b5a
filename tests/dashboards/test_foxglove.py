"""An MCAP file for Foxglove: what independent readers find in it is what the library
says."""

from types import SimpleNamespace

import numpy as np
import pytest

from foxglove_files import START, held, numbers, read
from hefting.core.spatial import skew
from hefting.dashboards import replay_of, write_dashboard
from hefting.logs import read_log
from hefting.prediction import predict
from hefting.scene import headline_of

pytest.importorskip("foxglove")
pytest.importorskip("rosbags")


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
