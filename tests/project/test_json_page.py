"""docs/json.md: it names every key that a command prints, and no other."""

import inspect
import re
from pathlib import Path

import pytest

import hefting
from hefting.core.inertia import InertialParameters
from hefting.estimators import describe_methods
from hefting.identification.agreement import Agreement
from hefting.logs import write_log
from hefting.planning.result import Plan
from hefting.planning.space import FAR
from hefting.robots import repair_inertias
from hefting.simulation import UR5, simulate, sinusoids
from plans import random_plan

PAGE = (Path(__file__).parents[2] / "docs" / "json.md").read_text()
SECTIONS = dict(re.findall(r"## ([^\n]+)\n(.*?)(?=\n## |\Z)", PAGE, flags=re.DOTALL))
BODY = InertialParameters.from_points([[0.0, 0.0, 0.1], [0.05, 0.0, 0.2]], [0.4, 0.3])
BY_NAME = {"streams": "wrench", "extremes": "fx", "signal_to_noise": "force"}
"""Keys whose own keys are names, with one of them."""

OWN_KEYS = {"provenance", "settings", "hyperparameters", "verdicts", "doubts"}
"""Keys whose own keys are not those of the page."""


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What each command prints of a recording of 4 s, of a link and of a batch."""
    folder = tmp_path_factory.mktemp("printed")
    log = simulate(UR5.motion(sinusoids(4.0, 50.0, 1.0)), BODY)
    found = hefting.identify(log)
    write_log(log, folder / "log.csv")
    arm = folder / "arm.urdf"
    arm.write_text(
        '<robot name="arm"><link name="flat"><inertial><mass value="1"/><inertia '
        'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3"/></inertial></link></robot>'
    )
    many = hefting.batch([folder / "log.csv", folder / "no.csv"], folder / "results")
    agreement = Agreement.of({"a": found.estimate, "b": found.estimate})
    return {
        # the command adds the errors with --truth
        "identify, calibrate": found.estimate.to_dict() | {"errors": None},
        "inspect": hefting.inspect(log).to_dict(),
        "predict": hefting.predict(found.estimate, log).to_dict(),
        "compare": agreement.to_dict(),
        "plan": random_plan(2).to_dict(),
        # the command adds the file of --repair
        "check": repair_inertias(arm).to_dict() | {"repaired": None},
        "batch": many.to_dict(),
        "methods": describe_methods()["Bayes"],
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
        if name not in OWN_KEYS:
            assert keys_below(name, value) <= anywhere, name


def test_it_says_from_where_on_no_clearance_is_computed():
    assert f"where {FAR:g} is {FAR:g} m or more" in SECTIONS["plan"]
    assert f"{FAR:g} stands for {FAR:g} or more" in inspect.getsource(Plan)


def test_it_names_the_axes_of_a_links_inertia(printed):
    told = SECTIONS["check"]
    assert "axes of the inertial's own `<origin>`" in told
    for name in printed["check"]["links"][0]:
        assert f"`{name}`" in told
