"""Real-time records of Universal Robots, written from known flange poses and wrenches
by their definitions."""

import numpy as np
import pandas as pd
import pytest

import hefting
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.core.spatial import rotation_matrices
from hefting.identification import identify
from hefting.logs import read_log, write_log
from hefting.logs.ur_csv import is_ur
from hefting.simulation import UR5, hammer, simulate, sinusoids
from log_files import fails, mapped
from ur_records import (
    ALL,
    COUNT,
    FLANGE,
    FORCE_ONLY,
    MOVING,
    NO_OFFSET,
    OFFSET,
    ORIGIN,
    TIME,
    TURNING,
    WRENCH,
    record,
    rotation_vector,
)


@pytest.mark.parametrize("separator", [" ", ","])
@pytest.mark.parametrize("offset", [NO_OFFSET, OFFSET])
@pytest.mark.parametrize("suffix", [".csv", ".txt"])
def test_pose_velocity_and_wrench_are_those_of_the_flange(
    tmp_path, separator, offset, suffix
):
    got = read_log(
        record(tmp_path / f"log{suffix}", *ALL, offset=offset, separator=separator)
    )
    assert got.warnings == ()
    np.testing.assert_array_equal(got["wrench"].time, TIME)
    np.testing.assert_array_equal(got["wrench"].values, WRENCH)
    # some tens of roundings of 1.1e-16
    np.testing.assert_allclose(
        rotation_matrices(got["orientation"].values), FLANGE, atol=4e-15
    )
    np.testing.assert_allclose(got["position"].values, ORIGIN, atol=4e-15)
    np.testing.assert_allclose(got["linear_velocity"].values, MOVING, atol=4e-15)
    np.testing.assert_allclose(got["angular_velocity"].values, TURNING, atol=4e-15)
    assert (
        got["joint_positions"].values.shape
        == got["joint_velocities"].values.shape
        == (COUNT, 6)
    )
    assert got.joint_names == ()
    assert "UR real-time record" in got.notes[0]
    assert "flange" in got.notes[1]
    assert "ft_raw_wrench" in got.notes[2]
    assert "large bias" in got.notes[2]


def test_forces_in_base_axes_are_turned_into_the_flange(tmp_path):
    got = read_log(record(tmp_path / "log.csv", *FORCE_ONLY))
    # ten times as large, hence roundings too
    np.testing.assert_allclose(got["wrench"].values, WRENCH, atol=2e-14)
    assert got.warnings == ()
    got = read_log(record(tmp_path / "log.csv", *FORCE_ONLY, offset=OFFSET))
    np.testing.assert_allclose(got["wrench"].values, WRENCH, atol=2e-14)
    assert got.warnings == (
        "torques of actual_TCP_force are taken about the flange, as on e-Series; CB3 gives them about the TCP",
    )


def test_without_the_offset_the_tcp_is_the_sensor(tmp_path):
    got = read_log(record(tmp_path / "log.csv", "actual_TCP_pose", "ft_raw_wrench"))
    np.testing.assert_allclose(got["position"].values, ORIGIN, atol=0)
    assert (
        "tcp_offset is not recorded: the TCP is taken to be at the flange, where axes"
        in got.warnings[0]
    )
    got = read_log(
        record(tmp_path / "log.csv", "actual_TCP_pose", "actual_TCP_force", "payload")
    )
    np.testing.assert_allclose(got["wrench"].values, WRENCH, atol=2e-14)
    assert "where the origin of its torques" in got.warnings[0]


def test_a_payload_that_the_controller_has_removed_is_refused(tmp_path):
    payload = np.where(np.arange(COUNT) < 5, 0.0, 1.25)[:, None]
    path = record(tmp_path / "log.csv", *FORCE_ONLY, payload=payload)
    fails(
        path,
        "row 7, column payload",
        "already removed a payload of 1.25 kg",
        "record ft_raw_wrench, or set",
        "to 0",
    )
    # that one is not compensated
    raw = read_log(record(path, *FORCE_ONLY, "ft_raw_wrench", payload=payload))
    np.testing.assert_array_equal(raw["wrench"].values, WRENCH)
    assert raw.warnings == ()
    unknown = read_log(
        record(path, "actual_TCP_pose", "actual_TCP_force", "tcp_offset")
    )
    assert len(unknown.warnings) == 1
    assert (
        "payload is not recorded: whatever is set in the controller is already removed"
        in unknown.warnings[0]
    )


