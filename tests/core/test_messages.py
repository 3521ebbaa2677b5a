"""Messages: text that programs can tell apart."""

import copy
import json
import pickle

from hefting.core.messages import Message, codes, note, warning


def test_a_message_is_its_text_and_more():
    said = warning("gravity-reversed", "check `gravity`", "gravity")
    assert said == "check `gravity`"
    assert json.dumps([said]) == '["check `gravity`"]'
    assert (said.code, said.severity, said.argument) == (
        "gravity-reversed",
        "warning",
        "gravity",
    )
    assert said.to_dict() == {
        "code": "gravity-reversed",
        "severity": "warning",
        "text": "check `gravity`",
        "argument": "gravity",
    }
    assert note("clock-offset", "late").severity == "note"


def test_copies_keep_the_code():
    """Worker processes send them."""
    said = warning("spikes", "47 spikes left out")
    for other in (
        copy.copy(said),
        copy.deepcopy(said),
        pickle.loads(pickle.dumps(said)),
    ):
        assert isinstance(other, Message)
        assert other.to_dict() == said.to_dict()


def test_codes_of_those_that_have_one():
    assert codes([warning("a", "x"), note("b", "y"), "plain"]) == {"a", "b"}


def test_no_message_controls_a_terminal():
    """Names in a file may hold anything."""
    said = warning("stream-left-out", "/wrench\x1b[31m\x07: left out")
    assert said == "/wrench?[31m?: left out"
    assert said.about(["a\rb"]) == "a?b: /wrench?[31m?: left out"
