"""Parts of rival explanations, without their fits: rotations, the words of a calibration
matrix, shares of a payload, and which offset stands out."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.spatial import STANDARD_GRAVITY, WRENCH, skew
from hefting.ingest.offset import Design, _stands_out
from hefting.ingest.response import Response
from hefting.ingest.rivals import not_rigid, two_mistakes, wrench_compensated
from hefting.ingest.rivals.axes_turned import (
    QUARTER_TURNS,
    _ascend,
    _quadratic,
    nearest_rotations,
)
from hefting.ingest.rivals.axis_flipped import _turns_apart
from hefting.ingest.rivals.base import _along_axis
from hefting.ingest.rivals.evidence import Rows
from hefting.ingest.rivals.sensor_calibration import RANGES, _largest_error


def test_quarter_turns_are_the_rotations_of_a_cube():
    assert QUARTER_TURNS.shape == (24, 3, 3)
    assert len(np.unique(QUARTER_TURNS.round(), axis=0)) == 24
    np.testing.assert_allclose(np.linalg.det(QUARTER_TURNS), 1.0)
    np.testing.assert_array_equal(np.abs(QUARTER_TURNS).sum(axis=1), 1.0)


def test_the_nearest_rotation_is_scipys():
    """Of any matrix, those that mirror too."""
    M = np.random.default_rng(1).normal(size=(20, 3, 3))
    found = nearest_rotations(M.reshape(4, 5, 9)).reshape(20, 3, 3)
    # the rotation R for which |M - R| is least aligns the axes with the rows of M
    expected = [Rotation.align_vectors(m.T, np.eye(3))[0].as_matrix() for m in M]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def problem():
    """Rows of two alternatives, and a case whose wrench they explain once it is turned."""
    rng = np.random.default_rng(2)
    known, maps = rng.normal(size=(2, 60, 7)), rng.normal(size=(7, 6, 4))
    R = Rotation.random(random_state=3).as_matrix()
    exact = np.einsum("kz,zcp,p->kc", known[1], maps, rng.normal(size=4))
    wrench = (exact.reshape(-1, 2, 3) @ R).reshape(-1, 6)
    weights, scale = rng.uniform(0.5, 2.0, (2, 60)), np.array(((1.0, 0.3), (2.0, 0.5)))
    case = cast(Any, SimpleNamespace(wrench=wrench))
    return case, Rows(known, maps, np.ones((2, 60))), weights, scale, R


def test_what_a_rotation_leaves_is_a_quadratic_of_its_entries():
    """By weighted least squares of the turned wrench."""
    case, rows, weights, scale, _ = problem()
    Q, square = _quadratic(case, rows, weights, scale)
    for o in range(2):
        R = Rotation.random(random_state=10 + o).as_matrix()
        turned = (case.wrench.reshape(-1, 2, 3) @ R.T).reshape(-1, 6)
        unit = np.sqrt(weights[o])[:, None] / np.repeat(scale[o], 3)
        A = np.einsum("kz,zcp->kcp", rows.known[o], rows.maps) * unit[:, :, None]
        b = (turned * unit).ravel()
        _, left, *_ = np.linalg.lstsq(A.reshape(len(b), -1), b)
        v = R.ravel()
        assert square[o] == pytest.approx(b @ b)
        assert square[o] - v @ Q[o] @ v == pytest.approx(left[0], rel=1e-6)


def test_the_ascent_finds_the_rotation_that_leaves_nothing():
    case, rows, weights, scale, R = problem()
    found, value = _ascend(case, rows, weights, scale, QUARTER_TURNS)
    # each of its steps takes a part of the error
    assert np.degrees(Rotation.from_matrix(found[1] @ R.T).magnitude()) < 3.0
    assert value[1] > value[0]
    Q, square = _quadratic(case, rows, weights, scale)
    v = found.reshape(2, 9)
    expected = np.einsum("oi,oij,oj->o", v, Q, v) - square
    np.testing.assert_allclose(value, expected / weights.sum(axis=1), atol=1e-9)


def test_force_and_torque_alone_are_turned_back():
    """An object of 2 kg, in either sign of the wrench: force 2 s, torque 2 [c]x s."""
    for seed, sign in enumerate((1.0, -1.0)):
        R = Rotation.random(random_state=seed).as_matrix()
        c = np.array((0.03, -0.05, 0.1))
        force, torque = 2.0 * sign * np.eye(3), 2.0 * sign * skew(c)
        (only, undo), *_ = _turns_apart(R @ force, torque)
        assert only == 0
        np.testing.assert_allclose(undo @ R, np.eye(3), atol=1e-12)
        both = [undo for only, undo in _turns_apart(force, R @ torque) if only == 1]
        assert len(both) == 2
        for undo in both:
            back = undo @ R @ torque
            np.testing.assert_allclose(back, -back.T, atol=1e-12)
            assert np.linalg.det(undo) == pytest.approx(1.0)
        off = [np.abs(undo @ R - np.eye(3)).max() for undo in both]
        assert min(off) < 1e-12


def test_the_largest_error_of_a_calibration_matrix_is_told():
    """By what it does to a channel, as a share of its range; a gain as it is."""
    size = np.array((10.0, 10.0, 10.0, 1.0, 1.0, 1.0))
    errors = np.zeros((6, 6))
    errors[1, 1] = -0.02
    errors[0, 3] = 0.15  # a newton metre makes 0.15 N: 1.5 % of a range
    assert _largest_error(errors, size) == (
        "gain-uneven",
        "the sensor's channels seem to have different gains, fy -2.0 % against the others",
    )
    errors[4, 2] = 3e-3
    code, what = _largest_error(errors, size)
    assert code == "cross-talk"
    assert f"{WRENCH[4]} to {WRENCH[2]} by +3.0 % of its range" in what
    np.testing.assert_array_equal(RANGES, (1.0, 1.0, 1.0, 0.1, 0.1, 0.1))


@pytest.mark.parametrize(
    ("mass", "weighed", "words", "judged"),
    [
        (2.0, 1.992, None, False),  # less than half a percent is missing
        (2.0, 1.988, "some 1 % of the object's weight", True),
        (2.0, 1.902, "some 5 % of", True),
        (2.0, 1.898, "some 5 % of", False),
        (2.0, 0.0, "some 100 % of", False),
        (2.0, -1.0, "some 3 kg, more than the object's,", False),
        (0.03, -2.9, "some 2.9 kg, more", False),
        (0.03, -3.1, None, False),
        (2.0, 2.49, None, False),
        (2.0, 2.51, "some 25 % of the object's weight seem to be added", False),
        (2.0, 11.9, "some 495 % of the object's weight seem to be added", False),
        (2.0, 12.1, None, False),
        (0.0, 1.0, None, False),
    ],
)
def test_a_payload_is_told_from_half_a_percent_to_a_hundred_times_the_weight(
    mass, weighed, words, judged, monkeypatch
):
    """A small share has to be seen by itself."""
    solution = np.zeros((1, 14))
    solution[0, 0], solution[0, 10] = mass, weighed
    fitted = SimpleNamespace(best=0, solution=solution)
    monkeypatch.setattr(wrench_compensated, "over_offsets", lambda *_: (fitted, 0.0))
    monkeypatch.setattr(wrench_compensated, "_effect", lambda fitted: 7.0)
    monkeypatch.setattr(wrench_compensated, "explains_nothing", lambda *_: False)
    case = SimpleNamespace(
        path=SimpleNamespace(moves=True, kind="smooth"),
        gravity=np.array(STANDARD_GRAVITY),
    )
    found = wrench_compensated.explain(cast(Any, case))
    assert (found is not None) is (words is not None)
    if found is not None:
        assert words in found.what
        assert (found.effect == 7.0) is judged
    for other in (
        {"moves": False, "kind": "static"},
        {"moves": True, "kind": "orientation"},
    ):
        case.path = SimpleNamespace(**other)
        assert wrench_compensated.explain(cast(Any, case)) is None
    case.path, case.gravity = SimpleNamespace(moves=True, kind="smooth"), np.zeros(3)
    assert wrench_compensated.explain(cast(Any, case)) is None


@pytest.mark.parametrize("axis", range(3))
def test_a_wrist_holds_an_object_within_its_reach(axis):
    """Whichever axis the COM is on."""
    for distance, held in ((0.9, True), (1.1, False)):
        vector = np.zeros(10)
        vector[0], vector[1 + axis] = -2.0, 2.0 * distance * two_mistakes.FARTHEST_COM
        found = SimpleNamespace(vector=vector, is_too_heavy=False)
        assert two_mistakes._is_held(cast(Any, found)) is held
        found.is_too_heavy = True
        assert not two_mistakes._is_held(cast(Any, found))


@pytest.mark.parametrize(
    ("last", "changes"), [(1.0, True), (0.0, False), (-1.0, False)]
)
def test_an_object_that_changes_never_weighs_nothing(last, changes):
    """A mass through zero is a drift of the sensor."""
    bodies = np.array([[2.0, 0.0, 0.1, 0.2], [last, 0.0, 0.05 * last, 0.1 * last]])
    solution = np.append(np.zeros(6), bodies)
    fitted = SimpleNamespace(best=0, solution=solution[None], scale=np.ones((1, 2)))
    found = not_rigid._explanation(cast(Any, fitted), 2)
    assert (found is not None) is changes


@pytest.mark.parametrize("axis", range(3))
def test_the_first_moment_lacks_as_much_as_the_mass_where_time_runs_too_fast(axis):
    """Of 40 %: within a tenth of what is missing, whichever axis the COM is on."""
    for wrong, alike in ((0.0, True), (0.8, True), (1.2, False)):
        solution = np.zeros(14)
        solution[1 + axis] = 0.3
        wrong *= wrench_compensated.ALIKE * 0.4 * 0.3
        solution[11 + axis] = 0.6 * 0.3 + wrong
        assert wrench_compensated._is_alike(solution, 0.4) is alike


def test_gravity_is_along_an_axis_that_it_is_within_three_degrees_of():
    for degrees, along in ((2.9, True), (3.1, False)):
        angle = np.radians(degrees)
        for sign in (1.0, -1.0):
            g = 9.81 * np.array((np.sin(angle), sign * np.cos(angle), 0.0))
            expected = np.array((0.0, sign * 9.81, 0.0)) if along else g
            np.testing.assert_allclose(_along_axis(g), expected)


def test_an_offset_stands_out_by_its_likelihood_over_all_that_are_far():
    offsets = 0.05 * np.arange(7)
    likelihood = np.array((-1.0, -1.0, -0.1, 0.0, -0.1, -0.09, -1.0))
    # of 100 ms and less from the best none counts
    fits = cast(Any, SimpleNamespace(best=3, likelihood=likelihood))
    assert _stands_out(fits, offsets, 26)
    assert not _stands_out(fits, offsets, 24)
    near = cast(Any, SimpleNamespace(best=1, likelihood=likelihood[:3]))
    assert not _stands_out(near, offsets[:3], 10**6)


def test_a_tilt_is_that_of_the_mass():
    solution = np.arange(1.0, 20.0)
    design = Design(np.zeros(0), np.zeros(0), np.zeros(0), 18)
    np.testing.assert_allclose(design.tilt_of(solution), (11.0, 15.0))
    np.testing.assert_allclose(design.tilt_of(-2.0 * solution), (11.0, 15.0))
    fixed = Design(np.zeros(0), np.zeros(0), np.zeros(0), 10)
    np.testing.assert_array_equal(fixed.tilt_of(solution), 0.0)
    solution[0] = 0.0
    np.testing.assert_array_equal(design.tilt_of(solution), 0.0)


def test_a_filter_is_told_from_three_deviations_on():
    for share, told in ((0.29, 0), (0.31, 1), (-0.9, 0)):
        found = Response(0.123, share, 0.1, np.zeros((2, 6)), np.zeros((10, 2)))
        assert len(found.messages()) == told
    found = Response(0.123, 0.9, 0.1, np.zeros((2, 6)), np.zeros((10, 2)))
    assert "lags by 0.12 s" in found.messages()[0]
