"""Three angles of a table nobody has described: which columns they are, and in which
form."""

from hefting.logs.map_sample import OTHER, Groups, Sample, words_of
from hefting.logs.map_text import Guess, unit_entry
from hefting.logs.orientations import form_of_angles
from hefting.logs.units import find_unit

UNTOLD, RPY = "", 'form = "rpy"'
"""Forms of a map; the first is told by the numbers."""
ZYX = 'form = "euler", order = "ZYX"'

ANGLES = {
    ("roll", "pitch", "yaw"): (RPY, ""),
    ("rx", "ry", "rz"): (UNTOLD, ""),
    ("a", "b", "c"): (ZYX, "as of KUKA; other makes have other orders"),
    ("alpharad", "betarad", "gammarad"): (ZYX, ""),
    ("posxa", "posxb", "posxc"): ('form = "euler", order = "ZYZ"', ""),
    ("w", "p", "r"): (RPY, ""),
}
"""Names of three angles, what a map says of them, and a doubt; the last three are those
of KUKA's Sunrise, Doosan and Fanuc."""

ANOTHER_FORM = 'or "rpy", or "euler" with its order: the names do not tell'
ANOTHER_ORDER = 'or "euler" in another order'
"""What a map says of forms of angles that are guessed."""

KINDS = {
    "rotation-vector": ('form = "rotation-vector"', ""),
    "angles": (UNTOLD, ""),
    "roll-pitch-yaw": (RPY, ANOTHER_ORDER),
}
"""The same of three components x, y, z, by the kind of what stands before them."""


def angles_of(sample: Sample, groups: Groups) -> Guess | None:
    """Three angles by their names, or a rotation vector."""
    names: dict[str, int] = {}
    last: dict[str, int] = {}
    for column in reversed(range(len(sample.names))):
        words = words_of(sample.words(column))
        if words and not OTHER & set(words):
            names["".join(words)] = last[words[-1]] = column
            if sample.words(column).endswith("Rad"):
                last[f"{words[-1]}rad"] = column
    for angles, form in ANGLES.items():
        for where in (names, last):
            if set(angles) <= set(where) and (len(angles[0]) > 1 or where is names):
                return turned(sample, tuple(where[a] for a in angles), *form)
    for kind, form in KINDS.items():
        if (columns := groups.find(kind, "xyz")) is not None:
            return turned(sample, columns, *form)
    return None


def turned(
    sample: Sample, columns: tuple[int, ...], form: str, doubt: str = ""
) -> Guess:
    """Three angles. Those of an untold form are a rotation vector, as of UR, or roll,
    pitch and yaw, as of xArm, where that would jump."""
    unit, remark = sample.stated_or_by_size(columns, "angle")
    if form == UNTOLD:
        radians = find_unit(unit, "angle", sample.source).to_si(
            sample.values[:, list(columns)]
        )
        chosen, why = form_of_angles(radians)
        form = f'form = "{chosen}"'
        doubt = f"{why}; {ANOTHER_ORDER}" if why else ANOTHER_FORM
    remark = "; ".join(filter(None, (remark, doubt)))
    return Guess("orientation", columns, (form, unit_entry(unit)), remark)
