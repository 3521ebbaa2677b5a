"""Names of columns: their words, their component (x, y, z, w or a number), and which
group of columns holds a quantity."""

import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

from hefting.core.messages import Message, warning
from hefting.logs.units import ALIASES, UNITS, squeezed

WORDS = {
    "force": ("f", "force", "forces", "kraft", "fuerza", "forza", "力"),
    "torque": (
        *("m", "torque", "torques", "moment", "moments", "tau", "mom", "mu"),
        *("torq", "drehmoment", "forcer", "wrenchr", "ftr", "fr", "couple", "par"),
        *("momento", "coppia", "モーメント", "トルク", "力矩", "扭矩", "转矩"),
    ),
    "torque-or-translation": ("t", "tr"),
    "wrench": ("ft", "fts", "wrench", "ftsensor", "hatk", "forcetorque"),
    "position": (
        *("", "p", "pos", "position", "translation", "trans", "xyz", "pose", "posx"),
        *("tcppose", "xpos", "framepos", "tvec", "位置"),
    ),
    "orientation": (
        *("q", "o", "r", "u", "quat", "quaternion", "xquat", "framequat"),
        *("orientation", "ori", "orn", "orient", "orientu", "rot", "rotation"),
    ),
    "angles": ("r", "orientation", "ori", "orn", "orient", "rot", "rotation", "姿勢"),
    "rotation-vector": ("rotvec", "rv", "rvec", "axisangle"),
    "roll-pitch-yaw": ("theta", "euler", "rpy"),
    "pose": ("", "pose", "tcppose", "posx", "coordrobot", "coordbase"),
    "pose-matrix": ("ot", "pose", "matrix", "transform", "tf"),
    "matrix": ("t", "h", "tf", "pose", "matrix", "transform"),
    "rotation-matrix": ("r", "rot", "rotation", "rotmat", "xmat", "orientation"),
    "joint_positions": (
        *("q", "j", "joint", "joints", "jointposition", "jpos", "statesposition"),
        *("jointpos", "jointangle", "jangle", "axisposition", "axisangle", "axisa"),
        *("motorpos", "motorposition", "actuatorsposition", "theta"),
    ),
    "axes": ("a",),
    "joint_torques": (
        *("tau", "tauj", "effort", "torque", "torques", "jointtorque", "jointtorques"),
        *("torquej", "torquea", "jtorque", "trq"),
    ),
    "joint_currents": ("current", "currents", "jointcurrent", "motorcurrent"),
    "gyroscope": ("g", "gyro", "gyroscope"),
    "linear_accelerometer": ("linearacc", "linearaccel", "linearaccelerometer"),
    "accelerometer": ("acc", "accel", "accelerometer"),
}
"""Words that columns of each kind may have before their component."""

QUANTITY_WORDS = frozenset(word for words in WORDS.values() for word in words)
"""Words of quantities, as opposed to those of an object or place."""

OTHER = {
    *("velocity", "vel", "speed", "twist", "acceleration", "current", "effort"),
    *("target", "desired", "des", "cmd", "command", "commanded", "goal", "setpoint"),
    *("d", "soll", "rsol", "planned", "plan", "nominal"),
    *("action", "actions", "delta", "diff"),
    *("pred", "predicted", "prediction", "expected", "model", "residual"),
    *("comp", "compensated", "gravity", "contact", "init", "initial"),
    *("ref", "reference", "error", "err", "bias", "offset", "std", "cov", "covariance"),
}
"""Words of columns of other quantities: rates, set points, results of a model or a
compensation, errors."""

PLACES = {"tcp", "ee", "eef", "end", "effector", "endeffector", "tool", "flange"}
"""Words of the place where a tool is held."""

FRAMES_HELD = PLACES | {"sensor", "wrist", "hand", "gripper", "link", "frame"}
"""Words of frames that move with the sensor: ``sensor_x`` is a position."""

ESTIMATED = re.compile("(?<![a-z])ext(?![a-z])|(?<![a-z])external|External|cartForce")
"""Names of external wrenches, which are without the load: Franka's ``K_F_ext_hat_K``,
Kinova's ``tool_external_wrench``, xArm's ``ft_ext_force``, KUKA's ``cartForce1_X``."""

ELSEWHERE = {
    *("imu", "camera", "cam", "object", "obj", "cube", "head", "marker"),
    *("base", "odom", "shoulder", "elbow", "forearm", "finger", "leader", "next"),
    *("filtered", "filt", "ext", "external"),
}
"""Words of other places, and of filtered and estimated signals."""

MEASURED = {"actual", "act", "ist", "rist", "measured", "meas", "mes", "msr"}
"""Words of measured quantities, as opposed to set points."""

