"""An experiment is one file and one line: its place in the list and on the page follow
from them."""

import pytest

pytest.importorskip(
    "mujoco", reason="MuJoCo is not installed (pip install 'hefting[sim]')"
)

from hefting.reproduction import EXPERIMENTS, FILES
from registries import PACKAGE, Copy

TOY = '''"""Toy: a number."""

from hefting.reproduction.experiment import Experiment, Report

EXPERIMENT = Experiment(
    name="toy",
    title="A toy",
    source="Nowhere",
    jobs=lambda quick: [{"seed": 1}],
    run=lambda job: {},
    report=lambda results: Report(()),
)
'''


def test_each_file_with_an_experiment_is_listed():
    files = (PACKAGE / "reproduction").glob("*.py")
    assert set(FILES) == {
        path.stem for path in files if "\nEXPERIMENT = " in path.read_text()
    }
    assert len(EXPERIMENTS) == len(FILES)
    assert all(experiment.name == name for name, experiment in EXPERIMENTS.items())


def test_a_new_experiment(tmp_path):
    copy = Copy(tmp_path)
    copy.add("reproduction/toy.py", TOY)
    copy.add_line("reproduction/__init__.py", '    "noise",', '    "toy",')
    said = copy.hefting("reproduce", "--list").splitlines()
    lines = [line for line in said if not line.startswith(" ")]
    assert [line.split()[0] for line in lines] == [
        *list(EXPERIMENTS)[:6],
        "toy",
        *list(EXPERIMENTS)[6:],
    ]
    assert lines[6].split(maxsplit=1)[1] == "A toy (Nowhere)"
