"""What the names of columns say: the words of a name, and its component x, y, z, w or a
number."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hefting.logs.units import UNITS

WORDS = {
    "force": ("f", "force", "forces"),
    "torque": ("m", "torque", "torques", "moment", "moments", "tau", "mom"),
    "torque-or-translation": ("t",),
    "wrench": ("ft", "fts", "wrench", "ftsensor", "hatk"),
    "position": (
        *("", "p", "pos", "position", "translation", "trans", "xyz", "pose", "posx"),
        *("tcp", "tcppose", "ee", "eef", "endeffector", "tool", "flange"),
    ),
    "orientation": (
        *("q", "o", "quat", "quaternion"),
        *("orientation", "ori", "rot", "rotation"),
    ),
    "angles": ("r",),
    "rotation-vector": ("rotvec", "rv", "axisangle"),
    "roll-pitch-yaw": ("theta", "euler", "rpy"),
    "pose": ("pose", "tcppose"),
    "pose-matrix": ("ee", "pose", "matrix", "transform", "tf"),
    "joint_positions": ("q", "j", "joint", "joints", "jointposition", "jpos"),
    "gyroscope": ("g", "gyro", "gyroscope"),
    "linear_accelerometer": ("linearacc", "linearaccel", "linearaccelerometer"),
    "accelerometer": ("acc", "accel", "accelerometer"),
}
"""Words that a column of each kind may have before its component."""

OTHER = {
    *("velocity", "vel", "speed", "twist", "acceleration", "current", "effort"),
    *("target", "desired", "des", "cmd", "command", "commanded", "goal", "setpoint"),
    *("ref", "reference", "error", "err", "bias", "offset", "std", "cov", "covariance"),
}
"""Words of columns that are none of those: rates, set points, errors."""


def squeezed(unit: str) -> str:
    """A unit as a word of a name: ``nmm``."""
    return re.sub(r"[^a-z0-9]", "", unit.lower())


UNIT_WORDS = frozenset(
    squeezed(name)
    for kind in ("length", "angle", "force", "torque")
    for name in UNITS[kind]
)
"""Units as they stand at the end of a name: ``Fx_N``, ``x_mm``."""


@dataclass(frozen=True)
class Groups:
    """Columns by what stands before their component: ``("ft", "force")`` -> ``{"x":
    3}``."""

    by_words: Mapping[tuple[str, ...], Mapping[str, int]]

    def find(self, kind: str, components: Sequence[str]) -> tuple[int, ...] | None:
        """Columns of the first group of a kind that has all these components."""
        for words, columns in self.by_words.items():
            last = words[-1] if words else ""
            told = last in WORDS[kind] or "".join(words[-2:]) in WORDS[kind]
            told = told and (kind != "accelerometer" or "linear" not in words)
            if told and not OTHER & set(words) and set(components) <= set(columns):
                return tuple(columns[c] for c in components)
        return None

    def numbered(self, kind: str, count: int) -> tuple[int, ...] | None:
        """The same for components that are numbers, from 0 or from 1."""
        for first in (0, 1):
            names = [str(first + k) for k in range(count)]
            if (columns := self.find(kind, names)) is not None:
                return columns
        return None


def group_columns(names: Sequence[str]) -> Groups:
    """The columns of a table by their names, without units in brackets."""
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column, name in enumerate(names):
        words = split_name(name)
        if words:
            groups.setdefault(tuple(words[:-1]), {}).setdefault(words[-1], column)
    return Groups(groups)


def split_name(name: str) -> list[str]:
    """Words of a name in small letters, its component as the last: ``Force_X``,
    ``forceX`` and ``force_x_N`` are ``force``, ``x``."""
    words = words_of(name)
    component = next((word for word in words if word in set("xyzw")), None)
    if component is not None:
        words.remove(component)
        return [*words, component]
    match = re.fullmatch(r"(.*?[a-z])([xyzw]|\d+)", words[-1]) if words else None
    return [*words[:-1], match[1], match[2]] if match else words


def words_of(name: str) -> list[str]:
    """Words of a name in small letters, without a unit at the end."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)
    words = re.findall(r"[a-z0-9]+", name.lower())
    return words[:-1] if len(words) > 1 and words[-1] in UNIT_WORDS else words
