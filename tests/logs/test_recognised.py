"""Logs as other programs write them, read without a column map: by the names of their
columns."""

import numpy as np
import pandas as pd
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import NO_DOUBT, codes
from hefting.logs import read_log
from hefting.logs.map_sample import BRACKETS
from hefting.logs.windows import windows
from known_rows import (
    CANONICAL,
    LINES,
    PLAIN,
    POSITION,
    QUATERNION,
    RNG,
    ROWS,
    TIME,
    TURNS,
    WRENCH,
    frame_of,
    same,
)
from log_files import refusal_time

START = 1_700_000_000
NEWTON_MILLIMETRES = WRENCH * ((1.0,) * 3 + (1e3,) * 3)
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
    "Japanese": (
        "時刻[s] 位置X[mm] 位置Y[mm] 位置Z[mm] 姿勢Rx[deg] 姿勢Ry[deg] 姿勢Rz[deg] 力X[N] 力Y[N]"
        " 力Z[N] モーメントX[N・mm] モーメントY[N・mm] モーメントZ[N・mm]",
        (TIME, 1e3 * POSITION, np.degrees(TURNS.as_euler("xyz")), NEWTON_MILLIMETRES),
    ),
    "French": (
        "Temps(s) X Y Z qx qy qz qw ForceX(N) ForceY(N) ForceZ(N)"
        " CoupleX(N.m) CoupleY(N.m) CoupleZ(N.m)",
        PLAIN,
    ),
    "Spanish": (
        "tiempo x y z qx qy qz qw fuerza_x fuerza_y fuerza_z par_x par_y par_z",
        PLAIN,
    ),
    "torques of get_tcp_force": (
        "t x y z rx ry rz Fx Fy Fz TRx TRy TRz",
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
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
    "a wrench's six by one word": (
        "t x y z roll pitch yaw FT_X FT_Y FT_Z FT_RX FT_RY FT_RZ",
        (TIME, POSITION, TURNS.as_euler("xyz"), WRENCH),
    ),
    "a wrench and its torque": (
        "t x y z roll pitch yaw wrench_x wrench_y wrench_z torque_x torque_y torque_z",
        (TIME, POSITION, TURNS.as_euler("xyz"), WRENCH),
    ),
    "set points beside it": (
        "time x_cmd y_cmd z_cmd x y z target_qx target_qy target_qz target_qw"
        " qx qy qz qw fx fy fz tx ty tz",
        (TIME, 2 * POSITION, POSITION, QUATERNION[::-1], QUATERNION, WRENCH),
    ),
}


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


@pytest.mark.parametrize("names", ["t pos_{}", "time p{}"])
def test_why_set_points_are_not_read_is_said(names):
    at, place = names.split()
    place = " ".join(place.format(axis) for axis in "xyz")
    turn = " ".join(f"target_q{axis}" for axis in "xyzw")
    frame = frame_of(f"{at} {place} {turn} fx fy fz tx ty tz", PLAIN)
    with pytest.raises(InputError, match="names with target are of set points"):
        hefting.as_recording(frame)


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


@pytest.mark.parametrize(
    ("positions", "torques"),
    [
        ("fr3_joint{}_position", "fr3_joint{}_effort"),
        ("joint_{}_pos", "joint_{}_torque"),
        ("J{} angle", "J{} torque"),
        ("AxisAct_A{}", "Torque_A{}"),
        ("axisQMsr_LBR_iiwa_7_R800_1[{}]", "axisTauMsr_LBR_iiwa_7_R800_1[{}]"),
        ("actuators[{}].position", "actuators[{}].torque"),
        ("theta{}", "tau{}"),
        ("A{}", "torque{}"),
    ],
)
def test_joints_by_their_numbers_wherever_they_stand(positions, torques):
    columns = [form.format(j) for form in (positions, torques) for j in range(1, 7)]
    speeds = [f"fr3_joint{j}_velocity" for j in range(1, 7)]
    names = ["time", *columns, *speeds, *CANONICAL[8:]]
    q, tau = RNG.uniform(-1.0, 1.0, (2, ROWS, 6))
    values = np.column_stack((TIME, q, tau, np.zeros((ROWS, 6)), WRENCH))
    got = hefting.as_recording(pd.DataFrame(values, columns=names))
    np.testing.assert_array_equal(got["joint_positions"].values, q)
    np.testing.assert_array_equal(got["joint_torques"].values, tau)


def test_joints_of_a_robot_beside_a_wrench_of_another_sensor():
    names = f"time {numbered('actual_q_')} fx fy fz tx ty tz"
    angles = RNG.uniform(-1.0, 1.0, (ROWS, 6))
    got = hefting.as_recording(frame_of(names, (TIME, angles, WRENCH)))
    np.testing.assert_array_equal(got["joint_positions"].values, angles)
    np.testing.assert_array_equal(got["wrench"].values, WRENCH)


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
