"""Mutations of bytes and of texts, whatever the file holds."""

import re
import struct
from collections.abc import Callable, Sequence

import numpy as np

Mutation = Callable[[bytes, np.random.Generator], bytes]
"""Takes the content of a file, gives another."""

ODD_TEXTS = (
    *("nan", "inf", "-inf", "-0", "0", "1", "-1", "1e300", "-1e300", "1e308", "-1e308"),
    *("1.7976931348623157e308", "1e-300", "5e-324", "1e154", "1e100", "-1e50", "1e19"),
    *("9223372036854775808", "-9223372036854775809", "4294967296", "2147483648", "1e9"),
    *("1e15", "1e5", "1e999", "0x1p3", "1_000", "1e", "", "--1", "1,5", "true", "null"),
    *("٣", "1e-30", "1" * 400, "0." + "0" * 400 + "1"),
)
"""Numbers, and what is taken for numbers, that programs stumble over."""

ODD_DOUBLES = (
    *(float("nan"), float("inf"), -float("inf"), 0.0, -0.0, 1.0, -1.0, 1e300, -1e300),
    *(1.7976931348623157e308, 5e-324, 1e-300, 1e154, 1e100, 1e19, 1e9, 1e5, 2.0**63),
)
"""Doubles that programs stumble over."""

ODD_INTEGERS = (
    *(0, 1, 2, 3, 7, 8, 127, 128, 255, 256, 32767, 65535, 65536, 2**31 - 1, 2**31),
    *(2**32 - 1, 2**32, 2**53, 2**62, 2**63 - 1, 2**63, 2**64 - 1),
)
"""Lengths and counts that programs stumble over."""

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
"""A number in a text."""


def choice(rng: np.random.Generator, items: Sequence):
    """One of the items, as it is."""
    return items[int(rng.integers(len(items)))]


def flip_bits(data: bytes, rng: np.random.Generator) -> bytes:
    """One to eight bits turned over."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 9)) if out else 0):
        out[_place(out, rng)] ^= 1 << int(rng.integers(8))
    return bytes(out)


def odd_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """A few bytes replaced by others."""
    at, count = _place(data, rng), int(rng.integers(1, 17))
    filler = choice(
        rng, (b"\0" * count, b"\xff" * count, rng.bytes(count), b"\x80", b'"', b"\n\r")
    )
    return data[:at] + filler + data[at + len(filler) :]


def truncate(data: bytes, rng: np.random.Generator) -> bytes:
    """Only the begin of the file."""
    return data[: int(rng.integers(len(data) + 1))]


def cut_out(data: bytes, rng: np.random.Generator) -> bytes:
    """The file without some part of it."""
    begin = _place(data, rng)
    return data[:begin] + data[begin + 1 + int(rng.geometric(0.01)) :]


def repeat(data: bytes, rng: np.random.Generator) -> bytes:
    """Some part of the file again, there or elsewhere."""
    begin, at = _place(data, rng), _place(data, rng)
    part = data[begin : begin + 1 + int(rng.geometric(0.01))]
    return data[:at] + part * int(rng.integers(1, 5)) + data[at:]


def odd_integer(data: bytes, rng: np.random.Generator) -> bytes:
    """A length or count replaced by another one."""
    width = choice(rng, (1, 2, 4, 8))
    number = choice(rng, ODD_INTEGERS) % (1 << 8 * width)
    order = choice(rng, ("little", "big"))
    return _overwrite(data, number.to_bytes(width, order), rng)


def odd_double(data: bytes, rng: np.random.Generator) -> bytes:
    """Eight or four bytes replaced by another number with a decimal point."""
    number = choice(rng, ODD_DOUBLES)
    if rng.random() < 0.7:
        return _overwrite(data, struct.pack("<d", number), rng)
    single = np.float32(np.clip(number, -3e38, 3e38)).tobytes()
    return _overwrite(data, single, rng)


def odd_number(data: bytes, rng: np.random.Generator) -> bytes:
    """A number of a text replaced by an odd one."""
    found = list(NUMBER.finditer(data))
    if not found:
        return flip_bits(data, rng)
    one = choice(rng, found)
    return data[: one.start()] + odd_text(rng) + data[one.end() :]


def scaled_numbers(data: bytes, rng: np.random.Generator) -> bytes:
    """All numbers of a text, or about so many of them, with another power of ten."""
    power, share = int(rng.integers(-330, 331)), choice(rng, (1.0, 0.5, 0.1))
    exponent = f"e{power}".encode()

    def scale(number: re.Match[bytes]) -> bytes:
        kept = rng.random() > share or b"e" in number[0].lower()
        return number[0] if kept else number[0] + exponent

    return NUMBER.sub(scale, data)


def odd_text(rng: np.random.Generator) -> bytes:
    """One of `ODD_TEXTS`."""
    return choice(rng, ODD_TEXTS).encode()


def swap_lines(data: bytes, rng: np.random.Generator) -> bytes:
    """A text with lines left out, repeated, or in another order."""
    lines = data.split(b"\n")
    kind, at, to = choice(rng, "drsp"), *rng.integers(len(lines), size=2).tolist()
    if kind == "d":
        del lines[min(at, to) : max(at, to) + 1]
    elif kind == "r":
        lines.insert(to, lines[at])
    elif kind == "s":
        lines[at], lines[to] = lines[to], lines[at]
    else:
        lines = [lines[i] for i in rng.permutation(len(lines))]
    return b"\n".join(lines)


def _place(data: bytes | bytearray, rng: np.random.Generator) -> int:
    """A place in the file, half of the time in its begin or end, where headers are."""
    where, size = rng.random(), max(len(data), 1)
    near = int(rng.integers(min(size, 200)))
    if where < 0.35:
        return near
    return size - 1 - near if where < 0.5 else int(rng.integers(size))


def _overwrite(data: bytes, part: bytes, rng: np.random.Generator) -> bytes:
    at = _place(data, rng)
    return data[:at] + part + data[at + len(part) :]


BYTES: tuple[Mutation, ...] = (
    flip_bits,
    odd_bytes,
    truncate,
    cut_out,
    repeat,
    odd_integer,
    odd_double,
)
"""Mutations of any file."""

TEXT: tuple[Mutation, ...] = (
    odd_number,
    odd_number,
    odd_number,
    scaled_numbers,
    swap_lines,
    flip_bits,
    odd_bytes,
    truncate,
    cut_out,
    repeat,
)
"""Mutations of a text with numbers."""
