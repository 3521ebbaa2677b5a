"""`benchmarks.trapezoids`: a quick run prints its tables, and errors and claims are
within bounds."""

import importlib
import re
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[2]))


@pytest.mark.usefixtures("same_poses", "nothing_looked_for")
def test_quick_run(monkeypatch, capsys):
    """Ratios of one short recording each scatter: four of a row's are within a factor
    of 2.5 of exact motion where 40 long ones are within 1.6."""
    monkeypatch.setattr(sys, "argv", ["trapezoids", "--quick"])
    importlib.import_module("benchmarks.trapezoids").main()
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if " all " in line]
    assert len(rows) == 8  # two kinds, two rates, two methods
    for row in rows:
        numbers = [float(x) for x in re.findall(r"\d+\.\d+", row)]
        assert len(numbers) == 7
        assert 0.3 < numbers[4] < 2.5, row
    claims = [line for line in lines if "claimed" in line]
    assert len(claims) == 8
    for line in claims:
        # four recordings, the errors at whose ends count most: half to twice
        assert 0.5 < float(line.split(": ")[1].split()[0]) < 2.0, line
    assert sum("0 to 20 ms" in line for line in claims) == 4
