"""Archives of NumPy's arrays are read as the same arrays in memory, and nothing in them
is unpickled."""

import io
import zipfile

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from scipy.spatial.transform import Rotation

from hefting.cli import render
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS
from hefting.logs import read_log, windows
from hefting.logs.given import as_recording
from hefting.logs.memory_table import MemoryTable
from hefting.logs.registry import find_format
from hefting.simulation import UR5, simulate, sinusoids


@pytest.fixture(scope="module")
def arrays():
    """Times (K,), poses (K, 4, 4) and wrenches (K, 6) of a motion."""
    body = InertialParameters.from_com(1.2, (0.01, -0.02, 0.08), 2e-3 * np.eye(3))
    motion = UR5.motion(sinusoids(4.0, 20.0, 1.0))
    log = simulate(motion, body, noise=NOISE_LEVELS["low"])
    pose = np.tile(np.eye(4), (len(log["wrench"]), 1, 1))
    pose[:, :3, :3] = Rotation.from_quat(log["orientation"].values).as_matrix()
    pose[:, :3, 3] = log["position"].values
    return log["wrench"].time, pose, log["wrench"].values


def same(first, second):
    """Whether two recordings hold the same samples."""
    assert list(first.streams) == list(second.streams)
    for name, stream in first.streams.items():
        np.testing.assert_array_equal(second[name].time, stream.time)
        np.testing.assert_allclose(second[name].values, stream.values, atol=1e-12)
    return True


def test_arrays_by_the_names_of_streams(arrays, tmp_path):
    time, pose, wrench = arrays
    path = tmp_path / "log.npz"
    np.savez(path, time=time, pose=pose, wrench=wrench[::2], wrench_time=time[::2])
    found = read_log(path)
    assert found.source == str(path)
    assert found.warnings == ()
    assert same(
        found,
        as_recording(time=time, pose=pose, wrench=wrench[::2], wrench_time=time[::2]),
    )
    np.savez(path, time=time, pose=pose, wrench=wrench, tool="gripper")
    assert [m.code for m in read_log(path).warnings] == []
    np.savez(path, time=time, pose=pose, wrench=wrench[:-1])
    with pytest.raises(InputError, match=rf"^{path}: wrench has") as refused:
        read_log(path)
    assert "give `wrench_time`" in str(refused.value)


@pytest.mark.parametrize("kind", ["O", "S", "c16"])
@pytest.mark.parametrize("name", ["time", "t", "wrench"])
def test_an_array_that_cannot_be_read_is_not_passed_over(arrays, tmp_path, name, kind):
    """Without its time, each row would be a static pose."""
    time, pose, wrench = arrays
    given = {"time": time, "pose": pose, "wrench": wrench}
    if name == "t":
        given["t"] = given.pop("time")
    given[name] = given[name].astype(kind)
    np.savez(tmp_path / "log.npz", **given)
    kind = {"O": "(Python objects|text)", "S": "S", "c16": "complex128"}[kind]
    with pytest.raises(InputError, match=f"'{name}'.* holds .*{kind}") as refused:
        read_log(tmp_path / "log.npz")
    assert "--wrench" not in render(str(refused.value))


def test_arrays_that_are_not_read_are_named(arrays, tmp_path):
    time, pose, wrench = arrays
    given = {"time": time, "pose": pose, "wrench": wrench}
    labels, images = np.full(len(time), "up"), np.zeros((len(time), 40, 40))
    np.savez(tmp_path / "log.npz", **given, labels=labels, images=images)
    found = read_log(tmp_path / "log.npz")
    assert same(found, as_recording(**given))
    (said,) = found.warnings
    assert said.code == "columns-ignored"
    assert "'labels', 'images'" in said


