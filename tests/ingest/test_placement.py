"""Where a sensor is in the logged frame: the motion of its points, and what is to be
typed for it."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.ingest.rivals.case import Motion
from hefting.ingest.rivals.placement import (
    _number,
    _round_turn,
    advice,
    angle_and_axis,
    moved,
    place_text,
    seen_from_log,
    turn_text,
    turned_by,
)


def turn(axis, degrees):
    axis = np.array(axis, dtype=float)
    return Rotation.from_rotvec(
        np.radians(degrees) * axis / np.linalg.norm(axis)
    ).as_matrix()


def test_a_point_of_a_turning_frame_moves_as_rigid_bodies_do():
    """a + alpha x r + w x (w x r)."""
    rng = np.random.default_rng(1)
    a, alpha, w = rng.normal(size=(3, 2, 5, 3))
    i, j = np.triu_indices(3)
    products = w[..., i] * w[..., j]
    rest = np.concatenate((alpha, products), axis=2)
    motion = Motion(a, rest, rng.normal(size=(2, 5, 3, 3)), np.ones((2, 5), bool))
    r = np.array((0.1, -0.2, 0.3))
    found = moved(motion, r)
    np.testing.assert_allclose(
        found.a, a + np.cross(alpha, r) + np.cross(w, np.cross(w, r))
    )
    assert found.rest is rest
    assert found.axes is motion.axes
    wrench = rng.normal(size=(4, 6))
    R = turn((1, 2, 3), 40.0)
    turned = turned_by(cast(Any, SimpleNamespace(wrench=wrench)), R)
    np.testing.assert_allclose(turned[:, :3], wrench[:, :3] @ R.T)
    np.testing.assert_allclose(turned[:, 3:], wrench[:, 3:] @ R.T)
    seen = seen_from_log(np.arange(1.0, 11.0), r)
    np.testing.assert_allclose(seen, [1.0, 2.1, 2.8, 4.3, *np.arange(5.0, 11.0)])


@pytest.mark.parametrize("degrees", [1e-3, 30.0, 120.0, 179.9])
def test_a_turn_has_an_angle_and_an_axis(degrees):
    angle, axis = angle_and_axis(turn((1, -2, 2), degrees))
    assert np.degrees(angle) == pytest.approx(degrees)
    np.testing.assert_allclose(axis, (1 / 3, -2 / 3, 2 / 3), atol=1e-6)
    none, axis = angle_and_axis(np.eye(3))
    assert none == 0.0
    np.testing.assert_array_equal(axis, (0.0, 0.0, 1.0))


def test_turns_and_places_are_told_with_their_deviations():
    said = turn_text(turn((0, -1e-9, 2), 30.04), np.radians(0.26))
    assert said == "30.0° ± 0.3° about (0.00, 0.00, 1.00)"
    place = place_text(np.array((0.1, -2e-4, -0.05)), np.array((1e-3, 2e-3, 0.01)))
    assert place == "(100 ± 1, 0 ± 2, -50 ± 10) mm"
    assert [_number(x, 4) for x in (0.5, 2.0, -1e-6, 0.12344, -0.1)] == [
        "0.5",
        "2",
        "0",
        "0.1234",
        "-0.1",
    ]


@pytest.mark.parametrize(
    ("axis", "degrees", "std", "said"),
    [
        ((0, 0, 1), 30.2, 0.1, "z:30"),
        ((0, 0, 1), 30.4, 0.1, None),  # four deviations off
        ((0, 0, 1), 30.31, 0.1, None),
        ((0, 0, 1), 30.29, 0.1, "z:30"),
        ((0, -1, 0), 45.0, 0.1, "y:-45"),
        ((-1, 0, 0), 90.0, 0.1, "x:-90"),
        ((-1, 0, 0), 180.0, 0.1, "x:180"),
        ((0, 0, 1), 30.0, 0.49, "z:30"),
        ((0, 0, 1), 30.0, 0.51, None),  # not known to half a degree
        ((1, 0.2, 0), 30.0, 0.1, None),
    ],
)
def test_a_turn_is_a_whole_number_of_degrees_where_it_is_known_and_within_three_deviations(
    axis, degrees, std, said
):
    covariance = np.radians(std) ** 2 * np.eye(3)
    assert _round_turn(turn(axis, degrees), covariance) == said


def case_with(pose=None, measured=False):
    return cast(
        Any,
        SimpleNamespace(
            path=SimpleNamespace(gravity_measured=measured),
            recording=SimpleNamespace(sensor_pose=pose),
        ),
    )


def test_what_to_type_is_a_turn_or_a_pose_beside_what_was_given():
    known, none = np.radians(0.1) ** 2 * np.eye(3), np.zeros(3)
    R, place = turn((0, 0, 1), 90.0), np.array((0.1, 0.0, -0.05))
    assert advice(case_with(), R, none, known) == "give `sensor_turned`='z:90'"
    quarter = "0,0,0.70711,0.70711"
    whole = f"give `sensor_pose_in_log`='0,0,0,{quarter}'"
    assert advice(case_with(), R, none) == whole
    said = advice(case_with(), R, place, known, " or else")
    assert said == f"give `sensor_pose_in_log`='0.1,0,-0.05,{quarter}' or else"
    assert "same axes" in advice(case_with(measured=True), R, none, known)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn((0, 0, 1), -60.0), (0.0, 0.2, 0.0)
    # the turn that was given, and the one found in its axes, are one
    pose[:3, 3] = 0.0
    said = advice(case_with(pose), R, none, known)
    assert said == "give `sensor_turned`='z:30' in place of the pose that was given"
    pose[:3, 3] = -(pose[:3, :3] @ place)
    said = advice(case_with(pose), turn((0, 0, 1), 60.0), place, known)
    assert said == "leave out the pose of the sensor that was given"
    for more, leave in ((0.4, True), (0.6, False)):
        said = advice(case_with(pose), turn((0, 0, 1), 60.0 + more), place, known)
        assert said.startswith("leave out") is leave
    for off, leave in ((0.0049, True), (0.0051, False)):
        there = place + np.array((off, 0.0, 0.0))
        said = advice(case_with(pose), turn((0, 0, 1), 60.0), there, known)
        assert said.startswith("leave out") is leave
    # deviations turn with the axes
    narrow = np.diag(np.radians((0.01, 0.2, 0.2))) ** 2
    quarter_turn = np.eye(4)
    quarter_turn[:3, :3] = turn((0, 1, 0), 90.0)
    own = quarter_turn[:3, :3].T @ turn((0, 0, 1), 30.1)
    said = advice(case_with(quarter_turn), own, none, narrow)
    assert "sensor_pose_in_log" in said
