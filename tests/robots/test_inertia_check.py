"""Which inertials no body can have: against exact arithmetic and the eigenvalues of the
pseudo-inertia, on random inertials and on published robots."""

import json
from importlib import metadata

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.robots import check_inertias
from inertial_urdfs import (
    KINDS,
    exists,
    parsed,
    pseudo_inertia,
    published_robots,
    random_robot,
)

FINE = '<origin xyz="0 0 0.1"/><mass value="1"/><inertia {}/>'
ROUND = 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'


def robot(tmp_path, *inertials, joints=""):
    links = "".join(
        f'<link name="link{i}">{f"<inertial>{text}</inertial>" if text else ""}</link>'
        for i, text in enumerate(inertials)
    )
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{links}{joints}</robot>')
    return path


def tensor(*entries):
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    return " ".join(f'{n}="{v}"' for n, v in zip(names, entries, strict=True))


def agreeing(path):
    """The checks of a file, after comparing each with both oracles; and how many
    eigenvalues were too near zero to tell."""
    checks, unclear = check_inertias(path), 0
    found = {c.link: c for c in checks if not c.inertial.is_massless}
    inertials = dict(parsed(path.read_bytes()))
    assert found.keys() == inertials.keys()
    for name, inertial in inertials.items():
        assert found[name].is_possible == exists(inertial), name
        eigenvalues = np.linalg.eigvalsh(pseudo_inertia(inertial))
        if abs(eigenvalues[0]) > 1e-14 * abs(eigenvalues).max():  # no rounding
            assert found[name].is_possible == (eigenvalues[0] > 0.0), name
        else:
            unclear += 1
    return checks, unclear


def test_random_inertials(tmp_path):
    """200 of which one in six can exist: by both oracles."""
    path = tmp_path / "robot.urdf"
    kinds = [KINDS[i % len(KINDS)] for i in range(200)]
    path.write_text(random_robot(np.random.default_rng(16), kinds))
    checks, unclear = agreeing(path)
    codes = {
        "solid": {None},
        "triangle": {"inertial-triangle"},
        "indefinite": {"inertial-not-definite"},
        "negative": {"inertial-not-definite"},
        "flat": {"inertial-thin"},
        "mass": {"inertial-mass"},
    }
    for kind, checked in zip(kinds, checks[1:], strict=True):
        assert (checked.fault and checked.fault.code) in codes[kind], checked.link
    assert unclear <= kinds.count("flat")


@pytest.mark.parametrize(
    "path", published_robots(), ids=lambda path: f"{path.parts[-3]}-{path.stem}"
)
def test_published_robots(path):
    agreeing(path)


def test_what_is_found_in_published_robots():
    """The figures of the changelog, in the release they were counted in."""
    robots = published_robots()
    if not robots or metadata.version("example-robot-data") != "6.0.0":
        pytest.skip("example-robot-data 6.0.0 is not installed")
    checks = [checked for path in robots for checked in check_inertias(path)]
    heavy = [checked for checked in checks if not checked.inertial.is_massless]
    bad = [checked for checked in heavy if not checked.is_possible]
    assert (len(robots), len(checks), len(heavy), len(bad)) == (69, 2149, 1768, 116)


@pytest.mark.parametrize(
    ("entries", "code", "shortfall"),
    [
        ((1, 0, 0, 1, 0, 1.5), None, None),
        ((1, 0, 0, 1, 0, 2.5), "inertial-triangle", 0.2),
        ((-0.5, 0, 0, 1, 0, 2), "inertial-not-definite", 0.25),
        ((1, 0, 3, 1, 0, 1), "inertial-not-definite", 0.5),  # moments -2, 1, 4
        ((1, 0, 0, 1, 0, 2), "inertial-thin", 0.0),
        ((0, 0, 0, 1, 0, 1), "inertial-thin", 0.0),
        ((0, 0, 0, 0, 0, 0), "inertial-zero", None),
        ((0, 0, 0, 4e-18, 0, 0), "inertial-zero", None),
    ],
)
def test_by_how_much(tmp_path, entries, code, shortfall):
    checked = check_inertias(robot(tmp_path, FINE.format(tensor(*entries))))[0]
    assert (checked.fault and checked.fault.code) == code
    assert checked.shortfall == pytest.approx(shortfall, abs=1e-15)
    assert checked.is_possible == (code is None) == (checked.nearest is None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<mass value="1"/>', "there is no <inertia>"),
        (f"<inertia {ROUND}/>", "there is no <mass>"),
        (f"<mass/><inertia {ROUND}/>", "<mass> has no value"),
        ('<mass value="1"/><inertia ixx="1"/>', "<inertia> has no ixy"),
        (f'<mass value="1 kg"/><inertia {ROUND}/>', "mass's value is '1 kg'"),
        (f'<mass value="nan"/><inertia {ROUND}/>', "mass's value is 'nan'"),
        (FINE.format(tensor(1, 0, "inf", 1, 0, 1)), "inertia's ixz is 'inf'"),
        (FINE.format(tensor(1, 0, "1_0", 1, 0, 1)), "inertia's ixz is '1_0'"),
        (FINE.format(tensor(1e300, 0, 0, 1, 0, 1)), "the tensor has a number above"),
        (FINE.format(ROUND).replace("0 0 0.1", "0 0"), "the origin's xyz is '0 0'"),
        (FINE.format(ROUND).replace('xyz="0 0', 'rpy="0 0'), None),
    ],
)
def test_what_cannot_be_read_is_the_links(tmp_path, text, message):
    """The other links are checked all the same."""
    checks = check_inertias(robot(tmp_path, text, FINE.format(ROUND)))
    assert checks[1].is_possible
    if message is None:
        assert checks[0].is_possible
        return
    fault = checks[0].fault
    assert fault is not None
    assert fault.code == "inertial-unreadable"
    assert message in fault
    assert checks[0].nearest is None
    assert checks[0].to_dict()["inertia"] is None


