"""Reading JSON, TOML and XML with care, and writing files whole or not at all."""

import json
import os
import re
import stat
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from hefting.core.errors import InputError

MAX_JSON = 40_000_000
"""Largest JSON file that is read [bytes]: one of a million point masses fits."""

MAX_LISTS = 1_000_000
"""Largest number of lists and objects in a JSON file that is read: an empty one takes
thirty times its bytes in memory; an estimate has a hundred."""

MAX_BYTES = 2 * 1024**3
"""Largest table that is read [bytes]: its numbers are held in memory, and slow motion
needs far less."""

MAX_XML = 16 * 2**20
"""Largest XML file that is read [bytes]; URDFs are thousands of times smaller."""

MAX_DEPTH = 10_000
"""Deepest nesting of XML elements that is read."""

MAX_INSIDE = 200_000_000
"""Largest sum of the depths of XML elements, by which the time to read them grows."""

TAG = re.compile(rb"""<(?:[^"'>]++|"[^"]*+"|'[^']*+')*+>""")
"""A tag with its attributes, whose values may contain the character that ends a tag."""

MAX_MAP = 64_000
"""Largest map that is read [bytes]; one that names a thousand columns has half."""

MAX_DOTS = 1000
"""Most dots in a line of a map. The time that `tomllib` takes for a dotted key grows
with the square of its dots: 2,000 take a quarter of a second, 50,000 two minutes and
more than 8 GB."""


def check_readable(path: str | Path) -> None:
    """`InputError` for an input that is neither a regular file nor a folder, as reading
    a pipe could wait for ever."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return  # reading the path raises the error
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        what = "is a pipe or a device, not a file"
        raise InputError(what, path, "write it to a file first")


def check_size(path: str | Path, largest: float | None = None) -> None:
    """`InputError` unless there is a file that is neither empty nor larger than
    `largest` [bytes], by default `MAX_BYTES`."""
    if not Path(path).is_file():
        lost = "is a link to no file" if os.path.islink(path) else "does not exist"
        what = "is not a file" if Path(path).exists() else lost
        raise InputError(what, where=path)
    size = Path(path).stat().st_size
    if size == 0:
        raise InputError("the file is empty", where=path)
    if size > (MAX_BYTES if largest is None else largest):
        what = f"the file has {size / 1e9:.1f} GB, more than 2 GiB"
        raise InputError(what, path, "cut out the part of interest")


def read_bytes(path: str | Path, largest: int, kind: str) -> bytes:
    """The bytes of a file; `InputError` when it cannot be read or has too many."""
    check_readable(path)
    try:
        with open(path, "rb") as stream:
            data = stream.read(largest + 1)
    except (OSError, ValueError) as error:  # a null byte in the path
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be read ({why})", where=path) from error
    if len(data) > largest:
        what = f"is larger than {largest:,} bytes, too large for {kind}"
        raise InputError(what, where=path)
    return data


def read_json(path: str | Path, fix: str | None = None) -> Any:
    """The content of a JSON file. `InputError` when it cannot be read, is too large or
    too deep, or is not JSON, with what to do then."""
    data = read_bytes(path, MAX_JSON, "JSON")
    if data.count(b"[") + data.count(b"{") > MAX_LISTS:
        raise InputError(f"holds more than {MAX_LISTS:,} lists", where=path)
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON ({str(error)[:80]})", path, fix) from error


def read_xml(path: str | Path) -> bytes:
    """The bytes of an XML file. `InputError` when it cannot be read, is larger than
    `MAX_XML`, or is not UTF-8."""
    data = read_bytes(path, MAX_XML, "XML")
    try:
        data.decode()
    except UnicodeDecodeError as error:
        raise InputError("is not UTF-8", where=path, fix="convert it first") from error
    return data


def parse_xml(
    data: bytes,
    path: str | Path,
    start: Callable[[str, dict[str, str], int, list[str]], None],
    end: Callable[[str, int, list[str]], None] | None = None,
) -> None:
    """Call ``start(tag, attributes, offset, inside)`` and ``end(tag, offset, inside)``
    at each tag of the XML in `data`, in order; ``inside`` are the tags of the elements
    around it, from the root.

    Offsets are those of the tags in `data` [bytes]; names keep their prefix. A document
    type declaration is refused, so no entity is ever expanded or fetched. `InputError`
    for one, when elements are nested deeper than `MAX_DEPTH`, and when it is not
    well-formed.
    """
    from xml.parsers import expat

    parser = expat.ParserCreate("utf-8")
    inside: list[str] = []
    count = 0

    def start_element(tag: str, attributes: dict[str, str]):
        nonlocal count
        count += len(inside)
        if len(inside) >= MAX_DEPTH or count > MAX_INSIDE:
            what = (
                f"has elements nested deeper than {MAX_DEPTH:,}, or too many deep ones"
            )
            raise InputError(what, where=path)
        start(tag, attributes, parser.CurrentByteIndex, inside)
        inside.append(tag)

    def end_element(tag: str):
        inside.pop()
        if end is not None:
            end(tag, parser.CurrentByteIndex, inside)

    def refuse_doctype(*_):
        what = "has a document type declaration, which is refused"
        raise InputError(what, where=path, fix="remove the DOCTYPE")

    parser.StartElementHandler, parser.EndElementHandler = start_element, end_element
    parser.StartDoctypeDeclHandler = refuse_doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputError(f"is not well-formed XML ({error})", where=path) from error


def is_xacro(path: str | Path, kind: str = "URDF") -> InputError:
    """The error of a robot description of a `kind` whose macros are not expanded."""
    fix = f"expand it first: xacro robot.xacro > robot.{kind.lower()}"
    return InputError(f"is xacro, not {kind}", where=path, fix=fix)


def check_no_xacro(tag: str, path: str | Path, kind: str = "URDF") -> None:
    """`InputError` for an element of xacro."""
    if tag.startswith("xacro:"):
        raise is_xacro(path, kind)


def tag_end(data: bytes, start: int) -> int:
    """Offset [bytes] of the end of the tag that `parse_xml` found at `start`."""
    tag = TAG.match(data, start)
    assert tag is not None  # expat found a tag here
    return tag.end()


def check_replaceable(path: str | Path, *inputs: str | Path | None) -> None:
    """`InputError` for an output that must not be written.

    It is one that exists and is no regular file, such as a folder, a pipe or a device,
    and one that is the same file as one of the `inputs`, by whatever name or link.
    """
    try:
        there = os.stat(path)
    except (OSError, ValueError):
        return  # writing to the path raises the error, if there is one
    if not stat.S_ISREG(there.st_mode):
        raise InputError(
            "cannot be written, as it is no regular file", path, "choose another name"
        )
    if any(_is_same(there, name) for name in inputs if name):
        raise InputError(
            "is an input and would be overwritten", path, "choose another name"
        )


def _is_same(one: os.stat_result, path: str | Path) -> bool:
    try:
        return os.path.samestat(one, os.stat(path))
    except (OSError, ValueError):  # an argument that names no file
        return False


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write `content` to a temporary neighbour of `path`, then rename it: a reader
    never sees half a file. Characters of a text that UTF-8 does not have are question
    marks.

    Raises `InputError` when the folder does not exist or cannot be written, and when
    something is there that is no regular file.
    """
    with replacing(path) as stream:
        text = isinstance(content, str)
        stream.write(content.encode(errors="replace") if text else content)


