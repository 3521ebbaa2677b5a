"""docs/json.md: it names every key that a command prints, and no other."""

import re
from pathlib import Path

import pytest

import hefting
from hefting.core.inertia import InertialParameters
from hefting.identification.agreement import Agreement
from hefting.simulation import UR5, simulate, sinusoids
from plans import random_plan

PAGE = (Path(__file__).parents[2] / "docs" / "json.md").read_text()
SECTIONS = dict(re.findall(r"## ([^\n]+)\n(.*?)(?=\n## |\Z)", PAGE, flags=re.DOTALL))
BODY = InertialParameters.from_points([[0.0, 0.0, 0.1], [0.05, 0.0, 0.2]], [0.4, 0.3])
BY_NAME = {"streams": "wrench", "extremes": "fx", "signal_to_noise": "force"}
"""Keys whose own keys are names, with one of them."""


@pytest.fixture(scope="module")
def printed():
    """What each command prints of a recording of 4 s."""
    log = simulate(UR5.motion(sinusoids(4.0, 50.0, 1.0)), BODY)
    found = hefting.identify(log)
    agreement = Agreement.of({"a": found.estimate, "b": found.estimate})
    return {
        "identify, calibrate": found.estimate.to_dict(),
        "inspect": hefting.inspect(log).to_dict(),
        "predict": hefting.predict(found.estimate, log).to_dict(),
        "compare": agreement.to_dict(),
        "plan": random_plan(2).to_dict(),
    }


def keys_below(name, value):
    """Keys of a value that is no table of names, or of its first member."""
    value = value.get(BY_NAME[name], value) if name in BY_NAME else value
    value = value[0] if isinstance(value, list) and value else value
    return set(value) if isinstance(value, dict) else set()


@pytest.mark.parametrize("section", SECTIONS)
def test_the_page_names_every_key(section, printed):
    told = SECTIONS[section]
    first = {
        name
        for row in re.findall(r"^\| (`[^|]*) \|", told, flags=re.MULTILINE)
        for name in re.findall(r"`(\w+)`", row)
    }
    assert first == set(printed[section])
    anywhere = set(re.findall(r"`(\w+)`", told))
    for name, value in printed[section].items():
        if name not in ("provenance", "settings"):
            assert keys_below(name, value) <= anywhere, name
