"""MATLAB's files are read as the same arrays in memory; only numbers are, within bounds."""

import struct
import zlib

import numpy as np
import pytest
from scipy.io import savemat
from test_npz import arrays, same

from hefting.core.errors import InputError
from hefting.logs import matlab_file, read_log
from hefting.logs.given import as_recording

__all__ = ["arrays"]
"""The fixture of another test."""


@pytest.fixture
def held(arrays):
    """The arrays by the names of `as_recording`."""
    return dict(zip(("time", "pose", "wrench"), arrays, strict=True))


def element(kind: int, data: bytes, order: str = "<") -> bytes:
    """An element of a file, padded."""
    return struct.pack(f"{order}II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(flags: int, *parts: bytes, name: bytes = b"", shape=(1, 1), order="<"):
    """An array with these parts after its name."""
    head = element(6, struct.pack(f"{order}II", flags, 0), order)
    head += element(5, struct.pack(f"{order}{len(shape)}i", *shape), order)
    return element(14, head + element(1, name, order) + b"".join(parts), order)


def written(folder, *elements: bytes, order: str = "<"):
    """A file of these elements."""
    mark = {"<": b"\x00\x01IM", ">": b"\x01\x00MI"}[order]
    path = folder / "log.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + mark + b"".join(elements))
    return path


@pytest.mark.parametrize("packed", [False, True])
def test_arrays_by_the_names_of_streams(held, tmp_path, packed):
    """Columns N x 1, rows 6 x N, pages 4 x 4 x N; text and pictures beside them."""
    own = {"time": held["time"][:, None], "wrench": held["wrench"].T}
    own |= {"pose": np.moveaxis(held["pose"], 0, -1), "operator": "Ada"}
    savemat(tmp_path / "log.mat", own, do_compression=packed)
    found = read_log(tmp_path / "log.mat")
    assert found.source == str(tmp_path / "log.mat")
    assert found.warnings == ()
    assert same(found, as_recording(**held))


def test_arrays_in_memory_may_be_turned_too(held):
    turned = held | {
        "pose": np.moveaxis(held["pose"], 0, -1),
        "wrench": held["wrench"].T,
    }
    assert same(as_recording(turned), as_recording(**held))


def test_structures_arrays_of_them_and_cells(held, tmp_path):
    expected = as_recording(**held)
    nested = {"log": {"t": held["time"], "robot": {"tcp_pose": held["pose"]}}}
    savemat(tmp_path / "log.mat", nested | {"ft": held["wrench"]})
    assert same(read_log(tmp_path / "log.mat"), expected)
    count = len(held["time"])
    kinds = [("t", float), ("T", float, (4, 4)), ("ft", float, 6), ("mode", object)]
    samples = np.empty(count, dtype=kinds)
    samples["t"], samples["T"] = held["time"], held["pose"]
    samples["ft"], samples["mode"] = held["wrench"], "guided"
    savemat(tmp_path / "log.mat", {"samples": samples})
    assert same(read_log(tmp_path / "log.mat"), expected)
    cells = np.empty(count, dtype=object)
    cells[:] = list(held["pose"])
    own = {"t": held["time"], "tcp_pose": cells, "ft": held["wrench"]}
    savemat(tmp_path / "log.mat", own)
    assert same(read_log(tmp_path / "log.mat"), expected)


def test_cells_of_structures_as_messages_of_the_ros_toolbox(held, tmp_path):
    pose = as_recording(**held)
    cells = np.empty((len(held["time"]), 1), dtype=object)
    for k, time in enumerate(held["time"]):
        stamp = {"Sec": int(time), "Nsec": round(1e9 * (time % 1))}
        halves = {"Force": held["wrench"][k, :3], "Torque": held["wrench"][k, 3:]}
        own = {"Position": pose["position"].values[k]}
        own |= {"Orientation": pose["orientation"].values[k]}
        cells[k, 0] = {"Header": {"Stamp": stamp}} | {
            part: {
                name: dict(zip("XYZW", values.tolist(), strict=False))
                for name, values in fields.items()
            }
            for part, fields in (("Wrench", halves), ("Pose", own))
        }
    savemat(tmp_path / "log.mat", {"messages": cells})
    found = read_log(tmp_path / "log.mat")
    for name, stream in pose.streams.items():
        np.testing.assert_allclose(found[name].values, stream.values, atol=1e-12)
        np.testing.assert_allclose(found[name].time, stream.time, atol=1e-9)


def test_the_other_order_of_bytes(held, tmp_path):
    elements = [
        matrix(
            6,
            element(9, np.asarray(values, ">f8").tobytes(order="F"), ">"),
            name=name.encode(),
            shape=values.shape,
            order=">",
        )
        for name, values in (held | {"time": held["time"][:, None]}).items()
    ]
    assert same(read_log(written(tmp_path, *elements, order=">")), as_recording(**held))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n", "is of MATLAB 7.3"),
        (b"\x89HDF\r\n\x1a\n" + b"\0" * 200, "is of MATLAB 7.3"),
        (b"\0\0\0\0\1\0\0\0" + b"\0" * 200, "is not of MATLAB 5 to 7"),
        (b"MATLAB 5.0 MAT-file".ljust(126) + b"IM" + b"\1", "cannot be read as .mat"),
        (b"MATLAB 5.0 MAT-file".ljust(126) + b"IM", "holds no arrays of numbers"),
    ],
)
def test_other_versions_and_damaged_files(tmp_path, content, said):
    (tmp_path / "log.mat").write_bytes(content)
    with pytest.raises(InputError, match=said) as refused:
        read_log(tmp_path / "log.mat")
    assert "'-v7')" in str(refused.value)


