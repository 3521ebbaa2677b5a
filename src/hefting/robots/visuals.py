"""What the links of a URDF look like: meshes, boxes, cylinders and spheres.

The file is hostile until shown otherwise: it is read by `hefting.core.files.parse_xml`,
meshes are taken only from the folder of the URDF and those below it, and what is drawn
is bounded. A mesh that is not there, or of a kind that is not read, is left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal
from urllib.parse import unquote

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_xml
from hefting.core.spatial import Array, frozen
from hefting.robots.urdf import read_numbers, read_origin

Part = Literal["visual", "collision"]

MOST_PARTS = 2_000
"""Most visual and collision elements of a robot."""
SIZES = {"box": ("size", 3), "cylinder": ("radius length", 2), "sphere": ("radius", 1)}
"""Attributes of each simple geometry, and how many numbers they are."""
LARGEST_SIZE = 1e3
"""[m] No part of an arm is larger."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """One element that a link looks like, in the frame of the link."""

    link: str
    part: Part
    position: Array
    """(3,) [m] of the geometry in the link's frame"""
    orientation: Array
    """(4,) unit quaternion x, y, z, w"""
    kind: str
    """``"mesh"`` or a key of `SIZES`"""
    size: tuple[float, ...]
    """scale of a mesh along its axes; else the numbers of `SIZES` [m]"""
    file: Path | None = None
    """of a mesh, inside the folder of the URDF"""


def read_geometries(path: str | Path) -> tuple[Geometry, ...]:
    """What the links of a URDF look like.

    Meshes that are not in the URDF's folder or below it, by whatever link, are left
    out. Raises `InputError`, naming the link, for a number that is not finite or too
    large, for more than `MOST_PARTS` elements, and for a file that `parse_xml` refuses.
    """
    parts: list[_Element] = []
    link = ""

    def start(tag: str, attributes: dict[str, str], _: int, inside: list[str]):
        nonlocal link
        if len(inside) == 1 and tag == "link":
            link = attributes.get("name", "")
        elif inside[1:] == ["link"] and tag in ("visual", "collision"):
            parts.append(_Element(link, tag))  # type: ignore[arg-type]
        elif parts and inside[1:3] == ["link", parts[-1].part]:
            parts[-1].inner.setdefault(tag, attributes)
        if len(parts) > MOST_PARTS:
            raise InputError(f"has more than {MOST_PARTS:,} visual parts", where=path)

    parse_xml(read_xml(path), path, start)
    return tuple(_geometries(parts, path))


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file of a mesh that a URDF names, in the URDF's `folder` or below it, or in
    the ROS package that holds the URDF.

    ``package://PACKAGE/meshes/x.stl`` is looked for as ``meshes/x.stl`` and as
    ``PACKAGE/meshes/x.stl``, then in the nearest folder above that is called PACKAGE
    and has a ``package.xml``. None for an absolute path, another address, a path or a
    link that leads out of these folders, and where there is no such file.
    """
    text = unquote(name)
    if "\0" in text:
        return None
    root = folder.resolve()
    places = [(root, text)]
    if text.startswith("package://"):
        whole = text.removeprefix("package://")
        package, _, inside = whole.partition("/")
        places = [(root, inside), (root, whole)]
        places += [(above, inside) for above in _packages(root, package)]
    elif "://" in text or text.startswith("/"):
        return None
    for place, path in places:
        try:
            file = (place / path).resolve()
            if path and file.is_relative_to(place) and file.is_file():
                return file
        except (OSError, RuntimeError, ValueError):  # too long, or links in a circle
            continue
    return None


def _packages(folder: Path, name: str) -> list[Path]:
    """The nearest folder above that is a ROS package of this name, if any is."""
    above = (each for each in (folder, *folder.parents) if each.name == name)
    return [each for each in above if (each / "package.xml").is_file()][:1]


@dataclass
class _Element:
    """A visual or collision element, with the attributes of the elements inside."""

    link: str
    part: Part
    inner: dict[str, dict[str, str]] = field(default_factory=dict)


def _geometries(parts: list[_Element], path: str | Path) -> Iterator[Geometry]:
    folder = Path(path).parent
    for element in parts:
        where = f"{path}, link '{element.link[:40]}'"
        position, orientation = read_origin(element.inner.get("origin", {}), where)
        kind = next((k for k in ("mesh", *SIZES) if k in element.inner), None)
        if kind is None:
            continue
        attributes = element.inner[kind]
        file = None
        if kind == "mesh":
            file = mesh_file(attributes.get("filename", ""), folder)
            if file is None:
                continue
            size = read_numbers(attributes.get("scale", "1 1 1"), 3, "a scale", where)
        else:
            names, count = SIZES[kind]
            text = " ".join(attributes.get(name, "") for name in names.split())
            size = read_numbers(text, count, f"the size of a {kind}", where)
        _check_size(np.concatenate((position, size)), where)
        yield Geometry(
            element.link,
            element.part,
            frozen(position),
            frozen(orientation),
            kind,
            tuple(size),
            file,
        )


def _check_size(values: Array, where: str) -> None:
    if np.abs(values).max() > LARGEST_SIZE:
        raise InputError(
            f"a visual part is larger than {LARGEST_SIZE:g} m",
            where,
            "give lengths in metres",
        )
