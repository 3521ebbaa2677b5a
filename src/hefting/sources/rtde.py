"""``rtde://HOST[:PORT]``: wrench, pose and joints from a controller of Universal
Robots, without ROS.

Source: Universal Robots, Real-Time Data Exchange (RTDE) Guide. Numbers are big-endian;
a package consists of its length, its kind and its content.
"""

import socket
import struct
import time
from collections.abc import Iterator, Sequence

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, note
from hefting.core.spatial import Array
from hefting.logs.ur_csv import FORCE, RAW, find_motion_and_wrench
from hefting.online.samples import Samples, SourceLostError
from hefting.sources import UNREADABLE, Pace, Request
from hefting.sources.tcp import SocketSource, connected, received

HEAD = struct.Struct(">HB")
"""Header of a package: its length, header included, and its kind."""

VERSION = 2
"""Version of the protocol, which controllers have from 3.3 on."""

REQUEST_VERSION, SETUP_OUTPUTS, START, DATA = map(ord, "VOSU")
"""Kinds of packages that are sent or read."""

CODES = {
    "DOUBLE": "(1,)>f8",
    "VECTOR6D": "(6,)>f8",
    "VECTOR3D": "(3,)>f8",
    "INT32": "(1,)>i4",
    "UINT32": "(1,)>u4",
}
"""NumPy type of each RTDE type."""


class RtdeError(Exception):
    """The controller does not speak the protocol, or has no such fields."""


