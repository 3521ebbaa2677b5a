"""``rtde://HOST[:PORT]``: wrench, pose and joints from a controller of Universal
Robots, without ROS."""

import socket
from collections import Counter

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, note
from hefting.core.spatial import Array
from hefting.logs.ur_csv import FORCE, RAW, find_motion_and_wrench
from hefting.online.samples import Samples, SourceLostError
from hefting.sources.address import address_of
from hefting.sources.limits import UNREADABLE
from hefting.sources.pacing import Pace
from hefting.sources.request import Request
from hefting.sources.rtde_protocol import (
    DATA,
    Dialogue,
    Packages,
    Recipe,
    RtdeError,
)
from hefting.sources.tcp import connected, received

PORT = 30004
"""Where controllers listen."""

RATE = 500.0
"""Packages a second that are asked for; CB3 sends 125."""

PATIENCE = 3.0
"""Longest wait for an answer [s]."""

WISHES = ("timestamp", "actual_TCP_pose", "tcp_offset", RAW, "actual_q", "actual_qd")
"""Fields that are asked for; what they mean: `hefting.logs.ur_csv`."""

NEEDED = ("timestamp", "actual_TCP_pose", RAW)
"""Fields without which there is nothing to identify."""


class RtdeSource:
    """The real-time data of a robot; its sensor is the flange."""

    def __init__(self, name: str, request: Request):
        self.name = name
        self.chosen: tuple[Message, ...] = ()
        self.skipped: Counter[str] = Counter()
        self._address = address_of(name, PORT, "rtde://192.168.0.2")
        self._socket: socket.socket | None = None
        self._packages, self._recipe = Packages(), Recipe(0, ("x",), ("DOUBLE",))
        self._early: list[bytes] = []
        self._pace = Pace()

    def open(self) -> None:
        """Connect; `InputError` where the host refuses, speaks something else, or has
        no wrench of its sensor."""
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
            came = self._packages.feed(data)
            contents = [*self._early, *(body for kind, body in came if kind == DATA)]
            self._early = []
        except RtdeError as error:
            raise SourceLostError(f"{self.name}: {error}") from error
        if not contents:
            return []
        values, bad = self._recipe.read(contents)
        if bad:
            self.skipped[UNREADABLE] += bad
        return self._samples(values) if len(values["timestamp"]) else []

    def close(self) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _samples(self, values: dict[str, Array]) -> list[Samples]:
        """The flange's motion, its wrench, and the joints."""
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
