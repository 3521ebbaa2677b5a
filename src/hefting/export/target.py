"""Target: description of a simulator, a controller or a table for
`hefting.export.export`.

Each target, or those of one make, are one file; `hefting.export` lists the files.

An inertial element is inserted in an existing XML file at the offset that a parser finds,
with every other byte unchanged. XML is not trusted: a document type declaration is
refused, so that entities are never expanded or fetched, and the size is bounded.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.core.errors import InputError, nearest
from hefting.core.files import check_no_xacro, parse_xml, read_xml, tag_end
from hefting.core.messages import Message
from hefting.export.body import Body

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate


@dataclass(frozen=True)
class Place:
    """Where a format keeps its inertial elements."""

    format: str
    """Name of the format."""
    roots: tuple[str, ...]
    """Possible root elements."""
    element: str
    """Element that holds the inertial."""
    parents: tuple[str, ...] | None
    """Possible parents of that element; None for any."""
    massive: str = ""
    """Element that gives mass if there is no inertial, if the format has one."""
    movers: tuple[str, ...] = ()
    """Elements inside it that only move or repeat what they hold; the first may hold the
    inertial."""
    scope: str = ""
    """Element by whose name the element's may be qualified, as in ``model::link``, if the
    format has that."""


def _no_warnings(*_: Body | str) -> list[Message]:
    return []


@dataclass(frozen=True)
class Target:
    """A form of a written estimate, with either `write` or `write_estimate`."""

    name: str
    """As given to `hefting.export.export` and ``hefting export --to``."""
    description: str
    """In half a line."""
    suffixes: tuple[str, ...] = ()
    """Suffixes of file names, with their dot, that select this target."""
    other_suffixes: tuple[str, ...] = ()
    """Suffixes of its file names that do not select it."""
    write: Callable[[Body], str] | None = None
    """Text of a complete file, or lines to paste, of a body."""
    write_estimate: Callable[["Estimate", str], str] | None = None
    """Text of the estimate in sensor axes, even if not consistent, with a name."""
    is_read_back: bool = False
    """Whether `Estimate.load` reads the text; its suffixes are then listed first."""
    wants_flange: bool = False
    """Whether its numbers must be in flange axes about the flange's origin; otherwise any
    frame is allowed."""
    needs_inertia: bool = False
    """Whether a point mass cannot be written."""
    takes_inertia: bool = True
    """Whether the text can hold an inertia."""
    in_sensor_axes: bool = False
    """Whether its numbers are in sensor axes for any pose of the sensor on the flange."""
    place: Place | None = None
    """Where a file of the format holds inertials; None: it cannot be put into one."""
    inertial: Callable[[Body], str] | None = None
    """Text of that inertial; given if `place` is."""
    warnings: Callable[[Body], list[Message]] = _no_warnings
    """Warnings about a body in this form."""
    file_warnings: Callable[[str, str], list[Message]] = _no_warnings
    """Warnings about the text of an existing file with the inertial of the element with
    this name."""


@dataclass
class _Holder:
    """An element that can hold an inertial: name, also with those of its scopes, offset
    [bytes] of its start tag, depth, and begin and end [bytes] of the inertial inside it,
    with its depth."""

    name: str
    scoped: str
    start: int
    depth: int
    inertial: tuple[int, int] | None = None
    inertial_depth: int = 0
    massive: int = 0
    """Number of elements in it that give it mass without an inertial."""

    @property
    def is_moved(self) -> bool:
        """Whether the inertial is in an element that moves it."""
        return self.inertial_depth > self.depth + 1


def put_inertial(
    path: str | Path, name: str | None, inertial: str, place: Place
) -> tuple[str, str]:
    """Text of the file with `inertial` in the element called `name`, and the previous
    source of its mass in words, or an empty text.

    Raises `InputError` if the file cannot be read, is not well-formed XML of that format
    in UTF-8, has a document type, is larger than `hefting.core.files.MAX_XML`, has
    elements of xacro, or does not hold the element exactly once.
    """
    data = read_xml(path)
    reader = _HolderReader(data, path, place)
    parse_xml(data, path, reader.start, reader.end)
    holder = _holder_named(reader, path, name, place)
    return _inserted(data, holder, inertial, place).decode(), _mass_source(
        holder, place
    )


def _inserted(data: bytes, holder: _Holder, inertial: str, place: Place) -> bytes:
    """The file's text with `inertial` in place of the holder's own, or first in it, by
    the indentation and line ends of the file."""
    margin = data[data.rfind(b"\n", 0, holder.start) + 1 : holder.start]
    margin = margin if not margin.strip() else b""
    deeper = margin + (b"\t" if b"\t" in margin else b"  ")
    newline = b"\r\n" if b"\r\n" in data else b"\n"
    block = inertial.encode().replace(b"\n", newline + deeper)
    if holder.inertial is not None:
        start, end = holder.inertial
        if not holder.is_moved:
            return data[:start] + block + data[end:]
        # the new one is not to be moved
        data = data[:start].rstrip() + data[end:]
    end = tag_end(data, holder.start)
    opening, closing = data[:end], b""
    if opening.endswith(b"/>"):  # an element without content
        opening = opening[:-2].rstrip() + b">"
        closing = newline + margin + b"</" + place.element.encode() + b">"
    return opening + newline + deeper + block + closing + data[end:]


def _mass_source(holder: _Holder, place: Place) -> str:
    """Where the mass of an element came from, in words; an empty text for none."""
    if holder.inertial is not None:
        moved = f" in a <{place.movers[0]}>" if holder.is_moved else ""
        return f"an inertial{moved}"
    if not holder.massive:
        return ""
    plural = "s" if holder.massive > 1 else ""
    return f"the mass of its {holder.massive} {place.massive}{plural}"


def _holder_named(
    reader: "_HolderReader", path: str | Path, name: str | None, place: Place
) -> _Holder:
    holders = reader.holders
    matches = [holder for holder in holders if holder.scoped == name]
    matches = matches or [holder for holder in holders if holder.name == name]
    if len(matches) == 1:
        return matches[0]
    count = Counter(each.name for each in holders)
    names = [each.name if count[each.name] == 1 else each.scoped for each in holders]
    if name is None:
        what = f"which <{place.element}> is it to go into?"
    elif matches:
        what = f"{len(matches)} <{place.element}> are named '{name}'"
    else:
        what = f"no <{place.element}> is named '{name}'{nearest(name, names)}"
    listed = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
    if not names:
        fix = f"the file has no <{place.element}> with a name"
    elif len(matches) > len({each.scoped for each in matches}):
        fix = "give each a name of its own"
    else:
        fix = f"choose one of: {listed}"
    if reader.included and not matches:
        fix += f"; or give the file that has it: it includes {', '.join(reader.included[:9])}"
    raise InputError(what, where=path, fix=fix)


class _HolderReader:
    """Finds holders from the tags of a file, which `parse_xml` gives, in their order."""

    def __init__(self, data: bytes, path: str | Path, place: Place):
        self._data, self._path, self._place = data, path, place
        self.holders: list[_Holder] = []
        self.included: list[str] = []
        """names of files that MJCF includes"""
        self._open: list[_Holder] = []
        """those whose end has not come, the innermost last"""
        self._scopes: list[tuple[str, int]] = []
        """names and depths of the open scopes, the innermost last"""

    def start(
        self, tag: str, attributes: dict[str, str], offset: int, inside: list[str]
    ) -> None:
        """Begin a scope or a holder, or note what the innermost open one holds."""
        place = self._place
        if not inside and tag not in place.roots:
            what = f"is not {place.format}: its root is <{tag}>, not <{place.roots[0]}>"
            raise InputError(what, where=self._path)
        check_no_xacro(tag, self._path, place.format)
        if tag == "include":
            self.included.append(attributes.get("file", "others"))
        if tag == place.scope:
            self._scopes.append((attributes.get("name", ""), len(inside)))
        if (
            tag == place.element
            and "name" in attributes
            and (place.parents is None or inside[-1] in place.parents)
        ):
            name = attributes["name"]
            scoped = "::".join([*(each for each, _ in self._scopes), name])
            if len(scoped) > 1000:
                raise InputError("has names of more than 1,000 characters", self._path)
            holder = _Holder(name, scoped, offset, len(inside))
            self._open.append(holder)
            self.holders.append(holder)
        elif self._open:
            self._note_content(self._open[-1], tag, attributes, offset, inside)

    def _note_content(
        self,
        holder: _Holder,
        tag: str,
        attributes: dict[str, str],
        offset: int,
        inside: list[str],
    ) -> None:
        """Note an inertial of a holder, or that something in it has mass."""
        place = self._place
        if not set(inside[holder.depth + 1 :]) <= set(place.movers):
            return
        if tag == "inertial":
            if holder.inertial is not None:
                what = f"<{place.element}> '{holder.name}' has two inertials"
                raise InputError(what, where=self._path, fix="remove one of them")
            holder.inertial = (offset, -1)  # `end` finds where it ends
            holder.inertial_depth = len(inside)
        elif tag == place.massive and _has_mass(attributes):
            holder.massive += 1

    def end(self, tag: str, offset: int, inside: list[str]) -> None:
        """End the innermost open scope or holder, or its inertial."""
        if self._scopes and len(inside) == self._scopes[-1][1]:
            self._scopes.pop()
        if not self._open:
            return
        holder = self._open[-1]
        if len(inside) == holder.depth:
            self._open.pop()
        elif (
            tag == "inertial"
            and holder.inertial is not None
            and holder.inertial[1] < 0
            and len(inside) == holder.inertial_depth
        ):
            start = holder.inertial[0]
            first = tag_end(self._data, start)
            is_empty = self._data[first - 2 : first] == b"/>"
            end = first if is_empty else self._data.index(b">", offset) + 1
            holder.inertial = (start, end)


def _has_mass(attributes: dict[str, str]) -> bool:
    """Whether neither the mass nor the density of an element is given as zero."""
    given = (attributes.get(name, "1").strip() for name in ("mass", "density"))
    numbers = (text.lower().partition("e")[0] for text in given)
    return not any(text and not text.strip("+-0.") for text in numbers)
