"""hefting simulate --torques: two runs, a URDF and the truth, from which the command that
is printed finds the object."""

import shlex

import numpy as np
import pytest

import hefting

pytest.importorskip("mujoco", reason="mujoco is not installed: hefting[sim]")
pytest.importorskip("pinocchio", reason="pinocchio is not installed: hefting[robot]")


def test_the_printed_command_finds_the_object(run, tmp_path, monkeypatch):
    """12 s of either run tell 1.1 kg to 2 %, four times the error of the benchmark's."""
    monkeypatch.chdir(tmp_path)
    words = ("--torques", "--arm", "xarm7", "--duration", "12", "--seed", "3")
    status, out, _ = run("simulate", "held.csv", *words)
    assert status == 0
    names = {"held.csv", "held.empty.csv", "held.urdf", "held.truth.json"}
    assert {path.name for path in tmp_path.iterdir()} == names
    (line,) = (each for each in out.splitlines() if each.startswith("read it back: "))
    command = shlex.split(line.removeprefix("read it back: "))
    assert command[0] == "hefting"
    status, told, _ = run(*command[1:], "--output", "found.json")
    assert status in (0, 3)
    found = hefting.Estimate.load("found.json") if status == 0 else None
    if found is None:
        pytest.fail(told)
    truth = 1.11
    assert found.mass == pytest.approx(truth, rel=0.02)
    low, high = found.interval("mass")
    assert low < truth < high


def test_the_runs_differ_and_the_same_seed_gives_the_same(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("--torques", "--duration", "2", "--rate", "50")
    for name, seed in (("a.csv", 1), ("b.csv", 1), ("c.csv", 2)):
        assert run("simulate", name, *words, "--seed", seed)[0] == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert (tmp_path / "a.csv").read_bytes() != (tmp_path / "c.csv").read_bytes()
    loaded, empty = (
        hefting.read_log(name, wrench_needed=False) for name in ("a.csv", "a.empty.csv")
    )
    assert loaded["joint_torques"].values.shape == (100, 6)
    angles = loaded["joint_positions"].values - empty["joint_positions"].values
    assert np.abs(angles).max() > 0.01  # another motion
    assert loaded.start - empty.start == pytest.approx(60.0)  # the same switching on


def test_both_runs_may_be_folders_of_bags(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("--torques", "--duration", "2", "--rate", "50")
    assert run("simulate", "held", *words)[0] == 0
    names = {"held", "held-empty", "held.urdf", "held.truth.json"}
    assert {path.name for path in tmp_path.iterdir()} == names


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("--bias", "20"), "--bias: is for a wrench; leave it out with --torques"),
        (("--arm", "pandas"), "did you mean 'panda'"),
        (("--truth", "held.urdf"), "two results would have this name"),
        (("--duration", "nan"), "nan"),
    ],
)
def test_what_cannot_be_simulated(run, tmp_path, monkeypatch, words, what):
    monkeypatch.chdir(tmp_path)
    status, _, err = run("simulate", "held.csv", "--torques", *words)
    assert status == 2
    assert what in err
    assert list(tmp_path.iterdir()) == []
