"""Column maps: the same recording through other names, units and forms, and logs as
others write them."""

import itertools
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv as pacsv
from pyarrow import parquet

from hefting.core.recording import Recording
from hefting.core.spatial import rotation_matrices
from hefting.logs import read_log, write_log
from hefting.logs.canonical import table_from_recording
from hefting.logs.units import UNITS, find_unit
from log_files import HEADER, ROWS, log, mapped, mapping_fails, random_recording, same

WRENCH = 'wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
POSE = 'orientation = ["qx", "qy", "qz", "qw"]\n'
TIME = 'time = "time"\n'


@pytest.fixture
def path(tmp_path) -> Path:
    return log(tmp_path, *ROWS)


# The same recording in other words

SAID = {
    "position": ("mm", 1e3),
    "linear_velocity": ("mm/s", 1e3),
    "angular_velocity": ("deg/s", 180 / np.pi),
    "linear_acceleration": ("g", 1 / 9.80665),
    "angular_acceleration": ("deg/s²", 180 / np.pi),
    "joint_positions": ("deg", 180 / np.pi),
    "joint_velocities": ("°/s", 180 / np.pi),
    "joint_torques": ("N mm", 1e3),
    "joint_currents": ("mA", 1e3),
    "wrench": (["kN", "N mm"], [1e-3] * 3 + [1e3] * 3),
    "gyroscope": ("deg/s", 180 / np.pi),
    "accelerometer": ("g", 1 / 9.80665),
    "linear_accelerometer": ("mm/s^2", 1e3),
}
"""Another unit of each stream, and how many of it make one in SI."""


def renamed(recording: Recording, reunited: bool) -> tuple[pa.Table, str]:
    """The recording's table with other names, in reverse order, perhaps in other units,
    and the map to it."""
    table = table_from_recording(recording)
    scales, lines = {}, []
    for name, stream in recording.streams.items():
        columns = [
            column for column in table.column_names if column not in ("time", *scales)
        ]
        columns = columns[: stream.values.shape[1]]
        unit, scale = SAID.get(name, (None, 1.0)) if reunited else (None, 1.0)
        scales |= dict(zip(columns, np.broadcast_to(scale, len(columns)), strict=True))
        given = f", unit = {unit!r}" if unit else ""
        lines.append(
            f"{name} = {{ columns = {['my ' + column for column in columns]}{given} }}"
        )
    if not recording.static:
        lines.append(
            'time = { column = "my time", unit = "ms" }'
            if reunited
            else "time = 'my time'"
        )
        scales["time"] = 1e3 if reunited else 1.0
    names = table.column_names[::-1]
    arrays = [
        pa.array(
            table[name].to_numpy() * scales[name], mask=table[name].is_null().to_numpy()
        )
        for name in names
    ]
    return pa.table(arrays, [f"my {name}" for name in names]), "\n".join(lines)


def write(table: pa.Table, path: Path) -> Path:
    (pacsv.write_csv if path.suffix == ".csv" else parquet.write_table)(table, path)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_other_names_give_the_same_recording(tmp_path, suffix, static, seed):
    sent = random_recording(seed, static)
    table, text = renamed(sent, False)
    assert same(mapped(write(table, tmp_path / f"log{suffix}"), text), sent)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_other_units_give_the_same_recording(tmp_path, suffix):
    sent = random_recording(3)
    table, text = renamed(sent, True)
    got = mapped(write(table, tmp_path / f"log{suffix}"), text)
    assert got.streams.keys() == sent.streams.keys()
    for name, stream in sent.streams.items():
        # to another unit and back is three roundings, of 1.1e-16 each
        np.testing.assert_allclose(
            got[name].values, stream.values, rtol=4.5e-16, atol=0
        )
        np.testing.assert_allclose(got[name].time, stream.time, rtol=4.5e-16, atol=0)


def test_the_canonical_map_is_the_canonical_reader(path, tmp_path):
    got = mapped(path, TIME + POSE + WRENCH)
    assert same(got, read_log(path))
    assert got.notes == (
        "time from column time [s]",
        "orientation from columns qx, qy, qz, qw, xyzw",
        "wrench from columns fx, fy, fz, tx, ty, tz [N, N m]",
    )
    write_log(got, tmp_path / "log.parquet")
    assert same(mapped(tmp_path / "log.parquet", TIME + POSE + WRENCH), got)


