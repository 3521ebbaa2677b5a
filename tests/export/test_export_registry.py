"""An export target is one file and one line: what is listed and written follows from
them."""

import re
from pathlib import Path

import pytest
from test_export_bodies import make

from commands import refused
from hefting.export import FILES, REGISTRY, SUFFIXES, TARGETS
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids
from registries import PACKAGE, Copy

README = (Path(__file__).parents[2] / "README.md").read_text()
NOT_TARGETS = {
    *("__init__", "body", "known", "notes", "principal", "splice"),
    "target",
}

TOY = '''"""Toy: the mass alone."""

from hefting.export.body import Body, number
from hefting.export.target import Target


def write(body: Body) -> str:
    """The mass [kg]."""
    return f"toy {number(body.mass)}\\n"


TARGET = Target(name="toy", description="a toy", suffixes=(".toy",), write=write, wants_flange=True)
'''


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with the toy target."""
    copy = Copy(tmp_path_factory.mktemp("toy"))
    copy.add("export/toy.py", TOY)
    copy.add_line("export/__init__.py", '    "ros2_control",', '    "toy",')
    return copy


@pytest.fixture(scope="module")
def estimate(copy):
    """File of an estimate, and the mass [kg] in it."""
    found = make("box", 0)[0]
    found.save(copy.folder / "estimate.json")
    return "estimate.json", found.parameters.mass


def test_each_file_is_listed_and_its_target_is_whole():
    assert (
        set(FILES)
        == {path.stem for path in (PACKAGE / "export").glob("*.py")} - NOT_TARGETS
    )
    assert all(
        any(name in file for file in FILES) for name in ("urdf", "ur", "estimate")
    )
    assert len(FILES) < len(REGISTRY)
    for name, target in REGISTRY.items():
        assert target.name == name == name.lower()
        assert (target.write is None) != (target.write_estimate is None)
        assert (target.place is None) == (target.inertial is None)
        assert all(suffix.startswith(".") for suffix in target.suffixes)
    suffixes = [suffix for target in REGISTRY.values() for suffix in target.suffixes]
    assert sorted(suffixes) == sorted(SUFFIXES)  # no two targets share one


def test_the_readme_names_every_target():
    words = set(re.findall(r"\w+", README.lower()))
    words |= set(re.findall(r"[\w-]+", README.lower()))
    assert set(TARGETS) <= words


def test_a_new_target_in_python(copy, estimate):
    file, mass = estimate
    code = (
        "from hefting.core.estimate import Estimate; from hefting.export import SUFFIXES, TARGETS, export; "
        f"found = export(Estimate.load({file!r}), 'toy'); "
        "print(TARGETS['toy'], SUFFIXES['.toy'], found.frame, *(w.code for w in found.warnings), found.text)"
    )
    assert copy.python("-c", code).split() == [
        "a",
        "toy",
        "toy",
        "sensor",
        "sensor-axes",
        "toy",
        repr(mass),
    ]


def test_a_new_target_on_the_command_line(copy, estimate):
    file, mass = estimate
    pose = ("--sensor-pose-in-flange", "0,0,0.03,0,0,0,1")
    exported, *helps = copy.hefting_each(
        ("export", file, "--to", "toy", *pose),
        ("export", "--help"),
        ("identify", "--help"),
    )
    assert exported == f"toy {mass!r}\n"  # 0.9 kg: one digit
    of_export, of_identify = (" ".join(text.split()) for text in helps)
    assert "ros2-control, toy, json or csv" in of_export
    assert ".usda, .toy, .csv or a picture" in of_identify


def test_a_new_target_by_its_suffix(copy):
    body = hammer().parameters
    write_log(
        simulate(UR5.motion(sinusoids(3.0, 100.0, 1.5)), body), copy.folder / "log.csv"
    )
    out = copy.hefting("identify", "log.csv", "--method", "OLS", "--output", "a.toy")
    assert "wrote a.toy (sensor axes)" in out
    assert "--sensor-pose-in-flange" in " ".join(out.split())
    word, mass = (copy.folder / "a.toy").read_text().split()
    assert word == "toy"
    assert float(mass) == pytest.approx(body.mass, rel=1e-3)  # no noise


def test_a_name_of_another_format_is_refused(run, copy, estimate, tmp_path):
    file = copy.folder / estimate[0]
    result = run("export", file, "--to", "mjcf", "--output", tmp_path / "x.urdf")
    assert refused(result, "x.urdf", "a file of urdf, not of mjcf", ".xml")
    words = ("--to", "urdf", "--output", tmp_path / "robot.xml")
    assert refused(run("export", file, *words), "not of urdf")
    (tmp_path / "r.xml").write_text("<robot><link name='a'/></robot>")
    status, _, _ = run(
        "export", file, *words, "--into", tmp_path / "r.xml", "--link", "a"
    )
    assert status == 0
    assert run("export", file, "--to", "ur", "--output", tmp_path / "x.txt")[0] == 0
    existing = tmp_path / "robot.urdf"
    existing.write_text("<robot/>")
    for name, of in (
        ("robot.urdf", "urdf"),
        ("ROBOT.URDF", "urdf"),
        ("robot.xml", "mjcf"),
        ("robot.mjcf", "mjcf"),
        ("robot.sdf", "sdf"),
        ("robot.usd", "usd"),
        ("robot.json", "franka-desk or json"),
        ("table.csv", "csv"),
    ):
        result = run("export", file, "--to", "ur", "--output", tmp_path / name)
        assert refused(result, f"{name}: is the name of a file of {of}, not of ur")
    assert existing.read_text() == "<robot/>"
    for name in ("a.usdc", "a.USDZ"):
        result = run("export", file, "--to", "usd", "--output", tmp_path / name)
        assert refused(result, f"{name}: is the name of a binary file", ".usda")
    for target, name in (
        ("franka-desk", "endeffector-config.json"),
        ("mjcf", "a.mjcf"),
        ("usd", "a.usd"),
        ("kuka", "a.dat"),
    ):
        output = tmp_path / name
        assert run("export", file, "--to", target, "--output", output)[0] == 0
