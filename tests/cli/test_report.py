"""An estimate as it is printed: aligned, wrapped, plain where no terminal is."""

import io
import sys
from dataclasses import replace

import numpy as np
import pytest

from hefting.cli import render, spell_out_signs
from hefting.cli.report.estimate import estimate_report, print_lines
from hefting.core.estimate import Estimate
from hefting.core.messages import warning
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
    for variables, styled in (({}, True), ({"NO_COLOR": "1"}, False)):
        monkeypatch.delenv("NO_COLOR", raising=False)
        monkeypatch.setenv("COLUMNS", "60")
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        monkeypatch.setattr(sys, "stdout", Terminal())
        print_lines(estimate_report(estimate))
        assert ("\x1b[33mverdict" in sys.stdout.getvalue()) is styled


def test_an_output_without_box_characters_gets_plain_ones(estimate, monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr(sys, "stdout", out)
    spell_out_signs()
    print_lines(estimate_report(replace(estimate, warnings=())))
    out.flush()
    assert "| mass " in out.buffer.getvalue().decode("latin-1")
