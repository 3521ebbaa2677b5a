"""URDFs of random inertials, and of robots that others publish."""

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.robots.inertials import ENTRIES

KINDS = ("solid", "triangle", "indefinite", "negative", "flat", "mass")


def random_inertial(
    rng: np.random.Generator, kind: str, slightest: float = 1e-8
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, COM (3,) and tensor (3, 3) at the COM: of a body, or of none because of
    what `kind` says; by a share of 1e-8 to 1."""
    mass, size = 10 ** rng.uniform(-3.0, 1.7), 10 ** rng.uniform(-2.0, 0.0)
    second = mass * size**2 * rng.uniform(0.1, 1.0, 3)
    violation = 10 ** rng.uniform(np.log10(slightest), 0.0) * 0.9 * second[1:].min()
    if kind in ("triangle", "indefinite"):
        second[0] = -violation
    if kind == "indefinite":
        second[1] = (
            -second[2] - violation
        )  # so that the moment about the first axis is negative
    if kind == "negative":
        second = -second
    if kind == "flat":  # exactly, in decimals
        second = np.round((0.0, *second[1:]), 12)
        tensor = np.diag(np.round(second.sum() - second, 12))
        return mass, size * rng.normal(size=3), tensor
    axes = Rotation.random(random_state=rng).as_matrix()
    second = (axes * second) @ axes.T
    tensor = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
    return -mass if kind == "mass" else mass, size * rng.normal(size=3), tensor


def random_robot(rng: np.random.Generator, kinds: list[str]) -> str:
    """A URDF with a chain of hinged links, one of each of `kinds`."""
    text = ["<?xml version='1.0'?>\n<robot name='chain'>\n  <link name='link0'/>"]
    for i, kind in enumerate(kinds, 1):
        mass, com, J = random_inertial(rng, kind)
        entries = [J[0, 0], J[0, 1], J[0, 2], J[1, 1], J[1, 2], J[2, 2]]
        tensor = " ".join(
            f'{n}="{float(v)!r}"' for n, v in zip(ENTRIES, entries, strict=True)
        )
        xyz = " ".join(repr(float(x)) for x in com)
        rpy = " ".join(repr(float(x)) for x in rng.uniform(-1.5, 1.5, 3))
        text.append(
            f"  <link name='link{i}'><!-- {kind} -->\n    <inertial>\n"
            f'      <origin xyz="{xyz}" rpy="{rpy}"/>\n      <mass value="{mass!r}"/>\n'
            f"      <inertia {tensor}/>\n    </inertial>\n  </link>\n"
            f"  <joint name='joint{i}' type='continuous'>"
            f"<parent link='link{i - 1}'/><child link='link{i}'/><axis xyz='0 0 1'/></joint>"
        )
    return "\n".join([*text, "</robot>\n"])


@cache
def published_robots() -> tuple[Path, ...]:
    """The URDFs of `example-robot-data`; none where it is not installed."""
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        return ()
    return tuple(sorted(Path(str(f.locate())) for f in files if f.suffix == ".urdf"))


def parsed(text: bytes) -> Iterator[tuple[str, ElementTree.Element]]:
    """Name and inertial of each link that has one with a mass or a tensor, by another
    parser."""
    for link in ElementTree.fromstring(text).findall("link"):
        inertial = link.find("inertial")
        if inertial is not None and any(numbers(inertial)):
            yield link.attrib["name"], inertial


def numbers(inertial: ElementTree.Element) -> list[Fraction]:
    """Mass, and the entries of the tensor, exactly as written."""
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    assert mass is not None
    assert tensor is not None
    texts = [mass.attrib["value"], *(tensor.attrib[name] for name in ENTRIES)]
    return [Fraction(text.strip()) for text in texts]


def exists(inertial: ElementTree.Element) -> bool:
    """Whether the pseudo-inertia about the COM, in the axes of the inertial, is
    positive definite: by its leading minors (Sylvester), in exact arithmetic."""
    mass, xx, xy, xz, yy, yz, zz = numbers(inertial)
    half = (xx + yy + zz) / 2
    a, b, c, d, e, f = half - xx, -xy, -xz, half - yy, -yz, half - zz
    second = a * d - b * b
    third = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    return mass > 0 and a > 0 and second > 0 and third > 0


def pseudo_inertia(inertial: ElementTree.Element) -> np.ndarray:
    """The 4 x 4 pseudo-inertia about the origin of the link, in its axes."""
    m, xx, xy, xz, yy, yz, zz = map(float, numbers(inertial))
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    origin = inertial.find("origin")
    given = {} if origin is None else origin.attrib
    c = np.array([float(x) for x in given.get("xyz", "0 0 0").split()])
    rpy = [float(x) for x in given.get("rpy", "0 0 0").split()]
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    second = R @ (0.5 * np.trace(J) * np.eye(3) - J) @ R.T + m * np.outer(c, c)
    return np.block([[second, m * c[:, None]], [m * c, m]])
