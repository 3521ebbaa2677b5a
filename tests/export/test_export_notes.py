"""Comments: verdict and warnings are repeated, and no text of an estimate's file can
leave its comment."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from test_export_bodies import CONTROLLERS, make
from test_export_controllers import READERS, WITHOUT_COMMENTS

from hefting.cli import render
from hefting.core.messages import note, warning
from hefting.export import export
from hefting.export.known import LONGEST, MOST, notes_of, plain, with_comment

MARKS = {"kuka": ";", "abb": "!", "fanuc": "!", "franka": "//", "doosan": "//"}
HOSTILE = (
    "a -->\n<link name='b'/> <!-- c",
    "x\nset_standard_digital_out(0, True)\r\narm.reset() \u2028 MoveJ p\x0b;\x85 y",
    '"""\n) def Xform "evil" { } \\" \'\'\'',
    "*/ system(); /* ${jndi} %s --",
    "{{}} {mass: 9}",
)


@pytest.fixture
def estimate():
    return replace(
        make("box", 0)[0],
        warnings=tuple(warning("no-shape", text) for text in HOSTILE)
        + tuple(warning("torque-units", text) for text in HOSTILE),
    )


def test_verdict_reasons_and_warnings():
    doubt = warning("torque-units", "turn it by 3° ± 1°: give `gravity`")
    quiet = warning("no-shape", "no shape given")
    found = replace(
        make("box", 0)[0],
        warnings=(quiet, doubt),
        provenance={"notes": [note("pose-source", "pose from tf")]},
    )
    assert notes_of(found) == (
        "estimate: usable with care",
        "- turn it by 3 deg +/- 1 deg: give gravity",
        "warning: no shape given",
    )
    text = " ".join(export(found, "urdf").text.split())
    assert "turn it by 3 deg +/- 1 deg: give gravity warning: no shape given" in text


def test_a_command_spells_options_which_end_no_comment(estimate):
    doubt = warning("torque-units", "turn it: give `gravity`='estimate' ---")
    found = replace(estimate, warnings=(doubt,))
    assert "give --gravity estimate ---" in export(found, "ur", say=render).text
    for target in ("urdf", "mjcf", "sdf"):
        text = export(found, target, say=render).text
        ElementTree.fromstring(text)
        assert "give gravity estimate" in text


def test_lines_and_their_number_are_bounded():
    assert len(plain("a" * 10**6)) == LONGEST
    many = replace(make("box", 0)[0], warnings=("w",) * 10**4)
    assert len(notes_of(many)) == MOST + 1
    longest = max(map(len, export(many, "abb").text.splitlines()))
    assert longest < 249  # what RAPID takes


@pytest.mark.parametrize(
    "target", [t for t in CONTROLLERS if t not in WITHOUT_COMMENTS]
)
def test_no_text_becomes_a_line_of_a_program(target, estimate):
    quiet = replace(estimate, warnings=())
    lines, expected = (
        [
            line
            for line in export(e, target).text.splitlines()
            if not line.startswith(MARKS.get(target, "#"))
        ]
        for e in (estimate, quiet)
    )
    assert lines == expected
    assert READERS[target](export(estimate, target).text)[0] == 0.9
    assert export(estimate, target).text.isascii()


def test_no_text_becomes_an_element(estimate):
    for target, path in (
        ("urdf", "link"),
        ("mjcf", "worldbody/body"),
        ("sdf", "model/link"),
    ):
        found, expected = (
            [
                (element.tag, element.attrib)
                for element in ElementTree.fromstring(export(e, target).text).iter()
            ]
            for e in (estimate, replace(estimate, warnings=()))
        )
        assert found == expected, path


def test_no_text_becomes_a_prim(estimate):
    pytest.importorskip("pxr")
    from pxr import Usd  # pyright: ignore[reportMissingImports]

    stage = Usd.Stage.CreateInMemory()
    assert stage.GetRootLayer().ImportFromString(export(estimate, "usd").text)
    assert [prim.GetName() for prim in stage.Traverse()] == ["object"]
    assert "usable with care" in stage.GetRootLayer().documentation


def test_no_text_becomes_a_parameter(estimate):
    quiet = replace(estimate, warnings=())
    found, expected = (
        yaml.safe_load(export(e, "ros2-control").text) for e in (estimate, quiet)
    )
    assert found == expected


def test_a_comment_goes_into_the_element():
    doubt = ("estimate: usable with care", "- a")
    assert with_comment("<a/>", ("estimate: good",)) == "<a/>"
    for element in ("<inertial mass='1'/>", "<inertial>\n  <mass/>\n</inertial>"):
        text = with_comment(element, doubt)
        assert text.count("<!--") == 1
        plain_, commented = (ElementTree.fromstring(t) for t in (element, text))
        assert commented.attrib == plain_.attrib
        assert [e.tag for e in commented] == [e.tag for e in plain_]


@pytest.mark.parametrize("target", ["ur", "franka", "urdf"])
def test_a_subtracted_tool_is_told(target):
    """The arm carries it too, and a payload without it is too light."""
    tool = [0.64, *[0.0] * 9]
    found = replace(make("box", 0)[0], provenance={"tool": tool})
    alone = replace(found, provenance={})
    pose = None if target == "urdf" else np.eye(4)
    exported = export(found, target, pose)
    said = [each.code for each in exported.warnings]
    assert ("tool-left-out" in said) == (target != "urdf")
    assert "tool-left-out" not in [e.code for e in export(alone, target, pose).warnings]
    if target != "franka":  # whose JSON has no comments
        assert exported.text.count("the tool of 0.64 kg that was subtracted") == 1
        assert "subtracted" not in export(alone, target, pose).text
    hostile = replace(found, provenance={"tool": ["x"] * 10})
    assert export(hostile, target, pose).text == export(alone, target, pose).text
    # of joint torques with an empty run
    empty = export(replace(found, provenance={"arm": "empty runs"}), target, pose)
    codes = [each.code for each in empty.warnings]
    assert ("tool-left-out" in codes) == (target != "urdf")
    assert "in the empty run" in f"{empty.text} {empty.warnings}"


@pytest.mark.parametrize(
    "pose", ["0,0,0.03,0,0,0,1", "0,0,30mm", [0, 0, 0.03, 0, 0, 0, 1]]
)
def test_a_pose_is_given_as_to_identify(pose):
    matrix = np.eye(4)
    matrix[2, 3] = 0.03
    estimate = make("box", 0)[0]
    assert export(estimate, "UR", pose).text == export(estimate, "ur", matrix).text


def test_a_pose_in_millimetres_is_told():
    pose = np.eye(4)
    pose[2, 3] = 30.0
    said = [each.code for each in export(make("box", 0)[0], "ur", pose).warnings]
    assert "com-far" in said
