"""Pairs of links that an SRDF says not to check for collisions.

Source: https://wiki.ros.org/srdf. The file is hostile until shown otherwise: it is read
by `hefting.core.files.parse_xml`.
"""

from collections.abc import Collection
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_xml

MOST = 200_000
"""Most pairs that are read: those of a humanoid with hands are some 5,000."""


def read_disabled_pairs(
    path: str | Path, links: Collection[str]
) -> frozenset[frozenset[str]]:
    """Pairs of `links` whose collisions the file disables.

    Raises `InputError` when the file cannot be read, is no XML, its root is not
    ``<robot>``, it names no pair of these links, or more than `MOST`.
    """
    pairs: set[frozenset[str]] = set()
    roots: list[str] = []

    def start(tag: str, attributes: dict[str, str], _: int):
        roots.append(tag)
        if roots[0] != "robot":
            what = f"is not SRDF: its root is <{tag[:40]}>, not <robot>"
            raise InputError(what, where=path)
        if tag == "disable_collisions":
            pair = {attributes.get("link1", ""), attributes.get("link2", "")}
            if pair <= set(links):
                pairs.add(frozenset(pair))
        if len(roots) > MOST:
            raise InputError(f"has more than {MOST:,} elements", where=path)

    parse_xml(read_xml(path), path, start, lambda *_: None)
    if not pairs:
        what = "has no <disable_collisions> between links of the robot"
        raise InputError(what, where=path, fix="is it of this robot?")
    return frozenset(pairs)