def test_a_column_of_times_may_be_t(tmp_path):
    path = record(tmp_path / "log.csv", *FORCE_ONLY)
    expected = read_log(path)
    path.write_text(path.read_text().replace("timestamp", "t", 1))
    got = read_log(path)
    np.testing.assert_array_equal(got["wrench"].time, expected["wrench"].time)
    path.write_text(path.read_text().replace("t ", "clock ", 1))
    fails(path, "there is no column timestamp; record it too, or give the column")


def test_a_sensor_that_reads_nothing_is_not_used(tmp_path):
    """Simulators, and robots without a sensor, write a constant."""
    constant = np.tile([1.0, 2, 3, 4, 5, 6], (COUNT, 1))
    got = read_log(
        record(
            tmp_path / "log.csv", *FORCE_ONLY, "ft_raw_wrench", ft_raw_wrench=constant
        )
    )
    np.testing.assert_allclose(got["wrench"].values, WRENCH, atol=2e-14)
    alone = read_log(
        record(
            tmp_path / "log.csv",
            "actual_TCP_pose",
            "tcp_offset",
            "ft_raw_wrench",
            ft_raw_wrench=constant,
        )
    )
    np.testing.assert_array_equal(alone["wrench"].values, constant)


def test_rotation_vectors_jump_at_half_a_turn_and_rotations_do_not(tmp_path):
    angles = np.linspace(np.pi - 0.01, np.pi + 0.01, COUNT)
    # as the controller gives it
    wrapped = np.where(angles > np.pi, angles - 2 * np.pi, angles)
    assert np.abs(np.diff(wrapped)).max() > 6
    axis = np.array([0.48, 0.6, 0.64])
    pose = np.concatenate([ORIGIN, wrapped[:, None] * axis], axis=1)
    got = read_log(
        record(
            tmp_path / "log.csv",
            "actual_TCP_pose",
            "ft_raw_wrench",
            "tcp_offset",
            actual_TCP_pose=pose,
        )
    )
    matrices = rotation_matrices(got["orientation"].values)
    assert np.abs(np.diff(matrices, axis=0)).max() < 0.0011  # the step of the angle


def test_joints_can_stand_for_the_pose_if_the_wrench_is_in_flange_axes(tmp_path):
    got = read_log(record(tmp_path / "log.csv", "actual_q", "ft_raw_wrench"))
    assert list(got.streams) == ["joint_positions", "wrench"]
    fails(
        record(tmp_path / "log.csv", "actual_q", "actual_TCP_force", "payload"),
        "in base axes",
        "no pose",
        "record",
    )


def test_repeated_rows_and_a_canonical_copy(tmp_path):
    path = record(tmp_path / "log.csv", *ALL)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:5], lines[4], *lines[5:]]))
    got = read_log(path)
    assert len(got["wrench"]) == COUNT
    assert got.warnings == (
        "dropped 1 repeated row, time and values alike (the first: row 6)",
    )
    write_log(got, tmp_path / "copy.csv")
    copy = read_log(tmp_path / "copy.csv")
    assert all(
        np.array_equal(copy[name].values, got[name].values)
        for name in got.streams
        if name != "orientation"
    )


def test_a_column_map_comes_first(tmp_path):
    path = record(tmp_path / "log.csv", *ALL)
    text = """
        time = "timestamp"
        position = "actual_TCP_pose_{0..2}"
        orientation = { columns = "actual_TCP_pose_{3..5}", form = "rotation-vector" }
        wrench = { columns = "actual_TCP_force_{0..5}", axes = "world" }
    """
    got = mapped(path, text)
    np.testing.assert_allclose(got["wrench"].values, WRENCH, atol=2e-14)
    assert not got.has("joint_positions")


def test_an_object_is_found_beside_the_bias_of_the_raw_wrench(tmp_path):
    """A real UR5e reads 25 kN along z with nothing in its hand: a constant in flange
    axes, as any bias."""
    body = hammer().parameters
    held = simulate(
        UR5.motion(sinusoids(4.0, 50.0, 1.5)),
        body,
        noise=Noise(0.05, 0.002),
        pose_noise=(1e-4, 1e-4),
        seed=1,
    )
    bias = np.array([1794, 393, 25406, -7.9, -17.5, -76.0])
    turned = [
        rotation_vector(matrix)
        for matrix in rotation_matrices(held["orientation"].values)
    ]
    pose = np.column_stack([held["position"].values, turned])
    table = np.column_stack(
        [
            held["wrench"].time,
            pose,
            np.zeros((len(pose), 6)),
            bias - held["wrench"].values,
        ]
    )
    names = [
        f"{field}_{j}"
        for field in ("actual_TCP_pose", "tcp_offset", "ft_raw_wrench")
        for j in range(6)
    ]
    lines = [" ".join(map(repr, row)) for row in table.tolist()]
    (tmp_path / "log.csv").write_text(
        "\n".join([" ".join(["timestamp", *names]), *lines])
    )
    found = identify(read_log(tmp_path / "log.csv"), method="OLS").estimate
    # 200 samples of 0.05 N against some 6 N: 0.1 %, and two to three times as much
    # beside a bias
    assert found.parameters.mass == pytest.approx(body.mass, rel=0.01)
    np.testing.assert_allclose(
        found.parameters.center_of_mass, body.center_of_mass, atol=0.005
    )


