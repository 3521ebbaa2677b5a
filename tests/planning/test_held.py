"""What is known of the object before the motion."""

from dataclasses import replace

import numpy as np
import pytest
from problems import BODY

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message
from hefting.estimators import Bayes
from hefting.planning.held import UNKNOWN_BOX, Held, box_corners
from hefting.shapes import Shape

POSE = np.array(
    ((0.0, -1.0, 0.0, 0.1), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.2), (0, 0, 0, 1.0))
)


def estimate(C):
    return Estimate("Bayes", BODY, 100, covariance=C)


def test_corners_are_those_of_the_shapes_own_box():
    shape = Shape.from_box(-0.1, 0.2, 0.0, 0.05, -0.3, 0.0, pose=POSE)
    low, high = np.array((-0.1, 0.0, -0.3)), np.array((0.2, 0.05, 0.0))
    expected = [
        POSE[:3, :3] @ np.where(share, high, low) + POSE[:3, 3]
        for share in np.ndindex(2, 2, 2)
    ]
    own = box_corners(shape)
    assert own.shape == (8, 3)
    for corner in expected:
        assert np.linalg.norm(own - corner, axis=1).min() < 1e-12


def test_nothing_known_is_a_box_and_next_to_no_information():
    own = Held.of(None, None)
    np.testing.assert_allclose(own.corners[[0, -1]], UNKNOWN_BOX)
    assert {each.code for each in own.notes} == {
        "plan-body-assumed",
        "plan-box-assumed",
    }
    # three standard deviations of a body of 1 kg
    assert 1.0 / np.sqrt(own.information[0, 0]) < 3.5
    C = np.linalg.inv(own.information)
    np.testing.assert_allclose(C, Bayes().prior_covariance(1.0), rtol=1e-6)


def test_the_shape_of_the_estimate_is_asked_for():
    made = estimate(np.eye(10))
    without = Held.of(made, None)
    (said,) = (n for n in without.notes if n.code == "plan-box-assumed")
    assert said.endswith("may be faster")
    known = replace(made, provenance={**made.provenance, "shape": "mug.stl"})
    (said,) = (n for n in Held.of(known, None).notes if n.code == "plan-box-assumed")
    assert said.endswith("may be faster: give mug.stl, as for the estimate")


def test_a_shape_knows_more_of_the_inertia_than_none():
    box = Shape.from_mesh(_mesh())
    known = [np.linalg.inv(Held.of(None, own).information) for own in (None, box)]
    assert (known[1].diagonal()[1:] < known[0].diagonal()[1:]).all()


def test_an_estimates_information_is_the_inverse_of_its_covariance():
    A = np.random.default_rng(0).normal(size=(10, 10))
    C = A @ A.T + np.eye(10)
    own = Held.of(estimate(C), None)
    np.testing.assert_allclose(own.information @ C, np.eye(10), atol=1e-9)
    np.testing.assert_array_equal(own.body.vector, BODY.vector)
    assert not [each for each in own.notes if each.code == "plan-body-assumed"]


def test_what_an_estimate_leaves_open_is_only_near_the_sensor():
    C = 1e-6 * np.eye(10)
    C[4:, 4:] = 0.0
    C[range(4, 10), range(4, 10)] = np.inf
    own = Held.of(estimate(C), None).information
    near = np.linalg.inv(Bayes().prior_covariance(BODY.mass))
    np.testing.assert_allclose(own - near, np.diag([1e6] * 4 + [0.0] * 6), atol=1e-3)


def test_the_box_of_no_shape_holds_the_com_of_an_estimate():
    own = Held.of(estimate(np.eye(10)), None)
    low, high = own.corners[0], own.corners[-1]
    half = 0.5 * np.ptp(np.array(UNKNOWN_BOX), axis=0)
    assert (low <= BODY.center_of_mass - half + 1e-12).all()
    assert (high >= BODY.center_of_mass + half - 1e-12).all()


@pytest.mark.parametrize("severity", ["warning", "error"])
def test_doubts_of_the_estimate_are_told(severity):
    doubt = Message("bias-drifts", "the bias drifts", severity)
    own = replace(estimate(np.eye(10)), warnings=(doubt,))
    [told] = [each for each in Held.of(own, None).notes if each.severity != "note"]
    assert (told.code, told.severity) == ("estimate-doubtful", severity)
    assert doubt in told


def test_an_estimate_without_covariance_is_refused():
    with pytest.raises(InputError, match="no covariance"):
        Held.of(Estimate("PMD", BODY, 100), None)


def _mesh():
    import trimesh

    return trimesh.creation.box((0.1, 0.05, 0.2))
