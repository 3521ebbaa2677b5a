"""Limits of what a shape's file may hold, checked on its bytes before anything is made
of them: a small file can ask for a lot of memory and time."""

from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import MAX_JSON, MAX_LISTS

MAX_WORDS = 12_000_000
"""Most words, and most lines, of a mesh or point cloud in text. A word takes up to 130
bytes of memory while it is read (ASCII PLY, .off), which makes 1.6 GB; it is 570,000
triangles of an ASCII .stl."""

MAX_LINE = 10_000
"""Longest line of a point cloud in text [characters]."""

MAX_CLOUD = 1_000_000
"""Most points of a cloud; the hull of so many takes some seconds."""

MAX_NUMBERS = 50_000_000
"""Most numbers that the vertices of a PLY file may have in all (0.4 GB)."""

MAX_NODES = 10_000
"""Most nodes of a scene: the time to place them can grow with the square of their
number."""

PART = 2**20
"""Bytes in which words are counted at a time."""


def check_text(data: bytes, path: str | Path) -> None:
    """`InputError` for a text of more than `MAX_WORDS` words or lines."""
    lines, words, between = 0, 0, True
    for first in range(0, len(data), PART):
        text = np.frombuffer(data, np.uint8, min(PART, len(data) - first), first)
        # blanks, commas and what ends a line
        blank = (text <= ord(" ")) | (text == ord(",")) | (text == ord(";"))
        starts = ~blank
        starts[1:] &= blank[:-1]
        starts[0] &= between
        words += int(np.count_nonzero(starts))
        lines += int(np.count_nonzero((text < ord(" ")) & (text != ord("\t"))))
        between = bool(blank[-1])
        if max(words, lines) > MAX_WORDS:
            raise InputError(
                f"holds more than {MAX_WORDS // 1_000_000} million words of text",
                path,
                "simplify or downsample it, or export it as a binary file",
            )


def check_count(count: int, path: str | Path) -> None:
    """`InputError` for a cloud of more than `MAX_CLOUD` points."""
    if count > MAX_CLOUD:
        raise InputError(
            f"the point cloud has more than {MAX_CLOUD:,} points", path, "downsample it"
        )


def check_scene(scene: Any, size: int) -> None:
    """`ValueError` for a glTF scene whose arrays are longer than the file of `size`
    bytes that holds them (glTF allows ones made of nothing), or that has too many
    nodes."""
    made_of_nothing = [a["count"] for a in scene["accessors"] if "bufferView" not in a]
    if sum(accessor["count"] for accessor in scene["accessors"]) > size:
        raise ValueError("arrays longer than the file")
    if sum(made_of_nothing) > MAX_CLOUD:
        raise ValueError("long arrays made of nothing")
    if len(scene.get("nodes", ())) > MAX_NODES:
        raise ValueError("too many nodes")


def check_header(header: bytes) -> None:
    """`ValueError` for a glTF header that is too large to be read as JSON."""
    if len(header) > MAX_JSON or header.count(b"[") + header.count(b"{") > MAX_LISTS:
        raise ValueError("the header is too large")
