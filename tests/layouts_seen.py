"""Tables of one recording under the names that robots, sensors and their programs give,
and what other columns beside it hold."""

import numpy as np

from known_rows import (
    POSITION,
    QUATERNION,
    ROWS,
    TIME,
    TURNS,
    WRENCH,
)

RNG = np.random.default_rng(17)
WXYZ = QUATERNION[:, [3, 0, 1, 2]]
MATRICES = np.tile(np.eye(4), (ROWS, 1, 1))
MATRICES[:, :3, :3], MATRICES[:, :3, 3] = TURNS.as_matrix(), POSITION
ELSE = RNG.normal(size=(ROWS, 7))
"""What other columns hold."""
RPY, ZYX = TURNS.as_euler("xyz"), TURNS.as_euler("ZYX")
SMALL = 0.3 * np.sin(TIME[:, None] + (0.0, 1.0, 2.0))
"""[rad] Angles that neither form of three lets jump."""


def each(pattern: str, of: str = "x y z") -> str:
    """Names with each of these in the place of ``*``."""
    return " ".join(pattern.replace("*", one) for one in of.split())


def numbered(name: str, count: int, first: int = 0) -> str:
    return " ".join(f"{name}{first + i}" for i in range(count))


POSE, FT = "x y z qx qy qz qw", "fx fy fz tx ty tz"
BASIC = f"time {POSE}"
IJ = [f"{i}{j}" for i in range(4) for j in range(4)]

