"""docs/extending.md: what it adds to the package works as it says, in a copy."""

import json
import re
import shlex
import tomllib
from pathlib import Path

import pytest

from hefting.logs import read_log
from hefting.simulation import demo
from registries import Copy

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text()
BLOCKS = re.findall(
    r"^`src/hefting/([\w/]+\.py)`[^\n]*:\n\n```(?:python|text)\n(.*?)```",
    PAGE,
    re.DOTALL | re.MULTILINE,
)
"""File of the package and text of each block; of an existing file, a line that it has,
and those below it."""
COMMANDS = [
    shlex.split(line)[1:]
    for text in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    for line in text.splitlines()
]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with all that the page adds, and files for its commands."""
    copy = Copy(tmp_path_factory.mktemp("extended"))
    for file, text in BLOCKS:
        if (copy.folder / "hefting" / file).exists():
            line, *new = text.splitlines()
            for each in reversed(new):
                copy.add_line(file, line, each)
        else:
            copy.add(file, text)
    made = demo.run(copy.folder, pictures=False)
    made.estimate.save(copy.folder / "held.json")
    log = read_log(made.log)
    rows = [
        {"time": float(t)}
        | {name: s.values[k].tolist() for name, s in log.streams.items()}
        for k, t in enumerate(log["wrench"].time)
    ]
    (copy.folder / "log.samples").write_text("\n".join(map(json.dumps, rows)) + "\n")
    return copy


@pytest.fixture(scope="module")
def said(copy):
    """What each command of the page prints, by the command."""
    texts = copy.hefting_each(*map(tuple, COMMANDS))
    return {" ".join(words): text for words, text in zip(COMMANDS, texts, strict=True)}


def test_the_page_adds_three_things():
    assert [file for file, _ in BLOCKS] == [
        *("estimators/uniform.py", "estimators/methods.py"),
        *("logs/json_log.py", "logs/registry.py"),
        *("export/toml_file.py", "export/__init__.py"),
    ]


def test_the_method(said):
    """The mass is that of the demo; one density is wrong for its COM by 8 mm, so the mass
    is off a little."""
    assert "Uniform" in said["methods"]
    (text,) = (text for words, text in said.items() if "--method uniform" in words)
    found = json.loads(text)
    assert found["method"] == "Uniform"
    assert found["physically_consistent"]
    assert found["mass"] == pytest.approx(0.67, rel=0.1)


def test_the_format(copy, said):
    assert "wrench" in said["inspect log.samples"]
    again = read_log(copy.folder / "again.csv")
    log = read_log(copy.folder / "log.csv")
    for name, stream in log.streams.items():
        assert (again[name].values == stream.values).all(), name
    bad = copy.folder / "bad.samples"
    bad.write_text('{"time": 0.0, "wrench": [1]}\n')
    code = f"import hefting; hefting.read_log({bad.name!r})"
    with pytest.raises(
        AssertionError, match=r"bad.samples, line 1: wrench has 1 numbers"
    ):
        copy.python("-c", code)


def test_the_target(copy, said):
    held = tomllib.loads((copy.folder / "held.toml").read_text())["payload"]
    assert held["frame"] == "sensor"
    assert held["mass"] == pytest.approx(0.67, rel=0.02)
    (text,) = (text for words, text in said.items() if words.startswith("export"))
    flange = tomllib.loads(text)["payload"]
    assert flange["frame"] == "flange"
    # the sensor is 30 mm ahead of the flange
    assert flange["center_of_mass"][2] == pytest.approx(0.09, abs=0.001)
    assert len(flange["inertia"]) == 6
