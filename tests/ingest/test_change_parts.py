"""Parts of finding changes: intervals, joint fits, bodies and stretches; and what is said of
them."""

import re
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from benchmarks.changing import moved

from changing_cells import body, random_cells
from hefting.core.inertia import InertialParameters
from hefting.identification import identify
from hefting.ingest.changes.assignment import NO_BODY, Assignment, Part
from hefting.ingest.changes.bodies import JointModel, is_suspicious, with_noise_scale
from hefting.ingest.changes.cells import (
    COST_OF_INTERVAL,
    LARGEST_BIAS,
    LARGEST_PARAMETERS,
    SMALLEST_VARIANCE,
    UNKNOWNS,
    Intervals,
    partition,
)
from hefting.ingest.changes.find import _without_excursions
from hefting.ingest.changes.stretches import (
    Changes,
    EventKind,
    Stretch,
    Touch,
    center_of_mass,
    change_warnings,
    event_between,
    with_returns,
)
from hefting.simulation import UR5, WRENCH_NOISE, Faults, record, wield_analytically


def test_the_cost_of_an_interval_is_that_of_least_squares():
    """Against `lstsq` of the rows of the interval and of the prior."""
    rng = np.random.default_rng(0)
    cells = random_cells(rng, 40)
    begin, end = 5, 29
    rows = np.concatenate(
        (cells.regressor, np.broadcast_to(np.eye(6), (40, 6, 6))), axis=2
    )[begin:end].reshape(-1, UNKNOWNS)
    prior = np.diag(1.0 / np.concatenate((LARGEST_PARAMETERS, LARGEST_BIAS)))
    solution = np.linalg.lstsq(
        np.vstack((rows, prior)),
        np.append(cells.whitened[begin:end].ravel(), np.zeros(UNKNOWNS)),
    )[0]
    residual = cells.whitened[begin:end].ravel() - rows @ solution
    square = np.sum(residual.reshape(-1, 2, 3) ** 2, axis=(0, 2))
    equations = 3.0 * (end - begin)
    variance = np.maximum(square / (equations - 0.5 * UNKNOWNS), SMALLEST_VARIANCE)
    expected = float(np.sum(equations * np.log(variance)))
    found = Intervals(cells).cost(np.array([begin]), np.array([end]))
    # the normal equations square the condition number, of 1e3 here
    assert found[0] == pytest.approx(expected, rel=1e-6)


def test_the_partition_has_the_least_cost_of_all():
    """Of all divisions of 30 cells into up to three intervals of eight cells or more;
    skipped cells are dearer than what they save here."""
    rng = np.random.default_rng(1)
    cells = random_cells(rng, 30, change=13)
    fits = Intervals(cells)
    penalty = UNKNOWNS * np.log(6.0 * len(cells)) + COST_OF_INTERVAL

    def cost(bounds: tuple[int, ...]) -> float:
        edges = np.array((0, *bounds, len(cells)))
        each = fits.cost(edges[:-1], edges[1:])
        return float(each.sum()) + penalty * len(each)

    every = [
        bounds
        for n in range(3)
        for bounds in combinations(range(8, 23), n)
        if min(np.diff((0, *bounds, 30))) >= 8
    ]
    best = min(every, key=cost)
    assert best == (13,)
    assert partition(cells) == [(0, 13), (13, 30)]
    assert partition(random_cells(rng, 30)) == [(0, 30)]


def test_two_bodies_are_joined_at_the_cost_that_is_foretold():
    """The increase of the sum of squares is exact in a linear model, but for the prior,
    of which there is one for each body: a hundredth here."""
    rng = np.random.default_rng(2)
    cells = random_cells(rng, 60, change=30)
    model = JointModel(cells, [(0, 30), (30, 60)])
    two, one = model.fit([0, 1]), model.fit([0, 0])
    increase = float(one.squares.sum() - two.squares.sum())
    assert two.increase(0, 1) == pytest.approx(increase, rel=0.03)


