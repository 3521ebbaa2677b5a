"""A method is one file and one line: a toy, added to a copy of the source, is known
wherever methods are."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.estimators import (
    METHODS,
    VARIANTS,
    default_method,
    describe_methods,
    methods,
    options,
)
from hefting.estimators.base import INVARIANCES, ROLES
from hefting.logs import write_log
from hefting.simulation import UR5, simulate, sinusoids

SOURCE = Path(hefting.__file__).parent
LIST = "estimators/methods.py"
LINE = "from hefting.estimators.toy import Toy as Toy\n"
TOY = '''"""Toy: a ball that is as heavy as the mean force."""

from dataclasses import dataclass, field
from typing import ClassVar

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.estimators.base import BiasModel, require_samples
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.quadratic import Quadratic


@dataclass(frozen=True, eq=False)
class Toy(PointEstimator):
    """A ball that explains the wrench in scale alone."""

    consistent = True
    source = "nowhere"
    best_for = "a test"
    rank = 65
    variants: ClassVar = {"small": {"ball_radius": 0.01}}

    ball_radius: float = field(
        default=0.25, metadata={"help": "of the ball [m]; default 0.25, 100 % of it", "metavar": "R"}
    )
    bias: BiasModel = "none"

    @property
    def name(self):
        """Toy, or of the small ball."""
        return "Toy-small" if self.ball_radius == 0.01 else "Toy"

    def estimate(self, state):
        """The estimate."""
        require_samples(state.samples)
        J = 0.4 * self.ball_radius**2
        ball = InertialParameters([1, 0, 0, 0, J, 0, 0, J, 0, J])
        mass = Quadratic.of(state, None, self.bias == "estimate").measured_mass(ball.vector)
        found = Estimate(self.name, InertialParameters(mass * ball.vector), state.samples)
        return self.with_intervals(found, state)
'''
SCRIPT = """
import contextlib, io, json, sys

import hefting
from hefting.cli import main

log, said = sys.argv[1], {}
for name, words in {
    "methods": ["methods", "--verbose"],
    "json": ["methods", "--json"],
    "help": ["identify", "--help"],
    "identify": ["identify", log, "--method", "toy", "--ball-radius", "0.5", "--json"],
    "report": [
        "identify", log, "--method", "toy", "--ball-radius", "0.5", "--verbose"
    ],
    "wrong": ["identify", log, "--method", "OLS", "--ball-radius", "0.5"],
    "compare": ["identify", log, "--method", "all", "--json"],
}.items():
    sys.argv, out, error = ["hefting", *words], io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error), contextlib.suppress(SystemExit):
        main()
    said[name] = out.getvalue() + error.getvalue()
said["file"] = hefting.__file__
said["public"] = [hefting.Toy.__name__, "Toy" in dir(hefting), "Toy" in hefting.__all__]
print(json.dumps(said))
"""


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A second of a kilogram in motion."""
    ball = InertialParameters([1.0, 0, 0, 0, 0.1, 0, 0, 0.1, 0, 0.1])
    path = tmp_path_factory.mktemp("registry") / "log.csv"
    write_log(
        simulate(
            UR5.motion(sinusoids(1.0, 100.0, 1.0)),
            ball,
            noise=Noise(0.05, 0.002),
            seed=1,
        ),
        path,
    )
    return path


@pytest.fixture(scope="module")
def said(log, tmp_path_factory):
    """What the commands say with the toy: one file, and one line elsewhere."""
    folder = tmp_path_factory.mktemp("source")
    copy = folder / "hefting"
    shutil.copytree(SOURCE, copy)  # with what is compiled
    (copy / "estimators" / "toy.py").write_text(TOY)
    (copy / LIST).write_text((copy / LIST).read_text() + LINE)
    environment = os.environ | {
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        "COLUMNS": "200",
    }
    command = [sys.executable, "-c", SCRIPT, str(log)]
    out = subprocess.run(
        command, check=True, capture_output=True, text=True, env=environment, cwd=folder
    ).stdout
    said = json.loads(out)
    assert Path(said["file"]).parent == copy
    return said


