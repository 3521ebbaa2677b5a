"""Pairs of links that an SRDF leaves out."""

import pytest

from hefting.core.errors import InputError
from hefting.planning.solids import read_disabled_pairs

LINKS = ("a", "b", "c")


def test_pairs_of_known_links_are_read(tmp_path):
    path = tmp_path / "r.srdf"
    path.write_text(
        '<robot name="r"><group name="g"/>'
        '<disable_collisions link1="a" link2="b" reason="Never"/>'
        '<disable_collisions link1="c" link2="elsewhere"/></robot>'
    )
    assert read_disabled_pairs(path, LINKS) == {frozenset("ab")}


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("<robot/>", "no <disable_collisions>"),
        ("<model/>", "is not SRDF"),
        ("<robot>", "not well-formed"),
        ("<!DOCTYPE r><robot/>", "document type"),
        ('<robot xmlns:xacro="x"><xacro:a/></robot>', "is xacro, not SRDF; expand it"),
        ('<robot><disable_collisions link1="x" link2="y"/></robot>', "of this robot"),
    ],
)
def test_others_are_refused(tmp_path, text, what):
    path = tmp_path / "r.srdf"
    path.write_text(text)
    with pytest.raises(InputError, match=what):
        read_disabled_pairs(path, LINKS)
