"""The files that the pages of the docs name, with something in them to be found."""

from pathlib import Path
from shutil import copy

import numpy as np
from scipy.spatial.transform import Rotation

from bags import Entry, write
from demo_files import write_demo
from disturbances import body
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.logs import write_log
from hefting.simulation import UR5, Arm, Faults, Rates, random_smooth, record
from hefting.simulation.faults import WRENCH_NOISE
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS, TorqueRobot
from hefting.simulation.wield import wield_analytically
from reference.recorded import changed

OBJECT = body(0.512)
GRIPPER = body(0.4)
FAULTS = Faults(wrench_noise=WRENCH_NOISE["moderate"])
ARM = TORQUE_ARMS["ur5e"]
IN_MARKER = np.array((0.0, 0.02, -0.11))
"""Place of the sensor [m], with the marker's axes."""
FRAMES = ("tool0", "ft_link", "link_eef", "fr3_link8")
"""Frames at the flange, as the makers of robots call them."""


def make(folder: Path) -> None:
    """Write all of them.

    ``log.csv`` holds poses and wrenches; of others its place takes ``franka.csv``, with
    the columns of a map, or ``joints.csv``, with joint angles. Those that begin with
    ``marker-`` hold the poses of a marker, in which the sensor is at `IN_MARKER`. In
    ``picked-up.csv`` nothing is held for two seconds.
    """
    write_demo(folder / "demo")
    for name in ("held.json", "now.json"):
        copy(folder / "demo" / "estimate.json", folder / name)
    _robots(folder)
    _torques(folder)
    logs = {"log": OBJECT, "empty": GRIPPER, "full": GRIPPER + OBJECT}
    for name, thing in logs.items():
        write_log(_recorded(thing), folder / f"{name}.csv")
        write_log(_of_marker(_recorded(thing)), folder / f"marker-{name}.csv")
    copy(folder / "full.csv", folder / "held.csv")
    copy(folder / "marker-full.csv", folder / "marker-held.csv")
    _of_ur(_recorded(OBJECT), folder / "record.csv")
    _of_franka(_recorded(OBJECT), folder / "franka.csv")
    write_log(_picked_up(_recorded(OBJECT)), folder / "picked-up.csv")
    joints = _with_joints(folder / "robot.urdf")
    write_log(joints, folder / "joints.csv")
    write(folder, "bare.mcap", _messages(joints)).rename(folder / "log.mcap")


def _recorded(thing: InertialParameters) -> Recording:
    """Eight seconds in the hand of an arm."""
    motion = random_smooth(8.0, 100.0, 1.2, seed=3)
    return record(wield_analytically(UR5, motion, thing), FAULTS, seed=4)


def _of_marker(recording: Recording) -> Recording:
    """With the poses of the marker."""
    R = Rotation.from_quat(recording["orientation"].values)
    return changed(recording, "position", lambda _, place: place - R.apply(IN_MARKER))


def _picked_up(recording: Recording) -> Recording:
    """With nothing but noise in the wrench for two seconds."""

    def bare(time: Array, wrench: Array) -> Array:
        noise = np.random.default_rng(6).normal(size=wrench.shape)
        return np.where(time[:, None] < 2.0, noise * FAULTS.wrench_noise, wrench)

    return changed(recording, "wrench", bare)


def _robots(folder: Path) -> None:
    """One arm under the names that the pages give it."""
    more = "".join(
        f'<link name="{name}"/><joint name="to_{name}" type="fixed">'
        f'<parent link="flange"/><child link="{name}"/></joint>'
        for name in FRAMES
    )
    text = ARM.urdf.replace("</robot>", f"{more}</robot>")
    for name in ("arm", "robot", "xarm7", "fr3"):
        (folder / f"{name}.urdf").write_text(text)


def _torques(folder: Path) -> None:
    """An empty and a loaded run of joint torques."""
    robot = TorqueRobot(ARM, seed=2)
    for name, thing, start in (("empty", None, 0.0), ("held", body(1.1), 60.0)):
        motion = wide_smooth(15.0, 50.0, len(name), ARM.arm)
        write_log(
            robot.record(motion, thing, start, seed=len(name)), folder / f"{name}.mcap"
        )


def _with_joints(urdf: Path) -> Recording:
    """Joint angles, the poses that follow from them, and the wrench."""
    arm = Arm.from_urdf(urdf, "ft_link")
    motion = random_smooth(8.0, 100.0, 1.2, seed=3, arm=arm)
    return record(
        wield_analytically(arm, motion, OBJECT), FAULTS, Rates(joints=100.0), 4
    )


def _messages(recording: Recording) -> list[Entry]:
    """Wrenches, transforms and joint states of a ROS bag."""
    entries: list[Entry] = []
    for k, time in enumerate(np.array(recording["wrench"].time)):
        logged = int(1e9 * (1.7e9 + time))
        position, orientation, q, wrench = (
            recording[name].values[k]
            for name in ("position", "orientation", "joint_positions", "wrench")
        )
        transform = {
            "stamp": logged,
            "frame": "base_link",
            "child_frame_id": "ft_link",
            "transform.translation": position,
            "transform.rotation": orientation,
        }
        head = {"stamp": logged, "frame": "ft_link"}
        force = {"wrench.force": wrench[:3], "wrench.torque": wrench[3:]}
        names = {"name": list(recording.joint_names or ()), "position": q}
        entries += [
            ("/tf", "tf2_msgs/TFMessage", logged, {"transforms": [transform]}),
            ("/ft_sensor/wrench", "geometry_msgs/WrenchStamped", logged, head | force),
            ("/joint_states", "sensor_msgs/JointState", logged, head | names),
        ]
    return entries


def _of_ur(recording: Recording, path: Path) -> None:
    """A real-time record: poses with rotation vectors, the raw wrench, no payload."""
    vectors = Rotation.from_quat(recording["orientation"].values).as_rotvec()
    columns = {
        "timestamp": np.array(recording["wrench"].time)[:, None],
        "actual_TCP_pose": np.hstack((recording["position"].values, vectors)),
        "ft_raw_wrench": recording["wrench"].values,
        "payload": np.zeros((len(vectors), 1)),
        "tcp_offset": np.zeros((len(vectors), 6)),
    }
    names = [
        name if values.shape[1] == 1 else f"{name}_{i}"
        for name, values in columns.items()
        for i in range(values.shape[1])
    ]
    _write_table(path, " ", names, np.hstack(list(columns.values())))


def _of_franka(recording: Recording, path: Path) -> None:
    """Times in ms, poses as matrices column by column."""
    poses = np.tile(np.eye(4), (len(recording["wrench"].time), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(recording["orientation"].values).as_matrix()
    poses[:, :3, 3] = recording["position"].values
    names = [
        "time",
        *(f"O_T_EE[{i}]" for i in range(16)),
        *(f"ft_{i}" for i in range(6)),
    ]
    time = 1e3 * np.array(recording["wrench"].time)
    columns = (
        time[:, None],
        poses.transpose(0, 2, 1).reshape(-1, 16),
        recording["wrench"].values,
    )
    _write_table(path, ",", names, np.hstack(columns))


def _write_table(path: Path, separator: str, names: list[str], rows: Array) -> None:
    head = separator.join(names)
    np.savetxt(path, rows, delimiter=separator, header=head, comments="", fmt="%.9g")
