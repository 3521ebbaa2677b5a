"""Mistakes in a column map: one clear line for each, and nothing but that whatever the
map says."""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hefting.core.errors import InputError
from hefting.logs import read_log
from log_files import ROWS, log, mapped, mapping_fails

WRENCH = 'wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
POSE = 'orientation = ["qx", "qy", "qz", "qw"]\n'
TIME = 'time = "time"\n'


@pytest.fixture
def path(tmp_path) -> Path:
    return log(tmp_path, *ROWS)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("this is no TOML", ("map.toml", "is not TOML", "wrench = {")),
        ("a = [" * 5000, ("is not TOML",)),
        (
            "wrnech = []",
            (
                "map.toml",
                "unknown key 'wrnech' (did you mean 'wrench'?)",
                "time, position, orientation",
            ),
        ),
        (TIME + POSE, ("gives no wrench",)),
        (TIME + WRENCH, ("neither an orientation nor joint angles",)),
        ("force = ['fx', 'fy', 'fz']\n" + POSE, ("only one of force and torque",)),
        (
            WRENCH + POSE + "force = 'f{0..2}'\ntorque = 't{0..2}'",
            ("gives both wrench and force",),
        ),
        (
            WRENCH + POSE + "pose = { columns = 'T{0..15}', form = 'matrix4' }",
            ("gives both pose and orientation",),
        ),
        (
            WRENCH + "orientation = ['qx', 'qy', 'qz']",
            ("orientation.columns", "names 3 columns, orientation (xyzw) has 4"),
        ),
        (POSE + "wrench = ['fx']", ("wrench.columns", "names 1 columns, wrench has 6")),
        (POSE + "wrench = []", ("wrench.columns", "names no column")),
        (POSE + "wrench = [0, 1, 2, 3, 4, 5]", ("0 is no column", "counted from 1")),
        (POSE + "wrench = [true]", ("True is no column",)),
        (POSE + "wrench = { unit = 'N' }", ("does not say which columns",)),
        (
            POSE + "wrench = { column = 'f{0..5}' }",
            ("key wrench", "unknown word 'column' (did you mean 'columns'?)"),
        ),
        (
            POSE + "wrench = 'f{5..0}'",
            ("'f{5..0}' counts no columns", "smaller number first"),
        ),
        (POSE + "wrench = 'f{0..999999}'", ("counts no columns",)),
        (POSE + f"wrench = {['f{0..999}'] * 2}", ("more than 1000 columns",)),
        (
            POSE + "wrench = { columns = 'f{0..5}', unit = 'N' }",
            ("1 units, not 2", "force and one of torque"),
        ),
        (
            POSE + "wrench = { columns = 'f{0..5}', unit = ['N', 'Nkm'] }",
            ("unknown unit of torque 'Nkm'", "N mm, N cm"),
        ),
        (
            POSE + "wrench = { columns = 'f{0..5}', unit = ['N', 3] }",
            ("unit of torque is not text",),
        ),
        (
            POSE + "wrench = { columns = 'f{0..5}', axes = 'base' }",
            ("'base' are no axes", "sensor or world"),
        ),
        (
            WRENCH + "orientation = { columns = 'q{0..3}', form = 'wzyx' }",
            ("'wzyx' is no form", "xyzw, wxyz, rot"),
        ),
        (
            WRENCH + "orientation = { columns = 'q{0..3}', unit = 'deg' }",
            ("form xyzw has no unit",),
        ),
        (
            WRENCH + "orientation = { columns = 'q{0..2}', form = 'euler' }",
            ("None is no order", "ZYX about moving"),
        ),
        (
            WRENCH
            + "orientation = { columns = 'q{0..2}', form = 'euler', order = 'ZZX' }",
            ("'ZZX' is no order",),
        ),
        (
            WRENCH
            + "orientation = { columns = 'q{0..2}', form = 'euler', order = 'Zyx' }",
            ("'Zyx' is no order",),
        ),
        (
            WRENCH
            + "orientation = { columns = 'q{0..2}', form = 'rpy', order = 'ZYX' }",
            ("form rpy has no order",),
        ),
        (
            WRENCH
            + "orientation = { columns = 'q{0..2}', form = 'rpy', unit = 'grad' }",
            ("of angle 'grad'", "rad, deg"),
        ),
        (
            WRENCH + "pose = 'T{0..15}'",
            ("does not say the form of the pose", "matrix4, matrix4-columns"),
        ),
        (
            WRENCH + "pose = { columns = 'T{0..11}', form = 'matrix4' }",
            ("names 12 columns, pose (matrix4) has 16",),
        ),
        (WRENCH + POSE + "time = { unit = 's' }", ("neither column nor rate",)),
        (
            WRENCH + POSE + "time = { columns = 'time' }",
            ("key time", "'columns' (did you mean 'column'"),
        ),
        (WRENCH + POSE + "time = 't{0..1}'", ("names 2 columns, time is one",)),
        (WRENCH + POSE + "time = { rate = 0 }", ("rate 0 is no positive number", "Hz")),
        (WRENCH + POSE + "time = { rate = nan }", ("rate nan",)),
        (WRENCH + POSE + "time = { rate = true }", ("rate True",)),
        (
            WRENCH + POSE + "time = { column = 'time', rate = 2, unit = 's' }",
            ("both unit and rate",),
        ),
        (
            WRENCH + POSE + "time = { column = 'time', unit = 'ticks' }",
            ("unknown unit of time 'ticks'", "s, ms, us, ns"),
        ),
        (
            WRENCH + "joint_positions = { columns = ['qx', 'qy'], names = ['a'] }",
            ("1 different names for 2 joints",),
        ),
        (
            WRENCH + "joint_positions = { columns = ['qx', 'qy'], names = ['a', 'a'] }",
            ("1 different names for 2",),
        ),
        (
            WRENCH + "joint_positions = { columns = ['qx'], names = 'a' }",
            ("are not a list of names",),
        ),
        (
            WRENCH + POSE + "separator = 'x'",
            ("key separator", "'x' is no separator", "tab or space"),
        ),
        (
            WRENCH + POSE + "header = 0",
            ("key header", "0 is no line number", "or false"),
        ),
        (WRENCH + POSE + "header = true", ("True is no line number",)),
        (WRENCH + POSE + f"header = {'9' * 40}", ("a huge number is no line number",)),
        (
            WRENCH + POSE + f"header = 0x{'f' * 9999}",
            ("a huge number is no line number",),
        ),
        (WRENCH + POSE + "skip = -1", ("key skip", "-1 is no number of lines")),
        (WRENCH + POSE + "decimal = ';'", ("key decimal", "';' is no decimal mark")),
        (
            WRENCH + POSE + "decimal = ','\nseparator = ','",
            ("both separated by a comma",),
        ),
        (WRENCH + POSE + "nan = 'zero'", ("key nan", "'zero' is not known", "blank")),
        (
            WRENCH + POSE + "time = 'Time '",
            (
                "key time",
                "no column 'Time ' (did you mean 'time'?)",
                "its columns are 'time'",
            ),
        ),
        (
            WRENCH.replace("fz", "Fz2") + POSE,
            ("key wrench", "log.csv has no column 'Fz2' (did you mean 'fz'?)"),
        ),
        (
            WRENCH + POSE.replace('"qw"', "99"),
            ("key orientation", "no column number 99", "has 11 columns"),
        ),
        (WRENCH + POSE + "header = 9", ("there is no line 9 with the column names",)),
        (WRENCH + POSE + "header = 2", ("row 2", "numbers, not column names")),
        (WRENCH + POSE + "skip = 3", ("no samples",)),
        (
            WRENCH
            + "orientation = { columns = [2, 3, 4, 5, 6, 7, 8, 9, 10], form = 'matrix' }",
            ("row 2, columns qx..ty", "no rotation matrix"),
        ),
        (
            "wrench = { columns = [6,7,8,9,10,11], axes = 'world' }\njoint_positions = ['qx']",
            ("no orientation to turn it by",),
        ),
        (
            POSE + "force = { columns = [6,7,8], axes = 'world' }\ntorque = [9,10,11]",
            ("force and torque are in different axes",),
        ),
    ],
)
def test_mistakes_in_a_map(path, text, words):
    mapping_fails(path, text, *words)