def test_arrays_of_other_names_are_read_by_what_the_names_say(arrays, tmp_path):
    time, pose, wrench = arrays
    expected = as_recording(time=time, pose=pose, wrench=wrench)
    path = tmp_path / "log.npz"
    images = np.zeros((len(time), 40, 40), dtype=np.uint8)
    np.savez_compressed(path, t=time, tcp_pose=pose, ft=wrench, images=images)
    found = read_log(path)
    assert [m.code for m in found.warnings] == ["columns-by-name"]
    assert same(found, expected)
    # Franka's matrices are stored column by column, this wrench with a row a channel
    matrices = pose.transpose(0, 2, 1).reshape(-1, 16)
    np.savez(path, timestamp=time, O_T_EE=matrices, wrench=wrench.T)
    assert same(read_log(path), expected)


def test_arrays_in_dictionaries_and_matrices_of_rotation(arrays):
    time, pose, wrench = arrays
    robot = {"t": time, "position": pose[:, :3, 3], "R": pose[:, :3, :3]}
    found = as_recording(
        {"robot": robot, "ft": {"force": wrench[:, :3], "torque": wrench[:, 3:]}}
    )
    assert same(found, as_recording(time=time, pose=pose, wrench=wrench))
    assert "row by row" in str(found.warnings[0])


def test_time_of_another_name_is_not_passed_over(arrays):
    """The names `pose` and `wrench` do, without `time`, for static poses."""
    time, pose, wrench = arrays
    found = as_recording({"t": time, "pose": pose, "wrench": wrench})
    assert not found.static
    assert same(found, as_recording(time=time, pose=pose, wrench=wrench))


def test_columns_of_arrays():
    """Rows of matrices one after the other, dictionaries looked into, lists as arrays,
    and what is no sample's numbers left as it is."""
    matrices = np.arange(5 * 16.0).reshape(5, 4, 4)
    table = MemoryTable.of(
        {
            "t": [[0.0], [1.0], [2.0], [3.0], [4.0]],
            "robot": {"pose": matrices, "q": np.arange(10.0).reshape(2, 5)},
            "image": np.zeros((5, 101)),
            "calibration": np.eye(3),
            "name": "arm",
            "ragged": [[1.0], [1.0, 2.0]],
        }
    )
    assert table.names == (
        "t",
        *(f"robot.pose_{j}" for j in range(16)),
        "robot.q_0",
        "robot.q_1",
        "image",
        *(f"calibration_{j}" for j in range(3)),
        "name",
        "ragged",
    )
    np.testing.assert_array_equal(table.columns["robot.pose_6"], matrices[:, 1, 2])
    np.testing.assert_array_equal(table.columns["robot.q_1"], np.arange(5.0) + 5)
    np.testing.assert_array_equal(table.columns["t"], np.arange(5.0))


def test_masked_samples_of_arrays_stay_blank(arrays):
    time, pose, wrench = arrays
    masked = np.ma.masked_array(wrench, mask=np.zeros(wrench.shape, bool))
    masked[3] = np.ma.masked
    for given in (masked, masked.T):
        found = as_recording({"t": time, "tcp_pose": pose, "ft": given})
        np.testing.assert_array_equal(
            found["wrench"].values, np.delete(wrench, 3, axis=0)
        )


def test_what_scipy_reads_of_matlab_is_a_recording(arrays, tmp_path):
    time, pose, wrench = arrays
    held = {"t": time, "robot": {"pose": np.moveaxis(pose, 0, -1)}, "ft": wrench.T}
    savemat(tmp_path / "log.mat", held)
    loaded = loadmat(tmp_path / "log.mat", simplify_cells=True)
    expected = as_recording(time=time, pose=pose, wrench=wrench)
    assert same(as_recording(loaded), expected)


def test_a_column_map_names_the_numbers_of_arrays(arrays, tmp_path):
    time, pose, wrench = arrays
    np.savez(tmp_path / "log.npz", a=1e3 * time, b=pose, c=wrench)
    (tmp_path / "map.toml").write_text(
        'time = { column = "a", unit = "ms" }\n'
        'pose = { columns = "b_{0..15}", form = "matrix4" }\n'
        'wrench = { columns = "c_{0..5}" }\n'
    )
    found = read_log(tmp_path / "log.npz", tmp_path / "map.toml")
    expected = as_recording(time=time, pose=pose, wrench=wrench)
    np.testing.assert_allclose(
        found["wrench"].time, expected["wrench"].time, atol=1e-12
    )
    np.testing.assert_array_equal(found["wrench"].values, expected["wrench"].values)
    np.testing.assert_allclose(found["position"].values, expected["position"].values)


