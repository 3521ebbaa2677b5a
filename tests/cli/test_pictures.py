"""Pictures from the command line: of one's own data, and of a shape before anything is
identified."""

import json
import re
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip(
    "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
)

from commands import refused
from hasty_pictures import draw_hastily
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.identification import identify
from hefting.logs import read_log, write_log
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

pytestmark = pytest.mark.usefixtures("same_commands")

HELD = "0,-0.08,0.06,-0.7071068,0,0,0.7071068"


@pytest.fixture(autouse=True)
def hasty(monkeypatch):
    """What is in the pictures is tested in plots/."""
    draw_hastily(monkeypatch)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log, one whose quaternions have w first, one of static poses, the mesh, an
    estimate."""
    folder = tmp_path_factory.mktemp("pictures")
    motion = UR5.motion(sinusoids(4.0, 40.0, 1.0))
    log = simulate(motion, hammer().parameters.moved(POSE), seed=1)
    write_log(log, folder / "log.csv")
    poses = {name: log[name][::20] for name in ("orientation", "wrench")}
    write_log(Recording(poses, static=True), folder / "static.csv")
    q = log["orientation"]
    turned = dict(log.streams) | {
        "orientation": Stream(q.time, q.values[:, [3, 0, 1, 2]])
    }
    write_log(Recording(turned), folder / "w_first.csv")
    mesh = hammer().mesh()
    (folder / "hammer.stl").write_bytes(
        mesh.copy().apply_scale(1e3).export(file_type="stl")
    )
    shape = Shape.from_mesh(mesh, pose=POSE)
    identify(read_log(folder / "log.csv"), shape).estimate.save(folder / "e.json")
    return folder


def shape_of(folder, pose=HELD):
    return "--shape", folder / "hammer.stl", "--unit", "mm", "--object-pose", pose


def is_picture(path):
    data = path.read_bytes()
    if path.suffix == ".svg":
        return ElementTree.fromstring(data).tag.endswith("svg")
    return data.startswith(b"%PDF" if path.suffix == ".pdf" else b"\x89PNG")


# hefting identify


@pytest.mark.parametrize(
    ("log", "known"),
    [
        ("log.csv", "shape"),
        ("log.csv", "box"),
        ("static.csv", "shape"),
        ("static.csv", "nothing"),
    ],
)
def test_identify_draws_any_log(run, folder, tmp_path, log, known):
    given = {
        "shape": shape_of(folder),
        "box": ("--shape", "box:-0.1,0.1,-0.1,0.3,0,0.1"),
        "nothing": (),
    }[known]
    path = tmp_path / "found.png"
    status, out, err = run("identify", folder / log, *given, "--output", path)
    assert (status, err) == (0, "")
    assert f"wrote {path}" in out.splitlines()
    assert is_picture(path)


def test_every_format_the_same_every_time_beside_an_estimate(run, folder, tmp_path):
    names = ("a.png", "a.svg", "a.PDF", "a.json")
    outputs = [word for name in names for word in ("--output", tmp_path / name)]
    words = ("identify", folder / "log.csv", *shape_of(folder), *outputs)
    assert run(*words)[0] == 0
    before = [(tmp_path / name).read_bytes() for name in names]
    assert run(*words)[0] == 0
    assert [(tmp_path / name).read_bytes() for name in names] == before
    assert is_picture(tmp_path / "a.png")
    assert is_picture(tmp_path / "a.svg")
    assert before[2].startswith(b"%PDF")


def test_json_stays_one_object(run, folder, tmp_path):
    path = tmp_path / "a.svg"
    words = ("identify", folder / "log.csv", "--json", "--output", path)
    status, out, _ = run(*words)
    assert status == 0
    assert json.loads(out)["verdict"] == "good"
    assert is_picture(path)


def test_of_several_methods_the_recommended_one_is_drawn(run, folder, tmp_path):
    path = tmp_path / "a.svg"
    words = ("identify", folder / "log.csv", "--method", "OLS,LMI", "--output", path)
    assert run(*words)[0] == 0
    assert is_picture(path)


def test_what_is_not_to_be_used_is_drawn_and_says_so(
    run, folder, tmp_path, monkeypatch
):
    import hefting.plots.style as drawn

    said = []
    write = drawn.write_headline
    monkeypatch.setattr(
        drawn,
        "write_headline",
        lambda figure, lines, usable: (
            said.append((lines, usable)) or write(figure, lines, usable)
        ),
    )
    path, urdf = tmp_path / "a.png", tmp_path / "a.urdf"
    words = ("identify", folder / "w_first.csv", "--output", path, "--output", urdf)
    status, _, err = run(*words)
    assert status == 3
    assert is_picture(path)
    assert not urdf.exists()
    assert str(urdf) in err
    ((lines, usable),) = said
    assert not usable
    assert "do not use" in lines[0]
    assert "quaternions" in " ".join(lines)


def test_nothing_is_written_unless_all_can_be(run, folder, tmp_path):
    path = tmp_path / "a.png"
    words = ("identify", folder / "log.csv", "--output", path)
    assert refused(run(*words, "--output", tmp_path / "a.gif"), "not an output format")
    assert refused(run(*words, "--output", folder / "log.csv"), "is an input")
    assert refused(run(*words, "--output", tmp_path / "no" / "a.png"), "folder")
    assert not path.exists()


def test_without_matplotlib_it_is_said_before_anything_is_done(
    run, folder, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    path = tmp_path / "a.png"
    for words in (("identify", tmp_path / "no.csv"), ("show", "--shape", "no.stl")):
        status, out, err = run(*words, "--output", path)
        assert (status, out, err.count("\n")) == (1, "", 1)
        assert "pip install 'hefting[plot]'" in err
        assert not path.exists()


def test_without_matplotlib_the_demo_leaves_pictures_out(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    status, out, err = run("demo", "--output", tmp_path / "demo")
    assert (status, err) == (0, "")
    assert "verdict: good" in out
    assert out.endswith("without pictures: pip install 'hefting[plot]'\n")
    assert not list(tmp_path.glob("demo/*.png"))
    status, out, err = run("reproduce", "--quick", "--output", tmp_path / "all")
    assert (status, out) == (1, "")
    assert "pip install 'hefting[plot]'" in err
    assert not (tmp_path / "all").exists()


# hefting show


def test_show_draws_a_shape_and_says_where_it_is(run, folder, tmp_path):
    path = tmp_path / "shape.svg"
    status, out, err = run("show", *shape_of(folder), "--output", path)
    assert (status, err) == (0, "")
    low, high = 1e3 * hammer().mesh().apply_transform(POSE).bounds
    first, second, last = out.splitlines()
    # seven digits of the quaternion
    for axis, a, b in zip("xyz", low, high, strict=True):
        assert f"{axis} {a:.1f} to {b:.1f}".replace("-", "−") in first
    assert second.startswith("COM of uniform density")
    assert last == f"wrote {path}"
    assert is_picture(path)


def test_show_tells_a_wrong_pose_by_the_log(run, folder, tmp_path):
    """Turned by half a turn the COM that the log tells is not in the shape."""
    end = ("--output", tmp_path / "a.png")
    right = run("show", folder / "log.csv", *shape_of(folder), *end)
    assert right[0] == 0
    assert "inside the convex hull" in right[1]
    assert "are pose and unit right?" not in right[1]
    turned = shape_of(folder, "0,-0.08,0.06,0.7071068,0,0,0.7071068")
    wrong = run("show", folder / "log.csv", *turned, *end)
    assert wrong[0] == 0
    assert "outside the convex hull: are pose and unit right?" in wrong[1]


def test_show_tells_of_the_log_less_the_tool(run, folder, tmp_path):
    """Of a tool that is given, or of the one that the estimate was made beside."""
    tool = InertialParameters.from_com(0.3, (0.0, 0.0, -0.2), 1e-3 * np.eye(3))
    Estimate("OLS", tool, 100).save(tmp_path / "tool.json")
    made = {"tool": list(tool.vector)}
    body = hammer().parameters.moved(POSE)
    Estimate("OLS", body, 100, provenance=made).save(tmp_path / "e.json")
    left = InertialParameters(body.vector - tool.vector).center_of_mass
    for word, name in (("--tool", "tool.json"), ("--estimate", "e.json")):
        more = (word, tmp_path / name, "--output", tmp_path / "a.png")
        status, out, _ = run("show", folder / "log.csv", *shape_of(folder), *more)
        assert status == 0
        said = " ".join(out.split()).partition("less the tool: ")[2]
        told = re.findall(r"[xyz] (\S+)(?: ±|,)", said)[:3]
        # mm: of a log without noise, smoothed
        np.testing.assert_allclose(
            [float(x.replace("−", "-")) for x in told], 1e3 * left, atol=1.0
        )


def test_show_draws_an_estimate(run, folder, tmp_path):
    path = tmp_path / "a.pdf"
    words = ("--estimate", folder / "e.json", "--output", path)
    status, out, _ = run("show", *shape_of(folder), *words)
    assert status == 0
    center = 1e3 * Estimate.load(folder / "e.json").parameters.center_of_mass
    line = next(line for line in out.splitlines() if line.startswith("estimate"))
    assert f"y {center[1]:.0f}" in line.replace(".", " ") or f"{center[1]:.1f}" in line
    assert is_picture(path)


@pytest.mark.parametrize("kind", ["box", "cloud"])
def test_show_draws_shapes_of_every_kind(run, tmp_path, kind):
    spec = "box:-0.1,0.1,-0.1,0.1,0,0.2"
    if kind == "cloud":
        spec = tmp_path / "cloud.npy"
        np.save(spec, np.random.default_rng(1).uniform(0.0, 0.1, (5000, 3)))
    path = tmp_path / "a.png"
    assert run("show", "--shape", spec, "--output", path)[0] == 0
    assert is_picture(path)


def test_show_refuses_in_one_line(run, folder, tmp_path):
    shape = shape_of(folder)
    assert refused(run("show", *shape, "--output", "a.jpg"), "not a picture format")
    assert refused(run("show", *shape, "--output", folder / "no" / "a.png"), "folder")
    path = tmp_path / "a.png"
    assert refused(run("show", "--output", path), "--shape")
    gone = run("show", "--shape", tmp_path / "no.stl", "--output", path)
    assert refused(gone, "no.stl")
    # what would have been passed over
    for option in ("--tool", "--gravity", "--pose-topic", "--map"):
        lonely = run("show", *shape, option, "x", "--output", path)
        assert refused(lonely, f"{option}: there is no log; give LOG, or leave it out")
    assert not path.exists()