def test_intervals_left_out_have_no_part_in_a_fit():
    rng = np.random.default_rng(3)
    cells = random_cells(rng, 60)
    spoilt = replace(cells, wrench=cells.wrench + 100.0 * (cells.time > 3.95)[:, None])
    parts = [(0, 40), (40, 60)]
    clean, left = (JointModel(c, parts).fit([0, -1]) for c in (cells, spoilt))
    np.testing.assert_array_equal(clean.bodies, left.bodies)
    assert left.squares[1].sum() == 0.0
    # 240 equations, of which body and bias take 34, or less by what the prior tells
    assert 2.0 * left.equations.sum() == pytest.approx(240 - 34, abs=5.0)
    # the variance of unit noise by 206 residuals: within three standard deviations
    assert left.variance == pytest.approx([1.0, 1.0], abs=3.0 * (2.0 / 103.0) ** 0.5)


def test_the_noise_scale_is_that_of_the_noise_beside_a_change():
    """Whatever changes: it is known to a seventh by 300 differences; but for the error
    of a good sensor."""
    rng = np.random.default_rng(4)
    for change in (None, 50):
        cells = with_noise_scale(random_cells(rng, 100, change), np.zeros(2))
        floor = 0.005 * np.linalg.norm(
            np.std(cells.wrench, axis=0).reshape(2, 3), axis=1
        )
        np.testing.assert_allclose(cells.scale, np.hypot(1.0, floor), rtol=0.3)
        assert is_suspicious(cells) == (change is not None)


@pytest.mark.parametrize(
    ("before", "after", "kind"),
    [
        (body(0.0), body(1.0), "picked-up"),
        (body(-0.01), body(0.3), "picked-up"),
        (body(1.1), body(0.1), "put-down"),
        (body(1.0), body(1.3), "swapped"),
        (body(1.0), body(0.4), "swapped"),
        (body(1.0), body(1.01, 0.0, 0.0, 0.12), "slipped"),
        (body(1.0), body(1.06), "swapped"),
    ],
)
def test_kinds(before: np.ndarray, after: np.ndarray, kind: str):
    assert event_between(before, after, 0.005) == kind


def test_masses_of_one_size_within_their_errors_have_slipped():
    assert event_between(body(1.0), body(1.3), 0.1) == "slipped"


def test_a_negligible_mass_has_no_centre():
    assert center_of_mass(body(0.01), 1.0) is None
    np.testing.assert_allclose(center_of_mass(body(1.0), 1.0), (0.0, 0.0, 0.1))


def test_the_stretch_chosen_has_an_object_where_there_is_one():
    bare = Stretch(0.0, 8.0, 0.0, None, "picked-up", bare=True)
    held = Stretch(8.2, 12.0, 1.0, None, "swapped", bare=False)
    other = Stretch(12.2, 15.0, 2.0, None, None, bare=False)
    assert Changes((bare, held, other), (), 15.0).chosen is held
    assert Changes((bare,), (Touch(8.0, 15.0),), 15.0).chosen is bare


def test_beside_a_tool_the_longest_stretch_with_an_object_is_chosen():
    """Of 1 kg, whose recording was 1 % off; the object hangs beside it."""
    tool = body(1.0)
    com = np.array((0.0, 0.05, 0.05))
    empty = Stretch(0.0, 8.0, 1.01, com, "swapped", bare=False)
    held = Stretch(8.2, 12.0, 1.5, com, None, bare=False)
    assert Changes((empty, held), (), 12.0).chosen is empty
    found = Changes((empty, held), (), 12.0).beside(tool)
    assert found.chosen.start == 8.2
    assert found.stretches[0].event == "picked-up"
    own = (1.5 * com - tool[1:4]) / 0.5
    assert found.chosen.mass == pytest.approx(0.5, abs=1e-12)
    np.testing.assert_allclose(found.chosen.center_of_mass, own, atol=1e-12)
    assert "`duration` 8.00 (the tool alone)" in change_warnings(found, chosen=True)[1]


@pytest.mark.parametrize(("mass", "said"), [(0.25, True), (0.04, False)])
def test_a_gripper_that_the_recording_shows_empty_is_said_to_be_included(mass, said):
    """Below 5 % of what is held it may be the sensor's error."""
    com = np.array((0.0, 0.0, 0.05))
    short = Stretch(0.0, 3.0, mass, com, "picked-up", bare=True)
    held = Stretch(3.2, 12.0, 1.0, com, "put-down", bare=False)
    bare = Stretch(12.2, 17.0, mass, com, None, bare=True)
    found = Changes((short, held, bare), (), 17.0)
    assert found.gripper is (bare if said else None)
    _, used = change_warnings(found, chosen=True)
    advice = (
        f"; the gripper of {mass} kg is included: to leave it out, calibrate it, by this "
        "recording too, and give that as `tool`"
    )
    assert (advice in used) == ("gripper" in used) == said
    subtracted = found.beside(body(mass))
    assert "included" not in change_warnings(subtracted, chosen=True)[1]
    assert "included" not in change_warnings(Changes((bare,), (), 17.0), chosen=True)[0]


