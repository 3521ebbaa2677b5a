"""Mutations of tables: of separated text, and of Parquet files."""

import io

import numpy as np

from benchmarks.fuzzing.bytes_mutations import (
    ODD_DOUBLES,
    TEXT,
    Mutation,
    choice,
    odd_text,
)

NAMES = ("time", "px", "qw", "fx", "q1", "q999", "vx", "", "Time", "timestamp", "ts")
"""Names that columns get, besides those of other columns."""


def text_columns(data: bytes, rng: np.random.Generator) -> bytes:
    """Separated text with its columns changed: left out, repeated, renamed, in another
    order, or with other numbers."""
    rows = [line.split(b",") for line in data.split(b"\n")]
    width = len(rows[0])
    at, to = rng.integers(width, size=2).tolist()
    kind = choice(rng, ("drop", "repeat", "rename", "swap", "fill", "scale", "blank"))
    power, filler = f"e{int(rng.integers(-20, 310))}".encode(), odd_text(rng)
    begin = int(rng.integers(len(rows))) if rng.random() < 0.5 else 0
    if kind == "rename":
        rows[0][at] = choice(rng, (rows[0][to], *(name.encode() for name in NAMES)))
    for number, row in enumerate(rows):
        if len(row) != width or kind == "rename":
            continue
        header = number == 0
        if kind == "drop":
            del row[at]
        elif kind == "repeat":
            row.insert(to, row[at])
        elif kind == "swap":
            row[at], row[to] = row[to], row[at]
        elif number >= begin and not header:
            row[at] = {"fill": filler, "scale": row[at] + power}.get(kind, b"")
    return b"\n".join(b",".join(row) for row in rows)


def text_values(data: bytes, rng: np.random.Generator) -> bytes:
    """Separated text with other numbers in one to four columns that are still such as
    a log may hold: constant, zero, larger or smaller, of the other sign, repeated."""
    rows = [line.split(b",") for line in data.split(b"\n")]
    width = len(rows[0])
    for at in rng.integers(width, size=int(rng.integers(1, 5))).tolist():
        kind = choice(rng, ("constant", "zero", "power", "sign", "step", "large"))
        power = f"e{int(rng.integers(-20, 9))}".encode()
        large = f"{rng.choice((1e-30, 1e-9, 1e3, 1e5, 1e8)):g}".encode()
        first = next((row[at] for row in rows[1:] if len(row) == width), b"0")
        for number, row in enumerate(rows[1:]):
            if len(row) == width:
                row[at] = {
                    "constant": first,
                    "zero": b"0",
                    "power": row[at] + power,
                    "sign": row[at].lstrip(b"-")
                    if row[at][:1] == b"-"
                    else b"-" + row[at],
                    "step": large if number % 7 == 3 else row[at],
                    "large": large,
                }[kind]
    return b"\n".join(b",".join(row) for row in rows)


def text_cells(data: bytes, rng: np.random.Generator) -> bytes:
    """One to twenty cells of separated text replaced by odd numbers."""
    rows = [line.split(b",") for line in data.split(b"\n")]
    for _ in range(int(rng.integers(1, 21))):
        row = choice(rng, rows)
        row[int(rng.integers(len(row)))] = odd_text(rng)
    return b"\n".join(b",".join(row) for row in rows)


def separators(data: bytes, rng: np.random.Generator) -> bytes:
    """Separated text with other separators, line ends, encoding or mark at its
    begin."""
    kind = int(rng.integers(7))
    if kind < 3:
        return data.replace(b",", (b";", b"\t", b" ")[kind])
    if kind == 3:
        return data.replace(b"\n", choice(rng, (b"\r\n", b"\r", b"\n\n", b"\n \n")))
    if kind == 4:
        return b"\xef\xbb\xbf" + data
    if kind == 5:
        return data.decode(errors="replace").encode("utf-16")
    return b"\n" * int(rng.integers(1, 50)) + data


def parquet_table(data: bytes, rng: np.random.Generator) -> bytes:
    """A Parquet file with its columns changed: numbers, nulls, kinds, names, order."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.read_table(io.BytesIO(data))
        names, columns = table.column_names, list(table.columns)
        for _ in range(int(rng.integers(1, 4))):
            _change_column(names, columns, rng)
        out = io.BytesIO()
        compression = choice(rng, ("none", "snappy", "zstd"))
        parquet.write_table(
            pa.table(columns, names=names), out, compression=compression
        )
        return out.getvalue()
    except (pa.ArrowException, OSError, ValueError, IndexError, TypeError):
        return data  # mutated before: no table any more


def arrow_table(data: bytes, rng: np.random.Generator) -> bytes:
    """The same of a file or a stream of Arrow."""
    import pyarrow as pa
    from pyarrow import ipc

    try:
        source = pa.BufferReader(data)
        is_file = data[:6] == b"ARROW1"
        table = (ipc.open_file if is_file else ipc.open_stream)(source).read_all()
        table.validate(full=True)
        names, columns = table.column_names, list(table.columns)
        for _ in range(int(rng.integers(1, 4))):
            _change_column(names, columns, rng)
        out = io.BytesIO()
        options = ipc.IpcWriteOptions(compression=choice(rng, (None, "lz4", "zstd")))
        new = ipc.new_file if is_file else ipc.new_stream
        changed = pa.table(columns, names=names)
        with new(out, changed.schema, options=options) as writer:
            writer.write_table(changed)
        return out.getvalue()
    except (pa.ArrowException, OSError, ValueError, IndexError, TypeError):
        return data  # mutated before: no table any more


def _change_column(names: list, columns: list, rng: np.random.Generator) -> None:
    """Change one column in place."""
    import pyarrow as pa

    at, to = rng.integers(len(names), size=2).tolist()
    kind = choice(
        rng, ("odd", "odd", "odd", "fill", "scale", "null", "kind", "name", "swap")
    )
    if kind == "name":
        names[at] = choice(rng, (names[to], *NAMES))
        return
    if kind == "swap":
        columns[at], columns[to] = columns[to], columns[at]
        return
    values = np.array(columns[at].to_pylist(), dtype=float)
    if kind == "kind":
        wanted = choice(
            rng, (pa.string(), pa.float32(), pa.float16(), pa.int64(), pa.list_(pa.int8()))
        )  # fmt: skip
        finite = np.nan_to_num(values, posinf=0.0, neginf=0.0).clip(-6e4, 6e4)
        made = [[1]] * len(finite) if pa.types.is_list(wanted) else finite
        text = [str(value) for value in finite] if wanted == pa.string() else made
        numbers = finite.astype(int) if wanted == pa.int64() else text
        columns[at] = pa.array(numbers, wanted)
        return
    chosen = rng.random(len(values)) < choice(rng, (0.02, 0.3, 1.0))
    if kind == "null":
        columns[at] = pa.array(values, mask=chosen)
        return
    with np.errstate(over="ignore"):
        values[chosen] = {
            "odd": rng.choice(ODD_DOUBLES, int(chosen.sum())),
            "fill": choice(rng, ODD_DOUBLES),
            "scale": values[chosen] * 10.0 ** rng.uniform(-300, 300),
        }[kind]
    columns[at] = pa.array(values)


TABLE: tuple[Mutation, ...] = (
    *(text_values,) * 8,
    text_columns,
    text_cells,
    text_cells,
    separators,
    *TEXT,
)
"""Mutations of separated text."""
