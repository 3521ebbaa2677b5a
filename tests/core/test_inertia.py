"""Inertial parameters: conversions against closed forms and Pinocchio, group laws,
physical consistency."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.inertia import EXPLANATIONS, TOLERANCE, InertialParameters
from hefting.core.spatial import inverse_pose
from random_problems import random_body, random_pose

SCALES = [(1e-3, 1e-3), (0.2, 0.03), (1.0, 0.1), (50.0, 2.0)]
"""Mass [kg] and size [m], from a gram of a millimetre to a heavy beam."""
FROM_PINOCCHIO = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]
"""Pinocchio has Ixx Ixy Iyy Ixz Iyz Izz, the project Jxx Jxy Jxz Jyy Jyz Jzz."""


def natural_scale(body: InertialParameters) -> np.ndarray:
    """Largest value each entry of the vector can have at the body's mass and second
    moment (10,)."""
    second = np.sqrt(np.trace(body.inertia_at_origin) * body.mass)
    return np.repeat((body.mass, second, np.trace(body.inertia_at_origin)), (1, 3, 6))


def assert_same(
    first: InertialParameters, second: InertialParameters, tolerance: float = 1e-14
):
    """Equal up to rounding relative to each entry's natural scale."""
    scale = natural_scale(second)
    np.testing.assert_allclose(
        first.vector / scale, second.vector / scale, rtol=0.0, atol=tolerance
    )


# closed forms: a solid's tensor, found anew from points that fill it


def box_points(sides):
    """Gauss-Legendre points and weights: exact for the quadratic moments of a box."""
    nodes, weights = np.polynomial.legendre.leggauss(2)
    grid = (
        np.array(np.meshgrid(nodes, nodes, nodes)).reshape(3, -1).T
        * np.asarray(sides)
        / 2
    )
    return grid, np.prod(
        np.array(np.meshgrid(weights, weights, weights)).reshape(3, -1), axis=0
    ) / 8


def disc_points(radius):
    """Points of equal weight on a ring whose second moments are those of a disc:
    radius/sqrt(2)."""
    angle = np.arange(4) * np.pi / 2
    return radius / np.sqrt(2) * np.column_stack(
        (np.cos(angle), np.sin(angle))
    ), np.full(4, 0.25)


def cylinder_points(radius, height):
    ring, weights = disc_points(radius)
    nodes, w = np.polynomial.legendre.leggauss(2)
    points = np.array([[*p, z * height / 2] for p in ring for z in nodes])
    return points, np.array([a * b / 2 for a in weights for b in w])


def sphere_points(radius):
    """Six points on the axes at sqrt(3/5) of the radius: mean of x² is radius²/5."""
    return np.vstack((np.eye(3), -np.eye(3))) * radius * np.sqrt(0.6), np.full(6, 1 / 6)


def solids(mass, size):
    a, b, c = size, 0.6 * size, 0.2 * size
    yield (
        "box",
        box_points((a, b, c)),
        mass / 12 * np.diag((b * b + c * c, a * a + c * c, a * a + b * b)),
    )
    across = mass / 12 * (3 * a * a + b * b)
    yield "cylinder", cylinder_points(a, b), np.diag((across, across, mass * a * a / 2))
    yield "sphere", sphere_points(a), 0.4 * mass * a * a * np.eye(3)


@pytest.mark.parametrize(("mass", "size"), SCALES)
def test_every_representation_agrees_on_closed_forms(mass, size):
    rng = np.random.default_rng(1)
    for _, (points, weights), tensor in solids(mass, size):
        R, c = Rotation.random(random_state=rng).as_matrix(), size * rng.normal(size=3)
        by_com = InertialParameters.from_com(mass, c, R @ tensor @ R.T)
        parallel_axes = R @ tensor @ R.T + mass * (c @ c * np.eye(3) - np.outer(c, c))
        assert_same(InertialParameters.from_origin(mass, c, parallel_axes), by_com)
        assert_same(
            InertialParameters.from_points(points @ R.T + c, mass * weights), by_com
        )
        assert_same(
            InertialParameters.from_pseudo_inertia(by_com.pseudo_inertia), by_com
        )
        assert by_com.mass == mass
        np.testing.assert_allclose(by_com.center_of_mass, c, rtol=1e-15)
        # rounding of the parallel-axis term, which is the larger
        np.testing.assert_allclose(
            by_com.inertia_at_com,
            R @ tensor @ R.T,
            atol=1e-14 * np.trace(parallel_axes),
        )
        np.testing.assert_allclose(
            by_com.inertia_at_origin,
            parallel_axes,
            atol=1e-14 * np.trace(parallel_axes),
        )
        moments, axes = by_com.principal()
        np.testing.assert_allclose(
            moments, np.sort(np.diag(tensor)), atol=1e-14 * np.trace(parallel_axes)
        )
        np.testing.assert_allclose(
            axes * moments @ axes.T,
            by_com.inertia_at_com,
            atol=1e-14 * np.trace(parallel_axes),
        )
        assert np.linalg.det(axes) == pytest.approx(1.0)


