"""Mutations that keep the structure of a file: JSON, TOML, XML, arrays, glTF."""

import io
import json
import re
import struct
import zipfile
import zlib
from typing import Any

import numpy as np

from benchmarks.fuzzing.bytes_mutations import (
    ODD_DOUBLES,
    ODD_INTEGERS,
    Mutation,
    choice,
    odd_text,
)

DEEP = 2000
"""Depth of nested lists and elements."""


def json_value(data: bytes, rng: np.random.Generator) -> bytes:
    """JSON with one value, key or item changed, left out or added."""
    try:
        content = json.loads(data)
    except (ValueError, RecursionError):
        return data
    if not isinstance(content, dict | list) or not content:
        return json.dumps(_odd_value(rng)).encode()
    _change_json(content, rng)
    return json.dumps(content).encode()


def _change_json(content: Any, rng: np.random.Generator) -> None:
    """Change something somewhere in a list or an object that is not empty."""
    keys = list(content) if isinstance(content, dict) else list(range(len(content)))
    key = choice(rng, keys)
    inner = content[key]
    if isinstance(inner, dict | list) and inner and rng.random() < 0.75:
        _change_json(inner, rng)
        return
    kind = choice(rng, ("odd", "odd", "odd", "drop", "swap", "more", "scale"))
    if kind == "drop":
        del content[key]
    elif kind == "swap":
        other = choice(rng, keys)
        content[key], content[other] = content[other], content[key]
    elif kind == "more" and isinstance(content, list):
        content.extend(content[: int(rng.integers(1, 20))])
    elif kind == "scale" and isinstance(inner, int | float):
        power = float(rng.uniform(-300, 300))
        content[key] = float(np.clip(inner, -1e8, 1e8)) * 10.0**power
    else:
        content[key] = _odd_value(rng)


def _odd_value(rng: np.random.Generator) -> Any:
    numbers = (*ODD_DOUBLES, *ODD_INTEGERS, 10**400, -1, True, False, None)
    others = (
        "",
        "text",
        "nan",
        "\x1b[31m",
        "x" * 3000,
        [],
        {},
        [[]],
        [1, [2]],
        {"": 0},
    )
    return choice(rng, numbers) if rng.random() < 0.7 else choice(rng, others)


def json_nesting(data: bytes, rng: np.random.Generator) -> bytes:
    """JSON that is deep or wide: a value replaced by lists in lists."""
    found = list(re.finditer(rb"[-+.\deE]+|null|true", data))
    bomb = choice(
        rng, (b"[" * DEEP + b"]" * DEEP, b"[" * DEEP, b"[" + b"[]," * DEEP + b"[]]")
    )
    if not found:
        return bomb
    one = choice(rng, found)
    return data[: one.start()] + bomb + data[one.end() :]


def json_line(data: bytes, rng: np.random.Generator) -> bytes:
    """A file of JSON lines, of which one is mutated as JSON."""
    lines = data.split(b"\n")
    at = int(rng.integers(len(lines)))
    lines[at] = choice(rng, JSON)(lines[at], rng)
    return b"\n".join(lines)


def toml_line(data: bytes, rng: np.random.Generator) -> bytes:
    """TOML with a value, a key or a word changed, or with a line more."""
    lines = data.decode(errors="replace").split("\n")
    at = int(rng.integers(len(lines)))
    words = list(re.finditer(r'"[^"]*"|[\w.+-]+', lines[at]))
    kind = choice(rng, ("word", "word", "word", "line", "dotted", "nested"))
    if kind == "word" and words:
        one = choice(rng, words)
        others = re.findall(r"[\w.]+", "\n".join(lines)) or ["x"]
        new = choice(
            rng,
            (
                *(
                    odd_text(rng).decode(),
                    choice(rng, others),
                    "[]",
                    "{}",
                    '""',
                    "true",
                ),
                *("1979-05-27", '"q{0..999}"', '"x{1..5}y"', '"\\u0000"', "10" * 300),
            ),
        )
        lines[at] = lines[at][: one.start()] + new + lines[at][one.end() :]
    elif kind == "line":
        lines.insert(at, choice(rng, ("[time]", "[[wrench]]", "skip = -1", "= 1", "#")))
    elif kind == "dotted":
        key = ".".join("a" * int(rng.integers(1, 20 * DEEP)))
        lines.insert(
            at, choice(rng, (f"{key} = 1", f"[{key}]", f"x = {{ {key} = 1 }}"))
        )
    else:
        lines.insert(at, "x = " + "[" * DEEP + "]" * int(rng.integers(DEEP + 1)))
    return "\n".join(lines).encode(errors="replace")