def test_a_minus_is_the_negative_of_a_column_unless_it_is_part_of_a_name(tmp_path):
    """Here a column is called -tx."""
    header = HEADER.replace("tx", "-tx")
    path = log(tmp_path, *ROWS, header=header)
    said = 'wrench = ["fx", "fy", "-fz", "-tx", "-ty", "tz"]\n'
    got, right = mapped(path, TIME + POSE + said), read_log(log(tmp_path, *ROWS))
    signs = np.array((1, 1, -1, 1, -1, 1))
    np.testing.assert_array_equal(got["wrench"].values, signs * right["wrench"].values)


def test_units():
    exact = {
        "mm": 0.001,
        "in": 0.0254,
        "us": 1e-6,
        "kgf": 9.80665,
        "N mm": 0.001,
        "lbf": 4.4482216152605,
        "min": 60.0,
    }
    for kind, units in UNITS.items():
        for name in units.keys() & exact.keys():
            assert find_unit(name, kind, "here").to_si(np.ones(1))[0] == exact[name]
        # the SI unit is first: the default
        assert next(iter(units.values())).to_si(np.ones(1))[0] == 1.0
    assert find_unit("deg", "angle", "here").to_si(np.array([180.0]))[0] == np.pi
    assert find_unit("lbf in", "torque", "here").to_si(np.ones(1))[0] == pytest.approx(
        0.1129848290276167, rel=1e-15
    )
    for other in ("Nm", "N*m", "N·m", "N m"):
        assert find_unit(other, "torque", "here").name == "N m"
    assert find_unit("m/s2", "acceleration", "here") == find_unit(
        "m/s²", "acceleration", "here"
    )


# Orientations: products of turns about the axes, written out


def about(axis: str, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis.lower()]
    matrix = np.eye(3)
    matrix[[i, j, i, j], [i, j, j, i]] = c, c, -s, s
    return matrix


