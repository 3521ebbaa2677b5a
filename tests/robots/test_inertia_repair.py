"""The nearest inertia tensor: against a conic solver and the laws it must keep; and
files in which nothing else changes."""

import re
import shutil
import subprocess
import warnings

import cvxpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.robots import check_inertias, repair_inertias
from hefting.robots.inertia_check import (
    distance,
    least_second_moment,
    nearest_inertia,
    second_moments,
)
from inertial_urdfs import (
    KINDS,
    exists,
    parsed,
    published_robots,
    random_inertial,
    random_robot,
)

BAD = [kind for kind in KINDS if kind not in ("solid", "mass")]
ONE = """<?xml version='1.0'?>
<!-- <inertia ixx="9"/> stays -->
<robot name='r'>
\t<link name="a">  <inertial>
      <mass value="1"/> <!-- a > b -->
      <inertia note='ixx="7"' izz = ' 5 ' iyy='2' iyz="0.0" ixz="0" ixy="-0" ixx="1e0"></inertia>
    </inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="2" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial></link>
  <link name="c"><inertial><mass value="-1"/>
    <inertia ixx="2" ixy="0" ixz="0" iyy="2" iyz="0" izz="9"/></inertial></link>
</robot>"""
"""Link `a` fails, `b` does not, `c` cannot be helped."""


@pytest.fixture(scope="module")
def conic():
    """Least distance and nearest second moments about the COM, by the problem as it is
    stated: pseudo-inertias of the same mass and COM, through Clarabel."""
    Sigma = cvxpy.Variable((3, 3), symmetric=True)
    wanted, outer = cvxpy.Parameter((3, 3)), cvxpy.Parameter((3, 3))
    first, mass = cvxpy.Parameter((3, 1)), cvxpy.Parameter((1, 1))
    # less the second moments that every body has at least
    P = cvxpy.bmat([[Sigma - outer, first], [first.T, mass]])
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.norm(Sigma - wanted, "fro")), [P >> 0])

    def solve(m, com, J):
        # lengths and masses of about one, so that tolerances mean the same everywhere
        S = second_moments(J)
        size = np.linalg.norm(S)
        c = com * np.sqrt(m / size)
        wanted.value = S / size + np.outer(c, c)
        outer.value = least_second_moment(m, J) / size * np.eye(3)
        first.value, mass.value = c[:, None], np.ones((1, 1))
        tight = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-10)
        # which it misses by far less than 1e-6 where it says "may be inaccurate"
        with warnings.catch_warnings(action="ignore", category=UserWarning):
            problem.solve(cvxpy.CLARABEL, **tight, max_iter=200)
        return problem.value * size

    return solve


def test_nearest_as_of_a_conic_solver(conic):
    """200 random inertials: the distance is the optimum to 1e-6, the tensor feasible.

    The solver's optimum is good to 1e-9 of the tensor's size, so violations are of a
    hundredth of it or more; slighter ones follow in the next test.
    """
    rng = np.random.default_rng(17)
    for i in range(200):
        kind = ("triangle", "indefinite", "negative")[i % 3]
        mass, com, J = random_inertial(rng, kind, slightest=1e-2)
        found = nearest_inertia(mass, J)
        lowest = np.linalg.eigvalsh(second_moments(found))[0]
        # as digits are rounded
        assert lowest >= least_second_moment(mass, J) * (1.0 - 1e-6)
        assert distance(J, found) == pytest.approx(conic(mass, com, J), rel=1e-6)


@pytest.mark.parametrize("kind", BAD)
def test_optimality_of_slight_changes(kind):
    """What is added and what is left above the least second moments are positive
    semidefinite and orthogonal, which only the projection is (Moreau)."""
    rng = np.random.default_rng(21)
    for _ in range(50):
        mass, _, J = random_inertial(rng, kind)
        found = nearest_inertia(mass, J)
        left = second_moments(found) - least_second_moment(mass, J) * np.eye(3)
        added = second_moments(found) - second_moments(J)
        # of the 13 digits that are written
        rounding = 1e-12 * max(np.linalg.norm(J), np.linalg.norm(found))
        assert np.linalg.eigvalsh(added)[0] >= -rounding
        assert np.linalg.eigvalsh(left)[0] >= -rounding
        assert np.linalg.norm(added @ left) <= rounding * (
            np.linalg.norm(added) + np.linalg.norm(left)
        )


@pytest.mark.parametrize("kind", BAD)
def test_laws(kind):
    rng = np.random.default_rng(18)
    for _ in range(20):
        mass, _, J = random_inertial(rng, kind)
        found = nearest_inertia(mass, J)
        scale = np.abs(found).max()
        # nothing changes any more, but for a millionth of the millionth of the sum
        # that is now a little more, twice
        np.testing.assert_allclose(
            nearest_inertia(mass, found), found, rtol=0, atol=1e-11 * scale
        )
        # in other axes it is the same tensor
        R = Rotation.random(random_state=rng).as_matrix()
        np.testing.assert_allclose(
            nearest_inertia(mass, R @ J @ R.T), R @ found @ R.T, atol=2e-12 * scale
        )
        # in other units of mass too
        np.testing.assert_allclose(
            nearest_inertia(3.0 * mass, 3.0 * J), 3.0 * found, atol=1e-11 * scale
        )


