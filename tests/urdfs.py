"""URDF texts for tests: their parts, and the arm of the simulation."""

import numpy as np


def joint(name, kind, parent, child, inner=""):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inner}</joint>'


def urdf(links, *joints):
    return (
        "<robot name='r'>"
        + "".join(f"<link name='{link}'/>" for link in links)
        + "".join(joints)
        + "</robot>"
    )


LINKS = (
    "base",
    "shoulder",
    "upper_arm",
    "forearm",
    "wrist_1",
    "wrist_2",
    "wrist_3",
    "tool0",
)
SIX = tuple(f"joint_{i}" for i in range(1, 7))
MOVED = (
    (0.0, 0.0, 0.0), (0.0, np.pi / 2, 0.089159), (-0.425, 0.0, 0.0), (-0.39225, 0.0, 0.0),
    (0.0, np.pi / 2, 0.10915), (0.0, -np.pi / 2, 0.09465), (0.0, 0.0, 0.0823),
)  # fmt: skip
"""a [m], alpha [rad] and d [m] of the UR5 after each turn, as its maker gives them."""
KINDS = ["revolute"] * 6 + ["fixed"]
LIMIT = '<limit lower="-6.3" upper="6.3" effort="1" velocity="1"/>'
UR5_URDF = urdf(
    LINKS,
    *(
        joint(
            *names,
            f'<origin xyz="{a} 0 {d}" rpy="{float(alpha)} 0 0"/><axis xyz="0 0 1"/>'
            + LIMIT,
        )
        for *names, (a, alpha, d) in zip(
            (*SIX, "flange"), KINDS, LINKS[:-1], LINKS[1:], MOVED, strict=True
        )
    ),
)
"""The arm of the simulation: the frame of joint i + 1 is that of joint i after its
turn, moved by d, a and alpha."""
