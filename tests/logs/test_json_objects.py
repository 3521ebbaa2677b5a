"""JSON lines are read as the same samples in memory: objects in objects, lists, joints by
their names."""

import json

import numpy as np
import pytest
from test_npz import arrays, same

from hefting.core.errors import InputError
from hefting.logs import read_log
from hefting.logs.given import as_recording
from hefting.logs.json_lines import open_json_lines
from log_files import check_line

__all__ = ["arrays"]
"""The fixture of another test."""


def xyz(values):
    return dict(zip("xyzw", values.tolist(), strict=False))


@pytest.fixture
def recording(arrays):
    time, pose, wrench = arrays
    return as_recording(time=time, pose=pose, wrench=wrench)


@pytest.fixture
def rows(recording):
    """Time, position, quaternion and wrench of each sample."""
    streams = (recording[s].values for s in ("position", "orientation", "wrench"))
    return list(zip(recording["wrench"].time, *streams, strict=True))


@pytest.fixture
def write(tmp_path):
    """Writes lines, as they are or as JSON."""

    def write(lines, end="\n"):
        texts = [x if isinstance(x, str) else json.dumps(x) for x in lines]
        (tmp_path / "log.jsonl").write_text("\n".join(texts) + end)
        return tmp_path / "log.jsonl"

    return write


def test_lists_by_the_names_of_streams(rows, recording, write):
    names = ("time", "position", "orientation", "wrench")
    lines = [
        dict(zip(names, [t, *(values.tolist() for values in row)], strict=True))
        for t, *row in rows
    ]
    found = read_log(write(lines))
    assert found.warnings == ()
    assert same(found, recording)


def test_messages_of_ros_one_a_line_with_their_topics(rows, recording, write):
    """As `mcap cat --json` writes them: a pose of another topic is not mixed in."""
    lines = []
    for t, position, quaternion, wrench in rows:
        both = {"force": xyz(wrench[:3]), "torque": xyz(wrench[3:])}
        tool = {"position": xyz(position), "orientation": xyz(quaternion)}
        other = {"position": xyz(position[::-1]), "orientation": xyz(quaternion[::-1])}
        stamp = {"stamp": {"sec": int(t), "nanosec": round(1e9 * (t % 1))}}
        for topic, data in (
            ("/camera/pose", {"pose": other}),
            ("/ft/wrench", {"wrench": both}),
            ("/tcp/pose", {"pose": tool}),
        ):
            data = {"header": stamp} | data
            lines.append({"topic": topic, "log_time": t, "data": data})
    found = read_log(write(lines))
    assert same(found, recording)
    assert "columns-by-name" in [m.code for m in found.warnings]


def test_matrices_by_the_name_of_a_stream_in_some_lines(arrays, write):
    """And the time as JSON of protobuf has it."""
    time, pose, wrench = arrays
    lines = [
        {
            "timestamp": {"seconds": str(int(t)), "nanos": round(1e9 * (t % 1))},
            "pose": None if k % 4 else matrix.tolist(),
            "wrench": w.tolist(),
        }
        for k, (t, matrix, w) in enumerate(zip(time, pose, wrench, strict=True))
    ]
    table = open_json_lines(write(lines))
    np.testing.assert_array_equal(table.arrays["pose"][::4], pose[::4])
    assert np.isnan(table.arrays["pose"][1]).all()
    found = read_log(write(lines))
    np.testing.assert_allclose(found["wrench"].time, time, atol=1e-9)
    np.testing.assert_allclose(found["orientation"].time, time[::4], atol=1e-9)
    named = [{"time": t} | line for t, line in zip(time, lines, strict=True)]
    found = read_log(write([{"robot": "r1", "version": 2}, *named]))  # no sample
    np.testing.assert_array_equal(found["position"].values, pose[::4, :3, 3])


def test_matrices_dates_and_numbers_as_text(arrays, recording, write):
    time, pose, wrench = arrays
    lines = [
        {
            "timestamp": f"2026-01-31T12:00:{t:09.6f}Z",
            "tcp_pose": matrix.tolist(),
            "mode": "guided",
            "fz": str(w[2]),
            **{f"f{a}": w[i] for i, a in enumerate("xy")},
            **{f"t{a}": w[3 + i] for i, a in enumerate("xyz")},
        }
        for t, matrix, w in zip(time, pose, wrench, strict=True)
    ]
    found = read_log(write(lines))
    for name, stream in recording.streams.items():
        np.testing.assert_allclose(found[name].values, stream.values, atol=1e-12)
        np.testing.assert_allclose(found[name].time, time, atol=2e-6)


