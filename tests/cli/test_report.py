"""An estimate as it is printed: aligned, wrapped, plain where no terminal is."""

import io
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.table import Table

from hefting.cli import render, spell_out_signs
from hefting.cli.report.estimate import (
    assumptions,
    estimate_report,
    print_lines,
    summary,
)
from hefting.cli.report.printing import print_report
from hefting.core.estimate import Estimate
from hefting.core.messages import warning
from hefting.page.origin import assumptions as section
from random_problems import random_body


@pytest.fixture
def estimate() -> Estimate:
    doubt = warning("much-said", "check `gravity` " + 30 * "and so on ", "gravity")
    return Estimate(
        "LMI",
        random_body(np.random.default_rng(1)),
        7,
        1.0,
        np.eye(10),
        warnings=(doubt,),
    )


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("named", [{"sensor_frame": "flange"}, {}])
def test_a_table_by_torques_names_its_frame(estimate, named):
    made = {"torque_gain_std": 0.01, "torque_noise": (0.1,)} | named
    lines = estimate_report(replace(estimate, provenance=made))
    told = f"in axes of {named.get('sensor_frame', '--sensor-frame')}"
    assert f"LMI: what the arm holds, {told}" in [line.text for line in lines]


def test_columns_stand_under_each_other(estimate, capsys):
    print_lines(estimate_report(estimate, estimate.parameters))
    lines = capsys.readouterr().out.splitlines()
    table = [line for line in lines if line[0] in "┏┃┡│├└"]
    assert len({len(line) for line in table}) == 1
    assert [cell.strip() for cell in table[1].split("┃")[1:-1]] == [
        "quantity",
        "estimate",
        "± std",
        "truth",
        "unit",
    ]
    for line in table:
        assert [k for k, mark in enumerate(line) if mark in "┏┃┡│├└┳╇┼┴┓┩┤┘"] == [
            k for k, mark in enumerate(table[0]) if mark in "┏┳┓"
        ]


def test_long_lines_are_wrapped_and_arguments_become_options(estimate, capsys):
    print_lines(estimate_report(estimate), render)
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 100
    assert "verdict: usable with care\n- check --gravity and so on" in out
    assert "\x1b" not in out
    print_lines(estimate_report(estimate))
    assert "- check `gravity`" in capsys.readouterr().out


def test_a_terminal_gets_styles_unless_it_wants_none(estimate, monkeypatch):
    plain = ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)
    for variables, styled in (({}, True), *plain):
        monkeypatch.delenv("NO_COLOR", raising=False)
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv("COLUMNS", "60")
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        monkeypatch.setattr(sys, "stdout", Terminal())
        print_lines(estimate_report(estimate))
        assert ("\x1b[33mverdict" in sys.stdout.getvalue()) is styled


def test_tables_fit_a_narrow_terminal(estimate, monkeypatch):
    """Three columns more than a table's cells take: no head is broken."""
    monkeypatch.setenv("COLUMNS", "46")
    monkeypatch.setattr(sys, "stdout", Terminal())
    print_lines(estimate_report(estimate, estimate.parameters))
    assert max(map(len, re.findall(r"[┏┃│].*", sys.stdout.getvalue()))) <= 46
    monkeypatch.setattr(sys, "stdout", Terminal())
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for name in ("samples", "missing", "repeated", "orientation"):
        table.add_column(name, overflow="fold")
    table.add_row("1000", "0", "0", "1")
    monkeypatch.setenv("COLUMNS", "39")
    print_report(Group(table))
    shown = re.sub(r"\x1b\[[0-9;]*m", "", sys.stdout.getvalue())
    assert "samples missing repeated orientation" in shown


def test_an_output_without_box_characters_gets_plain_ones(estimate, monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr(sys, "stdout", out)
    spell_out_signs()
    print_lines(estimate_report(replace(estimate, warnings=())))
    out.flush()
    assert "| mass " in out.buffer.getvalue().decode("latin-1")


def test_a_sign_that_is_uncertain_is_told_so_everywhere(estimate):
    made = {"wrench": "on-object", "wrench_found": True, "gravity": (0.0, 0.0, -9.8)}
    own = replace(
        estimate, provenance=made, warnings=(warning("sign-uncertain", "either"),)
    )
    page = str(section(own, render).content)
    for text in (*summary(own), *assumptions(own), page):
        assert "found from gravity" not in text
    assert "wrench on the object, uncertain" in " ".join(summary(own))
    assert "wrench on-object (uncertain)" in " ".join(assumptions(own))
    assert ", uncertain" in page
