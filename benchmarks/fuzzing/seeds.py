"""Whole files from which mutated ones are made: small, written by the project's own
writers and simulation, the same every time."""

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Seed:
    """A whole input."""

    name: str
    """of the file that is mutated, within a folder of its own"""
    data: bytes
    beside: Mapping[str, bytes] = field(default_factory=dict)
    """other files in that folder, which stay as they are"""
    argument: str = ""
    """what the command is given; empty: the file itself"""


def make_seeds(folder: Path) -> dict[str, list[Seed]]:
    """Seeds by the kind of file; files in `folder` are what commands read beside
    them."""
    _make_logs(folder)
    return {
        "csv": _read(folder, "log.csv", "exact.csv", "static.csv", "rates.csv", "lists.csv", "labview.lvm"),
        "mapped": [*_read(folder, "robot.csv")],
        "parquet": _read(folder, "log.parquet", "rates.parquet"),
        "npz": _read(folder, "named.npz", "arrays.npz"),
        "mat": _read(folder, "plain.mat", "packed.mat"),
        "jsonl": _read(folder, "messages.jsonl"),
        "arrow": _read(folder, "log.feather", "log.arrow"),
        "ur": [*_read(folder, "ur.csv"), *_ur_records()],
        "bag": [*_read(folder, "log.bag"), *_bags(folder, "ros1-bz2.bag", "ros1-lz4.bag")],
        "mcap": [*_read(folder, "log.mcap"), *_bags(folder, "bare.mcap", "bare-storage.mcap")],
        "db3": [*_storage(folder), *_bags(folder, "bare.db3")],
        "folder": _folders(folder),
        "estimate": _read(folder, "estimate.json", "ols.json", "tool.json"),
        "truth": _read(folder, "truth.json"),
        "bias": _read(folder, "bias.json"),
        "pose": _read(folder, "pose.json", "matrix.json"),
        "toml": _read(folder, "robot.toml"),
        "urdf": _read(folder, "robot.urdf"),
        "inertials": [Seed("robot.urdf", INERTIALS.encode())],
        "into-urdf": _read(folder, "robot.urdf"),
        "into-mjcf": _read(folder, "body.xml"),
        "into-sdf": _read(folder, "body.sdf"),
        "mesh": _meshes(),
        "cloud": _clouds(),
        "held": _meshes(),
        "arm": _read(folder, "robot.urdf"),
        "plan-arm": _read(folder, "arm.urdf"),
        "plan-srdf": [Seed("arm.srdf", SRDF.encode())],
        "plan-estimate": _read(folder, "estimate.json", "ols.json"),
        "options": [Seed("words.txt", line.encode()) for line in OPTIONS],
    }  # fmt: skip


OPTIONS = (
    "inspect\n{folder}/log.csv\n--gravity\n0,0,-9.80665",
    "identify\n{folder}/log.csv\n--gravity\n0,0,-9.80665\n--method\nOLS",
    "identify\n{folder}/log.csv\n--start\n0.5\n--duration\n2.5\n--points\n56",
    "identify\n{folder}/static.csv\n--bias\ntare:0,3\n--shape\nbox:-0.1,0.1,-0.2,0.1,0,0.3",
    "identify\n{folder}/static.csv\n--shape\n{folder}/box.stl\n--pose-std\n5mm,5deg\n--shape-std\n20%",
    "identify\n{folder}/log.csv\n--until\nmass=1%,com=2mm,inertia=20%\n--sensor-error\n0.005",
    "identify\n{folder}/static.csv\n--shape\n{folder}/box.stl\n--object-pose\n0,0,0.1,0,0,0,1",
    "identify\n{folder}/static.csv\n--shape\n{folder}/box.stl\n--points-per-cm3\n0.5\n--method\nPMD",
    "predict\n{folder}/estimate.json\n{folder}/log.csv\n--gravity\n0,0,-9.8\n--start\n1\n--duration\n2",
    "export\n{folder}/estimate.json\n--to\nur\n--sensor-pose-in-flange\n0,0,0.03,0,0,0,1",
)
"""Commands, a word a line, whose words are mutated."""

SRDF = (
    '<robot name="r"><group name="all"><chain base_link="base" tip_link="tool"/></group>'
    '<disable_collisions link1="turret" link2="lower" reason="Never"/>'
    '<disable_collisions link1="base" link2="upper" reason="Never"/></robot>'
)
"""Which links of the arm of boxes are not checked against each other."""