def test_a_column_map_counts_where_arrays_have_the_names_of_streams(arrays, tmp_path):
    """In memory as in a file: here of a wrench with another sign."""
    time, pose, wrench = arrays
    given = {"time": time, "pose": pose, "wrench": wrench}
    np.savez(tmp_path / "log.npz", **given)
    columns = ", ".join(f'"-wrench_{j}"' for j in range(6))
    (tmp_path / "map.toml").write_text(
        'time = "time"\npose = { columns = "pose_{0..15}", form = "matrix4" }\n'
        f"wrench = {{ columns = [{columns}] }}\n"
    )
    for source in (given, tmp_path / "log.npz"):
        found = as_recording(source, column_map=tmp_path / "map.toml")
        np.testing.assert_array_equal(found["wrench"].values, -wrench)


def test_python_objects_are_not_unpickled(arrays, tmp_path):
    """Unpickling would call `explode`."""
    time, pose, wrench = arrays
    path = tmp_path / "log.npz"
    np.savez(path, log=np.array([Exploding()], dtype=object))
    with pytest.raises(InputError, match="'log' holds Python objects"):
        read_log(path)
    given = {"t": time, "tcp_pose": pose, "ft": wrench}
    np.savez(path, log=np.array([Exploding()], dtype=object), **given)
    assert read_log(path).has("wrench")


def test_names_of_columns_beside_their_matrix_are_no_samples(tmp_path):
    """They are as many as the matrix is wide."""
    path, names = tmp_path / "log.npz", ["t", *"xyz", *"abcd", *"fghijk"]
    np.savez(path, data=np.ones((40, 14)), columns=np.array(names))
    with pytest.raises(InputError, match="unknown columns: 'data_0', 'data_1'"):
        read_log(path)


class Exploding:
    """Fails where it is unpickled."""

    def __reduce__(self):
        return explode, ()


def explode():
    raise AssertionError("unpickled")


def test_more_numbers_than_are_read_are_refused_by_the_header(tmp_path):
    """A header that promises 16 GB is not believed by reserving them."""
    content = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (2_000_000_000,)}
    np.lib.format.write_array_header_1_0(content, header)
    with zipfile.ZipFile(tmp_path / "log.npz", "w") as archive:
        archive.writestr("time.npy", content.getvalue())
    with pytest.raises(InputError, match="more than 100,000,000 numbers"):
        read_log(tmp_path / "log.npz")


def test_a_header_that_ends_too_early_is_refused_in_a_line(tmp_path):
    with zipfile.ZipFile(tmp_path / "log.npz", "w") as archive:
        archive.writestr("time.npy", b"\x93NUMPY\x01\x00\x02\x00((")
    with pytest.raises(InputError, match=r"cannot be read as \.npz"):
        read_log(tmp_path / "log.npz")


def test_an_empty_array_among_others_is_said_to_be_empty(arrays):
    time, pose, wrench = arrays
    given = {"time": time, "orientation": pose[:, :3, :3], "wrench": wrench}
    with pytest.raises(InputError, match="position has 0 samples, but time has 80"):
        as_recording(given | {"position": np.zeros((0, 3))})


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9, 0.999])
def test_a_cut_archive_is_refused_in_a_line(arrays, kept, tmp_path):
    time, pose, wrench = arrays
    path = tmp_path / "log.npz"
    np.savez(path, time=time, pose=pose, wrench=wrench)
    data = path.read_bytes()
    path.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(InputError, match=r"cannot be read as \.npz"):
        read_log(path)


def test_an_archive_is_not_cut_into_windows(arrays, tmp_path):
    time, pose, wrench = arrays
    path = tmp_path / "log.npz"
    np.savez(path, time=time, pose=pose, wrench=wrench)
    assert find_format(path).name == "NumPy"
    assert not windows.needs_windows(path)
    with pytest.raises(InputError, match="only CSV or Parquet is read window"):
        next(windows.windows(path))