ASIDE = (
    PLACES
    | MEASURED
    | {"raw", "data", "value", "values", "signals", "filtered", "filt", "sensor"}
    | {"in", "wxyz", "xyzw"}
)
"""Words anywhere in a name that do not tell the quantity."""

UNIT_WORDS = frozenset(
    squeezed(name)
    for kind in ("length", "angle", "force", "torque")
    for name in UNITS[kind]
) | frozenset(ALIASES)
"""Units at the end of a name: ``Fx_N``, ``x_mm``, ``Fx in N``."""


CAMEL = "(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])(?!(?<=R)(?:Ist|Sol))|(?<=[\u3040-\u9fff])(?=[A-Za-z])"
"""Beginning of a word in ``ForceXRaw``, ``力X``, not in KUKA's ``RIst_X``."""

FRAMES = r"^([pqtv])_[A-Z]{1,3}(_[A-Z]{1,2})?(?=_[xyzw])|(?<=Msr)_LBR_\w+(?=\[)"
"""Frames after a letter, as in EuRoC's ``p_RS_R_x``, and KUKA's names of an arm, as in
``axisQMsr_LBR_iiwa_7_R800_1[0]``."""


NUMBERED = (
    r"(?<![a-z])(joint|j|axis|motor|actuators)_?(\d+)_([a-z]{2,}(?:_[a-z]{2,})*)$"
)
"""A joint and its number before the quantity, as in ``fr3_joint4_position``."""


@dataclass(frozen=True)
class Choice:
    """Columns that seem to hold a quantity."""

    columns: tuple[int, ...]
    words: tuple[str, ...]
    """of their names"""
    rank: int = 0
    """plausibility; see `rank_of`"""
    equals: tuple[int, ...] = ()
    """first columns of other choices of the same rank"""


@dataclass(frozen=True)
class Groups:
    """Columns by the words before their component, and by that: ``("ft", "force")`` ->
    ``{"x": 3}``."""

    by_words: Mapping[tuple[str, ...], Mapping[str, int]]

    def find(
        self, kind: str, components: Sequence[str], near: Set[str] = frozenset()
    ) -> Choice | None:
        """The columns of a group of a kind that has all these components, and if they
        are numbers no others; of several groups that of the highest rank by the words
        `near` it (`best_of`)."""
        numbers = components[0].isdigit()
        found = []
        for words, columns in self.by_words.items():
            there = {c for c in columns if c.isdigit()} if numbers else set(columns)
            if not set(components) <= there or (
                numbers and len(there) > len(components)
            ):
                continue
            if is_of_kind(words, kind, numbered=numbers) and not (
                kind == "angles" and "w" in columns
            ):
                chosen = tuple(columns[c] for c in components)
                found.append(Choice(chosen, words, rank_of(words, near)))
        return best_of(found)

    def words_of_kinds(self, kinds: Sequence[str]) -> set[str]:
        """All words of the groups of these kinds; none if a group has one word."""
        found = [w for w in self.by_words if any(is_of_kind(w, kind) for kind in kinds)]
        bare = any(len(words) == 1 for words in found)
        return set() if bare else {word for words in found for word in words}

    def xyz_of_words(self, near: Set[str]) -> Choice | None:
        """Columns x, y, z whose words are all in `near`, those of other choices: the
        position ``right_x`` beside ``right_qx``."""
        for words, columns in self.by_words.items():
            if words and set(words) <= near and set("xyz") <= set(columns):
                return Choice(tuple(columns[c] for c in "xyz"), words)
        return None

    def numbered(
        self, kind: str, count: int, near: Set[str] = frozenset()
    ) -> Choice | None:
        """`find` for `count` components numbered from 0 or from 1."""
        for first in (0, 1):
            names = [str(first + k) for k in range(count)]
            if (choice := self.find(kind, names, near)) is not None:
                return choice
        return None

    def matrix(
        self, kind: str, size: int, near: Set[str] = frozenset()
    ) -> Choice | None:
        """`find` for components of a matrix, ``R11`` or ``T_00``, row by row."""
        for first in (0, 1):
            line = range(first, first + size)
            names = [f"{i}{j}" for i in line for j in line]
            if (choice := self.find(kind, names, near)) is not None:
                return choice
        return None


def names_frame(words: Sequence[str]) -> bool:
    """Whether all words stand for a frame that moves with the sensor, as those of
    ``sensor_x``, ``wrist_link_x`` or ``sensor_in_base_x``."""
    plain = {_without_number(word) for word in words}
    known = plain <= FRAMES_HELD | MEASURED | {"in", "base", "world", "raw"}
    return known and bool(plain & FRAMES_HELD)


