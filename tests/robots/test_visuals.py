"""What links look like: parts, meshes from the URDF's own folder alone, and one line for
what is wrong."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.robots.arm import MOST_PARTS, mesh_file, read_geometries


def robot(inner, name="tip"):
    return f"<robot name='r'><link name='{name}'>{inner}</link></robot>"


def visual(geometry, origin=""):
    return f"<visual>{origin}<geometry>{geometry}</geometry></visual>"


def read(tmp_path, text):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    return read_geometries(path)


@pytest.fixture
def folder(tmp_path):
    """A URDF's folder with a mesh below it, and a mesh beside it."""
    inside = tmp_path / "robot"
    (inside / "meshes").mkdir(parents=True)
    (inside / "meshes" / "a.stl").write_bytes(b"solid")
    (tmp_path / "secret.stl").write_bytes(b"solid")
    (inside / "link.stl").symlink_to(tmp_path / "secret.stl")
    return inside


def test_each_kind_of_part(tmp_path):
    (tmp_path / "a.stl").write_bytes(b"solid")
    origin = "<origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>"
    parts = read(
        tmp_path,
        robot(
            visual("<mesh filename='a.stl' scale='2 2 -2'/>", origin)
            + visual("<box size='1 2 3'/>")
            + visual("<cylinder radius='0.1' length='0.4'/>")
            + "<collision><geometry><sphere radius='0.2'/></geometry></collision>"
        ),
    )
    assert [(p.part, p.kind, p.size) for p in parts] == [
        ("visual", "mesh", (2.0, 2.0, -2.0)),
        ("visual", "box", (1.0, 2.0, 3.0)),
        ("visual", "cylinder", (0.1, 0.4)),
        ("collision", "sphere", (0.2,)),
    ]
    mesh = parts[0]
    np.testing.assert_array_equal(mesh.position, (1.0, 2.0, 3.0))
    half = np.sqrt(0.5)
    np.testing.assert_allclose(mesh.orientation, (0.0, 0.0, half, half), atol=1e-15)
    assert mesh.file == (tmp_path / "a.stl").resolve()


def test_an_origin_of_something_else_is_not_the_parts(tmp_path):
    inner = "<inertial><origin xyz='9 9 9'/></inertial>"
    (part,) = read(tmp_path, robot(inner + visual("<box size='1 1 1'/>")))
    assert not part.position.any()


@pytest.mark.parametrize(
    "name", ["meshes/a.stl", "package://robot/meshes/a.stl", "./meshes/../meshes/a.stl"]
)
def test_a_mesh_in_the_folder_is_found(folder, name):
    assert mesh_file(name, folder) == (folder / "meshes" / "a.stl").resolve()


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("package://arms/meshes/b.stl", True),
        ("package://arms/../secret.stl", False),
        ("package://arms/out.stl", False),  # a link that leads out of the package
        ("package://other/meshes/b.stl", False),
        ("package://no_package/secret.stl", False),  # a folder above, no package
    ],
)
def test_a_mesh_of_the_package_that_holds_the_urdf_is_found(tmp_path, name, found):
    """As in ROS: the URDF in ``arms/robots/ur/urdf``, its meshes elsewhere in arms."""
    package = tmp_path / "no_package" / "arms"
    folder = package / "robots" / "ur" / "urdf"
    for each in (folder, package / "meshes"):
        each.mkdir(parents=True)
    for each in (package / "meshes" / "b.stl", tmp_path / "no_package" / "secret.stl"):
        each.write_bytes(b"solid")
    (package / "package.xml").write_text("<package/>")
    (package / "out.stl").symlink_to(tmp_path / "no_package" / "secret.stl")
    expected = (package / "meshes" / "b.stl").resolve() if found else None
    assert mesh_file(name, folder) == expected


@pytest.mark.parametrize(
    "name",
    [
        "../secret.stl",
        "meshes/../../secret.stl",
        "package://../secret.stl",
        "package://robot/../secret.stl",
        "..%2fsecret.stl",
        "link.stl",  # leads out of the folder
        "file:///etc/passwd",
        "http://192.0.2.1/a.stl",
        "/etc/passwd",
        "meshes",
        "nowhere.stl",
        "a\0b",
        "x" * 5_000,
        "",
        "package://",
    ],
)
def test_no_other_file_is(folder, name):
    assert (folder.parent / "secret.stl").exists()
    assert mesh_file(name, folder) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (robot(visual("<box size='1 2'/>")), "the size of a box is '1 2'"),
        (robot(visual("<box size='1 2 nan'/>")), "not 3 finite numbers"),
        (robot(visual("<sphere/>")), "the size of a sphere is ''"),
        (robot(visual("<box size='1 1 1e9'/>")), "larger than 1000 m"),
        (robot(visual("<box size='1 1 1'/>") * (MOST_PARTS + 1)), "more than 2,000"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]>" + robot(""), "document type declaration"),
        ("<robot>", "not well-formed"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path, text, words):
    with pytest.raises(InputError, match=words) as error:
        read(tmp_path, text)
    assert len(str(error.value).splitlines()) == 1
