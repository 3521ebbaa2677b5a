"""What stands before and around the names of columns: comments, units, and rows that are
none."""

import pytest

from hefting.core.errors import InputError
from hefting.logs import read_log
from known_rows import (
    CANONICAL,
    LINES,
    ROWS,
    WRENCH,
    same,
    text_of,
)

UNITS = "s,m,m,m,,,,,N,N,N,Nm,Nm,Nm"
BEFORE = {
    "nothing": LINES,
    "comments": ["# recorded in the lab, by hand", "% robot: UR5", "", *LINES],
    "a commented header": ["# made by a script", f"# {LINES[0]}", *LINES[1:]],
    "rostopic": [f"%{LINES[0]}", *LINES[1:]],
    "other text": ["Recorded: 2026-01-31 12:00", "Robot;UR5", "", *LINES],
    "units": [LINES[0], UNITS, *LINES[1:]],
    "groups": [",pose,,,pose,,,,wrench,,,wrench,,", *LINES],
    "decimal commas": text_of(";", ","),
    "tabs and decimal commas": text_of("\t", ","),
}


@pytest.mark.parametrize("case", BEFORE)
def test_what_stands_around_the_names(tmp_path, case):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(BEFORE[case]) + "\n")
    got = read_log(path)
    assert same(got)
    assert not got.warnings
    lines = [line for line in BEFORE[case] if line]
    first = BEFORE[case].index(lines[-ROWS])
    assert got["wrench"].rows[0] == first + 1


def test_a_row_that_is_too_short_is_no_line_of_units(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join((LINES[0], "0,1,2", *LINES[1:])))
    with pytest.raises(InputError, match="row 2: there are 3 cells under 14"):
        read_log(path)


def test_a_short_text_without_a_last_line_end(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join(("# by hand", *LINES[:3])))
    assert len(read_log(path)["wrench"]) == 2


def test_names_far_down_are_read_where_a_map_says_so(tmp_path):
    path, told = tmp_path / "log.csv", tmp_path / "map.toml"
    path.write_text("\n".join(("note;" * 3,) * 400) + "\n" + "\n".join(LINES))
    wrench, turned = CANONICAL[8:], CANONICAL[4:8]
    told.write_text(
        f'header = 401\ntime = "time"\nwrench = {wrench}\norientation = {turned}\n'
    )
    assert read_log(path, told)["wrench"].values.tolist() == WRENCH.tolist()
