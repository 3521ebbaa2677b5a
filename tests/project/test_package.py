"""The package as it is published: wheel and source, each by itself."""

import subprocess
import sys
import tarfile
import zipfile

import pytest

import hefting
from hefting.core.errors import MissingDependencyError
from project.environments import ROOT, Environment, metadata_of

USES = {
    "batch": "import hefting.jobs.cluster, distributed",
    "docs": "import furo, myst_parser, numpydoc, sphinx, sphinx_copybutton, sphinx_gallery",
    "live": "import cyclonedds, foxglove, rosbags, websockets, zenoh",
    "plot": "import hefting.plots, matplotlib",
    "robot": "import hefting.torques.dynamics, pinocchio",
    "ros": "import hefting.logs.ros, rosbags",
    "sim": "import hefting.simulation, mujoco",
    "view": "import hefting.viewer, plotly, viser",
}
"""What an extra is there for."""
ABSENT = {
    "live": ("live", "ws://127.0.0.1:1"),
    "plot": ("identify", "log.csv", "--output", "out.png"),
    "ros": ("identify", "log.mcap"),
    "sim": ("simulate", "out.csv"),
    "view": ("view", "log.csv"),
}
"""Commands that need an extra."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Wheel and source archive."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, source


@pytest.fixture(scope="module")
def core(built, tmp_path_factory):
    """The wheel with what it needs at least."""
    folder = tmp_path_factory.mktemp("core")
    return Environment(folder / "env", built[0])


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A short recording, as a table and as a bag."""
    folder = tmp_path_factory.mktemp("log")
    for name in ("log.csv", "log.mcap"):
        hefting.write_log(_recording(), folder / name)
    return folder


def _recording():
    from hefting.core.measurements import Noise
    from hefting.simulation import UR5, hammer, simulate, sinusoids

    motion = UR5.motion(sinusoids(6.0, 100.0, 1.0))
    return simulate(motion, hammer().parameters, noise=Noise(0.05, 0.0025), seed=1)


def test_the_wheel_holds_the_package_and_nothing_else(built):
    with zipfile.ZipFile(built[0]) as wheel:
        names = wheel.namelist()
    said = metadata_of(built[0])
    assert {"hefting/py.typed", "hefting/__init__.pyi"} <= set(names)
    tops = {name.split("/")[0] for name in names}
    assert tops == {"hefting", f"hefting-{hefting.__version__}.dist-info"}
    kept = {path for path in (ROOT / "src").rglob("*.py*") if path.suffix != ".pyc"}
    own = {name for name in names if name.startswith("hefting/")}
    assert {str(path.relative_to(ROOT / "src")) for path in kept} <= own
    assert said["Version"] == hefting.__version__
    assert said["License-Expression"] == "Apache-2.0"
    assert set(said.get_all("Provides-Extra")) == {*USES, "all"}


def test_the_wheel_is_small(built):
    """Some 440 files of Python; half of it is documentation. A mistake that is named takes
    2 kB."""
    assert built[0].stat().st_size < 1.295e6


def test_the_source_builds_the_same_wheel(built, tmp_path):
    """And holds what its tests need."""
    with tarfile.open(built[1]) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    for name in (
        "tests/conftest.py",
        "benchmarks/problem.py",
        "docs/live.md",
        "examples/own_arrays.py",
    ):
        assert (folder / name).is_file()
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d"]
    subprocess.run(
        [*command, str(tmp_path)], cwd=folder, check=True, capture_output=True
    )
    (again,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(again) as own, zipfile.ZipFile(built[0]) as wheel:
        assert {i.filename: i.CRC for i in own.infolist()} == {
            i.filename: i.CRC for i in wheel.infolist()
        }


def test_the_core_alone_identifies(core, log):
    assert "No broken requirements" in core.check()
    done = core.run("-m", "hefting", "identify", "log.csv", cwd=log)
    assert done.returncode == 0, done.stderr
    assert "mass" in done.stdout


@pytest.mark.parametrize("extra", ABSENT)
def test_an_absent_extra_says_what_to_install(core, log, extra):
    done = core.run("-m", "hefting", *ABSENT[extra], cwd=log)
    said = done.stderr.strip()
    assert done.returncode in (1, 2)
    assert len(said.splitlines()) == 1
    command = str(MissingDependencyError("", extra)).split("run: ")[1]
    assert command in said


@pytest.mark.parametrize("extra", USES)
def test_an_extra_is_whole(built, tmp_path, extra):
    own = Environment(tmp_path / "env", built[0], extra)
    done = own.run("-c", USES[extra], cwd=tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("extra", ["all", "docs"])
def test_what_the_extras_need_is_there_as_they_ask(built, tmp_path, extra):
    """Each other extra alone is a part of all."""
    own = Environment(tmp_path, built[0], extra)
    assert "No broken requirements" in own.check()
