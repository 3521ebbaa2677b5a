"""Bayes with a shape that is not quite the object's: distortions, their effect on the
prior, and wrong shapes."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.messages import codes
from hefting.core.spatial import Array, inverse_pose, pose_matrix, quaternion_of
from hefting.estimators import Bayes
from hefting.estimators.bayes.distortion import Distortions, affine
from hefting.estimators.bayes.prior import Prior
from hefting.identification import identify
from hefting.shapes import Shape
from hefting.shapes.shape import ROUGH
from hefting.simulation import UR5, hammer, simulate, sinusoids, wield

NOISE = NOISE_LEVELS["moderate"]
POSE_STD = (0.005, float(np.radians(5.0)))
POSE = np.eye(4)
POSE[:3, :3] = Rotation.from_euler("xyz", (0.4, -0.7, 1.1)).as_matrix()
POSE[:3, 3] = (0.03, -0.02, 0.06)


@cache
def mesh():
    return hammer().mesh()


def placed(pose=POSE, **settings) -> Shape:
    return Shape.from_mesh(mesh(), pose=pose, points=56, **settings)


@cache
def noisy(seed: int, samples: int = 500) -> Measurements:
    body = hammer().parameters.moved(POSE)
    return wield(UR5.motion(sinusoids(samples / 100.0, 100.0, 1.5)), body).with_noise(
        NOISE, seed
    )


def holds(estimate: Estimate, body: InertialParameters) -> Array:
    """Whether the intervals of mass, COM and inertia about the sensor hold the body:
    (10,) booleans."""
    assert estimate.intervals is not None
    rows, columns = np.triu_indices(3)
    inside = []
    for name in ("mass", "center_of_mass", "inertia_at_origin"):
        (low, high), value = estimate.intervals[name], np.asarray(getattr(body, name))
        held = np.asarray((low <= value) & (value <= high))
        inside.extend(held[rows, columns] if held.ndim == 2 else np.atleast_1d(held))
    return np.array(inside)


# distortions


def test_affine_moves_every_point():
    """Parameters of points moved one by one, against the map of parameters."""
    rng = np.random.default_rng(1)
    x, m = rng.normal(size=(20, 3)), rng.uniform(0.1, 1.0, 20)
    A, t = rng.normal(size=(3, 3)), rng.normal(size=3)
    moved = InertialParameters.from_points(x @ A.T + t, m)
    np.testing.assert_allclose(
        affine(A, t) @ InertialParameters.from_points(x, m).vector,
        moved.vector,
        rtol=1e-12,
    )


@pytest.mark.parametrize("i", range(6))
def test_a_pose_that_is_off_changes_the_body_as_the_effect_says(i):
    """Against the homogeneous body of the mesh put there anew, a thousandth of a
    deviation each way; the rest is of
    second order: a millionth."""
    step = 1e-3
    sizes = np.repeat(POSE_STD, 3)

    def there(sign: int) -> Array:
        delta, twist = np.eye(4), np.zeros(6)
        twist[i] = sign * step * sizes[i]
        delta[:3, :3] = Rotation.from_rotvec(twist[3:]).as_matrix()
        delta[:3, 3] = twist[:3]
        return placed(POSE @ delta).homogeneous.vector

    effect = Distortions.of(placed(), POSE_STD, 0.0).effects(
        placed().homogeneous.vector, np.zeros(6)
    )[:, i]
    found = (there(1) - there(-1)) / (2.0 * step)
    np.testing.assert_allclose(effect, found, atol=1e-5 * np.abs(effect).max())


def test_a_shape_of_another_size_is_among_the_distortions():
    """The mesh scaled by a thousandth about its origin, which is inside, and stretched
    along its own axes."""
    shape = placed()
    distortions = Distortions.of(shape, (0.0, 0.0), 0.2)
    assert len(distortions.shifts) == 7
    effects = distortions.effects(shape.homogeneous.vector, np.zeros(7))
    assert (mesh().bounds[0] <= 0.0).all()
    grown = mesh().copy().apply_scale(1.001)
    found = (
        Shape.from_mesh(grown, pose=POSE, points=56).homogeneous.vector
        - shape.homogeneous.vector
    )
    # second order: 0.1 %
    np.testing.assert_allclose(
        effects[:, 0] * 0.005, found, atol=2e-3 * np.abs(found).max()
    )
    for axis in range(3):
        stretched, A = mesh().copy(), np.eye(4)
        A[axis, axis] = 1.001
        A[:3, 3] = -(A[:3, :3] - np.eye(3)) @ mesh().center_mass
        stretched.apply_transform(A)
        found = (
            Shape.from_mesh(stretched, pose=POSE, points=56).homogeneous.vector
            - shape.homogeneous.vector
        )
        np.testing.assert_allclose(
            effects[:, 1 + axis] * 0.005, found, atol=2e-3 * np.abs(found).max()
        )
        aside = effects[:4, 4 + axis]  # of half a side, along that side
        np.testing.assert_allclose(
            aside[1:], 0.1 * shape.extents[axis] * POSE[:3, axis], atol=1e-12
        )


@pytest.mark.parametrize("where", [0.0, 1.0])
def test_the_prior_widens_by_the_distortions_and_no_more(where):
    """About any of them: the mean and the spread of the line through that point."""
    sure, scores = Prior.of(placed(), (0.0, 0.0)), np.full(13, where)
    about = Prior.of(placed(), POSE_STD, 0.2).about(scores)
    M = about.move.parameters
    effects = Distortions.of(placed(), POSE_STD, 0.2).effects(
        placed().homogeneous.vector, scores
    )
    np.testing.assert_allclose(
        about.prior.mean + effects @ scores, M @ sure.mean, rtol=1e-12
    )
    for one, other in zip(sure.spread, about.prior.spread, strict=True):
        one, other = (M @ one)[1:, 1:], other[1:, 1:]
        scale = np.linalg.norm(other, axis=1)
        added = (
            other @ other.T - one @ one.T - effects[1:] @ effects[1:].T
        ) / np.outer(scale, scale)
        np.testing.assert_allclose(added, 0.0, atol=1e-9)  # rounding
    np.testing.assert_array_equal(sure.about(np.zeros(0)).prior.mean, sure.mean)


def test_the_most_likely_distortion_is_the_mean_given_the_parameters():
    """Of jointly Gaussian z and x = effects z + L y: z's mean given x is effects' (cov
    x)^-1 x."""
    about = Prior.of(placed(), POSE_STD, 0.2).about(np.zeros(13))
    effects = Distortions.of(placed(), POSE_STD, 0.2).effects(
        placed().homogeneous.vector, np.zeros(13)
    )[1:]
    rng = np.random.default_rng(2)
    for j in (0, 5, 23):
        L = about.prior.spread[j, 1:, 1:]
        x = L @ rng.normal(size=9)
        scale = np.linalg.norm(L, axis=1)
        C = L @ L.T / np.outer(scale, scale)
        expected = (effects / scale[:, None]).T @ np.linalg.solve(C, x / scale)
        j_all = len(about.prior.spread)
        weights, means = np.zeros(j_all), np.tile(about.prior.mean, (j_all, 1))
        weights[j] = 1.0
        # of 2 kg
        means[j] = 2.0 * np.concatenate(([1.0], about.prior.mean[1:] + 0.5 * x))
        np.testing.assert_allclose(
            about.most_likely(weights, means), 0.5 * expected, atol=1e-6
        )


# estimates


def test_a_grasp_that_is_off_is_found_out_and_believed_only_as_far_as_said():
    """The hammer sits 5 mm and 5 degrees from where it is said to be, along ten random
    ways."""
    truth, rng = hammer().parameters.moved(POSE), np.random.default_rng(3)
    held = []
    for seed in range(10):
        aside, axis = rng.normal(size=(2, 3))
        delta = np.eye(4)
        delta[:3, :3] = Rotation.from_rotvec(
            POSE_STD[1] * axis / np.linalg.norm(axis)
        ).as_matrix()
        delta[:3, 3] = POSE_STD[0] * aside / np.linalg.norm(aside)
        shape = placed(POSE @ delta)
        estimate = Bayes(shape, noise=NOISE, pose_std=POSE_STD).fit(noisy(seed))
        assert estimate.physically_consistent
        assert not estimate.warnings
        held.append(holds(estimate, truth))
    assert np.mean(held) > 0.9  # of one body; of many see benchmarks.calibration


def test_uncertainty_widens_intervals():
    """A pose of which nothing is said counts as less sure than an exact one."""
    z = noisy(1, 20)  # little, so that the shape matters
    sure = Bayes(placed(), noise=NOISE, pose_std=(0.0, 0.0)).fit(z)
    unsaid = Bayes(placed(), noise=NOISE).fit(z)
    assert np.trace(unsaid.covariance[1:4, 1:4]) > np.trace(sure.covariance[1:4, 1:4])
    for settings in ({"pose_std": POSE_STD}, {"shape_std": 0.2}):
        wide = Bayes(placed(), noise=NOISE, **settings).fit(z)
        assert np.trace(wide.covariance[4:, 4:]) > 1.1 * np.trace(
            sure.covariance[4:, 4:]
        )


def test_a_thin_object_beside_its_shape_is_still_a_body():
    """A plate of 2 mm held 4 mm from where it is said to be: its COM is outside the
    shape, but not where that is."""
    plate = Shape.from_box(-0.1, 0.1, -0.02, 0.02, 0.05, 0.052, points=56)
    body = InertialParameters(0.2 * plate.homogeneous.vector).moved(
        np.array(((1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, 0.004), (0, 0, 0, 1.0)))
    )
    z = wield(UR5.motion(sinusoids(5.0, 100.0, 1.5)), body).with_noise(NOISE, 1)
    estimate = Bayes(plate, noise=NOISE, shape_std=0.0, pose_std=(0.005, 0.0)).fit(z)
    assert plate.margin(estimate.parameters.center_of_mass) < 0.0
    assert estimate.hull_margin is not None
    assert estimate.hull_margin > 0.0
    assert estimate.physically_consistent
    assert estimate.parameters.center_of_mass[2] == pytest.approx(0.055, abs=0.001)
    sure = Bayes(plate, noise=NOISE, shape_std=0.0, pose_std=(0.0, 0.0)).fit(z)
    assert any("no mass inside the shape" in line for line in sure.warnings)


def test_boxes_and_hulls_know_that_they_are_rough():
    box, hull = Shape.from_box(0, 0.1, 0, 0.1, 0, 0.1), Shape.from_hull(mesh())
    assert box.shape_std == hull.shape_std == ROUGH
    assert placed().shape_std == 0.0
    z = noisy(2, 20)
    told = Bayes(hull, noise=NOISE).fit(z)
    same = Bayes(hull, noise=NOISE, shape_std=ROUGH).fit(z)
    np.testing.assert_array_equal(told.covariance, same.covariance)
    rough, sure = (Prior.of(hull, (0.0, 0.0), share) for share in (ROUGH, 0.0))
    rough = rough.about(np.zeros(len(rough.distortions.shifts))).prior
    for one, other in zip(rough.spread, sure.spread, strict=True):
        assert (np.sum(one[1:, 1:] ** 2, axis=1) > np.sum(other[1:, 1:] ** 2, 1)).all()
    with pytest.raises(InputError, match="share from 0 to 1"):
        replace(box, shape_std=1.5)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"pose_std": (0.1,)}, "deviations are two"),
        ({"pose_std": (-0.1, 0.0)}, "deviations are two"),
        ({"pose_std": (np.nan, 0.0)}, "deviations are two"),
        ({"shape_std": 1.5}, "share from 0 to 1"),
        ({"shape_std": np.nan}, "share from 0 to 1"),
        ({"systematic": np.zeros((3, 3))}, "is \\(10, 10\\) and finite"),
    ],
)
def test_what_cannot_be_is_refused(settings, said):
    with pytest.raises(InputError, match=said):
        Bayes(placed(), **settings)


@pytest.mark.parametrize("aside", [0.3, 2.0])
def test_a_shape_in_the_wrong_place_does_not_take_the_mass_away(aside):
    """The mesh is 30 cm or 2 m from the object: that is said, and mass and COM are
    those of the wrench."""
    truth = hammer().parameters.moved(POSE)
    recording = simulate(
        UR5.motion(sinusoids(5.0, 100.0, 1.0)), truth, noise=NOISE, seed=1
    )
    pose = POSE.copy()
    pose[0, 3] += aside
    estimate = identify(recording, placed(pose)).estimate
    assert estimate.parameters.mass == pytest.approx(truth.mass, rel=0.05)
    assert estimate.intervals is not None
    assert np.abs(estimate.intervals["mass"] / truth.mass - 1.0).max() < 0.05
    said = " ".join(estimate.warnings)
    assert "check the shape's pose" in said
    assert "no mass inside the shape explains the wrench" in said


def test_what_contradicts_the_shape_is_never_sure_enough():
    """However narrow: the reason stands in the warning."""
    truth = hammer().parameters.moved(POSE)
    recording = simulate(
        UR5.motion(sinusoids(5.0, 100.0, 1.0)), truth, noise=NOISE, seed=1
    )
    pose = POSE.copy()
    pose[0, 3] += 0.3
    estimate = identify(recording, placed(pose), until="mass=5%").estimate
    assert estimate.sufficient is False
    assert (
        "not as sure as asked for: the wrench contradicts the shape or the scale"
        in estimate.warnings
    )


def wrongly_given(how: str) -> Shape:
    """The hammer's mesh in its place, but for a mistake."""
    x, y, z, w = quaternion_of(POSE[:3, :3])
    turned, quarter = mesh().copy(), np.eye(4)
    quarter[:3, :3] = Rotation.from_euler("x", -90.0, degrees=True).as_matrix()
    about_z = np.eye(4)
    about_z[:3, :3] = Rotation.from_euler("z", 90.0, degrees=True).as_matrix()
    return {
        "right": lambda: placed(),
        "by the inverse of its pose": lambda: placed(inverse_pose(POSE)),
        "with w first": lambda: placed(pose_matrix((*POSE[:3, 3], w, x, y, z))),
        "0.394 times as large": lambda: Shape.from_mesh(
            mesh().copy().apply_scale(2.54), pose=POSE
        ),
        "turned by 90° about its own x": lambda: Shape.from_mesh(
            turned.apply_transform(quarter), pose=POSE
        ),
        "turned by -90° about the sensor's z": lambda: placed(about_z @ POSE),
    }[how]()


@pytest.mark.parametrize(
    "how",
    [
        "right",
        "by the inverse of its pose",
        "with w first",
        "0.394 times as large",
        "turned by 90° about its own x",
        "turned by -90° about the sensor's z",
    ],
)
def test_a_shape_given_otherwise_than_it_is_is_named(how):
    """Where the wrench tells it: the answer is then without the shape."""
    found = Bayes(wrongly_given(how)).fit(noisy(1))
    told = [m for m in found.warnings if "which would fit" in m]
    assert len(told) == (how != "right")
    assert codes(told) == ({"shape-contradicts-wrench"} if told else set())
    assert all(how in message for message in told)
    assert (found.provenance.get("shape_known") == "reach") == bool(told)
    assert holds(found, hammer().parameters.moved(POSE)).all()