def turned_by(vector: np.ndarray) -> np.ndarray:
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def read_orientations(folder: Path, columns: np.ndarray, said: str) -> np.ndarray:
    """Rotation matrices (N, 3, 3) that are read from columns (N, d)."""
    names = [f"o{j}" for j in range(columns.shape[1])]
    lines = [
        ",".join(map(repr, [k / 10, *row.tolist(), 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
        for k, row in enumerate(columns)
    ]
    path = log(
        folder, *lines, header=",".join(["time", *names, *HEADER.split(",")[5:]])
    )
    got = mapped(
        path,
        TIME
        + WRENCH
        + f'orientation = {{ columns = "o{{0..{len(names) - 1}}}", {said} }}',
    )
    return rotation_matrices(got["orientation"].values)


ANGLES = np.vstack(
    [
        np.random.default_rng(0).uniform(-np.pi, np.pi, (6, 3)),
        # gimbal lock and near nothing
        [[0.3, np.pi / 2, -1.1], [0.3, 1e-9, 0.2], [0, 0, 1e-12]],
    ]
)
ORDERS = [
    "".join(order)
    for order in itertools.product("xyz", repeat=3)
    if order[0] != order[1] != order[2]
]


@pytest.mark.parametrize("unit", ["rad", "deg"])
@pytest.mark.parametrize("order", [*ORDERS[::2], *(order.upper() for order in ORDERS)])
def test_euler_angles(tmp_path, order, unit):
    wanted = []
    for angles in ANGLES:
        first, second, third = (
            about(axis, angle) for axis, angle in zip(order, angles, strict=True)
        )
        wanted.append(
            first @ second @ third if order.isupper() else third @ second @ first
        )
    columns = ANGLES if unit == "rad" else np.rad2deg(ANGLES)
    got = read_orientations(
        tmp_path, columns, f'form = "euler", order = "{order}", unit = "{unit}"'
    )
    # some tens of roundings of 1.1e-16
    np.testing.assert_allclose(got, wanted, atol=5e-15)


def test_the_other_forms(tmp_path):
    """Each form of the same rotations, turns by nearly pi and by next to nothing
    included."""
    rpy = np.array(
        [
            about("z", yaw) @ about("y", pitch) @ about("x", roll)
            for roll, pitch, yaw in ANGLES
        ]
    )
    got = read_orientations(tmp_path, np.rad2deg(ANGLES), 'form = "rpy", unit = "deg"')
    np.testing.assert_allclose(got, rpy, atol=5e-15)
    axis = np.array([0.6, 0.0, 0.8])
    vectors = np.vstack(
        [
            ANGLES[:6],
            *(
                axis * angle
                for angle in (np.pi - 1e-9, np.pi, np.pi + 1e-9, 1e-9, 2 * np.pi)
            ),
        ]
    )
    matrices = np.array([turned_by(vector) for vector in vectors])
    np.testing.assert_allclose(
        read_orientations(tmp_path, vectors, 'form = "rotation-vector"'),
        matrices,
        atol=5e-15,
    )
    nine = read_orientations(tmp_path, matrices.reshape(-1, 9), 'form = "matrix"')
    np.testing.assert_allclose(nine, matrices, atol=5e-15)
    xyzw = np.array([[0.1, 0.7, -0.5, 0.5], [0, 0, 0, -1.0]])
    np.testing.assert_array_equal(
        read_orientations(tmp_path, xyzw, 'form = "xyzw"'),
        read_orientations(tmp_path, xyzw[:, [3, 0, 1, 2]], 'form = "wxyz"'),
    )


@pytest.mark.parametrize("form", ["matrix4", "matrix4-columns"])
def test_homogeneous_matrices(tmp_path, form):
    rotation = turned_by(np.array([0.4, -0.9, 2.0]))
    position = np.array([100.0, -200.0, 300.0])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    cells = (pose if form == "matrix4" else pose.T).reshape(-1).tolist()
    row = ",".join(map(repr, [0.0, *cells, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
    path = log(
        tmp_path,
        row,
        header="time," + ",".join(f"T[{j}]" for j in range(16)) + ",fx,fy,fz,tx,ty,tz",
    )
    text = TIME + WRENCH + 'pose = { columns = "T[{0..15}]", unit = "mm", form = "%s" }'
    got = mapped(path, text % form)
    np.testing.assert_allclose(got["position"].values, [position / 1e3], rtol=1e-15)
    np.testing.assert_allclose(
        rotation_matrices(got["orientation"].values)[0], rotation, atol=1e-15
    )
    other = {"matrix4": "matrix4-columns", "matrix4-columns": "matrix4"}[form]
    mapping_fails(
        path, text % other, "row 2, columns T[0]..T[15]", "last line", "0 0 0 1", form
    )


def test_a_wrench_in_world_axes_is_turned_by_the_pose_of_its_row(tmp_path):
    lines = [
        "0,0,0,0,1,1,2,3,4,5,6",
        "0.1,0,0,1,0,,,,,,",
        "0.2,0,0,0.5,0.5,1,2,3,4,5,6",
    ]
    half = str(np.sqrt(0.5))
    path = log(tmp_path, *(line.replace("0.5", half) for line in lines))
    world = WRENCH.replace("= [", "= { columns = [").replace("]", '], axes = "world" }')
    got = mapped(path, TIME + POSE + world)["wrench"]
    # a quarter turn about z takes sensor axes to world axes: sensor x is world y
    np.testing.assert_allclose(
        got.values, [[1, 2, 3, 4, 5, 6], [2, -1, 3, 5, -4, 6]], atol=2e-15
    )
    assert got.time.tolist() == [0, 0.2]
    path = log(tmp_path, lines[0], "0.1,,,,,1,2,3,4,5,6")
    mapping_fails(path, POSE + world, "row 3", "no orientation in its row")


def test_a_wrench_in_world_axes_is_turned_by_the_pose_at_its_time(tmp_path):
    """As of a bag, whose streams have rates of their own, or of two files."""
    quarter = str(np.sqrt(0.5))
    lines = [
        "0,0,0,0,1,,,,,,",
        "0.1,,,,,1,2,3,4,5,6",
        f"0.2,0,0,{quarter},{quarter},,,,,,",
        "0.3,,,,,1,2,3,4,5,6",
    ]
    world = WRENCH.replace("= [", "= { columns = [").replace("]", '], axes = "world" }')
    got = mapped(log(tmp_path, *lines), TIME + POSE + world)["wrench"]
    # an eighth of a turn about z in the middle, a quarter from the last pose on
    half = np.sqrt(0.5)
    np.testing.assert_allclose(
        got.values[0], half * np.array([3, 1, 3 / half, 9, 1, 6 / half])
    )
    np.testing.assert_allclose(got.values[1], [2, -1, 3, 5, -4, 6], atol=2e-15)


# Logs as others write them


def test_franka(tmp_path):
    """libfranka: time in ms, matrices by columns, joints in brackets."""
    names = [
        f"state.{n}[{j}]"
        for n, w in (("q", 7), ("O_T_EE", 16), ("K_F_ext_hat_K", 6))
        for j in range(w)
    ]
    matrix = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0.3, 0, 0.5, 1]
    rows = [
        [1000 + k, 0.9, *range(7), *matrix, *(10, 20, 30, 1, 2, 3)] for k in range(3)
    ]
    path = log(
        tmp_path,
        *(",".join(map(str, row)) for row in rows),
        header=", ".join(["time", "rate", *names]),
    )
    text = """
        time = { column = "time", unit = "ms" }
        pose = { columns = "state.O_T_EE[{0..15}]", form = "matrix4-columns" }
        wrench = "state.K_F_ext_hat_K[{0..5}]"
        joint_positions = { columns = "state.q[{0..6}]", names = ["j1", "j2", "j3", "j4", "j5", "j6", "j7"] }
    """
    got = mapped(path, text)
    assert got["wrench"].time.tolist() == [1.0, 1.001, 1.002]
    assert got["position"].values[0].tolist() == [0.3, 0, 0.5]
    np.testing.assert_allclose(
        np.abs(got["orientation"].values[0]), [1, 0, 0, 0], atol=1e-15
    )
    assert got["joint_positions"].values[0].tolist() == list(range(7))
    assert got.joint_names == ("j1", "j2", "j3", "j4", "j5", "j6", "j7")
    assert got.notes[1] == (
        "pose from columns state.O_T_EE[0], state.O_T_EE[1], state.O_T_EE[2], state.O_T_EE[3], state.O_T_EE[4], "
        "state.O_T_EE[5], state.O_T_EE[6], state.O_T_EE[7] and 8 more [m], matrix4-columns"
    )


def test_kuka_with_decimal_commas(tmp_path):
    path = log(
        tmp_path,
        "12;1000,5;0;-250;90;0;0;0,5;0;0;0;0;100",
        header="t;X;Y;Z;A;B;C;Fx;Fy;Fz;Tx;Ty;Tz",
    )
    text = """
        decimal = ","
        time = { column = "t", unit = "ms" }
        position = { columns = ["X", "Y", "Z"], unit = "mm" }
        orientation = { columns = ["A", "B", "C"], form = "euler", order = "ZYX", unit = "deg" }
        force = ["Fx", "Fy", "Fz"]
        torque = { columns = ["Tx", "Ty", "Tz"], unit = "N mm" }
    """
    got = mapped(path, text)
    assert got["wrench"].time.tolist() == [0.012]
    assert got["position"].values.tolist() == [[1.0005, 0, -0.25]]
    np.testing.assert_allclose(
        got["orientation"].values, [[0, 0, np.sqrt(0.5), np.sqrt(0.5)]], atol=1e-15
    )
    assert got["wrench"].values.tolist() == [[0.5, 0, 0, 0, 0, 0.1]]
    bad = log(
        tmp_path,
        "12;1.5;0;-250;90;0;0;0,5;0;0;0;0;100",
        header="t;X;Y;Z;A;B;C;Fx;Fy;Fz;Tx;Ty;Tz",
    )
    mapping_fails(bad, text, "row 2, column X", "'1.5' is not a number")


def test_motion_capture_with_several_header_lines(tmp_path):
    """Frames instead of times, units under the names, names that repeat, gaps left
    blank."""
    lines = [
        "Format Version,1.23,Take Name,hammer",
        "",
        ",,Wand,Wand,Wand,Tool,Tool,Tool,Tool,Tool,Tool,ATI,ATI,ATI,ATI,ATI,ATI",
        "Frame,Sub,X,Y,Z,RX,RY,RZ,X,Y,Z,fx,fy,fz,tx,ty,tz",
        ",,mm,mm,mm,rad,rad,rad,mm,mm,mm,N,N,N,Nm,Nm,Nm",
        "101,0,7,7,7,0,0,3.14,1,2,3,1,2,3,4,5,6",
        "102,0,7,7,7,,,,,,,1,2,3,4,5,6",
        "104,0,7,7,7,0,0,-3.14,4,5,6,1,2,3,4,5,6",
    ]
    text = """
        header = 4
        skip = 1
        time = { column = "Frame", rate = 200 }
        orientation = { columns = ["RX", "RY", "RZ"], form = "rotation-vector" }
        position = { columns = [%s], unit = "mm" }
        wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]
    """
    path = log(tmp_path, *lines[1:], header=lines[0])
    got = mapped(path, text % "9, 10, 11")
    assert got["position"].values.tolist() == [
        [0.001, 0.002, 0.003],
        [0.004, 0.005, 0.006],
    ]
    assert got["position"].time.tolist() == [101 / 200, 104 / 200]
    assert got["position"].rows.tolist() == [6, 8]
    assert got["wrench"].rows.tolist() == [6, 7, 8]
    mapping_fails(
        path,
        text % "'X', 'Y', 'Z'",
        "key position",
        "2 columns 'X'",
        "number of one of them: 3, 9",
    )
    mapping_fails(
        path,
        text.replace("skip = 1", "skip = 0") % "9, 10, 11",
        "row 5, column RX",
        "'rad' is not a number",
    )
    found = text.replace("header = 4", "").replace("skip = 1", "")
    assert same(mapped(path, found % "9, 10, 11"), got)  # both are found


def test_a_file_without_header(tmp_path):
    text = "header = false\ntime = 1\norientation = [2, 3, 4, 5]\nwrench = [6, 7, 8, 9, 10, 11]\n"
    path = log(tmp_path, *ROWS[1:], header=ROWS[0])
    assert same(mapped(path, text), read_log(log(tmp_path, *ROWS)))
    path = log(tmp_path, *ROWS, header="made by hand," + "," * 9)
    assert mapped(path, text + "skip = 1")["wrench"].rows.tolist() == [2, 3, 4]
    spaced = log(
        tmp_path,
        *(row.replace(",", "   ") for row in ROWS[1:]),
        header=ROWS[0].replace(",", "\t"),
    )
    mapping_fails(spaced, text, "row 2", "1 cells under 11")
    spaced = log(
        tmp_path,
        *(row.replace(",", "|") for row in ROWS[1:]),
        header=ROWS[0].replace(",", "|"),
    )
    assert len(mapped(spaced, text + "separator = '|'")["wrench"]) == 3
    mapping_fails(
        path.with_name("log.csv"),
        text.replace("11]", "12]") + "separator = '|'",
        "no column number 12",
        "has 11",
    )
    mapping_fails(
        spaced,
        text.replace("[2,", "['qx',") + "separator = '|'",
        "no column 'qx'",
        "no names: give their numbers",
    )


def test_time_by_counting_rows(path):
    got = mapped(path, POSE + WRENCH + "time = { rate = 250 }")
    assert got["wrench"].time.tolist() == [0, 0.004, 0.008]
    assert not got.static
    static = mapped(path, POSE + WRENCH)
    assert static.static
    assert static["wrench"].time.tolist() == [0, 1, 2]


def test_nan_means_not_measured_only_if_the_map_says_so(tmp_path):
    lines = [ROWS[0], "0.1,NaN,nan,NaN,NaN,1,2,3,4,5,6", ROWS[2]]
    path = log(tmp_path, *lines)
    text = TIME + POSE + WRENCH
    mapping_fails(path, text, "row 3, column qx", "the value is nan")
    got = mapped(path, text + 'nan = "blank"')
    assert got["orientation"].time.tolist() == [0, 0.2]
    assert len(got["wrench"]) == 3
    mapping_fails(
        log(tmp_path, lines[0], lines[1].replace("nan", "0")),
        text + "nan = 'blank'",
        "row 3",
        "cell is blank",
    )
    table = {name: [0.0, float("nan")] for name in HEADER.split(",")} | {
        "time": [0.0, 1.0],
        "qw": [1.0, float("nan")],
    }
    parquet.write_table(pa.table(table), tmp_path / "log.parquet")
    assert len(mapped(tmp_path / "log.parquet", text + 'nan = "blank"')["wrench"]) == 1


def test_times_since_1970(tmp_path):
    lines = [
        f"{1_700_000_000_000_000_000 + k * 5_000_000}{ROWS[0][1:]}" for k in range(3)
    ]
    path = log(tmp_path, *lines)
    got = mapped(path, POSE + WRENCH + 'time = { column = "time", unit = "ns" }')
    # doubles near 1.7e18 are 256 apart
    np.testing.assert_allclose(got["wrench"].time, [0, 0.005, 0.01], atol=256e-9)
    assert got.warnings == (
        "time was shifted by 1700000000.000000 s to start at 0; its resolution is 3e-07 s",
    )
    mapping_fails(path, POSE + WRENCH + TIME, "nanoseconds since 1970", "`column_map`")
    mapping_fails(
        path, POSE + WRENCH + 'time = { column = "time", unit = "us" }', "cannot be us"
    )
