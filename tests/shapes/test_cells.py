"""Moments of a solid in the cells of a grid: they sum to those of the solid, and are
those of boxes and polyhedra in closed form."""

import numpy as np
import pytest

from hefting.shapes.cells import POINTS, WEIGHTS, moments_in_cells
from hefting.shapes.solid import solid_from_mesh
from solids import SOLIDS, rotated, winding


def cells_of(mesh, shape):
    solid = solid_from_mesh(mesh.vertices, mesh.faces)
    low, size = solid.lower - 1e-9, (solid.extents + 2e-9) / shape
    triangles = solid.vertices[solid.faces]
    return solid, low, size, moments_in_cells(triangles, low, size, shape)


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("turned", [False, True])
def test_they_sum_to_those_of_the_solid(name, turned):
    mesh = rotated(SOLIDS[name], 5) if turned else SOLIDS[name]
    solid, _, size, found = cells_of(mesh, (7, 5, 6))
    whole = found.together(np.zeros(len(found.volume), dtype=int), 1)
    # rounding, by the number of pieces
    assert whole.volume[0] == pytest.approx(solid.volume, rel=1e-10)
    scale = np.linalg.norm(solid.extents)
    np.testing.assert_allclose(whole.centroids[0], solid.centroid, atol=1e-10 * scale)
    np.testing.assert_allclose(
        whole.central[0], solid.second_moment, atol=1e-9 * scale**2
    )
    share = found.volume / np.prod(size)
    assert share.min() > -1e-9
    assert share.max() < 1 + 1e-9


def test_boxes_in_closed_form():
    """A box whose faces are not those of the cells: each cell has a box."""
    _, low, size, found = cells_of(SOLIDS["box"], (4, 3, 2))
    np.testing.assert_allclose(found.volume, np.prod(size), rtol=1e-6)  # 1e-9 m of room
    centre = low + size * (np.indices((4, 3, 2)).reshape(3, -1).T + 0.5)
    np.testing.assert_allclose(found.centroids, centre, atol=1e-8)
    for second in found.central:
        np.testing.assert_allclose(second, np.diag(size**2 / 12), atol=1e-9)


def test_one_cell_by_counting_points():
    mesh, shape = rotated(SOLIDS["ring"], 2), (3, 3, 3)
    _, low, size, found = cells_of(mesh, shape)
    best = int(np.argmax(found.volume))
    corner = low + size * np.array(np.unravel_index(best, shape))
    points = corner + size * np.random.default_rng(0).random((5_000, 3))
    inside = winding(mesh.triangles, points) > 0.5
    # five standard errors
    share = found.volume[best] / np.prod(size)
    assert abs(inside.mean() - share) < 5 * np.sqrt(0.25 / 5_000)
    error = points[inside].mean(axis=0) - found.first[best] / found.volume[best]
    assert (np.abs(error) < 5 * size / np.sqrt(12 * inside.sum())).all()


def test_a_surface_inside_out_has_negative_volume():
    mesh = SOLIDS["sphere"]
    solid, low, size, found = cells_of(mesh, (3, 3, 3))
    turned = moments_in_cells(
        solid.vertices[solid.faces][:, ::-1], low, size, (3, 3, 3)
    )
    np.testing.assert_allclose(turned.volume, -found.volume, atol=1e-18)


def test_quadrature_is_exact_to_degree_four():
    """Over a triangle of area 1 the mean of x^i y^j, in barycentric coordinates, is 2
    i! j! / (i + j + 2)!."""
    from math import factorial

    assert WEIGHTS.sum() == pytest.approx(1.0, abs=1e-14)
    for i in range(5):
        for j in range(5 - i):
            exact = 2 * factorial(i) * factorial(j) / factorial(i + j + 2)
            found = WEIGHTS @ (POINTS[:, 0] ** i * POINTS[:, 1] ** j)
            assert found == pytest.approx(exact, abs=1e-14)  # digits of the constants