class Packages:
    """Splits a stream of bytes into packages."""

    def __init__(self):
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Kind and content of the packages that are complete with `data`. `RtdeError`
        for an impossible length."""
        self._rest += data
        position = 0
        while len(self._rest) - position >= HEAD.size:
            length, kind = HEAD.unpack_from(self._rest, position)
            if length < HEAD.size:
                raise RtdeError("a package has no length")
            if position + length > len(self._rest):
                break
            yield kind, self._rest[position + HEAD.size : position + length]
            position += length
        self._rest = self._rest[position:]


class Recipe:
    """How the fields of a data package are packed."""

    def __init__(self, number: int, fields: Sequence[str], types: Sequence[str]):
        self.number, self.fields = number, tuple(fields)
        kinds = ["u1", *(CODES[kind] for kind in types)]
        self._row = np.dtype(list(zip(("number", *fields), kinds, strict=True)))

    def blank(self) -> dict[str, Array]:
        """The fields (1, width) of a package of zeros."""
        data = bytes((self.number,)).ljust(self._row.itemsize, b"\0")
        return self.read([data])[0]

    def read(self, contents: Sequence[bytes]) -> tuple[dict[str, Array], int]:
        """The fields of n data packages of this recipe, each (n, width), and the number
        of other packages."""
        good = [
            content
            for content in contents
            if len(content) == self._row.itemsize and content[0] == self.number
        ]
        rows = np.frombuffer(b"".join(good), self._row)
        values = {name: rows[name].astype(float) for name in self.fields}
        return values, len(contents) - len(good)


class Dialogue:
    """Requests to a controller, each with one answer."""

    def __init__(self, connection: socket.socket, patience: float):
        self._connection, self._patience = connection, patience
        self.packages = Packages()
        self.data: list[bytes] = []
        """contents of data packages that came with answers"""

    def start(self, wishes: Sequence[str], rate: float) -> Recipe:
        """Request those of the fields that the controller has, and start the data.

        Raises `RtdeError`; `OSError` where the connection fails.
        """
        self._agree(REQUEST_VERSION, struct.pack(">H", VERSION))
        recipe, missing = self._setup(wishes, rate)
        if missing:
            there = [name for name in wishes if name not in missing]
            recipe, missing = self._setup(there, rate)
        if missing:
            raise RtdeError(f"the controller has no {', '.join(missing)}")
        self._agree(START, b"")
        return recipe

    def _setup(self, fields: Sequence[str], rate: float) -> tuple[Recipe, list[str]]:
        names = ",".join(fields).encode()
        answer = self._ask(SETUP_OUTPUTS, struct.pack(">d", rate) + names)
        types = answer[1:].decode("ascii", "replace").split(",")
        missing = [
            name for name, kind in zip(fields, types, strict=False) if kind not in CODES
        ]
        if len(types) != len(fields):
            raise RtdeError("the controller answers for other fields")
        known = [kind for kind in types if kind in CODES]
        there = [name for name in fields if name not in missing]
        return Recipe(answer[0] if answer else 0, there, known), missing

    def _agree(self, kind: int, content: bytes) -> None:
        if self._ask(kind, content)[:1] != b"\1":
            raise RtdeError(f"the controller refuses request {chr(kind)}")

    def _ask(self, kind: int, content: bytes) -> bytes:
        self._connection.sendall(HEAD.pack(HEAD.size + len(content), kind) + content)
        end = time.monotonic() + self._patience
        while (left := end - time.monotonic()) > 0:
            self._connection.settimeout(left)
            try:
                data = self._connection.recv(1 << 16)
            except TimeoutError:
                break
            if not data:
                raise RtdeError("the controller closed the connection")
            packages = list(self.packages.feed(data))
            self.data += [body for own, body in packages if own == DATA]
            answers = [body for own, body in packages if own == kind]
            if answers:
                return answers[0]
        raise RtdeError("the controller does not answer")


PORT = 30004

RATE = 500.0
"""[Hz] Requested rate of packages; CB3 sends 125."""

PATIENCE = 3.0
"""[s] Longest wait for an answer."""

WISHES = ("timestamp", "actual_TCP_pose", "tcp_offset", RAW, "actual_q", "actual_qd")
"""Requested fields; `hefting.logs.ur_csv` describes them."""

NEEDED = ("timestamp", "actual_TCP_pose", RAW)
"""Fields that an identification needs."""


class RtdeSource(SocketSource):
    """The real-time data of a robot; the sensor frame is the flange."""

    def __init__(self, name: str, request: Request):
        super().__init__(name, PORT, "rtde://192.168.0.2")
        self._packages, self._recipe = Packages(), Recipe(0, ("x",), ("DOUBLE",))
        self._early: list[bytes] = []
        self._pace = Pace()

    def open(self) -> None:
        """Connect; `InputError` where the host refuses, does not speak RTDE, or has no
        wrench of a sensor."""
        connection = connected(self.name, self._address[:2])
        try:
            dialogue = Dialogue(connection, PATIENCE)
            recipe = dialogue.start(WISHES, RATE)
            self._packages, self._early = dialogue.packages, dialogue.data
        except (RtdeError, OSError, ValueError) as error:
            connection.close()
            raise InputError(
                f"cannot be read ({error})",
                self.name,
                "check that this is a UR controller, and that RTDE is enabled",
            ) from error
        missing = [name for name in NEEDED if name not in recipe.fields]
        if missing:
            connection.close()
            raise InputError(
                f"the controller has no {', '.join(missing)}",
                self.name,
                f"use an e-Series controller from 5.9 on: {FORCE} is without the payload",
            )
        self._socket, self._recipe = connection, recipe
        notes: list[Message] = []
        warnings: list[Message] = []
        blank = recipe.blank()
        find_motion_and_wrench(blank, self.name, True, notes, warnings)
        about = f"wrench from {RAW}, flange axes, never zeroed: expect a large bias"
        self.chosen = (*notes, note("wrench-source", about), *warnings)

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        self._pace.wait()
        data = received(self._socket, self.name, timeout)
        try:
            packages = self._packages.feed(data)
            new = [body for kind, body in packages if kind == DATA]
            contents, self._early = [*self._early, *new], []
        except RtdeError as error:
            raise SourceLostError(f"{self.name}: {error}") from error
        if not contents:
            return []
        values, bad = self._recipe.read(contents)
        if bad:
            self.skipped[UNREADABLE] += bad
        return self._samples(values) if len(values["timestamp"]) else []

    def _samples(self, values: dict[str, Array]) -> list[Samples]:
        everything = np.concatenate(list(values.values()), axis=1)
        good = np.isfinite(everything).all(axis=1)
        if not good.all():
            self.skipped["values that are not finite"] += int((~good).sum())
            values = {name: column[good] for name, column in values.items()}
        time = values["timestamp"][:, 0]
        if not len(time):
            return []
        found = find_motion_and_wrench(values, self.name, True, [], [])
        joints = {"joint_positions": "actual_q", "joint_velocities": "actual_qd"}
        found |= {name: values[own] for name, own in joints.items() if own in values}
        return [Samples(name, time, array) for name, array in found.items()]


SOURCE = RtdeSource