def test_the_toy_is_listed(said):
    assert re.search(r"^\s*Toy\s+A ball that explains", said["methods"], re.MULTILINE)
    assert "OLS-reduced, LMI-ellipsoid, Toy-small" in " ".join(said["methods"].split())
    found = json.loads(said["json"])
    assert list(found) == ["Bayes", "PMD", "GEO", "HPS", "LMI", "OLS", "Toy", "RTLS"]
    own = {"ball_radius": 0.25, "bias": "none"}
    common = {
        "systematic": None,
        "carried": None,
        "sensor_accuracy": None,
        "mass": None,
        "noise_found": False,
        "intervals": True,
    }
    assert found["Toy"]["hyperparameters"] == own | common
    assert {
        name: of for name, of in found.items() if name != "Toy"
    } == describe_methods()


def test_its_hyperparameter_is_an_option(said):
    assert "--ball-radius R" in said["help"]
    assert "Toy: of the ball [m]; default 0.25, 100 % of it" in " ".join(
        said["help"].split()
    )
    found = json.loads(said["identify"])
    assert found["method"] == "Toy"
    assert found["provenance"]["ball_radius"] == 0.5
    # the noise of 100 samples makes 0.005
    assert found["mass"] == pytest.approx(1.0, abs=0.05)
    low, high = found["intervals"]["mass"]  # of any body, as its estimates are bodies
    assert 0.95 < low < found["mass"] < high < 1.05
    assert "ball_radius = 0.5" in said["report"]
    assert "OLS has no 'ball_radius'; Toy has it" in " ".join(said["wrong"].split())


def test_it_is_compared_and_public(said):
    assert {"Toy", "Toy-small"} <= {
        result["method"] for result in json.loads(said["compare"])["results"]
    }
    assert said["public"] == ["Toy", True, True]


def test_the_toy_is_gone():
    assert not hasattr(hefting, "Toy")
    assert "Toy" not in METHODS


def test_the_list_holds_methods_alone_and_each_says_what_it_must():
    classes = [
        value for name, value in vars(methods).items() if not name.startswith("_")
    ]
    assert set(classes) == set(METHODS.values())
    for name, kind in METHODS.items():
        assert "bias" in kind.hyperparameters(), name
        assert kind.role in ROLES
        assert kind.invariances <= set(INVARIANCES)
        assert kind.source
        assert kind.best_for
    assert len({kind.rank for kind in METHODS.values()}) == len(METHODS)


def test_the_methods_are_those_there_were():
    assert list(METHODS) == ["Bayes", "PMD", "GEO", "HPS", "LMI", "OLS", "RTLS"]
    assert list(VARIANTS) == [
        *(
            "PMD-full",
            "PMD-reduced",
            "GEO-blended",
            "GEO-reduced",
            "OLS-blended",
            "OLS-reduced",
            "LMI-ellipsoid",
        )
    ]
    assert VARIANTS["LMI-ellipsoid"] == ("LMI", {"ellipsoid": "shape"})
    assert (default_method(True), default_method(False)) == ("Bayes", "Bayes")
    assert list(options()) == ["c1", "regularization", "gamma"]


@pytest.mark.parametrize("kind", METHODS.values(), ids=METHODS)
def test_common_hyperparameters_are_checked_once_for_all(kind):
    names = kind.hyperparameters()
    needed = {"shape": "a hammer"} if "shape" in names else {}
    if needed:
        with pytest.raises(InputError, match="the shape must be a Shape"):
            kind(**needed)
    given = {"shape": None} if needed else {}
    with pytest.raises(InputError, match="unknown bias model 'some'"):
        kind(**given, bias="some")
    if "noise" in names:
        with pytest.raises(InputError, match="noise"):
            kind(**given, noise=-np.eye(6))


def test_an_option_of_several_methods_says_what_it_is_of_each(monkeypatch):
    """In the order of the methods; the first one's way of writing it is kept."""
    one = options()["gamma"]

    @dataclasses.dataclass
    class Toy:
        gamma: float = dataclasses.field(
            default=1.0, metadata={"help": "its own", "metavar": "G"}
        )

    more = {**METHODS, "Toy": Toy}
    monkeypatch.setattr("hefting.estimators.registry.METHODS", more)
    both = options()["gamma"]
    assert both.help == f"{one.help}; Toy: its own"
    assert both.metavar == one.metavar
    del more["GEO"]
    assert options()["gamma"].metavar == "G"