@contextmanager
def replacing(path: str | Path) -> Generator[BinaryIO, None, None]:
    """Context of a file that is written piece by piece and replaces `path` at the end,
    with the permissions of a file there, or leaves nothing if that is not reached.
    Raises `InputError` as `write_atomically`.
    """
    import tempfile

    check_replaceable(path)
    target = Path(os.path.realpath(path))  # a link stays a link
    try:
        handle, temporary = tempfile.mkstemp(
            prefix=f".{target.name}.", dir=target.parent
        )
        try:
            with os.fdopen(handle, "wb") as stream:
                yield stream
            os.umask(umask := os.umask(0))
            mode = target.stat().st_mode if target.exists() else 0o666 & ~umask
            os.chmod(temporary, stat.S_IMODE(mode))
            os.replace(temporary, target)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror or error})", where=path
        ) from error


def lock(handle: int) -> bool:
    """Lock an open file if no other has locked it; returns whether it is locked. The
    system unlocks it where it is closed."""
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def load_toml(
    path: str | Path, what: str = "column map", largest: int = MAX_MAP
) -> dict[str, Any]:
    """The content of a TOML file, which is to be a column map, say. `InputError` when
    it cannot be read, is larger than `largest` [bytes], has lines of too many dots, or
    is not TOML, in UTF-8 or UTF-16."""
    import tomllib

    data = read_bytes(path, largest, f"a {what}")
    try:  # UTF-16 by PowerShell's ``>``
        text = data.decode(json.detect_encoding(data))
        if any(line.count(".") > MAX_DOTS for line in text.split("\n")):
            raise InputError(f"has a line of more than {MAX_DOTS:,} dots", where=path)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        fix = 'write lines such as wrench = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"] }'
        raise InputError(f"is not TOML ({str(error)[:120]})", path, fix) from error
