"""The modular test object, its truth, mesh and points, and objects made of meshes:
against integrals."""

import json

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.identification.truth import load_truth
from hefting.simulation import (
    MODULAR,
    HeldObject,
    Part,
    hammer,
    held_modular,
    modular,
    paper_points,
)
from hefting.simulation.modular import SLOTS

STEP = 0.5e-3
"""Of the grid in the plane [m]: a part of all straight sides."""


def disc(x, y, center, radius):
    """Share of each pixel that a circle covers, as if its rim were straight there."""
    dx, dy = x - 1e-3 * center[0], y - 1e-3 * center[1]
    near = np.flatnonzero((np.abs(dx) < radius + STEP) & (np.abs(dy) < radius + STEP))
    share = np.zeros(len(x))
    share[near] = np.clip(
        (radius - np.hypot(dx[near], dy[near])) / STEP + 0.5, 0.0, 1.0
    )
    return share


def density_at(name, p, pockets):
    """Mean density [kg/m³] of pixels (n, 2) [m], at the pockets' height or not, by a
    configuration's description."""
    x, y = p.T
    h = (
        (np.abs(x) < 0.1)
        & (np.abs(y) < 0.15)
        & ((np.abs(y) > 0.1) | (np.abs(x) < 0.025))
    )
    boss = (np.abs(y) > 0.15) * disc(x, np.abs(y), (0, 150), 0.0075)
    density = 491.0 * (h + boss)
    for hole in [(0, y) for y in range(-150, 151, 50)] + [
        (x, y) for x in (-90, -40, 40, 90) for y in (-125, 125)
    ]:
        density *= 1.0 - disc(x, y, hole, 0.0033)
    for i, slot in enumerate(SLOTS if pockets else ()):
        density *= 1.0 - disc(x, y, slot, 0.015)
        steel, plastic = i in MODULAR[name].steel, i in MODULAR[name].abs
        density += (7847.0 * steel + 1321.0 * plastic) * disc(x, y, slot, 0.0127)
    return density


def integral(name):
    """Parameters by summing over a fine grid in the plane, exactly through the three
    layers that differ."""
    x = np.arange(-0.1 + STEP / 2, 0.1, STEP)
    y = np.arange(-0.158 + STEP / 2, 0.158, STEP)
    plane = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    P = np.zeros((4, 4))
    for low, high in ((0.0, 0.0123), (0.0123, 0.0377), (0.0377, 0.05)):
        rho = STEP**2 * density_at(name, plane, low == 0.0123)
        m, first, second = rho.sum(), rho @ plane, (plane.T * rho) @ plane
        h, h2, h3 = high - low, (high**2 - low**2) / 2, (high**3 - low**3) / 3
        P[:2, :2] += h * second
        P[:2, 2] += h2 * first
        P[:2, 3] += h * first
        P[2, 2:] += h3 * m, h2 * m
        P[3, 3] += h * m
    return InertialParameters.from_pseudo_inertia(np.triu(P) + np.triu(P, 1).T)


@pytest.mark.parametrize("name", MODULAR)
def test_the_truth_is_the_integral_over_the_density(name):
    summed, exact = integral(name), modular(name).parameters
    # pixels of 0.5 mm err by up to 6e-4 of a weight's mass; one bolt hole is 1.3e-3 of
    # the empty object's
    assert exact.mass == pytest.approx(summed.mass, rel=5e-4)
    np.testing.assert_allclose(exact.center_of_mass, summed.center_of_mass, atol=2e-5)
    scale = np.abs(exact.inertia_at_com).max()
    np.testing.assert_allclose(
        exact.inertia_at_com, summed.inertia_at_com, atol=5e-4 * scale
    )
    assert exact.consistency().is_consistent


def test_masses_and_symmetries():
    bodies = {name: modular(name).parameters for name in MODULAR}
    steel, plastic = (rho * np.pi * 0.0127**2 * 0.0254 for rho in (7847.0, 1321.0))
    assert steel == pytest.approx(0.101, abs=5e-4)  # the grams that are published
    assert plastic == pytest.approx(0.017, abs=5e-4)
    for name, filling in MODULAR.items():
        weights = len(filling.steel) * steel + len(filling.abs) * plastic
        assert bodies[name].mass == pytest.approx(
            bodies["empty"].mass + weights, rel=1e-12
        )
        assert bodies[name].center_of_mass[2] == pytest.approx(0.025, abs=1e-15)
    for name in ("barbell", "uniform", "corners", "rod", "empty"):
        np.testing.assert_allclose(
            bodies[name].center_of_mass, (0.0, 0.0, 0.025), atol=1e-15
        )
    for name in ("hammer", "tee", "half-n-half"):
        assert bodies[name].center_of_mass[1] > 0.025


def test_the_mesh_is_what_one_scans():
    """Watertight, with the bolt holes and not the pockets."""
    held = held_modular("hammer")
    surface = held.surface
    assert surface.is_watertight
    np.testing.assert_allclose(surface.extents, (0.2, 0.315, 0.05), atol=1e-9)
    h, hole, boss = 1500e-6, np.pi * 0.0033**2 * 0.05, 0.5 * np.pi * 0.0075**2 * 0.05
    # prisms of 32 sides
    assert surface.volume == pytest.approx(h - 15 * hole + 2 * boss, rel=2e-4)
    assert surface.euler_number == 2 - 2 * 15  # a handle for each through hole
    bounds = held.surface.copy().apply_transform(held.pose).bounds
    # its face on the flange
    np.testing.assert_allclose(bounds[:, 2], (0.0, 0.05), atol=1e-9)
    np.testing.assert_allclose(
        held.parameters.center_of_mass - held.in_object.center_of_mass,
        (0, 0.025, 0),
        atol=1e-15,
    )