@pytest.mark.parametrize("mass", [1e-9, 1e-3, 50.0])
@pytest.mark.parametrize("J", [np.zeros((3, 3)), -np.eye(3), 1e-30 * np.eye(3)])
def test_without_any_extent(mass, J):
    """As large as need be: a ball of the least size."""
    found = nearest_inertia(mass, J)
    expected = 2.0 * max(1e-8 * mass, 1e-14)
    np.testing.assert_allclose(found, expected * np.eye(3), rtol=1e-12, atol=0)


def test_repaired_random_links_exist(tmp_path):
    """By exact arithmetic on what is written; MuJoCo takes them, and took none before;
    Pinocchio reads the same mass and COM, and the tensor that was found."""
    pin = pytest.importorskip("pinocchio")
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "robot.urdf"
    rng = np.random.default_rng(19)
    path.write_text(random_robot(rng, [BAD[i % len(BAD)] for i in range(200)]))
    repaired = repair_inertias(path)
    assert len(repaired.failing) == 200
    assert not repaired.remaining
    assert all(exists(inertial) for _, inertial in parsed(repaired.after))
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_string(repaired.before.decode())
    mujoco.MjModel.from_xml_string(repaired.after.decode())
    before = pin.buildModelFromXML(repaired.before.decode()).inertias
    after = pin.buildModelFromXML(repaired.after.decode()).inertias
    for checked, old, new in zip(repaired.failing, before[1:], after[1:], strict=True):
        assert (old.mass, *old.lever) == (new.mass, *new.lever)
        # turned by the origin's rpy, which keeps principal moments
        moments = np.linalg.eigvalsh(new.inertia)
        np.testing.assert_allclose(
            moments, np.linalg.eigvalsh(checked.nearest), atol=1e-14 * moments[2]
        )
        assert np.linalg.eigvalsh(new.toPseudoInertia().toMatrix())[0] > 0.0


@pytest.mark.parametrize(
    "path", published_robots(), ids=lambda path: f"{path.parts[-3]}-{path.stem}"
)
def test_repaired_robots(path, tmp_path):
    """Only tensors change, and every link exists whose mass is positive."""
    repaired = repair_inertias(path)
    assert bool(repaired.diff()) == any(c.nearest is not None for c in repaired.failing)
    for name, inertial in parsed(repaired.after):
        by_hand = name in [checked.link for checked in repaired.remaining]
        assert exists(inertial) != by_hand
    assert all(checked.inertial.mass <= 0.0 for checked in repaired.remaining)
    assert without_tensors(repaired.after) == without_tensors(repaired.before)


def without_tensors(text: bytes) -> bytes:
    """A file without the numbers of its tensors."""
    return re.sub(
        rb"<inertia\s[^>]*>",
        lambda tag: re.sub(rb"""(i[xyz]{2}\s*=\s*)("[^"]*"|'[^']*')""", rb"\1", tag[0]),
        text,
    )


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("start", ["", "\ufeff"])
def test_every_other_byte_stays(tmp_path, newline, start):
    path = tmp_path / "robot.urdf"
    content = (start + ONE.replace("\n", newline)).encode()
    path.write_bytes(content)
    repaired = repair_inertias(path)
    assert path.read_bytes() == repaired.before == content
    assert [checked.link for checked in repaired.failing] == ["a", "c"]
    assert [checked.link for checked in repaired.remaining] == ["c"]
    # J = (1, 2, 5) has second moments (3, 2, -1): -1 becomes 1e-6 of the 5 that can be
    expected = content
    for old, new in ((b'"1e0"', b'"2.000005"'), (b"'2'", b"'3.000005'")):
        assert expected.count(old) == 1
        expected = expected.replace(old, new)
    assert repaired.after == expected


def test_tensors_that_exist_stay(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(random_robot(np.random.default_rng(20), ["solid"] * 20))
    repaired = repair_inertias(path)
    assert repaired.after == repaired.before
    assert repaired.diff() == ""
    path.write_text(ONE)
    once = repair_inertias(path)
    path.write_bytes(once.after)
    assert repair_inertias(path).after == once.after


@pytest.mark.skipif(not shutil.which("patch"), reason="needs patch")
@pytest.mark.parametrize("seed", range(6))
def test_patch_applies_the_diff(tmp_path, seed):
    """Whatever lies between the changes, and at the end."""
    rng = np.random.default_rng(seed)
    kinds = [str(rng.choice(["solid", "triangle", "flat"])) for _ in range(12)]
    text = random_robot(rng, kinds)
    if seed % 2:  # all in one line, without an end
        text = ONE.replace("\n", " ") if seed == 1 else text.rstrip("\n")
    if seed == 4:
        text = text.replace("\n  ", " ")
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    repaired = repair_inertias(path)
    diff = repaired.diff("repaired.urdf")
    assert diff.startswith(f"--- {path}\n+++ repaired.urdf\n@@ -")
    command = ["patch", "--silent", "--fuzz=0", str(path)]
    subprocess.run(command, input=diff.encode(), check=True)
    assert path.read_bytes() == repaired.after
    assert all(c.is_possible for c in check_inertias(path) if c.inertial.mass > 0.0)