def _make_logs(folder: Path) -> None:
    """Everything that can be read, and the results of reading it."""
    from folding_arm import folding_arm
    from hefting.core.files import write_atomically
    from hefting.core.inertia import InertialParameters
    from hefting.core.measurements import NOISE_LEVELS
    from hefting.core.recording import Recording, Stream
    from hefting.export import export
    from hefting.identification import calibrate, identify
    from hefting.logs import write_log
    from hefting.simulation import UR5, simulate, sinusoids, truth
    from urdfs import UR5_URDF

    body = InertialParameters.from_com(1.2, (0.01, -0.02, 0.08), 2e-3 * np.eye(3))
    joints = sinusoids(4.0, 20.0, 1.0)
    motion, noise = UR5.motion(joints), NOISE_LEVELS["moderate"]
    log = simulate(motion, body, noise=noise)
    exact = simulate(motion, body, noise=noise, exact=True)
    for suffix in (".csv", ".parquet", ".bag", ".mcap", ""):
        write_log(log, folder / f"log{suffix}")
    write_log(exact, folder / "exact.csv")
    rows = {name: stream[::5] for name, stream in log.streams.items()}
    index = np.arange(len(rows["wrench"]), dtype=float)
    static = {name: Stream(index, stream.values) for name, stream in rows.items()}
    write_log(Recording(static, static=True), folder / "static.csv")
    _make_archives(log, folder)
    _make_texts(log, folder)
    rates = dict(exact.streams) | {"wrench": exact["wrench"][::2]}
    rates["gyroscope"] = exact["angular_velocity"][::3]
    for suffix in (".csv", ".parquet"):
        write_log(Recording(rates), folder / f"rates{suffix}")
    angles = Stream(motion.time, joints.position)
    with_joints = {"joint_positions": angles, "wrench": log["wrench"]}
    write_log(Recording(with_joints), folder / "joints.csv")
    (folder / "robot.urdf").write_text(UR5_URDF)
    folding_arm(folder)
    (folder / "robot.csv").write_bytes(_foreign(log))
    (folder / "robot.toml").write_text(COLUMN_MAP)
    (folder / "ur.csv").write_bytes(_ur_record(log))

    light = InertialParameters.from_com(0.4, (0.0, 0.0, 0.03), 2e-4 * np.eye(3))
    gripper = simulate(motion, light, noise=noise)
    calibrate(gripper).save(folder / "tool.json")
    found = identify(log).estimate
    found.save(folder / "estimate.json")
    identify(log, method="OLS").estimate.save(folder / "ols.json")
    for suffix, target in ((".xml", "mjcf"), (".sdf", "sdf")):
        write_atomically(folder / f"body{suffix}", export(found, target).text)
    known = truth(body, (0.1, 0.1, 0.1), np.eye(4))
    for name, content in (
        ("truth", known),
        ("bias", [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]),
        ("pose", [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0]),
        ("matrix", np.eye(4).tolist()),
    ):
        (folder / f"{name}.json").write_text(json.dumps(content))
    (folder / "box.stl").write_bytes(_box().export(file_type="stl"))


def _make_texts(log: Any, folder: Path) -> None:
    """The same with lists in cells, of which some go over several lines, and as LabVIEW
    writes it, in two segments."""
    columns = [log["wrench"].time, log["position"].values, log["orientation"].values]
    columns += [log["wrench"].values[:, :3].tolist(), log["wrench"].values[:, 3:]]
    lines = ["time,position,quat,force,torque"]
    for time, *cells in zip(*columns, strict=True):
        lines.append(f"{time:.9g}" + "".join(f',"{cell}"' for cell in cells))
    (folder / "lists.csv").write_text("\n".join(lines) + "\n")
    names = ["x", "y", "z", "qx", "qy", "qz", "qw", "fx", "fy", "fz", "tx", "ty", "tz"]
    table = np.column_stack(
        [log[k].values for k in ("position", "orientation", "wrench")]
    )
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\n"
    for begin in (0, 40):
        head += (
            f"\nDate\t2026/01/31\nTime\t12:00:{begin / 20:06.3f}\nX_Dimension\tTime\n"
        )
        head += "Delta_X\t0.05\n***End_of_Header***\nX_Value\t" + "\t".join(names)
        head += "\tComment\n"
        for row in table[begin : begin + 40]:
            head += "\t" + "\t".join(f"{x:.9g}" for x in row) + "\n"
    (folder / "labview.lvm").write_text(head)


