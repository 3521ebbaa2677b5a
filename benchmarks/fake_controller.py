"""A controller of Universal Robots as far as its real-time data go, for tests:
`ur_rtde` connects to it too."""

import socket
import struct
import threading
from collections.abc import Iterator

from hefting.sources.rtde import HEAD, Packages

RATIO = 5
INTEGERS = ("robot_mode", "safety_mode", "joint_mode", "output_int_register")
WIDE = (
    "target_q",
    "target_qd",
    "target_qdd",
    "target_current",
    "target_moment",
    "actual_q",
    "actual_qd",
    "actual_current",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "target_TCP_pose",
    "target_TCP_speed",
    "joint_temperatures",
    "joint_control_output",
    "actual_joint_voltage",
    "tcp_offset",
    "ft_raw_wrench",
    "actual_current_as_torque",
)
"""Fields of six numbers."""

NARROW = ("actual_tool_accelerometer", "payload_cog", "elbow_position")
"""Fields of three numbers."""

VERSION = (5, 15, 0, 0)
"""Of the controller's software."""


def type_of(name: str) -> str:
    """The type of a field."""
    if name in WIDE:
        return "VECTOR6D"
    if name in NARROW:
        return "VECTOR3D"
    if name == "joint_mode":
        return "VECTOR6INT32"
    if name.startswith(INTEGERS):
        return "INT32"
    if "digital_" in name and name.endswith("bits"):
        return "UINT64"
    if name.endswith(("_bits", "state", "status")) or "bit_registers" in name:
        return "UINT32"
    return "DOUBLE"


CODES = {
    "DOUBLE": "d",
    "VECTOR6D": "6d",
    "VECTOR3D": "3d",
    "VECTOR6INT32": "6i",
    "INT32": "i",
    "UINT32": "I",
    "UINT64": "Q",
}


class Controller:
    """One conversation; the wrench's first number counts the packages.

    Parameters
    ----------
    connection : of the client.
    unknown : fields that this controller does not have.
    """

    def __init__(self, connection: socket.socket, unknown: tuple[str, ...] = ()):
        self.connection, self.unknown = connection, unknown
        self.names: list[str] = []
        self.started = threading.Event()
        self.closed = threading.Event()
        self._lock = threading.Lock()

    def serve(self, ticks: Iterator[tuple[int, int]], bad: int = 0) -> None:
        """Answer, and send data at each tick once they were started."""
        threading.Thread(target=self._answer, daemon=True).start()
        self.started.wait(10.0)
        for k, stamp in ticks:
            if self.closed.is_set():
                return
            try:
                self._send(ord("U"), self._data(k, stamp / 1e9))
                if bad and k % bad == 0:
                    self._send(ord("U"), b"\1short")
            except OSError:
                return

    def _data(self, k: int, time: float) -> bytes:
        known = {
            "timestamp": (time,),
            "ft_raw_wrench": (float(k), 0.0, -9.8, 0.01, 0.02, 0.0),
            "actual_TCP_pose": (k // RATIO, 0.5, 0.25, 0.0, 0.0, 0.0),
        }
        data = b"\1"
        for name in self.names:
            form = ">" + CODES[type_of(name)]
            blank = struct.unpack(form, bytes(struct.calcsize(form)))
            data += struct.pack(form, *known.get(name, blank))
        return data

    def _send(self, kind: int, content: bytes) -> None:
        with self._lock:
            head = HEAD.pack(HEAD.size + len(content), kind)
            self.connection.sendall(head + content)

    def _answer(self) -> None:
        packages = Packages()
        while True:
            try:
                data = self.connection.recv(1 << 16)
            except OSError:
                data = b""
            if not data:
                self.closed.set()
                return
            for kind, content in packages.feed(data):
                self._send(kind, self._reply(kind, content))
                if kind == ord("S"):
                    self.started.set()

    def _reply(self, kind: int, content: bytes) -> bytes:
        if kind == ord("v"):
            return struct.pack(">4I", *VERSION)
        if kind != ord("O"):
            return b"\1"
        self.names = content[8:].decode().split(",")
        types = [
            "NOT_FOUND" if name in self.unknown else type_of(name)
            for name in self.names
        ]
        return b"\1" + ",".join(types).encode()
