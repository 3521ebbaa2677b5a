"""RTDE: a fake controller that the manufacturer's community client reads too."""

import socket
import threading
import time

import numpy as np
import pytest
from benchmarks.fake_controller import Controller
from benchmarks.transports import start_peer
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.sources import Request
from hefting.sources.rtde import HEAD, Packages, Recipe, RtdeError, RtdeSource


class Robot:
    """A controller that listens on a port of its own."""

    def __init__(self, **options):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.options, self.served = options, threading.Event()
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self):
        connection, _ = self.server.accept()
        with connection:
            ticks = ((k, time.time_ns()) for k in range(100_000))
            Controller(connection, **self.options).serve(slowly(ticks))
            self.served.wait(5)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.served.set()
        self.server.close()
        self.thread.join(5)


def slowly(ticks):
    for tick in ticks:
        yield tick
        time.sleep(0.002)


def source_of(robot):
    return RtdeSource(f"rtde://127.0.0.1:{robot.port}", Request())


def read(source, count=30):
    """Samples by stream."""
    found: dict[str, list] = {}
    while sum(len(part) for part in found.get("wrench", ())) < count:
        for samples in source.read(1.0):
            rows = np.column_stack([samples.time, samples.values])
            found.setdefault(samples.stream, []).append(rows)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def test_wrench_pose_and_joints_are_read():
    with Robot() as robot:
        source = source_of(robot)
        source.open()
        found = read(source)
        source.close()
    names = {"wrench", "position", "orientation", "joint_positions"}
    assert set(found) == names | {"joint_velocities"}
    assert (np.diff(found["wrench"][:, 1]) == 1).all()
    assert found["orientation"][0, 1:].tolist() == [0, 0, 0, 1]
    assert not source.skipped
    assert "wrench-source" in [message.code for message in source.chosen]


def test_a_field_that_the_controller_lacks_is_done_without():
    with Robot(unknown=("tcp_offset", "actual_qd")) as robot:
        source = source_of(robot)
        source.open()
        found = read(source)
        source.close()
    assert "joint_velocities" not in found
    assert "tcp-offset-unknown" in [message.code for message in source.chosen]


def test_a_controller_without_the_sensors_wrench_is_refused():
    with Robot(unknown=("ft_raw_wrench",)) as robot, pytest.raises(InputError) as told:
        source_of(robot).open()
    assert "ft_raw_wrench" in str(told.value)


def test_what_is_no_controller_is_refused():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def answer():
            connection, _ = server.accept()
            with connection:
                connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

        threading.Thread(target=answer, daemon=True).start()
        source = RtdeSource(f"rtde://127.0.0.1:{port}", Request())
        with pytest.raises(InputError, match="cannot be read"):
            source.open()


def test_the_flange_is_where_tcp_offset_says():
    """The pose of the TCP, composed of flange and offset, gives back the flange."""
    rng = np.random.default_rng(0)
    fields = ("timestamp", "actual_TCP_pose", "tcp_offset", "ft_raw_wrench")
    flange = Rotation.random(20, rng=rng)
    place = rng.normal(size=(20, 3))
    offset = np.concatenate([[0.1, -0.2, 0.3], [0.4, 0.5, -0.6]])
    tcp = np.column_stack(
        [
            place + flange.apply(offset[:3]),
            (flange * Rotation.from_rotvec(offset[3:])).as_rotvec(),
        ]
    )
    wrench = rng.normal(size=(20, 6))
    values = {
        "timestamp": np.arange(20.0)[:, None],
        "actual_TCP_pose": tcp,
        "tcp_offset": np.tile(offset, (20, 1)),
        "ft_raw_wrench": wrench,
    }
    source = RtdeSource("rtde://127.0.0.1", Request())
    found = {
        s.stream: s.values for s in source._samples({k: values[k] for k in fields})
    }
    assert found["position"] == pytest.approx(place, abs=1e-12)
    turned = Rotation.from_quat(found["orientation"]) * flange.inv()
    assert turned.magnitude() == pytest.approx(0.0, abs=1e-12)
    assert np.array_equal(found["wrench"], wrench)


def test_the_fake_controller_is_one_for_ur_rtde():
    """An independent client reads the same numbers from it."""
    rtde_receive = pytest.importorskip("rtde_receive", reason="ur_rtde is missing")
    with socket.socket() as probe:
        # ur_rtde takes the usual port only
        if probe.connect_ex(("127.0.0.1", 30004)) == 0:
            pytest.skip("something listens on port 30004")
    # in another process, as ur_rtde lets no other thread run while it connects
    peer = start_peer("rtde", 30004, 20.0)
    try:
        client = rtde_receive.RTDEReceiveInterface(
            "127.0.0.1", 500.0, ["timestamp", "actual_TCP_pose", "ft_raw_wrench"]
        )
        end = time.monotonic() + 5
        while client.getFtRawWrench()[0] < 20 and time.monotonic() < end:
            time.sleep(0.01)
        wrench, pose = client.getFtRawWrench(), client.getActualTCPPose()
        client.disconnect()
    finally:
        peer.kill()
        peer.communicate()
    assert wrench[0] >= 20
    assert wrench[1:] == [0.0, -9.8, 0.01, 0.02, 0.0]
    assert pose[1:] == [0.5, 0.25, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("seed", range(3))
def test_packages_in_pieces_of_any_size(seed):
    rng = np.random.default_rng(seed)
    sent = [
        (int(rng.integers(256)), rng.bytes(int(rng.integers(40)))) for _ in range(50)
    ]
    data = b"".join(HEAD.pack(3 + len(body), kind) + body for kind, body in sent)
    cuts = np.sort(rng.integers(0, len(data), 30))
    packages = Packages()
    found = [
        package
        for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)
        for package in packages.feed(data[a:b])
    ]
    assert found == sent


def test_a_package_without_length_is_an_error():
    with pytest.raises(RtdeError):
        list(Packages().feed(b"\0\2U"))


def test_packages_of_another_recipe_or_size_are_counted():
    recipe = Recipe(1, ("x", "y"), ("DOUBLE", "VECTOR6D"))
    good = bytes((1,)) + bytes(56)
    values, bad = recipe.read([good, good[:-1], bytes((2,)) + bytes(56), good])
    assert bad == 2
    assert {name: array.shape for name, array in values.items()} == {
        "x": (2, 1),
        "y": (2, 6),
    }


def test_data_that_come_with_the_answer_to_start_are_kept():
    """Whole or in part, in one piece with the answer."""
    import socket

    from hefting.sources.rtde import DATA, HEAD, START, Dialogue

    def package(kind, content):
        return HEAD.pack(HEAD.size + len(content), kind) + content

    mine, theirs = socket.socketpair()
    with mine, theirs:
        second = package(DATA, b"\1second")
        theirs.sendall(package(START, b"\1") + package(DATA, b"\1first") + second[:4])
        dialogue = Dialogue(mine, 1.0)
        dialogue._agree(START, b"")
        assert dialogue.data == [b"\1first"]
        assert list(dialogue.packages.feed(second[4:])) == [(DATA, b"\1second")]