@pytest.mark.parametrize(("kind", "is_read"), [("timetable", False), ("figure", True)])
def test_objects_that_may_hold_the_recording_are_not_passed_over(
    held, tmp_path, kind, is_read
):
    """Without its time, each row would be a static pose."""
    savemat(tmp_path / "log.mat", held)
    texts = (element(1, text) for text in (b"T", b"MCOS", kind.encode()))
    one = element(14, element(6, struct.pack("<II", 17, 0)) + b"".join(texts))
    path = written(tmp_path, (tmp_path / "log.mat").read_bytes()[128:], one)
    if is_read:
        assert same(read_log(path), as_recording(**held))
        return
    with pytest.raises(
        InputError, match="T is a timetable, whose form is MATLAB's own"
    ):
        read_log(path)


@pytest.mark.parametrize("name", ["time", "t"])
@pytest.mark.parametrize("kind", ["lines", "cells", "complex"])
def test_a_time_that_is_no_number_is_not_passed_over(held, tmp_path, name, kind):
    time = held.pop("time")
    texts = [f"12:00:{value:09.6f}" for value in time]
    cells = np.array(texts, dtype=object)[:, None]
    kinds = {"lines": np.array(texts), "cells": cells, "complex": time + 1j}
    savemat(tmp_path / "log.mat", held | {name: kinds[kind]})
    with pytest.raises(
        InputError, match=f"{name}'? (holds|is not an array of numbers)"
    ):
        read_log(tmp_path / "log.mat")


def test_a_packed_file_is_unpacked_up_to_a_limit(tmp_path, monkeypatch):
    """A megabyte of zeros in a kilobyte."""
    monkeypatch.setattr("hefting.logs.matlab_file.MAX_CELLS", 1000)
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 1000)
    zeros = zlib.compress(matrix(6, element(9, bytes(10**6)), shape=(125_000, 1)))
    path = written(tmp_path, struct.pack("<II", 15, len(zeros)) + zeros)
    with pytest.raises(InputError, match="more than 1,000 numbers"):
        read_log(path)
    bytes_ = matrix(9, element(2, bytes(2000)), name=b"a", shape=(2000, 1))
    with pytest.raises(InputError, match="more than 1,000 numbers"):
        read_log(written(tmp_path, bytes_))


def test_structures_in_structures_are_read_up_to_a_depth(tmp_path, monkeypatch):
    """Reading without a limit would end the process."""
    deep = matrix(6, element(9, bytes(8)))
    for _ in range(500):
        deep = matrix(1, deep, name=b"a")
    with pytest.raises(InputError, match="or too deep"):
        read_log(written(tmp_path, deep))
    monkeypatch.setattr(matlab_file, "MOST_ARRAYS", 9)
    wide = matrix(1, *[matrix(6, element(9, bytes(8)))] * 9, shape=(1, 9))
    with pytest.raises(InputError, match="more than 9 arrays"):
        read_log(written(tmp_path, wide))


@pytest.mark.parametrize("shape", [(2, 2), (-1, 3), (10**9, 10**9)])
def test_a_shape_that_does_not_fit_its_numbers(tmp_path, shape):
    path = written(tmp_path, matrix(6, element(9, bytes(24)), name=b"a", shape=shape))
    with pytest.raises(
        InputError, match=r"cannot be read as \.mat \(3 numbers of shape"
    ):
        read_log(path)


def test_empty_fields_are_passed_over(held, tmp_path):
    savemat(tmp_path / "log.mat", held)
    empty = element(14, b"")
    fields = element(5, struct.pack("<i", 4)) + element(1, b"a\0\0\0b\0\0\0")
    one = matrix(2, fields, empty, empty, name=b"s")
    path = written(tmp_path, (tmp_path / "log.mat").read_bytes()[128:], one)
    assert same(read_log(path), as_recording(**held))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (matrix(6, element(9, b""), shape=(2**31 - 1,) * 20_000), "more than 64 axes"),
        (
            matrix(2, element(5, struct.pack("<i", 1)), element(1, bytes(10**6))),
            "more than 1,000 fields",
        ),
        (matrix(17, *[element(1, b"")] * 300_000), "holds no arrays"),
        (b"".join(matrix(6, element(9, bytes(8)), name=b"a%d" % i) for i in range(1001)),
         "more than 1,000 arrays"),
    ],
)  # fmt: skip
def test_what_is_long_is_not_written_out(tmp_path, content, said):
    """The product of the axes, names of fields, and parts of an object each took minutes, a
    megabyte of names 9 GB."""
    with pytest.raises(InputError, match=said):
        read_log(written(tmp_path, content))
