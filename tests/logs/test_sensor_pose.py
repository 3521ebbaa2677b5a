"""The sensor in the logged frame."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.messages import warning
from hefting.core.quantity import turned_about
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import pose_matrix
from hefting.logs import read_log
from hefting.logs.orientations import with_sensor_pose
from hefting.simulation import UR5, hammer, random_smooth, simulate


@pytest.fixture(scope="module")
def recording():
    motion = UR5.motion(random_smooth(2.0, 100.0, 1.0, seed=1))
    return simulate(motion, hammer().parameters, seed=1)


def test_poses_are_composed(recording):
    """T_world,sensor = T_world,log T_log,sensor, by homogeneous matrices."""
    pose = pose_matrix((0.01, -0.02, 0.05, *Rotation.from_euler("y", 0.4).as_quat()))
    found = with_sensor_pose(recording, pose)
    for k in (0, 57, 199):
        logged = pose_matrix(
            (
                *recording["position"].values[k],
                *recording["orientation"].values[k],
            )
        )
        seen = pose_matrix(
            (*found["position"].values[k], *found["orientation"].values[k])
        )
        np.testing.assert_allclose(seen, logged @ pose, atol=1e-12)
    assert found["wrench"] is recording["wrench"]


def test_where_the_sensor_is_answers_whose_poses_they_are(recording):
    said = warning("pose-frame-assumed", "whose?"), warning("rows-lost", "some"), "old"
    own = replace(recording, warnings=said)
    assert with_sensor_pose(own, np.eye(4)).warnings == said[1:]


def test_positions_of_another_clock_are_moved_at_their_own_times(recording):
    """Half as many positions, between the orientations; to the turn's second order."""
    position = recording["position"]
    times = 0.5 * (position.time[:-1] + position.time[1:])[::2]
    values = 0.5 * (position.values[:-1] + position.values[1:])[::2]
    other = Recording(
        {**recording.streams, "position": Stream(times, values)}, source="two clocks"
    )
    pose = pose_matrix((0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    found = with_sensor_pose(other, pose)["position"].values - values
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 0.1, atol=1e-12)
    axes = Rotation.from_quat(np.array(recording["orientation"].values))
    middle = 0.5 * (axes.apply((0.1, 0, 0))[:-1] + axes.apply((0.1, 0, 0))[1:])[::2]
    np.testing.assert_allclose(found, middle, atol=1e-4)


def test_logged_velocities_of_another_point_are_dropped(recording):
    n = len(recording["position"])
    moving = {
        name: Stream(recording["position"].time, np.zeros((n, 3)))
        for name in ("linear_velocity", "linear_acceleration", "angular_velocity")
    }
    logged = Recording({**recording.streams, **moving})
    elsewhere = pose_matrix((0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    kept = with_sensor_pose(logged, elsewhere)
    assert not kept.has("linear_velocity")
    assert not kept.has("linear_acceleration")
    assert kept.has("angular_velocity")
    assert with_sensor_pose(logged, turned_about("z:45")).has("linear_velocity")


def test_a_pose_in_millimetres_is_refused(recording):
    with pytest.raises(InputError, match=r"54\.8 m from the logged frame"):
        with_sensor_pose(recording, pose_matrix((10, -20, 50, 0, 0, 0, 1)))


@pytest.mark.parametrize("text", ["", "z", "w:3", "z:", "z:nan", "z:1e9", "z:45:3"])
def test_what_is_no_turn(text):
    with pytest.raises(InputError, match="z:45"):
        turned_about(text)


def test_in_a_column_map(tmp_path, recording):
    from hefting.logs import write_log

    log, toml = tmp_path / "log.csv", tmp_path / "map.toml"
    write_log(recording, log)
    columns = {
        "position": ["px", "py", "pz"],
        "orientation": ["qx", "qy", "qz", "qw"],
        "wrench": ["fx", "fy", "fz", "tx", "ty", "tz"],
    }
    text = 'time = "time"\n' + "".join(f"{k} = {v}\n" for k, v in columns.items())
    toml.write_text(text + 'sensor_turned = "z:45"\n')
    turned = with_sensor_pose(recording, turned_about("z:45"))["orientation"].values
    found = read_log(log, toml)["orientation"].values
    np.testing.assert_allclose(np.abs(np.sum(found * turned, axis=1)), 1.0, atol=1e-9)
    toml.write_text(text + "sensor_pose_in_log = [0, 0, 0.05, 0, 0, 0, 1]\n")
    moved = read_log(log, toml)["position"].values - recording["position"].values
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 0.05, atol=1e-9)
    toml.write_text(text + "sensor_pose_in_log = [0, 0, 0.05]\n")
    with pytest.raises(InputError, match="sensor_pose_in_log"):
        read_log(log, toml)
    toml.write_text(
        text + 'sensor_turned = "z:45"\nsensor_pose_in_log = [0, 0, 0, 0, 0, 0, 1]\n'
    )
    with pytest.raises(InputError, match="one of them"):
        read_log(log, toml)
