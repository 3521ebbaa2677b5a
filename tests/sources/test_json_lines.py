"""Lines of JSON: any pieces give the same samples; bad lines are counted, never
believed."""

import json
from collections import Counter

import numpy as np
import pytest

from hefting.sources import MAX_MESSAGE, TOO_LARGE
from hefting.sources.tcp import NO_JSON, NO_STREAM, NO_TIME, JsonLines

RNG = np.random.default_rng(19)
FORCE = RNG.normal(size=(40, 6))
TEXT = b"".join(
    json.dumps(
        {"time": k / 500, "wrench": list(row)}
        | ({"orientation": [0, 0, 0, 1]} if k % 5 == 0 else {})
    ).encode()
    + b"\n"
    for k, row in enumerate(FORCE)
)


def fed(pieces) -> tuple[dict, Counter]:
    """All samples by stream, and what was skipped."""
    skipped: Counter[str] = Counter()
    lines = JsonLines(skipped)
    found: dict[str, list] = {}
    for piece in pieces:
        for samples in lines.feed(piece):
            parts = found.setdefault(samples.stream, [])
            parts.append(np.column_stack([samples.time, samples.values]))
    return {name: np.concatenate(parts) for name, parts in found.items()}, skipped


@pytest.mark.parametrize("seed", range(4))
def test_pieces_of_any_size_give_the_samples(seed):
    cuts = np.sort(np.random.default_rng(seed).integers(0, len(TEXT), 60))
    pieces = [TEXT[a:b] for a, b in zip([0, *cuts], [*cuts, len(TEXT)], strict=True)]
    found, skipped = fed(pieces)
    # JSON writes a number so that it is read back to the last bit
    assert np.array_equal(found["wrench"][:, 1:], FORCE)
    assert np.array_equal(found["wrench"][:, 0], np.arange(40) / 500)
    assert len(found["orientation"]) == 8
    assert not skipped


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"no json", NO_JSON),
        (b"[1, 2]", NO_JSON),
        (b'{"time": 1, "wrench": [1, 2', NO_JSON),
        (b"[" * 100_000, NO_JSON),
        (b"\xff\xfe", NO_JSON),
        (b'{"wrench": [1, 2, 3, 4, 5, 6]}', NO_TIME),
        (b'{"time": "1", "wrench": [1, 2, 3, 4, 5, 6]}', NO_TIME),
        (b'{"time": true, "wrench": [1, 2, 3, 4, 5, 6]}', NO_TIME),
        (b'{"time": NaN, "wrench": [1, 2, 3, 4, 5, 6]}', NO_TIME),
        (b'{"time": 1}', NO_STREAM),
        (b'{"time": 1, "torque": [1]}', NO_STREAM),  # a wrench came before
        (b'{"time": 1, "wrench": "123456"}', NO_STREAM),
        (b'{"time": 1, "wrench": ["1", 2, 3, 4, 5, 6]}', NO_STREAM),
        (b'{"time": 1, "wrench": [[1, 2, 3, 4, 5, 6]]}', NO_STREAM),
        (b'{"time": 1, "wrench": [1e999, 2, 3, 4, 5, 6]}', NO_STREAM),
        (b'{"time": 1, "joint_positions": [' + b"0, " * 2000 + b"0]}", NO_STREAM),
        (b" " * (MAX_MESSAGE + 1) + b"{}", TOO_LARGE),
    ],
)
def test_bad_lines_are_counted_and_the_others_kept(line, reason):
    half = TEXT.index(b"\n", len(TEXT) // 2) + 1
    found, skipped = fed([TEXT[:half], line, b"\n", TEXT[half:]])
    assert skipped == {reason: 1}
    assert np.array_equal(found["wrench"][:, 1:], FORCE)


def test_a_key_that_is_no_stream_is_named_until_there_is_a_wrench():
    """The first of them; what else a robot sends is left alone later."""
    one, two = (
        b'{"time": 0, "%s": 1, "position": [0, 0, 0]}\n' % k for k in (b"ft", b"f")
    )
    _, skipped = fed([one, two, TEXT, one])
    assert skipped == {"'ft' is no stream": 2}


def test_a_line_without_end_takes_no_memory():
    """A hundred pieces of a megabyte: one skipped message, and the next line is read."""
    skipped: Counter[str] = Counter()
    lines = JsonLines(skipped)
    for _ in range(100):
        assert lines.feed(b"x" * MAX_MESSAGE) == []
        assert len(lines._rest) <= MAX_MESSAGE
    found = lines.feed(b'\n{"time": 1, "wrench": [1, 2, 3, 4, 5, 6]}\n')
    assert skipped == {TOO_LARGE: 1}
    assert [samples.stream for samples in found] == ["wrench"]


def test_a_last_line_without_end_is_read():
    lines = JsonLines(Counter())
    assert lines.feed(b'{"time": 1, "wrench": [1, 2, 3, 4, 5, 6]}') == []
    (samples,) = lines.end()
    assert samples.values.tolist() == [[1, 2, 3, 4, 5, 6]]
    assert lines.end() == []
