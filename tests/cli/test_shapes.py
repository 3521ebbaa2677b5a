"""--box and --hull: the same as what they stand for."""

import json

import pytest

from commands import refused
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log and the mesh, whole and with a hole."""
    folder = tmp_path_factory.mktemp("shapes")
    held = hammer()
    motion = UR5.motion(sinusoids(4.0, 50.0, 1.0))
    write_log(simulate(motion, held.parameters), folder / "log.csv")
    mesh = held.mesh()
    mesh.export(folder / "whole.stl")
    mesh.convex_hull.export(folder / "hull.stl")
    return folder


def vector(run, folder, *words):
    status, out, err = run("identify", folder / "log.csv", "--json", *words)
    assert (status, err) == (0, "")
    return json.loads(out)["vector"]


@pytest.mark.parametrize("text", ["0.2,0.4,0.6", "20cm,400mm,0.6m", "0.2,40cm,.6"])
def test_a_box_is_centred_at_the_pose(run, folder, text):
    one = vector(run, folder, "--box", text, "--object-pose", "0.1,0,0.2,0,0,0,1")
    other = vector(run, folder, "--shape", "box:0,0.2,-0.2,0.2,-0.1,0.5")
    # the same corners up to rounding of the sums
    assert one == pytest.approx(other, rel=1e-6, abs=1e-9)


def test_a_turned_box_is_the_box_with_its_sides_exchanged(run, folder):
    turned = "0,0,0,0,0,0.7071067811865476,0.7071067811865476"
    one = vector(run, folder, "--box", "0.4,0.2,0.8", "--object-pose", turned)
    other = vector(run, folder, "--box", "0.2,0.4,0.8")
    # its points are another grid of as many; the estimate moves by less than a percent
    # of the intervals, which are some percent of the inertia
    assert one[:4] == pytest.approx(other[:4], rel=1e-3, abs=1e-4)


def test_the_hull_of_a_mesh_is_a_rough_shape(run, folder):
    one = vector(run, folder, "--shape", folder / "whole.stl", "--hull")
    other = vector(run, folder, "--shape", folder / "hull.stl", "--shape-std", "20%")
    # the same hull, written with other triangles
    assert one == pytest.approx(other, rel=1e-3, abs=1e-5)
    assert one != vector(run, folder, "--shape", folder / "whole.stl")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--box", "1,2"), ("--box", "0.1,0.2,0.3")),
        (("--box", "1,2,-3"), ("--box", "'1,2,-3'")),
        (("--box", "1,2,0"), ("--box", "not three lengths")),
        (("--box", "1,2,3", "--shape", "a.stl"), ("--shape", "beside --box")),
        (("--hull",), ("--hull", "--shape FILE")),
        (("--hull", "--shape", "box:0,1,0,1,0,1"), ("--hull",)),
    ],
)
def test_mistakes(run, folder, words, said):
    assert refused(run("identify", folder / "log.csv", *words), *said)
