"""The paper's three errors by hand, and the laws of the distance between bodies."""

import numpy as np
import pytest
from scipy.linalg import expm, logm, sqrtm
from scipy.spatial.transform import Rotation

from hefting.core.accuracy import errors_between, riemannian_distance
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import inverse_pose
from random_problems import random_body, random_pose


def test_the_papers_errors_by_hand():
    """A block of 12 kg, sides 1, 2, 3 m: the scales are m/12 times 13, 10, 5 and 2, 3,
    6 (eq. 14)."""
    truth = InertialParameters.from_com(12.0, np.zeros(3), np.diag((13.0, 10.0, 5.0)))
    dJ = np.array(((1.3, 0.2, -0.6), (0.2, 0.5, 0.6), (-0.6, 0.6, -1.0)))
    estimate = InertialParameters.from_com(
        12.6, np.zeros(3), np.diag((13.0, 10.0, 5.0)) + dJ
    )
    found = errors_between(estimate, truth, (1.0, 2.0, 3.0))
    assert found.mass == pytest.approx(5.0)
    assert found.center_of_mass == 0.0
    expected = 100.0 * np.mean((1.3 / 13, 0.2 / 2, 0.6 / 3, 0.5 / 10, 0.6 / 6, 1.0 / 5))
    assert found.inertia_at_com == pytest.approx(expected)
    assert found.inertia_at_origin == pytest.approx(expected)  # the COM is the origin
    assert set(found.to_dict()) == {
        "mass",
        "center_of_mass",
        "inertia_at_origin",
        "inertia_at_com",
        "riemannian",
    }


def test_com_error_and_where_inertia_is_taken():
    """A shift of the COM alone: the tensor at the COM is right, that at the origin is
    not."""
    J, extents = np.diag((2.0, 2.0, 2.0)), np.array((0.5, 1.0, 2.0))
    truth = InertialParameters.from_com(2.0, (1.0, 0.0, 0.0), J)
    estimate = InertialParameters.from_com(2.0, (1.1, -0.2, 0.1), J)
    found = errors_between(estimate, truth, extents)
    assert found.center_of_mass == pytest.approx(
        100.0 * np.mean((0.1 / 0.5, 0.2 / 1.0, 0.1 / 2.0))
    )
    # rounding of the parallel-axis term
    assert found.inertia_at_com == pytest.approx(0.0, abs=1e-12)
    dJ = 2.0 * np.abs(
        ((0.04 + 0.01), 0.22, -0.11, 1.21 + 0.01 - 1.0, 0.02, 1.21 + 0.04 - 1.0)
    )
    scale = 2.0 / 12.0 * np.array((5.0, 0.5, 1.0, 4.25, 2.0, 1.25))
    assert found.inertia_at_origin == pytest.approx(100.0 * np.mean(dJ / scale))


def test_axes_are_those_of_the_shape():
    """Everything turned together leaves the errors; leaving out the axes does not."""
    rng = np.random.default_rng(1)
    truth, estimate, extents = random_body(rng), random_body(rng), (0.1, 0.2, 0.4)
    plain = errors_between(estimate, truth, extents).to_dict()
    for _ in range(5):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        a, b = estimate.moved(pose), truth.moved(pose)
        turned = errors_between(a, b, extents, pose[:3, :3]).to_dict()
        for name, value in plain.items():
            # rounding, by the condition of the pseudo-inertia
            assert turned[name] == pytest.approx(value, rel=1e-9)
        assert errors_between(a, b, extents).center_of_mass != pytest.approx(
            plain["center_of_mass"], rel=1e-3
        )


def test_no_error_for_the_truth_itself():
    body = random_body(np.random.default_rng(2))
    values = errors_between(body, body, (0.1, 0.1, 0.1)).to_dict()
    for name, value in values.items():
        # generalised eigenvalues of 1 up to rounding
        assert value == pytest.approx(0.0, abs=1e-12), name


@pytest.mark.parametrize(
    "extents", [(0.1, 0.1), (0.1, 0.0, 0.1), (0.1, -1.0, 0.1), (0.1, np.nan, 0.1)]
)
def test_extents_must_be_lengths(extents):
    body = random_body(np.random.default_rng(3))
    with pytest.raises(InputError, match="three positive lengths"):
        errors_between(body, body, extents)


