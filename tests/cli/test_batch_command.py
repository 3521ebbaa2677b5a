"""hefting batch: what is wrong whatever the recording is one line before the first, and
no folder is made."""

import numpy as np
import pytest

from commands import refused
from hefting.core.inertia import InertialParameters
from hefting.jobs import Jobs
from hefting.logs import write_log
from hefting.simulation import UR5, simulate, sinusoids

BODY = InertialParameters.from_com(0.8, (0.0, 0.0, 0.1), np.diag((3e-3, 3e-3, 1e-3)))


@pytest.fixture
def logs(tmp_path, monkeypatch):
    """A folder with a recording, which is not to be read."""

    def read(*_):
        raise AssertionError("a recording is read")

    monkeypatch.setattr(Jobs, "run", read)
    folder = tmp_path / "logs"
    folder.mkdir()
    write_log(simulate(UR5.motion(sinusoids(1.0, 100.0, 1.0)), BODY), folder / "a.csv")
    return folder


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--box", "1,1"), ("--box", "not three lengths")),
        (("--shape", "nope.stl"), ("nope.stl", "no such file")),
        (("--object-pose", "1,2"), ("1,2", "not a pose")),
        (("--method", "FOO"), ("unknown method 'FOO'",)),
        (("--gravity", "1"), ("--gravity", "not 3 finite numbers")),
        (("--until", "soon"), ("--until", "'soon' is no accuracy")),
        (("--mass", "x"), ("--mass", "no", "reading")),
        (("--pose-std", "5mm"), ("--pose-std", "5mm,5deg")),
        (("--bias", "nope.json"), ("nope.json", "cannot be read")),
        (("--bias", "nope"), ("--bias", "unknown bias model")),
        (("--bias", "tare:1"), ("--bias tare:START,END",)),
        (("--wrench", "up"), ("unknown wrench convention 'up'",)),
        (("--motion", "slow"), ("unknown source of motion 'slow'",)),
        (("--start", "-1"), ("--start", "before a recording")),
        (("--duration", "0"), ("--duration", "no time")),
        (("--tool", "nope.json"), ("nope.json", "cannot be read")),
        (("--map", "nope.toml"), ("nope.toml", "cannot be read")),
        (("--sensor-turned", "w"), ("'w' is no turn",)),
        (("--sensor-pose-in-log", "1"), ("1", "not a pose")),
        (("--urdf", "nope.urdf", "--sensor-frame", "tool"), ("nope.urdf",)),
    ],
)
def test_what_is_wrong_of_all_is_told_before_the_first(
    run, logs, tmp_path, given, said
):
    output = tmp_path / "results"
    assert refused(run("batch", logs, "--output", output, *given), *said)
    assert not output.exists()


def test_what_a_row_may_complete_is_not_refused(run, logs, tmp_path):
    """Of which shape the hull is, a manifest may say; here the recording is read."""
    with pytest.raises(AssertionError, match="a recording is read"):
        run("batch", logs, "--output", tmp_path / "results", "--hull")


def test_results_need_a_folder_of_their_own(run, logs, tmp_path):
    result = run("batch", logs, "--output", logs)
    assert refused(result, "logs: holds 'a.csv'", "choose another folder")
    assert [each.name for each in logs.iterdir()] == ["a.csv"]


def test_results_are_no_file(run, logs, tmp_path):
    result = run("batch", logs, "--output", tmp_path / "table.csv")
    assert refused(result, "table.csv: names a file", "name a folder")
    assert not (tmp_path / "table.csv").exists()


def test_a_report_is_not_among_the_results(run, logs, tmp_path):
    pytest.importorskip("plotly")
    output = tmp_path / "results"
    output.mkdir()
    report = ("--report", output / "report.html")
    result = run("batch", logs, "--output", output, *report)
    assert refused(result, "report.html: is among the results")


def test_who_stops_it_is_told_how_it_goes_on(run, logs, tmp_path, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Jobs, "run", stop)
    status, _, err = run("batch", logs, "--output", tmp_path / "results")
    assert status == 130
    assert "the same with --resume goes on" in err
