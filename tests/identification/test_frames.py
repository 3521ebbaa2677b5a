"""Frames: errors in another frame, and what is open there."""

from dataclasses import replace

import numpy as np
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate, estimate_given
from hefting.core.inertia import moving
from hefting.core.spatial import inverse_pose, pose_matrix, rotation_by
from hefting.core.undetermined import Undetermined
from hefting.estimators import OLS
from random_problems import random_body, random_motion, random_pose, with_wrench


@pytest.fixture
def estimate() -> Estimate:
    rng = np.random.default_rng(1)
    z = with_wrench(
        random_motion(rng, 40), random_body(rng), rng.normal(size=6), rng, 0.1, 0.005
    )
    return OLS(bias="estimate").fit(z)


def test_in_another_frame_errors_are_those_of_the_moved_body(estimate, tmp_path):
    """Covariance and intervals, by draws of the ten numbers and of the frame's pose: 4,000
    give a variance to 2.2 %, and the largest error of a hundred is some four times that."""
    rng = np.random.default_rng(8)
    pose, std = random_pose(rng), (1e-3, 1e-3)
    moved = hefting.in_frame(estimate, pose, frame="cup", pose_std=std)
    root = np.linalg.cholesky(estimate.covariance)
    # so small that all is linear
    share, drawn = 1e-3, []
    for _ in range(4_000):
        wrong = np.eye(4)
        wrong[:3, :3] = rotation_by(share * std[1] * rng.normal(size=3))
        wrong[:3, 3] = share * std[0] * rng.normal(size=3)
        vector = estimate.parameters.vector + share * root @ rng.normal(size=10)
        drawn.append(moving(inverse_pose(pose @ wrong)) @ vector)
    spread = np.cov(np.array(drawn).T) / share**2
    sizes = np.sqrt(spread.diagonal())
    expected = spread / np.outer(sizes, sizes)
    found = moved.covariance / np.outer(sizes, sizes)
    np.testing.assert_allclose(found, expected, atol=0.1)
    there = estimate.parameters.moved(inverse_pose(pose))
    np.testing.assert_allclose(moved.parameters.vector, there.vector, rtol=1e-9)
    for name in ("mass", "center_of_mass", "inertia_at_com"):
        half = 0.5 * np.ptp(moved.intervals[name], axis=0)
        np.testing.assert_allclose(half, 1.96 * moved.std[name], rtol=1e-9)
    assert moved.to_dict()["frame"] == "cup"
    back = hefting.in_frame(moved, inverse_pose(pose), frame="sensor")
    assert back.std["mass"] == pytest.approx(estimate.std["mass"], rel=1e-6)
    with pytest.raises(InputError, match="in the frame cup, not the sensor's"):
        estimate_given(moved)
    with pytest.raises(InputError, match="different frames: cup, sensor"):
        hefting.compare(moved, estimate)
    moved.save(tmp_path / "moved.json")
    with pytest.raises(InputError, match="is in cup axes; give the one in sensor axes"):
        hefting.Estimate.load(tmp_path / "moved.json")


def test_in_another_frame_is_open_what_follows_from_an_open_number(estimate):
    body = estimate.parameters
    covariance = estimate.covariance.copy()
    covariance[3, 3] = np.inf
    open_ = Undetermined.of_parameters({"mcz"}, "a prior")
    z_open = replace(estimate, covariance=covariance, undetermined=open_)
    quarter, eighth = (
        pose_matrix((0, 0, 0, np.sin(turn / 2), 0, 0, np.cos(turn / 2)))
        for turn in (np.pi / 2, np.pi / 4)
    )
    moved = hefting.in_frame(z_open, quarter)  # the new y is the old z
    assert moved.undetermined.center_of_mass.tolist() == [False, True, False]
    assert np.isinf(moved.covariance.diagonal()).tolist()[:4] == [
        False,
        False,
        True,
        False,
    ]
    assert moved.mass == pytest.approx(body.mass)
    assert not np.isfinite(moved.interval("center_of_mass")[:, 1]).any()
    moved = hefting.in_frame(z_open, eighth)
    assert moved.undetermined.center_of_mass.tolist() == [False, True, True]