@pytest.mark.parametrize("mass", ["0", "-2.5", "-1e-9"])
def test_masses(tmp_path, mass):
    text = FINE.format(ROUND).replace('value="1"', f'value="{mass}"')
    checked = check_inertias(robot(tmp_path, text))[0]
    assert checked.fault is not None
    assert checked.fault.code == "inertial-mass"
    assert checked.shortfall == -float(mass)
    assert checked.nearest is None


def test_the_smallest_numbers(tmp_path):
    """Of which ratios are beyond all numbers: no warning of NumPy's, which are errors
    here."""
    for mass, entries in (("5e-324", (1, 0, 0, 1, 0, 1)), ("1", (5e-324, *[0] * 5))):
        text = FINE.format(tensor(*entries)).replace('value="1"', f'value="{mass}"')
        (checked,) = check_inertias(robot(tmp_path, text))
        assert checked.fault or checked.doubts
        json.dumps(checked.to_dict(), allow_nan=False)


def test_frames_without_mass_are_fine(tmp_path):
    zero = FINE.format(tensor(*[0] * 6)).replace('value="1"', 'value="0"')
    checks = check_inertias(robot(tmp_path, "", zero))
    assert all(c.is_possible and c.inertial.is_massless for c in checks)
    assert not any(c.doubts for c in checks)


def test_doubts(tmp_path):
    far = FINE.format(ROUND).replace("0 0 0.1", "0 0 35")
    gram = FINE.format(tensor(*[x * 1e3 for x in (1, 0, 0, 1, 0, 1)]))
    speck = FINE.format(tensor(*[x * 1e-18 for x in (1, 0, 0, 1, 0, 1)]))
    joints = "".join(
        f'<joint name="j{i}" type="{kind}"><parent link="link{above}"/><child link="link{i}"/></joint>'
        for i, kind, above in (
            (1, "revolute", 0),
            (2, "fixed", 1),
            (3, "prismatic", 2),
            (4, "revolute", 3),
            (5, "fixed", 3),
            (6, "revolute", 6),  # a loop
        )
    )
    path = robot(tmp_path, far, "", gram, "", "", "", "", speck, joints=joints)
    checks = check_inertias(path)
    found = [[doubt.code for doubt in checked.doubts] for checked in checks]
    nothing = ["moved-without-mass"]  # links 3 and 4, not 1, which carries link 2
    assert found[:4] == [["com-far-from-link"], [], ["gyration-odd"], nothing]
    assert found[4:] == [nothing, [], nothing, ["gyration-odd"]]
    assert all(checked.is_possible for checked in checks)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<robot><xacro:macro name="a"/></robot>', "is xacro"),
        ('<robot><link name="${p}hand"/></robot>', "is xacro"),
        (
            '<robot><link name="a"><inertial><mass value="${m}"/></inertial></link></robot>',
            r"is xacro, not URDF; expand it first",
        ),
        ('<!DOCTYPE robot [<!ENTITY a "1">]><robot/>', "document type"),
        ("<mujoco/>", "its root is <mujoco>"),
        ("<robot><link/></robot>", "a <link> has no name"),
        ('<robot><link name="a"/><link name="a"/></robot>', "two links are named 'a'"),
        (
            '<robot><link name="a"><inertial/><inertial/></link></robot>',
            "link 'a' has two inertials",
        ),
        (f"<robot>{'<joint/>' * 2001}</robot>", "more than 2,000 links or joints"),
        ("<robot>", "not well-formed"),
    ],
)
def test_files_that_are_refused(tmp_path, text, message):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        check_inertias(path)
    assert str(path) in str(caught.value)


def test_only_inertials_of_links_count(tmp_path):
    """Not those of extensions, nor elements further inside."""
    path = tmp_path / "robot.urdf"
    path.write_text(
        '<robot><gazebo><link name="x"><inertial/></link></gazebo>'
        '<link name="a"><visual><inertial/></visual><inertial><extra><mass value="-1"/>'
        f"</extra>{FINE.format(ROUND)}<mass value='-1'/></inertial></link></robot>"
    )
    (checked,) = check_inertias(path)
    assert checked.is_possible
    assert checked.inertial.mass == 1.0


def test_tensors_in_the_axes_of_their_links(tmp_path):
    """Of turned inertials: as SciPy turns them, and as Pinocchio reads the file."""
    path = tmp_path / "robot.urdf"
    path.write_text(random_robot(np.random.default_rng(23), ["solid"] * 20))
    found = [checked.to_dict() for checked in check_inertias(path)][1:]
    elements = dict(parsed(path.read_bytes()))
    for each in found:
        rpy = elements[each["link"]].find("origin").attrib["rpy"].split()
        R = Rotation.from_euler("xyz", [float(x) for x in rpy]).as_matrix()
        inertia, turned = np.array(each["inertia"]), each["inertia_in_link_axes"]
        close = {"rtol": 0.0, "atol": 1e-14 * np.abs(inertia).max()}  # rounding
        np.testing.assert_allclose(turned, R @ inertia @ R.T, **close)
        assert np.abs(np.array(turned) - inertia).max() > 1e-3 * np.abs(inertia).max()
    pin = pytest.importorskip("pinocchio")
    read = pin.buildModelFromXML(path.read_text()).inertias[1:]
    for each, own in zip(found, read, strict=True):
        np.testing.assert_allclose(
            each["inertia_in_link_axes"],
            own.inertia,
            atol=1e-13 * np.abs(own.inertia).max(),
        )
        np.testing.assert_allclose(each["center_of_mass"], own.lever, rtol=1e-15)
