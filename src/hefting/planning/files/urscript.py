"""URScript: a program for controllers of Universal Robots that streams the motion.

Source: Universal Robots, *The URScript Programming Language*, ``movej``, ``servoj``.
"""

from pathlib import Path

import numpy as np

from hefting.core.spatial import Array
from hefting.planning.files import MotionFile
from hefting.planning.result import Plan, reduced_speed_told, speed_told

JOINTS = 6
"""Every arm of theirs has so many."""
STEP = 0.008
"""[s] between positions: one cycle of a CB3 controller, four of an e-Series, so that
the file is for both."""
LOOKAHEAD = 0.1
"""[s] over which the controller smooths; its default."""
GAIN = 300
"""Of the position controller; its default."""
APPROACH = (0.3, 0.25)
"""Acceleration [rad/s²] and speed [rad/s] of the way to the start."""
END = 1.0
"""[rad/s²] of the stop at the end, where the arm is at rest anyway."""


def _content(plan: Plan) -> bytes:
    FORMAT.require(len(plan.joints))
    count = int(np.ceil(plan.duration / STEP - 1e-9))
    positions = plan.at(STEP * np.arange(1, count + 1)).position
    start = plan.at([0.0]).position[0]
    acceleration, speed = APPROACH
    lines = [
        *(f"# {line}" for line in _comments(plan)),
        "def hefting_plan():",
        "  def go(q):",
        f"    servoj(q, 0, 0, {STEP}, {LOOKAHEAD}, {GAIN})",
        "  end",
        f"  movej({_list(start)}, a={acceleration}, v={speed})",
        *(f"  go({_list(q)})" for q in positions),
        f"  stopj({END})",
        "end",
    ]
    return ("\n".join(lines) + "\n").encode()


def _list(q: Array) -> str:
    return "[" + ",".join(f"{value:.7f}" for value in q) + "]"


def _comments(plan: Plan) -> list[str]:
    names = ", ".join(_printable(name) for name in plan.joints)
    source = _printable(Path(plan.source).name)
    speed = speed_told(plan.limits.corner_speed)
    return [
        f"Motion of {plan.duration:.4g} s planned by Hefting for '{_printable(plan.tip)}' of {source}",
        f"Joints: {names}; positions in rad, every {1e3 * STEP:.4g} ms",
        f"As planned it {reduced_speed_told(plan)}: at most {speed} at the object's corners",
        "The way to the start (movej) is not planned: nothing was checked along it",
        "Try it in simulation first (URSim), then at a low speed slider",
    ]


def _printable(text: str) -> str:
    """A name from a file as a part of a comment of one line."""
    return "".join(c if c.isprintable() else "?" for c in text)[:80]


FORMAT = MotionFile(".script", "URScript that streams it by servoj", _content, JOINTS)
"""Joint positions at 125 Hz, after a movej to the start."""