BESIDE = {
    "torques of joints": (
        f"{BASIC} {numbered('torque_', 7)} Fx Fy Fz Tx Ty Tz",
        (TIME, POSITION, QUATERNION, ELSE, WRENCH),
    ),
    "a magnetometer": (
        f"{BASIC} {each('F*')} {each('T*')} ax ay az gx gy gz mx my mz",
        (TIME, POSITION, QUATERNION, WRENCH, np.tile(ELSE[:, :3], 3)),
    ),
    "a prediction": (
        f"{BASIC} {each('pred_*', FT)} {each('meas_*', FT)}",
        (TIME, POSITION, QUATERNION, 1.2 * WRENCH, WRENCH),
    ),
    "a compensated wrench": (
        f"{BASIC} {each('wrench_compensated.*', FT)} {each('wrench_raw.*', FT)}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "filtered, behind": (
        f"{BASIC} {each('*_filtered', FT)} {each('*_raw', FT)}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "the other arm": (
        f"time {each('left_*', POSE)} {each('right_*', POSE)} {each('right_*', FT)}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "an object": (
        f"time {each('cube_pos_*')} {each('cube_quat_*', 'x y z w')} "
        f"{each('eef_pos_*')} {each('eef_quat_*', 'x y z w')} "
        f"{each('ee_force_*')} {each('ee_torque_*')}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "a tree of frames": (
        f"__time {each('/tf/base/elbow/translation/*')} "
        f"{each('/tf/base/elbow/rotation/*', 'x y z w')} "
        f"{each('/tf/base/tool0/translation/*')} "
        f"{each('/tf/base/tool0/rotation/*', 'x y z w')} "
        f"{each('/w/wrench/force/*')} {each('/w/wrench/torque/*')}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "an inertial sensor": (
        f"t {each('imu_orientation_*', 'x y z w')} x y z rx ry rz {each('F*')} {each('M*')}",
        (TIME, ELSE[:, :4], POSITION, SMALL, WRENCH),
    ),
    "a force without a torque": (
        f"{BASIC} {each('link_force_*')} {each('ft_force_*')} {each('ft_torque_*')}",
        (TIME, POSITION, QUATERNION, ELSE[:, :3], WRENCH),
    ),
    "gravity": (
        f"{BASIC} {each('gravity_force_*')} {each('gravity_torque_*')} "
        f"{each('Force*Raw', 'X Y Z')} {each('Torque*Raw', 'X Y Z')}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "a base": (
        f"time {each('base_link_position_*')} {each('base_link_orientation_*', 'x y z w')} "
        f"{each('link7_position_*')} {each('link7_orientation_*', 'x y z w')} {FT}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "a base that is called as the wrench is": (
        f"time {each('robot_base_pose_*', POSE)} {each('tcp_pose_*', POSE)} "
        f"{each('robot_ft_*', FT)}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "angles of the same": (
        f"t {each('/pose/position/*')} {each('/pose/orientation/*', 'x y z w')} "
        f"{each('/pose/orientation/*', 'roll pitch yaw')} "
        f"{each('/ft/force/*')} {each('/ft/torque/*')}",
        (TIME, POSITION, QUATERNION, RPY, WRENCH),
    ),
    "set points before it": (
        f"time {each('goal_pose_*', POSE)} {each('current_pose_*', POSE)} "
        f"{each('wrench_*', FT)}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "actions": (
        f"time {numbered('action.ee_pose_', 7)} {numbered('observation.ee_pose_', 7)} "
        f"{numbered('observation.force_torque_', 6)}",
        (TIME, ELSE, POSITION, QUATERNION, WRENCH),
    ),
    "Soll and Ist": (
        f"Zeit {each('*_soll', 'X Y Z A B C')} {each('*_ist', 'X Y Z A B C')} "
        f"{each('F*')} {each('M*')}",
        (TIME, ELSE[:, :6], POSITION, ZYX, WRENCH),
    ),
}
NAMES = {
    "KUKA's DataRecorder": (
        f"ZeitInSec ZeitInNanoSec {each('cartPosMsr1_*', 'X Y Z A B C')} "
        f"{each('cartForce1_*', 'X Y Z')} {each('cartTorque1_Tau*', 'X Y Z')}",
        (
            np.floor(TIME),
            np.round(1e9 * (TIME % 1)),
            1e3 * POSITION,
            np.degrees(ZYX),
            WRENCH,
        ),
    ),
    "libfranka": (
        "duration success_rate "
        f"{' '.join(f'O_T_EE[{i}]' for i in range(16))} {each('f_*')} {each('tau_*')}",
        (1e3 * TIME, ELSE[:, 0], MATRICES.swapaxes(1, 2).reshape(ROWS, 16), WRENCH),
    ),
    "a matrix": (
        f"t {each('T_*', ' '.join(IJ))} {FT}",
        (TIME, MATRICES.reshape(ROWS, 16), WRENCH),
    ),
    "a rotation matrix": (
        f"t x y z R11 R12 R13 R21 R22 R23 R31 R32 R33 {FT}",
        (TIME, POSITION, TURNS.as_matrix().reshape(ROWS, 9), WRENCH),
    ),
    "axis and angle": (
        f"time {numbered('eef_pos_', 3)} {numbered('eef_axis_angle_', 3)} {numbered('ft_', 6)}",
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
    ),
    "Doosan's posx": (
        f"time {numbered('posx_', 6)} {numbered('tool_force_', 6)}",
        (TIME, POSITION, TURNS.as_euler("ZYZ"), WRENCH),
    ),
    "ABB's EGM and its time": (
        f"header.seqno header.tm {each('pos.*')} {numbered('orient.u', 4)} "
        f"{numbered('measuredForce.force_', 6)}",
        (np.arange(ROWS), 1e3 * TIME + 12345, POSITION, WXYZ, WRENCH),
    ),
    "ABB's EGM": (
        f"time {each('pos.*')} {numbered('orient.u', 4)} {FT}",
        (TIME, POSITION, WXYZ, WRENCH),
    ),
    "simulators": (
        f"time {numbered('force_ee_', 3)} {numbered('torque_sensor_', 3)} "
        f"{numbered('xpos_', 3)} {numbered('quat_wxyz_', 4)}",
        (TIME, WRENCH, POSITION, WXYZ),
    ),
    "of a TCP": (
        f"timestamp {each('TCP_*', 'x y z rx ry rz')} {each('TCP_force_*', 'x y z rx ry rz')}",
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
    ),
    "of a TCP, its wrench by one letter": (
        f"time {each('tcp_*', 'x y z rx ry rz')} {each('f_*', 'x y z rx ry rz')}",
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
    ),
    "German angles of KUKA": (
        f"Zeit {each('Position*', 'X Y Z')} {each('Winkel_*', 'A B C')} "
        f"{each('Kraft*', 'X Y Z')} {each('Moment*', 'X Y Z')}",
        (TIME, 1e3 * POSITION, np.degrees(ZYX), WRENCH),
    ),
    "Simulink": (
        f"time {numbered('FT:', 6, 1)} {numbered('TCP:', 6, 1)}",
        (TIME, WRENCH, POSITION, SMALL),
    ),
    "MATLAB": (
        "time F(1) F(2) F(3) T(1) T(2) T(3) p(1) p(2) p(3) " + each("q*", "x y z w"),
        (TIME, WRENCH, POSITION, QUATERNION),
    ),
    "PyBullet": (
        f"t {each('link_pos_*')} {each('link_orn_*', 'x y z w')} {FT}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "what is desired, and a leader": (
        f"t {numbered('leader_pose_', 7)} {numbered('T_d_', 16)} {numbered('T_', 16)} "
        f"{numbered('finger_ft_', 6)} {numbered('wrist_ft_', 6)}",
        (
            TIME,
            POSITION[::-1],
            QUATERNION[::-1],
            MATRICES[::-1].reshape(ROWS, 16),
            MATRICES.reshape(ROWS, 16),
            0.1 * WRENCH,
            WRENCH,
        ),
    ),
    "times of computing before it": (
        f"loop_time cycle_time timestamp {POSE} {each('F*')} {each('M*')}",
        (np.abs(ELSE[:, 0]), np.full(ROWS, 0.01), TIME, POSITION, QUATERNION, WRENCH),
    ),
    "MuJoCo": (
        f"time {numbered('site_xpos_', 3)} {numbered('site_xquat_', 4)} {FT}",
        (TIME, POSITION, WXYZ, WRENCH),
    ),
    "a matrix of MuJoCo": (
        f"time {numbered('site_xpos_', 3)} {numbered('site_xmat_', 9)} {FT}",
        (TIME, POSITION, TURNS.as_matrix().reshape(ROWS, 9), WRENCH),
    ),
    "sensors of MuJoCo": (
        f"time {numbered('framepos_', 3)} {numbered('framequat_', 4)} "
        f"{numbered('force_', 3)} {numbered('torque_', 3)}",
        (TIME, POSITION, WXYZ, WRENCH),
    ),
    "Qualisys, whose angles may be in any order": (
        f"Time X Y Z Roll Pitch Yaw Residual {' '.join(f'Rot[{i}]' for i in range(9))} "
        f"{FT}",
        (
            *(TIME, 1e3 * POSITION, np.degrees(ZYX), np.abs(ELSE[:, 0])),
            *(TURNS.as_matrix().swapaxes(1, 2).reshape(ROWS, 9), WRENCH),
        ),
    ),
    "frames behind, as of Isaac Lab": (
        f"time {numbered('ee_pos_w_', 3)} {each('ee_quat_w_*', 'x y z w')} "
        f"{numbered('body_incoming_joint_wrench_b_', 6)}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "Vicon": (
        f"time {each('R*', 'X Y Z W')} {each('T*')} {each('F*')} {each('M*')}",
        (TIME, QUATERNION, POSITION, WRENCH),
    ),
    "Greek letters": (
        f"time_usec tvec_x tvec_y tvec_z phi theta psi {FT}",
        (1e6 * TIME, POSITION, RPY, WRENCH),
    ),
    "pounds": (
        f"record_time_nsec {each('*_meters', 'X Y Z')} qx qy qz qw "
        f"{each('F*(lbf)')} {each('T*(lbf-in)')}",
        (
            1.7e18 + 1e9 * TIME,
            POSITION,
            QUATERNION,
            WRENCH / ((4.4482216152605,) * 3 + (4.4482216152605 * 0.0254,) * 3),
        ),
    ),
    "an estimate of the controller by better names": (
        f"{BASIC} {each('tool_external_wrench_force_*')} "
        f"{each('tool_external_wrench_torque_*')} {numbered('ft_', 6)}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "Franka's estimate beside a sensor": (
        f"{BASIC} {numbered('K_F_ext_hat_K_', 6)} {numbered('ft_', 6)}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "a compensated wrench by canonical names": (
        f"{BASIC} {FT} {each('*_raw', FT)}",
        (TIME, POSITION, QUATERNION, ELSE[:, :6], WRENCH),
    ),
    "the position of a point, in its unit": (
        f"time_s {each('tip_*_mm')} qx qy qz qw fx fy fz taux tauy tauz",
        (TIME, 1e3 * POSITION, QUATERNION, WRENCH),
    ),
    "Chinese": (
        f"时间 {POSE} {each('力*', 'X Y Z')} {each('力矩*', 'X Y Z')}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "a time of any language by its unit": (
        f"Čas[ms] {each('*[mm]', 'X Y Z')} qx qy qz qw {each('F*')} {each('M*')}",
        (1e3 * TIME, 1e3 * POSITION, QUATERNION, WRENCH),
    ),
    "a time with a word behind": (
        f"n t_robot {POSE} {FT}",
        (np.arange(ROWS), TIME, POSITION, QUATERNION, WRENCH),
    ),
    "Simulink's structures with time": (
        f"wrench.time {numbered('wrench.signals.values_', 6)} pose.time "
        f"{numbered('pose.signals.values_', 7)}",
        (TIME, WRENCH, TIME, POSITION, QUATERNION),
    ),
    "Simulink's time": (f"tout {POSE} {FT}", (TIME, POSITION, QUATERNION, WRENCH)),
    "a sensor's name behind": (
        f"{BASIC} {each('F*_ati')} {each('T*_ati')}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "an arm's name behind": (
        f"{BASIC} {each('force_*_left')} {each('torque_*_left')}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "a translation by the letter of the torque": (
        f"time {each('pose_t*')} {each('pose_q*', 'x y z w')} {each('wrench_*', FT)}",
        (TIME, POSITION, QUATERNION, WRENCH),
    ),
    "kilograms": (
        f"elapsed {POSE} {each('F*[kg]')} {each('M*[kg-cm]')}",
        (
            TIME,
            POSITION,
            QUATERNION,
            WRENCH / 9.80665 * ((1.0,) * 3 + (1e2,) * 3),
        ),
    ),
}