# the distance


# by its own estimate of 1e-13
@pytest.mark.filterwarnings("ignore:logm result may be inaccurate")
def test_distance_in_closed_form():
    """|log(P1^-1/2 P2 P1^-1/2)| / sqrt(2), by matrix functions."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        a, b = random_body(rng, size=1.0), random_body(rng, size=1.0)
        root = np.linalg.inv(np.real(sqrtm(a.pseudo_inertia)))
        expected = np.linalg.norm(
            np.real(logm(root @ b.pseudo_inertia @ root))
        ) / np.sqrt(2.0)
        # matrix functions are good to 1e-12
        assert riemannian_distance(a, b) == pytest.approx(expected, rel=1e-10)


def test_distance_along_a_geodesic():
    """From P along P^1/2 exp(t S) P^1/2 it is |t| |S| / sqrt(2)."""
    rng = np.random.default_rng(5)
    body = random_body(rng, size=1.0)
    root, S = np.real(sqrtm(body.pseudo_inertia)), rng.normal(size=(4, 4))
    S = 0.2 * (S + S.T)
    for t in (-1.0, 0.0, 0.5, 2.0):
        other = InertialParameters.from_pseudo_inertia(root @ expm(t * S) @ root)
        expected = abs(t) * np.linalg.norm(S) / np.sqrt(2.0)
        assert riemannian_distance(body, other) == pytest.approx(
            expected, rel=1e-9, abs=1e-12
        )


def test_laws_of_a_distance():
    rng = np.random.default_rng(6)
    for _ in range(50):
        a, b, c = (random_body(rng, mass) for mass in (0.1, 1.0, 3.0))
        ab = riemannian_distance(a, b)
        bc = riemannian_distance(b, c)
        ac = riemannian_distance(a, c)
        assert min(ab, bc, ac) > 0.1
        assert riemannian_distance(b, a) == pytest.approx(ab, rel=1e-9)
        # by the condition of the pseudo-inertia
        assert riemannian_distance(a, a) == pytest.approx(0.0, abs=1e-9)
        assert ac <= (ab + bc) * (1.0 + 1e-12)


def test_distance_does_not_depend_on_frame_or_units():
    rng = np.random.default_rng(7)
    units = np.repeat((1e3, 1e6, 1e9), (1, 3, 6))  # g, mm
    for _ in range(30):
        a, b, pose = random_body(rng), random_body(rng), random_pose(rng)
        expected = riemannian_distance(a, b)
        # moved half a metre, a pseudo-inertia of 0.1 m has a condition of a thousand
        assert riemannian_distance(a.moved(pose), b.moved(pose)) == pytest.approx(
            expected, rel=1e-9
        )
        assert riemannian_distance(
            InertialParameters(a.vector * units), InertialParameters(b.vector * units)
        ) == pytest.approx(expected, rel=1e-10)
        back = inverse_pose(pose)
        assert riemannian_distance(a.moved(pose).moved(back), b) == pytest.approx(
            expected, rel=1e-9
        )


def test_no_distance_to_what_is_no_body():
    rng = np.random.default_rng(8)
    body = random_body(rng)
    turned_inside_out = InertialParameters(body.vector * np.repeat((1.0, -1.0), (4, 6)))
    for other in (
        InertialParameters(-body.vector),
        turned_inside_out,
        InertialParameters(np.zeros(10)),
    ):
        assert np.isnan(riemannian_distance(other, body))
        assert np.isnan(riemannian_distance(body, other))


def test_no_distance_to_a_flat_body():
    """On the boundary the distance is infinite; rounding must not make it a number."""
    rng = np.random.default_rng(9)
    for _ in range(10):
        points = rng.normal(size=(5, 3)) * (1.0, 1.0, 0.0)
        flat = InertialParameters.from_points(points, np.ones(5)).moved(
            random_pose(rng)
        )
        body = random_body(rng)
        assert np.isnan(riemannian_distance(flat, body))
        assert np.isnan(riemannian_distance(body, flat))