@pytest.mark.parametrize(
    ("density", "count"), [(0.04, 56), (0.09, 126), (0.01, 14), (0.12, 168), (0.5, 700)]
)
def test_points_of_the_papers_densities(density, count):
    held = held_modular("tee")
    points = paper_points(held, density)
    assert points.n == count
    steps = [np.diff(np.unique(points.positions[:, i].round(9))) for i in range(3)]
    for step in steps:  # one pitch along each axis
        assert len(step) == 0 or np.ptp(step) < 1e-8
    x, y, z = np.abs((points.positions - held.pose[:3, 3]).T)
    assert ((x < 0.1) & (y < 0.15) & ((y > 0.1) | (x < 0.025)) & (z < 0.05)).all()
    even = InertialParameters(points.cell_matrix.mean(axis=1))
    np.testing.assert_allclose(
        even.center_of_mass, points.homogeneous.center_of_mass, atol=1e-4
    )
    # the grid in the H without bosses and holes, against the mesh
    np.testing.assert_allclose(
        even.inertia_at_com, points.homogeneous.inertia_at_com, rtol=0.15, atol=1e-5
    )
    np.testing.assert_allclose(points.extents, (0.2, 0.315, 0.05), atol=1e-9)


def test_the_papers_grid():
    points = paper_points(held_modular("empty"))
    sides = [np.diff(np.unique(points.positions[:, i].round(9)))[0] for i in range(3)]
    # 25 cm³: 0.04 points/cm³
    np.testing.assert_allclose(sides, (0.040, 0.025, 0.025), atol=1e-9)


def test_half_a_cylinder():
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    half = Part("half cylinder", (0.02, 0.05), 1000.0, (0.1, -0.2, 0.3), turn)
    other = Part(
        "half cylinder",
        (0.02, 0.05),
        1000.0,
        (0.1, -0.2, 0.3),
        turn @ np.diag((-1.0, -1.0, 1.0)),
    )
    whole = Part("cylinder", (0.02, 0.05), 1000.0, (0.1, -0.2, 0.3), turn)
    np.testing.assert_allclose(
        (half.parameters + other.parameters).vector, whole.parameters.vector, atol=1e-15
    )
    mesh = half.mesh(sections=2000)
    mesh.density = 1000.0
    # as for whole ones
    assert half.parameters.mass == pytest.approx(mesh.mass, rel=2e-6)
    np.testing.assert_allclose(
        half.parameters.center_of_mass, mesh.center_mass, atol=1e-7
    )
    np.testing.assert_allclose(
        half.parameters.inertia_at_com, mesh.moment_inertia, atol=1e-10
    )


# objects made of meshes


def test_meshes_with_densities(tmp_path):
    """The hammer from a mesh a part: the closed form, up to the prisms' sides."""
    tool, pose = hammer(), np.eye(4)
    pose[:3, 3] = (0.1, 0.0, -0.05)
    parts = []
    for i, part in enumerate(tool.parts):
        part.mesh(sections=400).apply_scale(1e3).export(tmp_path / f"{i}.ply")
        parts.append((tmp_path / f"{i}.ply", part.density))
    held = HeldObject.from_meshes(parts, "mm", pose)
    expected = tool.parameters.moved(pose)
    # 400 sides lack 4e-5 of a circle's area, and the file has single precision
    np.testing.assert_allclose(
        held.parameters.vector,
        expected.vector,
        atol=2e-4 * np.abs(expected.vector).max(),
    )
    assert held.parameters.mass == pytest.approx(expected.mass, rel=1e-4)
    assert held.name == "0+1+2+3"
    assert 50 <= held.points(points=56).n <= 73


def test_meshes_that_have_no_truth(tmp_path):
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.export(tmp_path / "box.stl")
    with pytest.raises(InputError, match="density is -1"):
        HeldObject.from_meshes([(tmp_path / "box.stl", -1.0)])
    with pytest.raises(InputError, match="at least one mesh"):
        HeldObject.from_meshes([])
    box.update_faces(np.arange(len(box.faces)) > 1)
    box.export(tmp_path / "open.stl")
    with pytest.raises(InputError, match="not watertight"):
        HeldObject.from_meshes([(tmp_path / "open.stl", 1000.0)])
    with pytest.raises(InputError, match=r"no configuration.*did you mean 'hammer'"):
        modular("hamer")


def test_the_truth_as_a_file(tmp_path):
    held = held_modular("half-n-half")
    (tmp_path / "truth.json").write_text(json.dumps(held.truth()))
    known = load_truth(tmp_path / "truth.json")
    np.testing.assert_allclose(
        known.parameters.vector, held.parameters.vector, atol=1e-16
    )
    np.testing.assert_allclose(known.extents, (0.2, 0.315, 0.05), atol=1e-9)