def _make_archives(log: Any, folder: Path) -> None:
    """Arrays of NumPy and MATLAB by the names of streams, and by other names; the same
    as JSON lines and as Arrow's files."""
    from pyarrow import feather, ipc
    from scipy.io import savemat

    from hefting.logs.canonical import table_from_recording

    values = {name: log[name].values for name in ("position", "orientation", "wrench")}
    time = log["wrench"].time
    np.savez(folder / "named.npz", time=time, **values)
    poses = np.hstack([values["position"], values["orientation"]])
    pixels = np.zeros((2, 20, 20), dtype=np.uint8)
    np.savez_compressed(
        folder / "arrays.npz",
        t=time,
        tcp_pose=poses,
        ft=values["wrench"].T,
        image=pixels,
    )
    savemat(folder / "plain.mat", {"time": time[:, None], **values})
    nested = {"t": time, "robot": {"tcp_pose": poses, "mode": "held"}}
    cells = np.array([values["wrench"][0], pixels], dtype=object)
    packed = nested | {"ft": values["wrench"].T, "cells": cells}
    savemat(folder / "packed.mat", packed, do_compression=True)
    lines = [
        {
            "stamp": {"sec": 1_700_000_000 + int(t), "nanosec": int(1e9 * (t % 1))},
            "pose": {"position": dict(zip("xyz", pose[:3], strict=True))},
            "orientation": pose[3:].tolist(),
            "wrench": {"force": force[:3].tolist(), "torque": force[3:].tolist()},
            "joints": {"name": ["a", "b"], "position": [float(t), None]},
        }
        for t, pose, force in zip(time, poses, values["wrench"], strict=True)
    ]
    text = "\n".join(map(json.dumps, lines))
    (folder / "messages.jsonl").write_text(text)
    table = table_from_recording(log)
    feather.write_feather(table, str(folder / "log.feather"))
    with ipc.new_stream(str(folder / "log.arrow"), table.schema) as writer:
        writer.write_table(table)


INERTIALS = """\
<robot name="r">
  <link name="a"><inertial><origin xyz="0 0 0.1" rpy="0 0.3 0"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.3"/></inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="c"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
  <joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>
</robot>
"""
"""A robot of which one link's inertial no body can have."""


COLUMN_MAP = """\
time = { column = "ts", unit = "ms" }
position = { columns = ["x", "y", "z"], unit = "mm" }
orientation = { columns = ["A", "B", "C"], form = "euler", order = "ZYX", unit = "deg" }
wrench = { columns = "ft_{0..5}", unit = ["N", "N mm"], axes = "world" }
nan = "blank"
separator = ","
header = 1
skip = 0
"""
"""How `robot.csv` is read."""


def _foreign(log) -> bytes:
    """A log with other names and units of columns."""
    from scipy.spatial.transform import Rotation

    angles = Rotation.from_quat(np.array(log["orientation"].values))
    wrench = log["wrench"].values * [1.0, 1.0, 1.0, 1e3, 1e3, 1e3]
    table = np.column_stack(
        (
            1e3 * log["wrench"].time,
            1e3 * log["position"].values,
            angles.as_euler("ZYX", degrees=True),
            wrench,
        )
    )
    names = "ts,x,y,z,A,B,C," + ",".join(f"ft_{i}" for i in range(6))
    out = io.StringIO()
    np.savetxt(out, table, delimiter=",", header=names, comments="", fmt="%.9g")
    return out.getvalue().encode()


def _ur_record(log) -> bytes:
    """A log as a real-time record of a UR robot."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_quat(np.array(log["orientation"].values)).as_rotvec()
    parts = (log["wrench"].time[:, None], log["position"].values, turned)
    fields = [
        f"{field}_{i}"
        for field in ("actual_TCP_pose", "ft_raw_wrench")
        for i in range(6)
    ]
    out = io.StringIO()
    table = np.column_stack((*parts, log["wrench"].values))
    names = ",".join(("timestamp", *fields))
    np.savetxt(out, table, delimiter=",", header=names, comments="", fmt="%.9g")
    return out.getvalue().encode()


def _read(folder: Path, *names: str) -> list[Seed]:
    return [Seed(name, (folder / name).read_bytes()) for name in names]


def _ur_records() -> list[Seed]:
    """Real-time records of a UR robot, with the sensor's own wrench and without."""
    from tempfile import TemporaryDirectory

    import ur_records

    with TemporaryDirectory() as folder:
        made = [
            ur_records.record(Path(folder) / "log.csv", *fields, separator=separator)
            .read_bytes()
            .replace(b"\r\n", b"\n")
            for fields, separator in (
                (ur_records.ALL, ","),
                (("actual_TCP_pose", "actual_TCP_force", "payload", "tcp_offset"), ","),
                (("actual_TCP_pose", "ft_raw_wrench", "actual_TCP_speed"), " "),
            )
        ]
    return [Seed("ur.csv", data) for data in made]


