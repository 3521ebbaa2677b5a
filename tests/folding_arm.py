"""An arm of boxes that can fold onto itself and reach the floor, for tests of what it
keeps clear of."""

from urdfs import joint

LIMIT = '<limit lower="-2.9" upper="2.9" effort="50" velocity="2"/>'
SIZES = {
    "base": ("0.2 0.2 0.1", "0 0 0.05"),
    "turret": ("0.1 0.1 0.1", "0 0 0.05"),
    "upper": ("0.08 0.06 0.4", "0 0 0.2"),
    "lower": ("0.06 0.06 0.3", "0 0 0.15"),
    "hand": ("0.1 0.06 0.04", "0 0 0.02"),
}
"""Sides [m] of the box of each link, and where its centre is in the link's frame."""
JOINTS = (
    joint("turn", "revolute", "base", "turret", f'<origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>{LIMIT}'),
    joint("lift", "revolute", "turret", "upper", f'<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>{LIMIT}'),
    joint("bend", "revolute", "upper", "lower", f'<origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>{LIMIT}'),
    joint("nod", "revolute", "lower", "hand", f'<origin xyz="0 0 0.3"/><axis xyz="1 0 0"/>{LIMIT}'),
    joint("mount", "fixed", "hand", "tool", '<origin xyz="0 0 0.05" rpy="0 0 0.3"/>'),
)  # fmt: skip


def folding_arm(tmp_path, part="collision", joints=JOINTS, extra=""):
    """Its URDF, written to a file."""
    links = "".join(
        f'<link name="{name}"><{part}><origin xyz="{place}"/><geometry>'
        f'<box size="{size}"/></geometry></{part}></link>'
        for name, (size, place) in SIZES.items()
    )
    path = tmp_path / "arm.urdf"
    path.write_text(
        f"<robot name='r'>{links}<link name='tool'/>{''.join(joints)}{extra}</robot>"
    )
    return path