def test_pseudo_inertia_is_the_integral_of_homogeneous_points():
    rng = np.random.default_rng(2)
    points, masses = rng.normal(size=(6, 3)), rng.exponential(size=6)
    p = np.column_stack((points, np.ones(6)))
    expected = np.einsum("n,ni,nj->ij", masses, p, p)
    np.testing.assert_allclose(
        InertialParameters.from_points(points, masses).pseudo_inertia,
        expected,
        rtol=1e-13,
        atol=1e-14,
    )  # sums of six terms


@pytest.mark.parametrize(("mass", "size"), SCALES)
def test_agrees_with_pinocchio(mass, size):
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    rng = np.random.default_rng(3)
    for _ in range(20):
        body = random_body(rng, mass, size, size)
        other = random_body(rng, 2 * mass, size, size)
        theirs = pin.Inertia(body.mass, body.center_of_mass, body.inertia_at_com)
        ours = InertialParameters(theirs.toDynamicParameters()[FROM_PINOCCHIO])
        assert_same(ours, body, 1e-13)  # both convert to the COM and back
        pose = random_pose(rng, size)
        moved = theirs.se3Action(pin.SE3(pose))
        assert_same(
            InertialParameters(moved.toDynamicParameters()[FROM_PINOCCHIO]),
            body.moved(pose),
            1e-13,
        )
        joined = theirs + pin.Inertia(
            other.mass, other.center_of_mass, other.inertia_at_com
        )
        assert_same(
            InertialParameters(joined.toDynamicParameters()[FROM_PINOCCHIO]),
            body + other,
            1e-13,
        )


# laws of motion and sum


@pytest.mark.parametrize(("mass", "size"), SCALES)
def test_moves_form_a_group_and_sums_commute_with_them(mass, size):
    rng = np.random.default_rng(4)
    for _ in range(20):
        a, b = random_body(rng, mass, size, size), random_body(rng, mass, size, size)
        A, B = random_pose(rng, size), random_pose(rng, size)
        # a dozen products in each entry; a move out and back may carry terms ten times
        # as large
        assert_same(a.moved(A).moved(B), a.moved(B @ A), 1e-13)
        assert_same(a.moved(A).moved(inverse_pose(A)), a, 1e-12)
        assert_same((a + b).moved(A), a.moved(A) + b.moved(A), 1e-13)
        assert_same(a + b - b, a, 1e-14)
        assert_same(a + b, b + a, 0.0)
        moments, moved = a.principal()[0], a.moved(A).principal()[0]
        np.testing.assert_allclose(
            moments, moved, atol=1e-12 * np.trace(a.moved(A).inertia_at_origin)
        )
        np.testing.assert_allclose(
            a.moved(A).center_of_mass,
            A[:3, :3] @ a.center_of_mass + A[:3, 3],
            atol=1e-13 * size,
        )  # three products of the body's own size


def test_joined_points_are_the_sum():
    rng = np.random.default_rng(5)
    points, masses = rng.normal(size=(9, 3)), rng.exponential(size=9)
    parts = [
        InertialParameters.from_points(points[i : i + 3], masses[i : i + 3])
        for i in (0, 3, 6)
    ]
    assert_same(
        parts[0] + parts[1] + parts[2], InertialParameters.from_points(points, masses)
    )


# physical consistency


def principal_body(moments, mass=1.0):
    return InertialParameters.from_com(mass, (0.1, -0.2, 0.3), np.diag(moments))


@pytest.mark.parametrize(
    ("body", "first"),
    [
        (principal_body((1.0, 1.0, 1.0), mass=-1.0), "mass"),
        (principal_body((-0.1, 1.0, 1.0)), "inertia"),
        (principal_body((1.0, 1.0, 2.5)), "triangle"),
        (principal_body((1.0, 1.5, 2.0)), None),
    ],
)
def test_the_first_condition_that_fails_is_named(body, first):
    consistency = body.consistency()
    assert tuple(consistency.margins) == (
        "mass",
        "inertia",
        "triangle",
        "pseudo_inertia",
    )
    assert consistency.violated == first
    assert consistency.is_consistent is (first is None)
    assert str(consistency).startswith(
        "consistent" if first is None else EXPLANATIONS[first]
    )


def test_pseudo_inertia_never_fails_alone():
    """It implies the others, so it fails alone only by the scale it is measured on: by
    a hair beside them."""
    # triangle slack over the largest moment 2; pseudo-inertia twice that over 2
    hair = 1.5 * TOLERANCE
    body = InertialParameters.from_com(
        1.0, np.zeros(3), np.diag((1.0, 1.0, 2.0 + hair))
    )
    consistency = body.consistency()
    assert -TOLERANCE < consistency.margins["triangle"] < 0.0
    assert consistency.margins["triangle"] == pytest.approx(-hair / 2.0, rel=1e-5)
    assert consistency.margins["pseudo_inertia"] == pytest.approx(-hair / 2.0, rel=1e-5)
    assert consistency.is_consistent