def _bags(folder: Path, *forms: str) -> list[Seed]:
    """Bags with tf, poses, joints and wrenches, as other tools write them."""
    import bags

    entries: list[bags.Entry] = []
    for k in range(20):
        stamp = 1_700_000_000_000_000_000 + 20_000_000 * k
        turned = (0.0, 0.0, np.sin(0.05 * k), np.cos(0.05 * k))
        transform = {
            "stamp": stamp,
            "frame": "base",
            "child_frame_id": "tool0",
            "transform.translation": (0.1, 0.02 * k, 0.3),
            "transform.rotation": turned,
        }
        force = {"stamp": stamp, "frame": "tool0", "wrench.force": (1.0, 0.1 * k, 5.0)}
        names = {"name": ["a", "b"], "position": np.array([0.1, 0.1 * k])}
        entries += [
            ("/tf", "tf2_msgs/TFMessage", stamp, {"transforms": [transform]}),
            ("/ft", "geometry_msgs/WrenchStamped", stamp, force),
            ("/joints", "sensor_msgs/JointState", stamp, {"stamp": stamp, **names}),
        ]
    seeds = []
    for form in forms:
        place = folder / f"made-{form}"
        place.mkdir()
        path = bags.write(place, form, entries)
        seeds.append(Seed(path.name, path.read_bytes()))
    return seeds


def _storage(folder: Path) -> list[Seed]:
    """The SQLite file of a ROS 2 bag."""
    (path,) = (folder / "log").glob("*.db3")
    return [Seed("log.db3", path.read_bytes())]


def _folders(folder: Path) -> list[Seed]:
    """ROS 2 bags as folders: of each file, what happens when it is another."""
    files = {
        f"log/{path.name}": path.read_bytes() for path in (folder / "log").iterdir()
    }
    return [
        Seed(name, data, {k: v for k, v in files.items() if k != name}, "log")
        for name, data in sorted(files.items())
    ]


def _box():
    import trimesh

    return trimesh.creation.box((0.1, 0.05, 0.2))


def _meshes() -> list[Seed]:
    """A box and a sphere in every format of a mesh."""
    import trimesh

    sphere = trimesh.creation.icosphere(2, 0.05)
    seeds = []
    for mesh in (_box(), sphere):
        for kind in ("stl", "stl_ascii", "obj", "off", "glb", "ply"):
            data = mesh.export(file_type=kind)
            data = data.encode() if isinstance(data, str) else bytes(data)
            seeds.append(Seed(f"shape.{kind[:3]}", data))
        text = mesh.export(file_type="ply", encoding="ascii")
        seeds.append(
            Seed("shape.ply", text if isinstance(text, bytes) else text.encode())
        )
    return seeds


def _clouds() -> list[Seed]:
    """The same points in every format of a cloud; one with labels."""
    points = np.random.default_rng(5).uniform(-0.1, 0.1, (60, 3))
    lines = "\n".join(" ".join(f"{x:.6g}" for x in row) for row in points)
    array = io.BytesIO()
    np.save(array, points)
    head = "ply\nformat ascii 1.0\nelement vertex 60\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    labelled = "\n".join(
        f"{line} {i // 30}" for i, line in enumerate(lines.split("\n"))
    )
    return [
        Seed("cloud.xyz", lines.encode()),
        Seed("cloud.csv", b"x,y,z\n" + lines.replace(" ", ",").encode()),
        Seed("cloud.txt", lines.encode()),
        Seed("cloud.npy", array.getvalue()),
        Seed("cloud.ply", (head + "end_header\n" + lines).encode()),
        Seed(
            "cloud.ply",
            (head + "property int label\nend_header\n" + labelled).encode(),
        ),
    ]
