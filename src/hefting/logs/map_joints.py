"""The joints of an arm in a table with any names: angles, and torques or currents."""

import json
import re

import numpy as np

from hefting.logs.map_groups import OTHER, Groups, words_of
from hefting.logs.map_sample import Sample
from hefting.logs.map_text import Guess, in_unit, unit_entry

UNIT_NORM = 0.02
"""Largest deviation of a quaternion's norm from one."""
JOINT_EFFORTS = ("joint_torques", "joint_currents")
"""Keys of quantities that an arm without a wrist sensor measures."""
FEWEST_JOINTS = 4
"""Smallest number of columns that are taken for the joints of an arm."""

JOINT_STATE = re.compile(
    r"(?![\s\S]{300}).*joint[^/.]*[/.](?:([^/.]+)[/.](position|effort)|(position|effort)[/.](?!\d)([^/.]+))"
)
"""Short names of positions and efforts in JointState."""


def joints_of(sample: Sample, groups: Groups, near: set[str]) -> list[Guess] | None:
    """Angles of an arm's joints, and as many torques or currents, if any."""
    if len(named := _named_joints(sample, "position")) >= FEWEST_JOINTS:
        columns, names = (*named.values(),), (f"names = {json.dumps([*named])}",)
    else:
        counts = range(9, FEWEST_JOINTS - 1, -1)
        choices = [groups.numbered("joint_positions", n, near) for n in counts]
        # JointState's ``position`` and KUKA's ``A1`` alone might be another quantity
        choices += [
            groups.numbered(kind, n, near)
            for n in counts
            if groups.numbered("joint_torques", n, near)
            for kind in ("position", "axes")
        ]
        choice = next(filter(None, choices), None)
        if choice is None or (
            len(choice.columns) == 4 and has_unit_norm(sample, choice.columns)
        ):
            return None
        columns, names = choice.columns, ()
    unit, remark = sample.stated_or_by_size(columns, "angle")
    angles = Guess("joint_positions", columns, (unit_entry(unit), *names), remark)
    efforts = _named_joints(sample, "effort")
    if names and {*efforts} >= {*named}:
        columns = tuple(efforts[name] for name in named)
        return [angles, in_unit("joint_torques", "torque", "N m", sample, columns)]
    for key, kind, usual in (
        ("joint_torques", "torque", "N m"),
        ("joint_currents", "current", "A"),
    ):
        if found := groups.numbered(key, len(columns), near):
            return [angles, in_unit(key, kind, usual, sample, found.columns)]
    return [angles]


def _named_joints(sample: Sample, quantity: str) -> dict[str, int]:
    """Columns of a quantity of a robot's joints, by joint: ``wrist_3_joint`` (positions
    only) or PlotJuggler's ``/joint_states/joint_7/position``."""
    joints = {}
    for column in range(len(sample.names)):
        words = words_of(name := sample.words(column))
        if OTHER & {*words} - {"effort"}:
            continue
        if found := JOINT_STATE.fullmatch(name):
            if quantity == (found[2] or found[3]):
                joints[found[1] or found[4]] = column
        elif quantity == "position" and len(words) > 1 and words[-1] == "joint":
            joints[name] = column
    return joints


def has_unit_norm(sample: Sample, columns: tuple[int, ...]) -> bool:
    """Whether four columns hold unit quaternions."""
    with np.errstate(over="ignore"):
        norms = np.linalg.norm(sample.values[:, list(columns)], axis=1)
    known = norms[np.isfinite(norms)]
    return len(known) > 0 and bool((np.abs(known - 1.0) < UNIT_NORM).all())
