"""hefting check: what it prints, returns and writes."""

import json

import numpy as np
import pytest

from commands import refused
from hefting.robots import repair_inertias
from inertial_urdfs import random_robot


@pytest.fixture
def robot(tmp_path, monkeypatch):
    """A robot with two links that can be repaired, in the current folder."""
    monkeypatch.chdir(tmp_path)
    kinds = ["solid", "triangle", "solid", "indefinite"]
    path = tmp_path / "robot.urdf"
    path.write_text(random_robot(np.random.default_rng(2), kinds))
    return path


def test_a_line_for_each_link_that_fails(run, robot):
    status, out, err = run("check", "robot.urdf")
    assert (status, err) == (3, "")
    assert "no body can have the inertials of 2 of 5 links" in out
    (triangle,) = [line for line in out.splitlines() if "link2" in line]
    (indefinite,) = [line for line in out.splitlines() if "link4" in line]
    assert "triangle inequality" in triangle
    assert "tensor not positive definite" in indefinite
    assert triangle.count("%") == indefinite.count("%") == 2
    assert "fine: 2 links, and 1 without mass" in out
    assert "--repair FILE" in out
    assert max(map(len, out.splitlines())) <= 80
    assert list(robot.parent.iterdir()) == [robot]


def test_repair_writes_the_nearest_and_shows_it(run, robot):
    before = robot.read_bytes()
    status, out, err = run("check", robot, "--repair", "out.urdf", "--diff")
    assert (status, err) == (0, "")
    assert "wrote out.urdf, with 2 of 2 repaired" in out
    expected = repair_inertias(robot)
    assert (robot.parent / "out.urdf").read_bytes() == expected.after
    assert robot.read_bytes() == before
    assert out.endswith(expected.diff("out.urdf"))
    status, out, _ = run("check", "out.urdf")
    assert status == 0
    assert out == "out.urdf: all fine: 4 links, and 1 without mass\n"


def test_what_no_tensor_helps_is_named(run, robot):
    text = robot.read_text().replace('<mass value="', '<mass value="-', 1)
    robot.write_text(text)
    status, out, _ = run("check", robot, "--repair", "out.urdf")
    assert status == 3
    assert "to be given by hand, as no tensor helps: link1" in out
    assert "mass not positive" in out
    assert "with 2 of 3 repaired" in out


def test_json(run, robot):
    status, out, _ = run("check", robot, "--json")
    found = json.loads(out)
    assert status == 3
    assert found["schema"] == "hefting.check/1"
    assert (found["impossible"], found["impossible_after_repair"]) == (2, 0)
    assert (found["file"], found["repaired"]) == (str(robot), None)
    assert "Frobenius" in found["metric"]
    links = {link["link"]: link for link in found["links"]}
    assert [link["possible"] for link in links.values()] == [1, 1, 0, 1, 0]
    assert links["link2"]["fault"]["code"] == "inertial-triangle"
    assert links["link2"]["nearest"] == (
        repair_inertias(robot).checks[2].nearest.tolist()
    )
    assert links["link1"]["nearest"] is None
    status, out, _ = run("check", robot, "--json", "--repair", "out.urdf")
    assert status == 0
    assert json.loads(out)["repaired"] == "out.urdf"


def test_doubts_of_one_kind_are_one_line(run, tmp_path):
    path = tmp_path / "robot.urdf"
    links = "".join(f'<link name="l{i}"/>' for i in range(5))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(4)
    )
    path.write_text(f"<robot>{links}{joints}</robot>")
    status, out, _ = run("check", path)
    assert status == 0
    assert out.count("warning: ") == 1
    assert "l1: joint 'j0' moves it" in out
    assert "(and 3 more like it: --json)" in " ".join(out.split())


def test_misuse_is_one_line(run, robot):
    assert refused(run("check", "none.urdf"), "none.urdf", "cannot be read")
    assert refused(run("check", robot, "--repair", robot), "is an input")
    assert refused(run("check", robot, "--repair", "no/out.urdf"), "folder")
    (robot.parent / "robot.xacro").write_text('<robot><link name="${p}a"/></robot>')
    assert refused(run("check", "robot.xacro"), "is xacro", "expand it first")
    assert not (robot.parent / "out.urdf").exists()


def test_help_ends_with_two_examples(run, robot):
    status, out, _ = run("check", "--help")
    assert status == 0
    assert [line.split()[:2] for line in out.splitlines()[-2:]] == [
        ["hefting", "check"]
    ] * 2


def test_what_controls_a_terminal_is_not_printed(run, tmp_path):
    """Of names, and of the lines of a diff."""
    path = tmp_path / "robot.urdf"
    text = random_robot(np.random.default_rng(2), ["triangle"])
    text = text.replace("link1", "a\u009bb").replace("      <mass", "\t\u202e<mass")
    path.write_text(text.replace("\n", "\r\n"), encoding="utf-8", newline="")
    status, out, _ = run("check", path, "--diff")
    assert status == 3
    assert out.count("a?b") == 2
    assert "\n \t?<mass" in out
    assert "\r\n" in out
    assert not {"\u009b", "\u202e"} & set(out)