def xml_element(data: bytes, rng: np.random.Generator) -> bytes:
    """XML with an element or an attribute changed, left out, repeated or nested."""
    tags = list(re.finditer(rb"<[^<>]*>", data))
    values = list(re.finditer(rb'(\w+)="([^"]*)"', data))
    if not tags or not values:
        return data
    kind = choice(rng, ("value", "value", "number", "drop", "again", "deep", "type"))
    one, tag = choice(rng, values), choice(rng, tags)
    if kind in ("value", "number"):
        other = choice(rng, values)[2] if kind == "value" else odd_text(rng)
        return data[: one.start(2)] + other + data[one.end(2) :]
    if kind == "drop":
        return data[: one.start()] + data[one.end() :]
    if kind == "again":
        part = data[tag.start() : choice(rng, tags).end()]
        return data[: tag.end()] + part + data[tag.end() :]
    if kind == "deep":
        deep = int(rng.integers(1, 10 * DEEP))
        return data[: tag.end()] + b"<a>" * deep + data[tag.end() :]
    return b'<!DOCTYPE r [<!ENTITY a "aaaa">]>' + data


def npy_header(data: bytes, rng: np.random.Generator) -> bytes:
    """An array file with another header: shape, type, order or version."""
    if len(data) < 10:
        return data
    length = struct.unpack_from("<H", data, 8)[0]
    size = int(rng.choice(ODD_INTEGERS))
    shape = choice(
        rng, (f"({size}, 3)", f"({size},)", "()", "(3, 0)", "(-1, 3)", "(2, 3, 4)", "None")
    )  # fmt: skip
    kind = choice(
        rng, ("<f8", "<i8", "|i1", "|O", "<U9", "<f2", ">c16", "|V9", "<M8[s]")
    )
    fortran = choice(rng, ("True", "False", "1", "(("))
    header = f"{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}"
    if rng.random() < 0.3:
        header = choice(rng, ("{" * 50, "[" * 5000, "'a'*10**9", "\0", header * 3))
    text = header.encode().ljust(length) if rng.random() < 0.7 else header.encode()
    head = data[:6] + bytes([int(rng.choice((1, 1, 1, 2, 3, 9))), 0])
    return head + struct.pack("<H", len(text) % 65536) + text + data[10 + length :]


def npz_member(data: bytes, rng: np.random.Generator) -> bytes:
    """An archive of arrays, one of which has other numbers, another header, another
    name, or is missing."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except (
        zipfile.BadZipFile,
        zlib.error,
        OSError,
        ValueError,
        RuntimeError,
        EOFError,
    ):
        return data
    if not members:
        return data
    name = choice(rng, tuple(members))
    content = members.pop(name)
    kind = rng.random()
    if kind < 0.5 and len(content) > 200:
        changed = np.frombuffer(content[:-8], np.uint8).copy()
        for place in 128 + 8 * rng.integers(
            (len(content) - 136) // 8, size=rng.integers(1, 9)
        ):
            odd = np.float64(choice(rng, ODD_DOUBLES))
            changed[place : place + 8] = np.frombuffer(odd.tobytes(), np.uint8)
        members[name] = changed.tobytes() + content[-8:]
    elif kind < 0.7:
        members[name] = npy_header(content, rng)
    elif kind < 0.9:
        members[choice(rng, ("time.npy", "pose.npy", "\x1b[31m.npy", "a"))] = content
    stream = io.BytesIO()
    packing = int(rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)))
    with zipfile.ZipFile(stream, "w", packing) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def glb_scene(data: bytes, rng: np.random.Generator) -> bytes:
    """A binary glTF file with another description of its scene."""
    if len(data) < 20:
        return data
    length = struct.unpack_from("<I", data, 12)[0]
    changed = json_value(data[20 : 20 + length], rng)
    changed += b" " * (-len(changed) % 4)
    rest = data[20 + length :]
    size = 20 + len(changed) + len(rest)
    head = data[:8] + struct.pack("<II", size % 2**32, len(changed))
    return head + data[16:20] + changed + rest


JSON: tuple[Mutation, ...] = (json_value,) * 6 + (json_nesting,)
"""Mutations of JSON that leave it JSON."""

TOML: tuple[Mutation, ...] = (toml_line,)
"""Mutations of TOML."""

XML: tuple[Mutation, ...] = (xml_element,)
"""Mutations of XML."""