def test_joints_have_their_names(write):
    """Those of a gripper, in the same topic, are others; effort may be absent."""
    arm = {"name": ["b", "a"], "position": [1, 2.5], "effort": []}
    table = open_json_lines(
        write([{"joints": arm}, {"joints": {"name": ["g"], "position": [7]}}])
    )
    wanted = {"joints.b.position": [1, np.nan], "joints.a.position": [2.5, np.nan]}
    for name, values in (wanted | {"joints.g.position": [np.nan, 7]}).items():
        np.testing.assert_array_equal(table.columns[name], values)
    assert open_json_lines(write([arm])).names == ("b.position", "a.position", "name")


def test_blanks_and_what_is_no_number(write):
    lines = [
        {"a": None, "b": [1, None], "c": [1, 2], "d": 1, "e": True},
        "",
        {"a": "NaN", "c": [1], "d": "up", "e": 10**400, "f": [[{}]], "a.b": 1},
        {"b": [3, 4], "d": 2, "e": "null", "a": {"b": 5}, "g": "", "h": []},
    ]
    table = open_json_lines(write(lines))
    assert sorted(table.names) == ["a", "a.b", "b_0", "b_1", "c", "d", "e", "f"]
    np.testing.assert_array_equal(table.columns["b_1"], [np.nan, np.nan, 4])
    np.testing.assert_array_equal(table.columns["e"], [1, np.inf, np.nan])
    np.testing.assert_array_equal(table.columns["a.b"], [np.nan, 1, 5])
    for name in "cdf":
        with pytest.raises(
            InputError, match=f"column '{name}' holds text, not numbers"
        ):
            next(table.blocks([table.names.index(name)]))


def test_a_last_line_that_was_cut_is_left_out(rows, recording, write):
    lines = [
        {
            "time": t,
            "position": p.tolist(),
            "orientation": q.tolist(),
            "wrench": w.tolist(),
        }
        for t, p, q, w in rows
    ]
    found = read_log(write([*lines, '{"time": 4.0, "posi'], end=""))
    assert same(found, recording)
    assert [m.code for m in found.warnings] == ["end-left-out"]


DEEP = '{"a":' * 500 + "[" * 500


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([{"a": 1}, "{", {"a": 1}], "row 2: is no JSON object (Expecting property name"),
        (["[1, 2]", "[3, 4]"], "row 1: is no JSON object ("),
        (["{", ' "a": 1', "}"], "row 1: is no JSON object"),
        (["7"], "row 1: is no JSON object (it is another value); write one object"),
        ([DEEP * 400, {"a": 1}], "row 1: is no JSON object (maximum recursion depth"),
        ([{f"n{j}": 1 for j in range(1001)}], "more than 1000 names of numbers; write one"),
        (['{"a": 1}\0{"a": 2}'], "is binary"),
        ([{"wrench": [1, 2, 3, 4, 5, 6], "time": 0}] * 3, "there is no orientation"),
    ],
)  # fmt: skip
def test_what_is_no_recording_is_refused_in_one_line(write, lines, said):
    path = write(lines)
    with pytest.raises(InputError) as refused:
        read_log(path)
    check_line(str(refused.value), str(path), said)


def test_rows_are_lines(rows, write):
    lines = [
        {
            "time": t,
            "orientation": q.tolist(),
            "wrench": [float("inf"), *w[1:].tolist()],
        }
        for t, _, q, w in rows
    ]
    lines[:5] = [line | {"wrench": [1.0] * 6} for line in lines[:5]]
    lines = [{"t": line.pop("time")} | line for line in lines]
    with pytest.raises(InputError, match="row 6, column wrench_0: the value is inf"):
        read_log(write(lines))


def test_more_numbers_than_are_read(write, monkeypatch):
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 9)
    with pytest.raises(InputError, match="holds more than 9 numbers"):
        read_log(write([{"a": 1, "b": 2}] * 5))


@pytest.mark.parametrize(
    "lines",
    [
        [{"topic": "x" * 2000, "a": {"b": 1}}],
        [{"x" * 2000: {f"k{j}": "s" for j in range(9)}}],
    ],
)
def test_long_names_are_not_put_before_each_other(write, lines):
    """A megabyte before 3,000 names took more than 5 GB."""
    with pytest.raises(InputError, match="a name of more than 1,000 characters"):
        read_log(write(lines))


def test_names_of_other_things_are_counted_as_well(write):
    lines = [{f"k{j}": "s" for j in range(500 * i, 500 * i + 500)} for i in range(3)]
    with pytest.raises(InputError, match="more than 1000 names of numbers"):
        read_log(write(lines))


def test_lists_in_many_lists_are_no_numbers(write):
    deep = [1.0]
    for _ in range(62):
        deep = [deep]
    with pytest.raises(InputError) as refused:
        read_log(write([{"wrench": deep, "time": t, "pose": [1] * 7} for t in (0, 1)]))
    assert "\n" not in str(refused.value)
