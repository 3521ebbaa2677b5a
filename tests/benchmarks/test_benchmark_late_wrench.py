"""`benchmarks.late_wrench`: a row for each kind of motion and lag."""

import importlib
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))


def test_a_row_for_each_kind(monkeypatch, capsys):
    benchmark = importlib.import_module("benchmarks.late_wrench")
    monkeypatch.setattr(sys, "argv", ["late_wrench", "--seeds", "1"])
    monkeypatch.setattr(benchmark, "MOTIONS", ("smooth",))
    monkeypatch.setattr(benchmark, "LAGS", (("delay", 0.2), ("filter", 0.2)))
    monkeypatch.setattr(benchmark, "PARTS", (9.0,))
    benchmark.main()
    lines = capsys.readouterr().out.splitlines()
    delay, filtered = (float(line.split()[4]) for line in lines[2:])
    assert delay < 0.5  # 0.03 % in the median of 24
    assert filtered < 2.0  # 0.3 %; 2 % where it is taken for a delay