def best_of(choices: Sequence[Choice]) -> Choice | None:
    """The choice of the highest rank, of these that of the fewest words, of these the
    first; others of its rank are its `equals`."""
    if not choices:
        return None
    best = max(choices, key=lambda choice: (choice.rank, -len(choice.words)))
    equals = [c.columns[0] for c in choices if c.rank == best.rank and c is not best]
    return Choice(best.columns, best.words, best.rank, tuple(equals))


def rank_of(words: Sequence[str], near: Set[str]) -> int:
    """Plausibility of a group: number of its words that are in `near`, plus those that
    mean measured, raw or at a tool, minus those of other places (`ELSEWHERE`)."""
    plain = {_without_number(word) for word in words}
    there = len(plain & (PLACES | MEASURED | {"raw"})) - len(plain & ELSEWHERE)
    return len({*words} & near) + there


def is_of_kind(words: Sequence[str], kind: str, *, numbered: bool = False) -> bool:
    """Whether the words before a component name a kind of `WORDS`."""
    plain = [_without_number(word) for word in words]
    own = WORDS[kind] if kind in ("joint_torques", "joint_currents") else ()
    if is_other([word for word in words if word not in own]) or (
        kind == "accelerometer" and "linear" in plain
    ):
        return False
    rest = [word for word in plain if word not in ASIDE]
    if not rest:
        bare = set(plain) & PLACES if numbered else set(plain) <= PLACES | MEASURED
        return bool(bare) and "" in WORDS[kind]
    if kind == "joint_positions" and "current" in rest:
        return False
    return rest[-1] in WORDS[kind] or "".join(rest[-2:]) in WORDS[kind]


def is_other(words: Sequence[str]) -> bool:
    """Whether words name another quantity (`OTHER`); ``current_pose`` does not."""
    others = OTHER & set(words)
    return bool(others - {"current"}) or (bool(others) and words[-1] == "current")


def others_told(names: Sequence[str]) -> str:
    """A clause on those of the names that are of other quantities; empty for none."""
    found = {word for name in names for word in OTHER & {*words_of(name)}}
    which = ", ".join(sorted(found))
    what = f"; names with {which} are of set points, rates or results, and not read"
    return what if found else ""


def _without_number(word: str) -> str:
    return re.sub(r"(?<=[a-z])\d+$", "", word)


def group_columns(names: Sequence[str]) -> Groups:
    """The columns of a table by their names, which have no units in brackets."""
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column, name in enumerate(names):
        words = split_name(name)
        if words:
            groups.setdefault(tuple(words[:-1]), {}).setdefault(words[-1], column)
    return Groups(groups)


def split_name(name: str) -> list[str]:
    """Words of a name in small letters, its component last: ``Force_X``, ``forceX``,
    ``force_x_N`` and ``force_x_raw`` end in ``force``, ``x``, ``Fx_ati`` in ``f``, ``x``,
    ``joint4_position`` in ``position``, ``4``."""
    words = small_words(re.sub(NUMBERED, r"\1_\3_\2", "_".join(words_of(name))))
    if len(words) > 2 and re.fullmatch(r"[wb](\d+|[w-z])", "".join(words[-2:])):
        del words[-2]  # a frame, as in Isaac Lab
    places = [i for i, word in enumerate(words) if word in set("xyzw")]
    if places:
        component = words.pop(at := places[-1])
        at = at if words[:at] and words[at - 1] in QUANTITY_WORDS else 0
        return [*words[at:], *words[:at], component]  # ``force_x_left``
    behind: list[str] = []
    while len(words) > 1 and (words[-1] in ASIDE | OTHER):
        behind.append(words.pop())
    if words and (first := re.fullmatch(r"([fmtqrp])([xyzw])", words[0])):
        return [*behind, *words[1:], *first.groups()]
    match = re.fullmatch(r"(.*?[a-z])([xyzw]|\d+)", words[-1]) if words else None
    return [*behind, *words[:-1], *((match[1], match[2]) if match else words[-1:])]


def words_of(name: str) -> list[str]:
    """Words of a name in small letters, without a unit at the end."""
    name = re.sub(CAMEL, "_", re.sub(FRAMES, r"\1", name))
    words = small_words(name)
    while len(words) > 1 and words[-1] in UNIT_WORDS:
        words.pop()
    return words


def small_words(text: str) -> list[str]:
    """All words of a text in small letters, ``µ`` as ``u``; letters of any alphabet
    belong to words: ``速度X`` is no ``x``."""
    return re.findall(r"[^\W_]+", re.sub("[µμ]", "u", text.lower()))


def about_estimates(name: str) -> tuple[Message, ...]:
    """A warning of a wrench with such a name, if it is an estimate."""
    what = (
        f"{name} seems to be of a wrench that the controller estimates, without the load "
        "that is configured in it, so the result may lack that: record with a load of zero"
    )
    return (warning("payload-unknown", what),) if ESTIMATED.search(name) else ()