def test_a_mirroring_matrix_is_no_rotation(tmp_path):
    matrix = ",".join(f"r{i}" for i in range(9))
    path = log(
        tmp_path,
        "0,1,0,0,0,1,0,0,0,-1,1,2,3,4,5,6",
        header=f"time,{matrix},fx,fy,fz,tx,ty,tz",
    )
    text = WRENCH + "orientation = { columns = 'r{0..8}', form = 'matrix' }"
    mapping_fails(path, text, "row 2, columns r0..r8", "no rotation matrix")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_maps_as_powershell_and_editors_write_them(path, tmp_path, encoding):
    text = 'time = "time"\nwrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
    text += 'orientation = ["qx", "qy", "qz", "qw"]\n'
    (tmp_path / "map.toml").write_text(text, encoding="utf-8")
    expected = read_log(path, tmp_path / "map.toml")
    (tmp_path / "map.toml").write_text(text, encoding=encoding)
    assert (
        read_log(path, tmp_path / "map.toml").streams.keys() == expected.streams.keys()
    )
    dots = "a" + ".a" * 2000 + " = 1"
    (tmp_path / "map.toml").write_text(dots, encoding=encoding)
    with pytest.raises(InputError, match="more than 1,000 dots"):
        read_log(path, tmp_path / "map.toml")