def test_is_ur():
    assert is_ur(("timestamp", "actual_q_0"))
    assert not is_ur(("time", "qx", "q1", "fx", "timestamp"))
    assert not is_ur(("time", "actual_q_0", "fx"))
    pose = tuple(f"actual_TCP_pose_{i}" for i in range(6))
    force = ("Fx [N]", "Fy [N]", "Fz [N]")
    assert not is_ur(("timestamp", *pose, *force))
    assert is_ur(("timestamp", *pose, "actual_TCP_force_0", *force))
    for names in ((*force, "Mx", "My", "Mz"), tuple(f"ft_{i}" for i in range(6))):
        for own in ((), ("actual_TCP_force_0",), ("ft_raw_wrench_0",)):
            assert not is_ur(("timestamp", *pose, *own, *names))


def test_a_record_in_memory_is_read_as_its_file(tmp_path):
    """By the names of its columns alone the wrench was in base axes, and of the TCP."""
    path = record(tmp_path / "log.csv", *FORCE_ONLY, offset=OFFSET)
    got, expected = hefting.as_recording(pd.read_csv(path, sep=" ")), read_log(path)
    assert got.streams.keys() == expected.streams.keys()
    for name, stream in expected.streams.items():
        # pandas reads the last digit as it likes
        np.testing.assert_allclose(got[name].values, stream.values, atol=1e-12)
    assert codes(got.warnings) == codes(expected.warnings)


@pytest.mark.parametrize("own", ["actual_TCP_force", "ft_raw_wrench"])
@pytest.mark.parametrize("names", ["fx fy fz tx ty tz", "Fx Fy Fz Mx My Mz"])
def test_the_wrench_of_another_sensor_beside_the_controllers(own, names):
    """A doubt where the controller's is the robot's own sensor's."""
    wrench = np.random.default_rng(5).normal(size=(COUNT, 6))
    numbered = [f"{own}_{i}" for i in range(6)]
    columns = {"timestamp": 0.01 * np.arange(COUNT), "payload": np.ones(COUNT)}
    poses = {f"actual_TCP_pose_{i}": np.linspace(0, 0.1 * i, COUNT) for i in range(6)}
    others = dict(zip(numbered, 2.0 * wrench.T, strict=True))
    held = dict(zip(names.split(), wrench.T, strict=True))
    got = hefting.as_recording(columns | poses | others | held)
    np.testing.assert_array_equal(got["wrench"].values, wrench)
    assert ("columns-doubtful" in codes(got.warnings)) == (own == "ft_raw_wrench")


def test_times_may_be_called_time(tmp_path):
    path = record(tmp_path / "log.csv", *ALL)
    expected = read_log(path)["wrench"]
    text = path.read_text()
    path.write_text(text.replace("timestamp", "time", 1))
    got = read_log(path)["wrench"]
    np.testing.assert_array_equal(got.time, expected.time)
    np.testing.assert_array_equal(got.values, expected.values)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        (
            ("actual_TCP_pose", "actual_q"),
            ("there is no wrench", "record ft_raw_wrench"),
        ),
        (
            ("ft_raw_wrench", "payload"),
            ("neither a pose nor joint angles", "record actual_TCP_pose"),
        ),
    ],
)
def test_records_that_lack_something(tmp_path, fields, words):
    fails(record(tmp_path / "log.csv", *fields), *words)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("timestamp", "stamp", ("no column timestamp",)),
        (
            "tcp_offset_3",
            "note",
            (
                "column tcp_offset_3 is missing beside tcp_offset_0",
                "record all of tcp_offset",
            ),
        ),
        ("robot_mode", "payload", ("column payload is there 2 times",)),
        (
            "\r\n1234.508 ",
            "\r\nnoon ",
            ("row 3, column timestamp", "'noon' is not a number"),
        ),
        ("\r\n1234.508 ", "\r\nnan ", ("row 3, column timestamp", "nan")),
    ],
)
def test_broken_records(tmp_path, old, new, words):
    path = record(tmp_path / "log.csv", *ALL)
    text = path.read_bytes().decode()
    assert old in text
    path.write_bytes(text.replace(old, new, 1).encode())
    fails(path, *words)