def test_messages_name_times_kinds_and_what_to_give():
    one = Stretch(0.0, 4.0, 1.0, np.array((0.0, 0.01, 0.02)), "swapped", bare=False)
    other = Stretch(4.2, 9.0, 2.0, None, None, bare=False)
    found = Changes((one, other), (Touch(9.0, 20.0),), 20.0).later(1.0)
    assert [d["center_of_mass"] for d in found.to_dicts()] == [[0.0, 0.01, 0.02], None]
    change, touch, used = change_warnings(found, chosen=True)
    assert change == "the object changes: swapped at 5.1 s"
    assert "from 10.0 to 21.0 s, more than half of the recording" in touch
    assert "`start` 1.00 `duration` 4.00 (1 kg, COM (0, 10, 20) mm)" in used
    assert "only 5.20 to 10.00 s is used" in used
    assert change_warnings(None, chosen=True) == []


def test_of_many_parts_the_longest_are_listed():
    lengths = [2.0, 5.0, 3.0, 9.0, 1.0, 4.0, 6.0, 8.0]
    ends = np.cumsum(lengths)
    kinds = ["swapped"] * 7 + [None]
    parts = tuple(
        Stretch(end - length, end, 1.0, None, kind, bare=False)
        for end, length, kind in zip(ends, lengths, kinds, strict=True)
    )
    touches = tuple(Touch(10.0 * k, 10.0 * k + 1.0) for k in range(7))
    change, touch, used = change_warnings(Changes(parts, touches, 38.0), chosen=True)
    assert change.count("swapped") == 6
    assert change.endswith("and 1 more")
    assert "50.0 to 51.0 s and 1 more: touched" in touch
    starts = [float(x) for x in re.findall(r"`start` (\S+)", used)]
    assert starts == [2.0, 7.0, 10.0, 20.0, 24.0, 30.0]
    assert used.endswith("and 2 more")


@pytest.mark.parametrize(
    ("labels", "masses", "cell", "kept"),
    [
        ([0, 1, 0], (1.0, 1.1), 0.08, [0, 2]),  # somebody pushed: not another object
        ([0, 1, 0], (1.1, 1.0), 0.08, [0, 2]),
        ([0, 1, 0], (1.0, 1.1), 0.12, [0, 1, 2]),  # too steady for a hand
        ([0, 1, 0], (1.0, 0.1), 0.08, [0, 1, 2]),  # put down, and picked up again
        ([0, 1, 0], (0.1, 1.0), 0.08, [0, 1, 2]),
        ([0, 1, 2], (1.0, 1.1, 1.2), 0.08, [0, 1, 2]),  # swapped twice
        ([0, 1], (1.0, 1.1), 0.08, [0, 1]),
        ([0], (1.0,), 0.08, [0]),
    ],
)
def test_an_object_that_comes_back_was_touched_unless_it_was_put_down(
    labels, masses, cell, kept
):
    parts = [Part(30 * i, 30 * i + 30, label) for i, label in enumerate(labels)]
    time = cell * np.arange(30 * len(labels))
    found = SimpleNamespace(
        cells=SimpleNamespace(first=time, last=time + cell, interval=cell),
        stretches=parts,
        labels=[*labels, NO_BODY],
        fit=SimpleNamespace(bodies=np.array(masses)[:, None] * np.ones(10)),
    )
    assert _without_excursions(cast(Any, found)) == [parts[i] for i in kept]


