"""Versions of the peers: those installed, and those locked."""

import re
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from packaging.markers import Marker

PEERS = ("mujoco", "pin", "cvxpy-base", "clarabel", "numpy", "scipy")
"""Distributions that parties consist of."""
LOCKED = Path(__file__).resolve().parents[2] / "requirements" / "dev.txt"
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)(?:\s*;\s*([^\\\n]+))?", re.MULTILINE)
"""Name, version and, where there is one, for which environments."""


def installed() -> dict[str, str]:
    """Version by distribution; those that are not installed are left out."""
    found = {}
    for name in PEERS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def locked(path: Path = LOCKED) -> dict[str, str]:
    """The versions of `PEERS` that the requirements lock for this Python."""
    pinned = {
        name: locked
        for name, locked, marker in PIN.findall(path.read_text())
        if not marker or Marker(marker).evaluate()
    }
    return {name: pinned[name] for name in PEERS if name in pinned}


def differences(
    here: dict[str, str] | None = None, pinned: dict[str, str] | None = None
) -> list[str]:
    """A line for each peer of another version than is locked."""
    here = installed() if here is None else here
    pinned = locked() if pinned is None else pinned
    return [
        f"{name} is {here[name]}, and {wanted} is locked: figures may differ"
        for name, wanted in pinned.items()
        if name in here and here[name] != wanted
    ]
