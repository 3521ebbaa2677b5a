"""Inspection of logs that lack something, are wrong, or are of static poses: none makes it
fail."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hefting.cli import main
from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.inspection import inspect
from hefting.logs import read_log, write_log
from inspected import DURATION, RATE, found_of, log_of, printed, with_wrench
from recordings import DATA, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")


def static(log: Recording, rows=slice(None)) -> Recording:
    streams = {k: log[k][rows] for k in ("orientation", "wrench")}
    count = np.arange(float(len(streams["wrench"])))
    return Recording(
        {k: Stream(count, s.values) for k, s in streams.items()},
        static=True,
        source="poses",
    )


def odd_logs() -> dict[str, tuple[Recording, str]]:
    """Logs that lack something, and a word of the advice."""
    log = log_of()
    wrench, orientation, position = log["wrench"], log["orientation"], log["position"]
    joints = Stream(wrench.time, np.random.default_rng(9).normal(size=(len(wrench), 6)))
    held = Stream(wrench.time, np.repeat(orientation.values[:1], len(wrench), axis=0))
    return {
        "joints": (
            Recording({"joint_positions": joints, "wrench": wrench}),
            "`urdf` robot.urdf `sensor_frame` NAME",
        ),
        "wrench": (Recording({"wrench": wrench}), "qx qy qz qw"),
        "poses": (Recording({"orientation": orientation}), "record the wrench"),
        "three poses": (
            Recording({"orientation": orientation[:3], "wrench": wrench[:3]}),
            "too few",
        ),
        "one row": (
            Recording({"orientation": orientation[:1], "wrench": wrench[:1]}),
            "other orientations",
        ),
        "no overlap": (
            with_wrench(log, time=wrench.time + 100.0),
            "while the pose was",
        ),
        "zero wrench": (with_wrench(log, 0.0 * wrench.values), "zero throughout"),
        "a million newtons": (with_wrench(log, 1e9 * wrench.values), "newtons"),
        "one orientation": (
            Recording({"orientation": held, "wrench": wrench}),
            "other orientations",
        ),
        "static": (static(log, slice(None, None, 20)), "--shape"),
        "two static poses": (static(log, slice(0, 400, 399)), "ten static poses"),
        "one static pose": (static(log, slice(1)), "other orientations"),
        "turning only": (
            Recording({"orientation": orientation, "wrench": wrench}),
            "record positions",
        ),
        "eight poses": (
            Recording(
                {
                    "orientation": orientation[:8],
                    "position": position[:8],
                    "wrench": wrench[:8],
                }
            ),
            "",
        ),
    }


PAGE = (Path(__file__).parents[2] / "docs" / "json.md").read_text()
DOCUMENTED = {
    key
    for line in PAGE.split("\n## inspect\n")[1].split("\n## ")[0].splitlines()
    if line.startswith("| `")
    for key in re.findall(r"`(\w+)`", line.split(" | ")[0])
}


@pytest.mark.parametrize("name", list(odd_logs()))
def test_no_log_makes_it_fail(name):
    log, word = odd_logs()[name]
    found = inspect(log)
    assert found.advice
    assert word in " | ".join((*found.advice, *found.warnings))
    out = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert set(out) == DOCUMENTED
    assert set(out["streams"]) == set(log.streams)
    assert (found.facts is None) == ("object" in out["missing"])
    assert (found.movement is None) == ("motion" in out["missing"])
    assert (found.conditioned is None) == ("conditioning" in out["missing"])
    text = printed(found)
    assert text.index("\nmotion") < text.index("\nobject") < text.index("\nnext: ")
    assert "nan" not in text


def test_what_was_there_before_is_still_there():
    keys = (
        "log duration static streams motion linear_speed angular_speed dynamism quick_mass mass bias bias_t noise "
        "identifiability advice warnings undetermined wrench wrench_t"
    )
    out = found_of().to_dict()
    assert set(keys.split()) <= set(out) == DOCUMENTED
    assert out["streams"]["wrench"]["samples"] == RATE * DURATION
    assert out["streams"]["wrench"]["rate"] == pytest.approx(RATE)


def test_notes_of_the_reader_are_printed():
    log = replace(
        log_of(), notes=("wrench from topic /wrench",), warnings=("the file was cut",)
    )
    text = printed(inspect(static(log)))  # a static copy has none
    assert "topic" not in text
    found = inspect(replace(static(log), notes=log.notes, warnings=log.warnings))
    assert found.notes == log.notes
    assert "note: wrench from topic /wrench" in printed(found)
    assert "- the file was cut" in printed(found)


@pytest.mark.parametrize(
    "gravity", [(0.0, 0.0, 0.0), (0.0, 9.8), (np.nan, 0.0, 0.0), "down"]
)
def test_a_gravity_that_is_none(gravity):
    with pytest.raises(InputError, match="gravity"):
        inspect(log_of(), gravity)


def test_a_reversed_gravity_is_not_said_to_agree():
    """Nor is the sign said that was found with it."""
    found = inspect(log_of(gravity=(0.0, 0.0, 9.80665)))
    assert [w.code for w in found.warnings] == ["gravity-reversed"]
    assert found.gravity_hint is None
    assert "the data agree" not in printed(found)
    assert "on-sensor" not in printed(found)


def test_the_command_on_joint_angles(tmp_path, capsys, monkeypatch):
    """Without a URDF there is little to say, but that is said."""
    path = tmp_path / "joints.csv"
    write_log(odd_logs()["joints"][0], path)
    for words in ([], ["--json"]):
        monkeypatch.setattr("sys.argv", ["hefting", "inspect", str(path), *words])
        main()
        assert "give --urdf robot.urdf --sensor-frame NAME" in capsys.readouterr().out


@needs_recordings
@pytest.mark.parametrize(
    ("name", "gravity", "mass"),
    [("kuka-ati/static_poses", 9.82085, 0.9323), ("axia80/poses7", 9.80665, 1.1013)],
)
def test_recorded_static_poses(name, gravity, mass):
    found = inspect(read_log(DATA / f"{name}.csv"), (0.0, 0.0, -gravity))
    assert not found.sign.on_object
    # the published figures have four digits
    assert found.facts.mass == pytest.approx(mass, rel=1e-3)
    assert found.facts.quick_mass_less_bias == pytest.approx(mass, rel=1e-2)
    assert found.undetermined == ("Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")
    assert found.movement.turn > 2.0