def test_maps_that_cannot_be_opened(path, tmp_path):
    for chosen, words in (
        (tmp_path / "absent.toml", "No such file"),
        (tmp_path, "directory"),
    ):
        with pytest.raises(InputError, match=words):
            read_log(path, chosen)
    (tmp_path / "map.toml").write_bytes(b"a = 1\n" * 200_000)
    with pytest.raises(InputError, match="too large for a column map"):
        read_log(path, tmp_path / "map.toml")
    (tmp_path / "map.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not TOML"):
        read_log(path, tmp_path / "map.toml")


words = st.sampled_from(
    [
        "time",
        "qx",
        "fx",
        "m",
        "deg",
        "N m",
        "wxyz",
        "euler",
        "ZYX",
        "f{0..5}",
        "{9..1}",
        "",
        "é",
        "|",
    ]
)
values = st.recursive(
    words
    | st.integers(-3, 20)
    | st.booleans()
    | st.floats(allow_nan=True).map(lambda x: x),
    lambda inner: (
        st.lists(inner, max_size=6) | st.dictionaries(words, inner, max_size=3)
    ),
    max_leaves=8,
)
keys = st.sampled_from(
    ["time", "position", "orientation", "pose", "wrench", "force", "torque", "joint_positions", "separator", "header",
     "skip", "decimal", "nan", "accelerometer"]
)  # fmt: skip
inside = st.sampled_from(
    ["column", "columns", "unit", "form", "order", "rate", "names", "axes"]
)


def toml(value) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{toml(str(k))} = {toml(v)}" for k, v in value.items())
            + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, str):
        return '"' + value + '"'
    return str(value).lower()


@settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    st.dictionaries(
        keys, values | st.dictionaries(inside, values, max_size=4), max_size=5
    ),
    st.booleans(),
)
def test_no_map_gives_anything_but_a_recording_or_an_input_error(
    path, content, complete
):
    fixed = (
        {
            "wrench": ["fx", "fy", "fz", "tx", "ty", "tz"],
            "orientation": ["qx", "qy", "qz", "qw"],
        }
        if complete
        else {}
    )
    with suppress(InputError):
        mapped(
            path,
            "\n".join(
                f"{key} = {toml(value)}" for key, value in {**fixed, **content}.items()
            ),
        )
