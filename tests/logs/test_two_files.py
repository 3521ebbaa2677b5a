"""A wrench in one table and the poses to it in another."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs import read_log
from hefting.logs.column_map import column_map_of
from hefting.logs.mapped import has_columns
from hefting.logs.registry import find_format

RNG = np.random.default_rng(7)
TIME = 0.001 * np.arange(200)
WRENCH = RNG.normal(size=(200, 6))
POSE_TIME = 0.0125 + 0.008 * np.arange(20)
POSITION = RNG.uniform(-1.0, 1.0, (20, 3))
QUATERNION = Rotation.random(20, random_state=2).as_quat()
WRENCH_NAMES = ["fx", "fy", "fz", "tx", "ty", "tz"]
POSE_NAMES = ["px", "py", "pz", "qx", "qy", "qz", "qw"]
START = 1_700_000_000


def table(path, time_name, time, names, values):
    """A table of these columns, at the path."""
    frame = pd.DataFrame(np.column_stack((time, values)), columns=[time_name, *names])
    write = frame.to_parquet if path.suffix == ".parquet" else frame.to_csv
    write(path, index=False)
    return path


@pytest.fixture
def poses(tmp_path):
    values = np.hstack((POSITION, QUATERNION))
    return table(tmp_path / "robot.csv", "time", POSE_TIME, POSE_NAMES, values)


@pytest.fixture
def wrench(tmp_path):
    return table(tmp_path / "ft.csv", "time", TIME, WRENCH_NAMES, WRENCH)


def test_each_stream_comes_from_its_file(wrench, poses):
    got = read_log(wrench, poses=poses)
    assert got["wrench"].time.tolist() == TIME.tolist()
    assert got["wrench"].values.tolist() == WRENCH.tolist()
    assert got["orientation"].time.tolist() == POSE_TIME.tolist()
    np.testing.assert_allclose(got["orientation"].values, QUATERNION, atol=1e-15)
    assert got["position"].values.tolist() == POSITION.tolist()
    assert got.source == str(wrench)


def test_units_names_and_formats_of_their_own(tmp_path):
    """Milliseconds since 1970 beside seconds since 1970, which stay on one clock."""
    names = ["Fx [N]", "Fy [N]", "Fz [N]", "Mx [Nmm]", "My [Nmm]", "Mz [Nmm]"]
    values = WRENCH * ((1.0,) * 3 + (1e3,) * 3)
    first = table(tmp_path / "f.parquet", "t_ms", 1e3 * (START + TIME), names, values)
    vectors = Rotation.from_quat(QUATERNION).as_rotvec()
    others = table(
        tmp_path / "p.csv",
        "timestamp",
        START + POSE_TIME,
        [f"actual_TCP_pose_{k}" for k in range(6)],
        np.hstack((POSITION, vectors)),
    )
    got = read_log(first, poses=others)
    np.testing.assert_allclose(got["wrench"].values, WRENCH, rtol=1e-12)
    late = got["position"].time[0] - got["wrench"].time[0]
    assert late == pytest.approx(POSE_TIME[0], abs=5e-7)  # what 1.7e9 s resolve
    apart = (
        Rotation.from_quat(got["orientation"].values)
        * Rotation.from_quat(QUATERNION).inv()
    )
    assert apart.magnitude().max() < 1e-7
    assert {"columns-by-name", "time-shifted"} <= codes(got.warnings)


def test_a_column_map_is_of_the_wrench(tmp_path, poses):
    names = [f"channel {k}" for k in range(6)]
    first = table(tmp_path / "f.csv", "n", np.arange(200.0), names, WRENCH)
    (tmp_path / "map.toml").write_text(
        'time = { column = "n", rate = 1000 }\nwrench = [2, 3, 4, 5, 6, 7]\n'
    )
    got = read_log(first, tmp_path / "map.toml", poses=poses)
    assert got["wrench"].values.tolist() == WRENCH.tolist()
    np.testing.assert_allclose(got["wrench"].time, TIME, atol=1e-15)


@pytest.mark.parametrize("of", ["wrench", "poses"])
def test_a_column_map_is_of_the_file_that_has_its_columns(tmp_path, wrench, of):
    """Whichever of the two has names that say nothing."""
    columns = [f"channel {k}" for k in range(6)]
    degrees = Rotation.from_quat(QUATERNION).as_euler("XYZ", degrees=True)
    (tmp_path / "map.toml").write_text(
        'time = { column = "n", unit = "ms" }\nposition = ["channel 0", "channel 1", '
        '"channel 2"]\norientation = { columns = "channel {3..5}", form = "euler", '
        'order = "XYZ", unit = "deg" }\nsensor_turned = "z:90"\nheader = 1\n'
        if of == "poses"
        else 'time = { column = "n", unit = "ms" }\nwrench = "channel {0..5}"\n'
    )
    if of == "poses":
        values = np.hstack((POSITION, degrees))
        poses = table(tmp_path / "p.csv", "n", 1e3 * POSE_TIME, columns, values)
    else:
        values = np.hstack((POSITION, QUATERNION))
        poses = table(tmp_path / "p.csv", "time", POSE_TIME, POSE_NAMES, values)
        wrench = table(tmp_path / "f.csv", "n", 1e3 * TIME, columns, WRENCH)
    got = read_log(wrench, tmp_path / "map.toml", poses=poses)
    assert got["wrench"].values.tolist() == WRENCH.tolist()
    turned = Rotation.from_euler("z", 90.0 if of == "poses" else 0.0, degrees=True)
    expected = Rotation.from_quat(QUATERNION) * turned
    apart = Rotation.from_quat(got["orientation"].values) * expected.inv()
    # Euler angles near their singularity lose half of the digits
    assert apart.magnitude().max() < 1e-7
    with pytest.raises(InputError, match="the file with the wrench first"):
        read_log(poses, tmp_path / "map.toml", poses=wrench)


def test_two_files_without_names_have_a_map_in_two_parts(tmp_path):
    """Each part with a layout and a unit of time of its own; the sensor's pose in the
    logged frame may be in either."""
    np.savetxt(tmp_path / "f.csv", np.column_stack((1e3 * TIME, WRENCH)), "%.17g", ",")
    poses = np.column_stack((POSE_TIME, POSITION, QUATERNION))
    np.savetxt(tmp_path / "p.csv", poses, "%.17g", ";")
    chosen, turn = tmp_path / "map.toml", 'sensor_turned = "z:90"\n'
    first = (
        "header = false\ntime = { column = 1, unit = 'ms' }\nwrench = [2,3,4,5,6,7]\n"
    )
    second = "[poses]\nheader = false\ntime = 1\nposition = [2,3,4]\n"
    second += 'orientation = [5,6,7,8]\nseparator = ";"\n'
    turned = Rotation.from_quat(QUATERNION) * Rotation.from_euler("z", 90, degrees=True)
    for text in (first + turn + second, first + second + turn):
        chosen.write_text(text)
        got = read_log(tmp_path / "f.csv", chosen, poses=tmp_path / "p.csv")
        np.testing.assert_array_equal(got["wrench"].values, WRENCH)
        np.testing.assert_allclose(got["wrench"].time, TIME, atol=1e-15)
        apart = Rotation.from_quat(got["orientation"].values) * turned.inv()
        assert apart.magnitude().max() < 1e-12
    with pytest.raises(InputError, match="has a map of a second file; give that"):
        read_log(tmp_path / "f.csv", chosen)
    for text, said in (
        (first, r"p.csv, row 1: is numbers, .* in a table \[poses\] of it"),
        (f"poses = 3\n{first}", r"map.toml, key poses: is no table; write \[poses\]"),
        (f"{first}[poses]\nposition = [2]", "map.toml, table poses, key position"),
    ):
        chosen.write_text(text)
        with pytest.raises(InputError, match=said):
            read_log(tmp_path / "f.csv", chosen, poses=tmp_path / "p.csv")


def test_joint_angles_serve(tmp_path, wrench):
    joints = [f"q{k}" for k in range(1, 7)]
    values = RNG.normal(size=(20, 6))
    got = read_log(
        wrench, poses=table(tmp_path / "q.csv", "time", POSE_TIME, joints, values)
    )
    assert got["joint_positions"].values.tolist() == values.tolist()


def test_what_is_no_pair_of_files(tmp_path, wrench, poses):
    whole = tmp_path / "whole.csv"
    frame = pd.read_csv(poses).join(pd.read_csv(wrench)[WRENCH_NAMES])
    frame.to_csv(whole, index=False)
    late = table(
        tmp_path / "late.csv",
        "time",
        POSE_TIME + 60.0,
        POSE_NAMES,
        np.hstack((POSITION, QUATERNION)),
    )
    frames = table(
        tmp_path / "vicon.csv",
        "Frame",
        TIME,
        ["RX", "RY", "RZ", "TX", "TY", "TZ"],
        WRENCH,
    )
    epoch = table(tmp_path / "epoch.csv", "time", START + TIME, WRENCH_NAMES, WRENCH)
    (tmp_path / "held.bag").write_bytes(b"#ROSBAG V2.0\n")
    cases = (
        (poses, wrench, "robot.csv: there is no wrench"),
        (whole, poses, "whole.csv: holds position and orientation itself"),
        (whole, poses, "leave `poses` out, or name the wrench alone in a column map"),
        (wrench, frames, r"there is no time; .* column map time = .*\{ rate = 250 \}"),
        (wrench, epoch, "epoch.csv: there are neither poses nor joint angles"),
        (wrench, late, "do not overlap those of ft.csv"),
        (epoch, poses, "only the times of epoch.csv count from 1970"),
        (
            wrench,
            tmp_path / "held.bag",
            "only CSV, .* MATLAB and JSON lines are read in two files",
        ),
        (wrench, tmp_path / "none.csv", "none.csv: does not exist"),
    )
    for first, second, words in cases:
        with pytest.raises(InputError, match=words):
            read_log(first, poses=second)
    with pytest.raises(InputError, match=r"another file with them \(`poses`\)"):
        read_log(wrench)


@pytest.mark.parametrize("markers", [0, 3, 9])
@pytest.mark.parametrize("form", ["{}", "{:032X}"])
@pytest.mark.parametrize("parents", [False, True])
def test_exports_of_motive(tmp_path, wrench, markers, form, parents):
    """Names in five lines or six, of a rigid body and its markers, whose numbers are
    rows of numbers among them."""
    body = form.format(10**36)
    columns = [("Rigid Body", "ft", body, "", "Rotation", c) for c in "XYZW"]
    columns += [("Rigid Body", "ft", body, "", "Position", c) for c in "XYZ"]
    columns += [("Rigid Body", "ft", body, "", "Mean Marker Error", "")]
    values = [QUATERNION, POSITION, np.full((20, 1), 1e-4)]
    for k in range(markers):
        of = ("Rigid Body Marker", f"ft:Marker {k}", form.format(10**36 + k + 1), body)
        columns += [(*of, "Position", c) for c in "XYZ"]
        columns += [(*of, "Marker Quality", "")]
        values += [RNG.normal(size=(20, 3)), np.ones((20, 1))]
    heads = ("Type", "Name", "ID", "Parent", "", "Time (Seconds)")
    lines = [
        ["Frame" if "Time" in head else "", head, *line]
        for head, line in zip(heads, zip(*columns, strict=True), strict=True)
        if parents or head != "Parent"
    ]
    table = np.column_stack((POSE_TIME, *values)).tolist()
    lines += [[str(k), *map(repr, row)] for k, row in enumerate(table)]
    path = tmp_path / "motive.csv"
    path.write_text("\n".join(("Format Version,1.25", "", *map(",".join, lines))))
    got = read_log(wrench, poses=path)
    assert got["position"].values.tolist() == POSITION.tolist()
    np.testing.assert_allclose(got["orientation"].values, QUATERNION, atol=1e-15)
    assert codes(got.warnings) == {"columns-by-name"}


def test_joint_torques_alone_in_a_table(tmp_path):
    """As they are read where no wrench is needed."""
    names, angles = ([f"{name}{j}" for j in range(1, 7)] for name in ("tau", "q"))
    torques = table(tmp_path / "tau.csv", "time", TIME, names, WRENCH)
    values = RNG.uniform(-1.0, 1.0, (20, 6))
    joints = table(tmp_path / "q.csv", "time", POSE_TIME, angles, values)
    got = read_log(torques, poses=joints, wrench_needed=False)
    assert got["joint_torques"].values.tolist() == WRENCH.tolist()
    assert got["joint_positions"].values.tolist() == values.tolist()
    with pytest.raises(InputError, match="there is no wrench"):
        read_log(torques, poses=joints)


def test_a_map_with_signs_is_of_the_file_that_has_its_columns(tmp_path):
    chosen = column_map_of({"joint_torques": ["-m1", "m2"]}, "map", is_part=True)
    (tmp_path / "a.csv").write_text("time,m1,m2\n0,1,2\n0.1,1,2\n")
    table = find_format(tmp_path / "a.csv").open_table(tmp_path / "a.csv", None)
    assert has_columns(table, chosen)
