"""Logs as other programs write them, read without a column map: by the names of their
columns, below comments, with dates for times."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import NO_DOUBT, codes
from hefting.logs import read_log
from hefting.logs.map_sample import BRACKETS
from hefting.logs.windows import windows
from log_files import refusal_time

ROWS = 40
RNG = np.random.default_rng(11)
TIME = 0.01 * np.arange(ROWS)
POSITION = RNG.uniform(-1.0, 1.0, (ROWS, 3))
TURNS = Rotation.random(ROWS, random_state=5)
QUATERNION = TURNS.as_quat()
WRENCH = RNG.normal(size=(ROWS, 6)) * (5, 5, 5, 0.5, 0.5, 0.5)
START = 1_700_000_000
NEWTON_MILLIMETRES = WRENCH * ((1.0,) * 3 + (1e3,) * 3)
CANONICAL = [
    "time",
    "px",
    "py",
    "pz",
    "qx",
    "qy",
    "qz",
    "qw",
    "fx",
    "fy",
    "fz",
    "tx",
    "ty",
    "tz",
]
PLAIN = (TIME, POSITION, QUATERNION, WRENCH)

SEC = START + np.floor(TIME)
NANOSEC = np.round(1e9 * (TIME % 1))


def ros(separator: str) -> list[str]:
    """Names of the fields of a pose and a wrench, flattened."""
    return [
        *(separator.join(("pose", "position", c)) for c in "xyz"),
        *(separator.join(("pose", "orientation", c)) for c in "xyzw"),
        *(separator.join(("wrench", k, c)) for k in ("force", "torque") for c in "xyz"),
    ]


def numbered(name: str, count: int = 6) -> str:
    """Names of numbered columns."""
    return " ".join(f"{name}{i}" for i in range(count))


FRANKA = numbered("O_T_EE_", 16)
MATRICES = np.tile(np.eye(4), (ROWS, 1, 1))
MATRICES[:, :3, :3], MATRICES[:, :3, 3] = TURNS.as_matrix(), POSITION
BY_COLUMNS = MATRICES.transpose(0, 2, 1).reshape(ROWS, 16)
DEGREES = TURNS.as_euler("xyz", degrees=True)
IN_BASE = np.hstack((TURNS.apply(WRENCH[:, :3]), TURNS.apply(WRENCH[:, 3:])))


NAMES = {
    "short": ("t x y z qx qy qz qw Fx Fy Fz Mx My Mz", PLAIN),
    "units": (
        "Time[s] X[mm] Y[mm] Z[mm] Q_x Q_y Q_z Q_w Fx[N] Fy[N] Fz[N]"
        " Tx[Nmm] Ty[Nmm] Tz[Nmm]",
        (TIME, 1e3 * POSITION, QUATERNION, NEWTON_MILLIMETRES),
    ),
    "units as words": (
        "time_ms x_mm y_mm z_mm roll_deg pitch_deg yaw_deg fx_N fy_N fz_N"
        " tx_Nmm ty_Nmm tz_Nmm",
        (
            1e3 * TIME,
            1e3 * POSITION,
            TURNS.as_euler("xyz", degrees=True),
            NEWTON_MILLIMETRES,
        ),
    ),
    "seconds and nanoseconds": (
        "header.stamp.sec header.stamp.nanosec " + " ".join(ros(".")),
        (SEC, NANOSEC, POSITION, QUATERNION, WRENCH),
    ),
    "seconds and nanoseconds of ROS 1": (
        "secs nsecs " + " ".join(ros("_")),
        (SEC, NANOSEC, POSITION, QUATERNION, WRENCH),
    ),
    "PlotJuggler": ("__time " + " ".join(ros("/")), (START + TIME, *PLAIN[1:])),
    "TUM with a wrench": (
        "timestamp tx ty tz qx qy qz qw fx fy fz mx my mz",
        PLAIN,
    ),
    "robosuite": (
        "timestamps eef_pos_0 eef_pos_1 eef_pos_2 eef_quat_0 eef_quat_1 eef_quat_2 eef_quat_3"
        " ee_force_0 ee_force_1 ee_force_2 ee_torque_0 ee_torque_1 ee_torque_2",
        PLAIN,
    ),
    "ABB": (
        "time_since_start x y z q1 q2 q3 q4 fx fy fz tx ty tz",
        (TIME, POSITION, QUATERNION[:, [3, 0, 1, 2]], WRENCH),
    ),
    "TCP": (
        "Timestamp TCP_x TCP_y TCP_z TCP_rx TCP_ry TCP_rz"
        " TCP_Fx TCP_Fy TCP_Fz TCP_Tx TCP_Ty TCP_Tz",
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
    ),
    "Franka": (
        f"time {FRANKA} {numbered('K_F_ext_hat_K_')}",
        (TIME, BY_COLUMNS, WRENCH),
    ),
    "Franka in base axes": (
        f"time {FRANKA} {numbered('O_F_ext_hat_K_')}",
        (TIME, BY_COLUMNS, IN_BASE),
    ),
    "Franka in both axes": (
        f"time {FRANKA} {numbered('K_F_ext_hat_K_')} {numbered('O_F_ext_hat_K_')}",
        (TIME, BY_COLUMNS, WRENCH, IN_BASE),
    ),
    "a matrix of any name": (
        f"time {FRANKA.replace('O_T_EE', 'T_base_flange')} {numbered('ft_')}",
        (TIME, BY_COLUMNS, WRENCH),
    ),
    "KUKA Sunrise": (
        "timestamp_ms pose.x pose.y pose.z pose.alphaRad pose.betaRad pose.gammaRad"
        " force.x force.y force.z torque.x torque.y torque.z",
        (1e3 * TIME, 1e3 * POSITION, TURNS.as_euler("ZYX"), WRENCH),
    ),
    "RAPID of ABB": (
        "robtime trans.x trans.y trans.z rot.q1 rot.q2 rot.q3 rot.q4 Fx Fy Fz Tx Ty Tz",
        (TIME, POSITION, QUATERNION[:, [3, 0, 1, 2]], WRENCH),
    ),
    "EGM of ABB": (
        "Time[ms] X[mm] Y[mm] Z[mm] EulerX[deg] EulerY[deg] EulerZ[deg]"
        " Fx Fy Fz Mx My Mz",
        (1e3 * TIME, 1e3 * POSITION, DEGREES, WRENCH),
    ),
    "Fanuc": (
        "Time(sec) X(mm) Y(mm) Z(mm) W(deg) P(deg) R(deg) Fx(N) Fy(N) Fz(N) Mx My Mz",
        (TIME, 1e3 * POSITION, DEGREES, WRENCH),
    ),
    "Doosan": (
        "time posx_x posx_y posx_z posx_a posx_b posx_c"
        " ft_fx ft_fy ft_fz ft_mx ft_my ft_mz",
        (TIME, 1e3 * POSITION, TURNS.as_euler("ZYZ", degrees=True), WRENCH),
    ),
    "Doosan in real time": (
        f"time {numbered('actual_tcp_position_')} {numbered('external_tcp_force_')}",
        (TIME, 1e3 * POSITION, TURNS.as_euler("ZYZ", degrees=True), WRENCH),
    ),
    "Doosan's flange": (
        f"time {numbered('actual_flange_position_')} {numbered('raw_force_torque_')}",
        (TIME, 1e3 * POSITION, TURNS.as_euler("ZYZ", degrees=True), WRENCH),
    ),
    "xArm": (
        f"time {numbered('position_')} {numbered('ft_raw_')}",
        (TIME, 1e3 * POSITION, DEGREES, WRENCH),
    ),
    "EuRoC": (
        "#timestamp[ns] p_RS_R_x[m] p_RS_R_y[m] p_RS_R_z[m] q_RS_w[] q_RS_x[] q_RS_y[] q_RS_z[]"
        " fx fy fz tx ty tz",
        (1e9 * TIME, POSITION, QUATERNION[:, [3, 0, 1, 2]], WRENCH),
    ),
    "Kinova": (
        "timestamp tool_pose_x tool_pose_y tool_pose_z tool_pose_theta_x"
        " tool_pose_theta_y tool_pose_theta_z force_x force_y force_z"
        " torque_x torque_y torque_z",
        (TIME, POSITION, DEGREES, WRENCH),
    ),
    "units with factors": (
        "Zeit X[um] Y[um] Z[um] alphaRad betaRad gammaRad"
        " Fx[0.1N] Fy[0.1N] Fz[0.1N] Mx[1e-3Nm] My[1e-3Nm] Mz[1e-3Nm]",
        (
            TIME,
            1e6 * POSITION,
            TURNS.as_euler("ZYX"),
            WRENCH * ((10,) * 3 + (1e3,) * 3),
        ),
    ),
    "nanoseconds of Java": (
        "timestampNanos x y z qx qy qz qw fx fy fz tx ty tz",
        (1e9 * TIME, *PLAIN[1:]),
    ),
    "EGM's messages": (
        f"time x y z {numbered('u', 4)} fx fy fz tx ty tz",
        (TIME, POSITION, QUATERNION[:, [3, 0, 1, 2]], WRENCH),
    ),
    "a matrix by the letter of the torque": (
        f"time {numbered('T', 16)} Fx Fy Fz Tx Ty Tz",
        (TIME, BY_COLUMNS, WRENCH),
    ),
    "letters beyond ASCII": (
        "时间 速度X 速度Y 速度Z X Y Z qx qy qz qw fx fy fz tx ty tz",
        (TIME, 2 * POSITION, *PLAIN[1:]),
    ),
    "microseconds": (
        "time_µs Δx Δy Δz x y z qx qy qz qw fx fy fz tx ty tz",
        (1e6 * TIME, 2 * POSITION, *PLAIN[1:]),
    ),
    "another wrench before it": (
        "time x y z qx qy qz qw fx_filt fy_filt fz_filt tx_filt ty_filt tz_filt"
        " fx fy fz tx ty tz",
        (*PLAIN[:3], 0.9 * WRENCH, WRENCH),
    ),
    "a gripper's wrench before it": (
        "time x y z qx qy qz qw gripper_fx gripper_fy gripper_fz gripper_tx gripper_ty"
        " gripper_tz fx fy fz tx ty tz",
        (*PLAIN[:3], 0.9 * WRENCH, WRENCH),
    ),
    "set points beside it": (
        "time x_cmd y_cmd z_cmd x y z target_qx target_qy target_qz target_qw"
        " qx qy qz qw fx fy fz tx ty tz",
        (TIME, 2 * POSITION, POSITION, QUATERNION[::-1], QUATERNION, WRENCH),
    ),
}


def frame_of(names: str, parts: tuple[np.ndarray, ...]) -> pd.DataFrame:
    """The parts side by side under these names."""
    return pd.DataFrame(np.column_stack(parts), columns=names.split())


def same(got: hefting.Recording) -> bool:
    """Whether a recording holds what was written, apart from when it began."""
    apart = Rotation.from_quat(got["orientation"].values) * TURNS.inv()
    time = got["wrench"].time - got["wrench"].time[0]
    return (
        # seconds since 1970 resolve 2.4e-7 s; text of 17 digits is exact, and what is
        # converted from millimetres or degrees is rounded again
        np.allclose(time, TIME, atol=5e-7)
        and np.allclose(got["position"].values, POSITION, atol=1e-12)
        and np.allclose(got["wrench"].values, WRENCH, rtol=1e-12)
        and apart.magnitude().max() < 1e-7
    )


@pytest.mark.parametrize("case", NAMES)
@pytest.mark.parametrize("form", ["csv", "parquet", "memory"])
def test_other_names_are_read_by_what_they_say(tmp_path, case, form):
    frame = frame_of(*NAMES[case])
    if form == "memory":
        got = hefting.as_recording(frame)
    else:
        path = tmp_path / f"log.{form}"
        frame.to_csv(path, index=False) if form == "csv" else frame.to_parquet(path)
        got = read_log(path)
    assert same(got)
    assert "columns-by-name" in codes(got.warnings)


def test_what_was_taken_for_what_is_said_and_gives_no_doubt(tmp_path):
    names = "t X[mm] Y[mm] Z[mm] roll pitch yaw Fx Fy Fz Mx My Mz vx vy vz"
    parts = (TIME, 1e3 * POSITION, TURNS.as_euler("xyz"), WRENCH, POSITION)
    frame_of(names, parts).to_csv(tmp_path / "log.csv", index=False)
    [said] = read_log(tmp_path / "log.csv").warnings
    for words in (
        "time from t (s)",
        "wrench from Fx to Mz (N, N m)",
        "orientation from roll to yaw (rpy, rad)",
        "position from X[mm] to Z[mm] (mm)",
        "vx, vy, vz not read",
    ):
        assert words in said
    assert said.code in NO_DOUBT


def test_a_whole_canonical_log_is_read_as_such(tmp_path):
    """Velocities, which no other name would tell, are not lost for a column more."""
    names = " ".join(CANONICAL) + " vx vy vz wx wy wz joint_1 joint_2 joint_3 joint_4"
    parts = (*PLAIN, POSITION, POSITION, QUATERNION)
    got = hefting.as_recording(frame_of(names, parts))
    assert codes(got.warnings) == {"columns-ignored"}
    assert got.has("linear_velocity")
    assert not got.has("joint_positions")


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("time x y z qx qy qz qw fx fy fz tx ty k", "'tz' is missing beside fx fy"),
        ("k x y z qx qy qz qw fx fy fz tx ty tz", "did you mean"),
        ("time x y z px py qx qy qz qw fx fy fz tx", "missing beside px py"),
    ],
)
def test_a_name_that_is_lost_is_not_made_up(names, words):
    if names.startswith("k"):
        names = names.replace("k", "tiem", 1)
    frame = pd.DataFrame(RNG.normal(size=(ROWS, 14)), columns=names.split())
    with pytest.raises(InputError, match=words):
        hefting.as_recording(frame)


def test_of_a_wrench_that_a_controller_estimates_the_load_is_asked():
    for case in ("Franka", "Franka in base axes", "Franka in both axes"):
        got = hefting.as_recording(frame_of(*NAMES[case]))
        assert codes(got.warnings) == {"columns-by-name", "payload-unknown"}


def test_what_names_tell_is_said_where_they_do_not_tell_all():
    names = "time x y z phi psi chi fx fy fz tx ty tz"
    frame = frame_of(names, (TIME, POSITION, TURNS.as_rotvec(), WRENCH))
    with pytest.raises(InputError) as caught:
        hefting.as_recording(frame.rename(columns={"fx": "Fx"}))
    error = caught.value
    assert "no column seems to be the orientation: unknown are 'phi'" in error.what
    assert "wrench from Fx to tz" in error.what
    assert "column map" in error.fix
    assert "`poses`" in error.fix


def test_what_is_in_metres_turns_nothing():
    """``r`` is for rotations, too."""
    names = "time r_x[m] r_y[m] r_z[m] Fx Fy Fz Tx Ty Tz"
    with pytest.raises(InputError, match="no column seems to be the orientation"):
        hefting.as_recording(frame_of(names, (TIME, POSITION, WRENCH)))


def test_where_only_the_time_is_unknown_it_is_said_how_to_name_it():
    """Also that without it rows are static poses, as they may be."""
    names = NAMES["short"][0].replace("t x", "Takt x", 1)
    with pytest.raises(InputError) as caught:
        hefting.as_recording(frame_of(names, PLAIN))
    error = caught.value
    assert error.what.startswith("no column seems to be the time: unknown are 'Takt';")
    for words in ('time = { column = "time"', "{ rate = 250 }", "static poses"):
        assert words in error.fix


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1)])
@pytest.mark.parametrize(
    "form", ["{}", "/joint_states/{}/position", "/joint_states/position/{}"]
)
def test_joints_keep_their_names(order, form):
    """The URDF's order is found by them: tables of ROS have that of the alphabet. The
    others are as PlotJuggler writes them."""
    joints = ["pan_joint", "lift_joint", "elbow_joint", "wrist_1_joint"]
    if form != "{}":
        joints[-1] = "joint_7"
    angles = RNG.uniform(-1.0, 1.0, (ROWS, 4))
    columns = [form.format(joints[i]) for i in order]
    speeds = [name.replace("position", "velocity") for name in columns]
    beside = speeds if speeds != columns else []
    names = ["time", *columns, *beside, *CANONICAL[8:]]
    rates = np.zeros((ROWS, len(beside)))
    frame = frame_of(" ".join(names), (TIME, angles[:, list(order)], rates, WRENCH))
    got = hefting.as_recording(frame)
    assert got.joint_names == tuple(joints[i] for i in order)
    np.testing.assert_array_equal(got["joint_positions"].values, angles[:, list(order)])


def test_joints_of_a_robot_beside_a_wrench_of_another_sensor():
    names = f"time {numbered('actual_q_')} fx fy fz tx ty tz"
    angles = RNG.uniform(-1.0, 1.0, (ROWS, 6))
    got = hefting.as_recording(frame_of(names, (TIME, angles, WRENCH)))
    np.testing.assert_array_equal(got["joint_positions"].values, angles)
    np.testing.assert_array_equal(got["wrench"].values, WRENCH)


def text_of(separator: str = ",", decimal: str = ".") -> list[str]:
    """The canonical log as lines of text."""
    frame = frame_of(" ".join(CANONICAL), PLAIN)
    return frame.to_csv(index=False, sep=separator, decimal=decimal).splitlines()


LINES = text_of()
UNITS = "s,m,m,m,,,,,N,N,N,Nm,Nm,Nm"
BEFORE = {
    "nothing": LINES,
    "comments": ["# recorded in the lab, by hand", "% robot: UR5", "", *LINES],
    "a commented header": ["# made by a script", f"# {LINES[0]}", *LINES[1:]],
    "rostopic": [f"%{LINES[0]}", *LINES[1:]],
    "other text": ["Recorded: 2026-01-31 12:00", "Robot;UR5", "", *LINES],
    "units": [LINES[0], UNITS, *LINES[1:]],
    "groups": [",pose,,,pose,,,,wrench,,,wrench,,", *LINES],
    "decimal commas": text_of(";", ","),
    "tabs and decimal commas": text_of("\t", ","),
}


@pytest.mark.parametrize("case", BEFORE)
def test_what_stands_around_the_names(tmp_path, case):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(BEFORE[case]) + "\n")
    got = read_log(path)
    assert same(got)
    assert not got.warnings
    lines = [line for line in BEFORE[case] if line]
    first = BEFORE[case].index(lines[-ROWS])
    assert got["wrench"].rows[0] == first + 1


def test_a_row_that_is_too_short_is_no_line_of_units(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join((LINES[0], "0,1,2", *LINES[1:])))
    with pytest.raises(InputError, match="row 2: there are 3 cells under 14"):
        read_log(path)


@pytest.mark.parametrize("zone", ["", "Z", "+01:00"])
@pytest.mark.parametrize("between", ["T", " "])
def test_dates_are_times(tmp_path, zone, between):
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    dates = [
        (began + timedelta(seconds=t)).strftime(f"%Y-%m-%d{between}%H:%M:%S.%f") + zone
        for t in TIME
    ]
    lines = [
        f"{date},{line.partition(',')[2]}"
        for date, line in zip(dates, LINES[1:], strict=True)
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join((LINES[0], *lines)))
    assert same(read_log(path))
    path.write_text("\n".join((LINES[0], *lines[:9], "soon" + lines[9][4:])))
    with pytest.raises(
        InputError, match=r"row 11, column time: 'soon.*is no date like"
    ):
        read_log(path)


WAYS = {"%d.%m.%Y %H:%M:%S.%f": "timestamp", "%H:%M:%S.%f": "Time"}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("block", [2**20, 1500])
def test_dates_with_the_day_first_and_times_of_day(tmp_path, monkeypatch, way, block):
    """Which go on past midnight, in whatever block."""
    monkeypatch.setattr("hefting.logs.csv_file.READ", block)
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    times = [(began + timedelta(seconds=t)).strftime(way) for t in TIME]
    frame = frame_of(" ".join(CANONICAL), PLAIN).assign(time=times)
    path = tmp_path / "log.csv"
    frame.rename(columns={"time": WAYS[way]}).to_csv(path, index=False)
    assert same(read_log(path))


@pytest.mark.parametrize("name", ["when", "记录", "#", "Timestamp"])
@pytest.mark.parametrize("step", [0.01, 0.5, 2.0])
def test_dates_are_the_time_by_whatever_name(tmp_path, name, step):
    """Those of static poses tell that they are such."""
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    times = [(began + timedelta(seconds=step * k)).isoformat() for k in range(ROWS)]
    frame = frame_of(" ".join(CANONICAL), PLAIN).assign(time=times)
    path = tmp_path / "log.csv"
    frame.rename(columns={"time": name}).to_csv(path, index=False)
    got = read_log(path)
    assert got.static == (step > 1.0)
    if not got.static:
        assert got.duration == pytest.approx(step * (ROWS - 1))


def test_of_a_time_that_is_not_read_it_is_said_what_is(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"{LINES[0]}\n3-Apr-2026 13:31:07,{LINES[1].partition(',')[2]}")
    with pytest.raises(InputError, match=r"in seconds, or as 2026-01-31T12:00:00.000"):
        read_log(path)


@pytest.mark.parametrize("date", ["2026-13-41T12:00:00", "9999-12-31T12:00:00"])
def test_a_date_that_cannot_be_is_named(tmp_path, date):
    """The first of all is no date at all, so that its column is one of numbers."""
    dates = [f"2026-01-31T12:00:0{k}" for k in range(10)]
    lines = [
        f"{d},{line.partition(',')[2]}"
        for d, line in zip(dates, LINES[1:], strict=False)
    ]
    path = tmp_path / "log.csv"
    for row, words in ((4, "is no date like"), (2, "is not a number")):
        wrong = [LINES[0], *lines]
        wrong[row - 1] = f"{date},{LINES[row - 1].partition(',')[2]}"
        path.write_text("\n".join(wrong))
        with pytest.raises(
            InputError, match=f"row {row}, column time: '{date}' {words}"
        ):
            read_log(path)


@pytest.mark.parametrize("kind", ["date", "date with a zone", "duration"])
def test_times_of_pandas_in_parquet(tmp_path, kind):
    frame = frame_of(" ".join(CANONICAL), PLAIN)
    time = pd.to_timedelta(frame["time"], unit="s")
    if kind != "duration":
        time = pd.Timestamp("2026-01-31T12:00") + time
    if kind == "date with a zone":
        time = time.dt.tz_localize("Europe/Berlin")
    frame.assign(time=time).to_parquet(tmp_path / "log.parquet")
    assert same(read_log(tmp_path / "log.parquet"))


def test_the_index_of_a_frame_is_its_time(tmp_path):
    """Where it grows by more than rows do."""
    frame = frame_of(" ".join(CANONICAL), PLAIN)
    frame.drop(columns="time").set_index(TIME).to_csv(tmp_path / "log.csv")
    assert same(read_log(tmp_path / "log.csv"))
    frame.to_csv(tmp_path / "log.csv")  # 0, 1, 2 in front of the time
    got = read_log(tmp_path / "log.csv")
    assert same(got)
    assert codes(got.warnings) == {"columns-ignored"}


INDICES = {
    "dates": pd.Timestamp("2026-01-31T23:59:59.9") + pd.to_timedelta(TIME, unit="s"),
    "numbers": pd.Index(2.0 + TIME),
    "a name": pd.Index(TIME, name="stamp"),
}


@pytest.mark.parametrize("case", INDICES)
def test_the_index_of_a_frame_is_its_time_in_memory_and_in_parquet(tmp_path, case):
    frame = frame_of(" ".join(CANONICAL), PLAIN).drop(columns="time")
    frame = frame.set_index(INDICES[case])
    frame.to_parquet(tmp_path / "log.parquet")
    for got in (hefting.as_recording(frame), read_log(tmp_path / "log.parquet")):
        assert same(got)


def test_an_index_of_picked_rows_is_no_time(tmp_path):
    frame = frame_of(" ".join(CANONICAL), PLAIN).drop(columns="time")
    frame = frame[frame["fx"] > 0.0]
    frame.to_parquet(tmp_path / "log.parquet")
    for got in (hefting.as_recording(frame), read_log(tmp_path / "log.parquet")):
        assert got.static


def test_windows_say_once_what_was_taken(tmp_path):
    frame = frame_of(*NAMES["short"])
    frame.to_csv(tmp_path / "log.csv", index=False)
    first, *others = windows(tmp_path / "log.csv", rows=15)
    assert "columns-by-name" in codes(first.warnings)
    assert others
    assert not any("columns-by-name" in codes(each.warnings) for each in others)


def test_without_a_wrench_nothing_is_taken_by_its_name(tmp_path):
    frame_of(*NAMES["short"]).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(InputError, match="did you mean 'time'"):
        read_log(tmp_path / "log.csv", wrench_needed=False)


def test_a_short_text_without_a_last_line_end(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(("# by hand", *LINES[:3])))
    assert len(read_log(path)["wrench"]) == 2


def test_names_far_down_are_read_where_a_map_says_so(tmp_path):
    path, told = tmp_path / "log.csv", tmp_path / "map.toml"
    path.write_text("\n".join(("note;" * 3,) * 400) + "\n" + "\n".join(LINES))
    wrench, turned = CANONICAL[8:], CANONICAL[4:8]
    told.write_text(
        f'header = 401\ntime = "time"\nwrench = {wrench}\norientation = {turned}\n'
    )
    assert read_log(path, told)["wrench"].values.tolist() == WRENCH.tolist()


def test_dates_of_1970_and_decimal_commas_beside_dates(tmp_path):
    """The first of all is zero seconds, and dates keep their point."""
    lines = text_of(";", ",")
    rows = [
        f"1970-01-01T00:00:{0.25 * k:06.3f};{line.partition(';')[2]}"
        for k, line in enumerate(lines[1:])
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join((lines[0], *rows)))
    got = read_log(path)
    assert got["wrench"].time.tolist() == (0.25 * np.arange(ROWS)).tolist()
    assert got["wrench"].values.tolist() == WRENCH.tolist()
    path.write_text("\n".join((lines[0], *rows[:5], rows[5].replace("0,", "0.5,", 1))))
    with pytest.raises(InputError, match=r"row 7, column .*is not a number"):
        read_log(path)


def test_a_name_of_many_marks_takes_no_time_that_grows_with_its_square(tmp_path):
    """Where blanks before a unit were looked for, 60,000 marks took more than 9 s."""
    few, many = (refusal_time(BRACKETS, count * "_") for count in (2_000, 20_000))
    # ten times as long, with a margin for clocks; the square would be a hundred
    assert many < 40.0 * few
    found = BRACKETS.match("Fx_[N]")
    assert found is not None
    assert found.groups() == ("Fx", "N")
    path = tmp_path / "log.csv"
    rows = [line + ",1" for line in LINES[1:]]
    path.write_text("\n".join((f"{LINES[0]},{60_000 * '_'}", *rows)))
    assert len(read_log(path)["wrench"]) == len(LINES) - 1