@pytest.mark.parametrize(
    ("ends", "masses", "cell", "kept"),
    [
        ((0, 193, 200), (1.0, 1.1), 0.1, [(0, 200, 0)]),  # 0.7 of 20 s at the end
        ((0, 7, 200), (1.1, 1.0), 0.1, [(0, 200, 1)]),  # and at the start
        ((0, 193, 200), (1.0, 0.1), 0.1, [(0, 193, 0), (193, 200, 1)]),  # put down
        ((0, 188, 200), (1.0, 1.1), 0.1, [(0, 188, 0), (188, 200, 1)]),  # 1.2 s
        ((0, 48, 60), (1.0, 1.1), 0.1, [(0, 48, 0), (48, 60, 1)]),  # much of all
        ((0, 90, 193, 200), (1.0, 1.1, 1.2), 0.1, [(0, 90, 0), (90, 200, 1)]),
        ((0, 592, 600), (1.0, 1.1), 0.3, [(0, 600, 0)]),  # the shortest of 3 minutes
    ],
)
def test_a_body_held_briefly_at_an_end_is_its_neighbour(ends, masses, cell, kept):
    """A tremor of the hand at the end of a right recording had been a slip of 15 mm."""
    labels = range(len(masses))
    parts = [Part(a, b, i) for a, b, i in zip(ends[:-1], ends[1:], labels, strict=True)]
    time = cell * np.arange(ends[-1])
    found = SimpleNamespace(
        cells=SimpleNamespace(first=time, last=time + cell, interval=cell),
        stretches=parts,
        labels=[*labels],
        fit=SimpleNamespace(bodies=np.array(masses)[:, None] * np.ones(10)),
    )
    assert _without_excursions(cast(Any, found)) == kept


@pytest.mark.parametrize(
    ("labels", "masses", "told"),
    [
        ([0, 1, 0], (0.4, 1.6), ["picked-up", "put-down", None]),
        ([0, 1, 0, 1], (0.9, 1.2), ["picked-up", "put-down", "picked-up", None]),
        ([0, 1, 0], (1.2, 0.9), ["put-down", "picked-up", None]),
        ([0, 1, 2], (0.4, 1.6, 1.2), ["swapped", "swapped", None]),
    ],
)
def test_of_two_bodies_that_take_turns_the_lighter_is_the_gripper(labels, masses, told):
    events = cast(list[EventKind | None], ["swapped"] * (len(labels) - 1) + [None])
    assert with_returns(events, labels, [masses[label] for label in labels]) == told


def test_what_a_gripper_held_for_a_while_is_found():
    """A 0.35 kg gripper holds 1.3 kg from 5 to 13 of 16 s."""
    gripper, held = (
        InertialParameters.from_com(m, (0.0, 0.01, z), 2e-3 * m * np.eye(3))
        for m, z in ((0.35, 0.04), (1.65, 0.07))
    )
    joints = moved("random", 16.0, seed=4)
    one, other = (wield_analytically(UR5, joints, body) for body in (gripper, held))
    z = one.measurements
    share = np.interp(z.time, (5.0, 5.2, 13.0, 13.2), (0.0, 1.0, 1.0, 0.0))[:, None]
    wrench = z.wrench + share * (other.measurements.wrench - z.wrench)
    z = replace(z, force=wrench[:, :3], torque=wrench[:, 3:])
    log = record(
        replace(one, measurements=z), Faults(wrench_noise=WRENCH_NOISE["low"]), seed=5
    )
    found = identify(log)
    assert "picked-up at 5.1 s, put-down at 13.1 s" in " ".join(
        map(str, found.warnings)
    )
    # half a percent of the sensor's gain, which is assumed, is in the interval
    low, high = found.estimate.intervals["mass"]
    assert low < 1.65 < high < 1.7


def test_a_body_reaches_as_far_as_it_explains_the_wrench():
    """But into no interval of another body, and no stretch before it."""
    explains = {0: range(0, 28), 1: range(22, 60)}
    made = Assignment(
        cast(Any, range(60)),
        cast(Any, SimpleNamespace(intervals=[(5, 20), (30, 45)])),
        [0, 1],
        cast(Any, None),
        1.0,
    )

    def explained(i: int) -> np.ndarray:
        return np.isin(np.arange(60), explains[i])

    object.__setattr__(made, "_explained", explained)
    assert made._extended(0, 0) == (0, 28)
    assert made._extended(0, 3) == (3, 28)
    assert made._extended(1, 28) == (28, 60)
    explains[0] = range(0, 60)
    assert made._extended(0, 0) == (0, 30)


def test_stretches_in_json_have_a_centre_of_mass_or_none():
    com = np.array((0.0, 0.01, 0.02))
    held = Stretch(0.0, 4.0, 1.0, com, "put-down", bare=False)
    bare = Stretch(4.2, 9.0, 0.0, None, None, bare=True)
    first, second = Changes((held, bare), (), 9.0).to_dicts()
    assert first["center_of_mass"] == [0.0, 0.01, 0.02]
    assert second["center_of_mass"] is None