def test_margins_mean_what_they_say():
    margins = principal_body((1.0, 1.5, 2.0)).consistency().margins
    second = np.array((1.25, 0.75, 0.25))  # half the trace less each moment
    # rounding of the parallel-axis term
    assert margins["mass"] == 1.0
    assert margins["inertia"] == pytest.approx(0.5, rel=1e-12)
    assert margins["triangle"] == pytest.approx(0.5 / 2.0, rel=1e-12)
    assert margins["pseudo_inertia"] == pytest.approx(
        second.min() / second.max(), rel=1e-12
    )
    negative = (
        InertialParameters(-principal_body((1.0, 1.5, 2.0)).vector)
        .consistency()
        .margins
    )
    assert negative["mass"] == -1.0
    assert negative["inertia"] == pytest.approx(-1.0, rel=1e-12)


def test_consistent_exactly_when_the_pseudo_inertia_is_positive():
    rng = np.random.default_rng(6)
    outcomes = []
    for _ in range(300):
        P = np.diag(rng.uniform(-0.3, 1.0, 4))
        turn = np.eye(4)
        turn[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        turn[:3, 3] = rng.normal(size=3)
        body = InertialParameters.from_pseudo_inertia(turn @ P @ turn.T)
        expected = bool(np.linalg.eigvalsh(P).min() > 0.0)
        assert body.consistency().is_consistent is expected
        outcomes.append(expected)
    assert 50 < sum(outcomes) < 250


@pytest.mark.parametrize(("mass", "size"), SCALES)
@pytest.mark.parametrize("offset", [0.0, 1.0, 30.0])
def test_points_are_always_consistent(mass, size, offset):
    """Any non-negative masses, boundary cases included: coplanar and collinear points,
    few points, one point."""
    rng = np.random.default_rng(7)
    for n in (1, 2, 3, 4, 20):
        for axes in (3, 2, 1):
            for _ in range(10):
                points = size * rng.normal(size=(n, 3))
                points[:, axes:] = 0.0
                points = points @ Rotation.random(
                    random_state=rng
                ).as_matrix() + offset * size * rng.normal(size=3)
                body = InertialParameters.from_points(
                    points, mass * rng.exponential(size=n) ** 3
                )
                consistency = body.consistency()
                assert consistency.is_consistent, (n, axes, str(consistency))
                if n <= 3 or axes < 3:  # flat: one second moment is zero
                    assert consistency.margins["pseudo_inertia"] == pytest.approx(
                        0.0, abs=TOLERANCE
                    )
                    assert consistency.margins["triangle"] == pytest.approx(
                        0.0, abs=TOLERANCE
                    )
                if n <= 2 or axes == 1:  # a rod: one moment is zero
                    assert consistency.margins["inertia"] == pytest.approx(
                        0.0, abs=TOLERANCE
                    )
                if n >= 5 and axes == 3:
                    assert min(consistency.margins.values()) > 1e-6


def test_margins_do_not_depend_on_frame_or_units():
    rng = np.random.default_rng(8)
    for _ in range(30):
        body = random_body(rng)
        expected = list(body.consistency().margins.values())
        moved = body.moved(random_pose(rng, 0.2)).consistency().margins
        # the parallel-axis term is up to a hundred times the tensor at the COM
        np.testing.assert_allclose(list(moved.values()), expected, atol=1e-12)
        grams_millimetres = body.vector * np.repeat((1e3, 1e6, 1e9), (1, 3, 6))
        other = InertialParameters(grams_millimetres).consistency().margins
        np.testing.assert_allclose(list(other.values()), expected, atol=1e-12)


def test_nothing_is_no_body():
    for vector in (np.zeros(10), np.full(10, np.nan), np.r_[0.0, np.ones(9)]):
        assert InertialParameters(vector).consistency().violated == "mass"
    assert np.isnan(InertialParameters(np.zeros(10)).center_of_mass).all()


# values


def test_margins_of_a_point_mass_at_the_origin_are_zero():
    """No inertia at all: on the edge of each condition, not undefined."""
    margins = (
        InertialParameters.from_points(np.zeros((1, 3)), [2.0]).consistency().margins
    )
    assert margins == {
        "mass": 1.0,
        "inertia": 0.0,
        "triangle": 0.0,
        "pseudo_inertia": 0.0,
    }


def test_values_are_copied_read_only_and_compared_whole():
    values = np.arange(10.0)
    body = InertialParameters(values)
    values[0] = 5.0
    assert body.mass == 0.0
    with pytest.raises(ValueError, match="read-only"):
        body.vector[0] = 1.0
    assert isinstance(body == InertialParameters(np.arange(10.0)), bool)


def test_wrong_shapes_are_refused():
    for vector in (np.zeros(9), np.zeros((1, 10)), 3.0):
        with pytest.raises(InputError, match="ten numbers"):
            InertialParameters(vector)
    with pytest.raises(InputError, match="proper rotation"):
        InertialParameters(np.arange(10.0)).moved(np.diag((1.0, 1.0, -1.0, 1.0)))


def test_a_body_with_an_unknown_number_has_no_margins():
    vector = random_body(np.random.default_rng(3)).vector.copy()
    vector[7] = np.nan
    margins = InertialParameters(vector).consistency().margins
    assert margins
    assert all(np.isnan(value) for value in margins.values())
