"""Cells in which changes are looked for, which of their blocks are left out, and whether
a change is looked for at all."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from changing_cells import body, random_cells
from hefting.ingest.changes import assignment
from hefting.ingest.changes.assignment import (
    NO_BODY,
    Assignment,
    SeparateBodies,
    _with_a_run_changed,
    assign,
    without_contacts,
)
from hefting.ingest.changes.bodies import JointModel, _best_change, is_suspicious
from hefting.ingest.changes.cells import _starts, _without_spikes, has_long_contact
from hefting.ingest.outliers import Outliers, no_outliers


@pytest.mark.parametrize(
    ("lasts", "width"), [(8.0, 0.1), (60.0, 0.1), (120.0, 0.2), (180.0, 0.3)]
)
def test_cells_last_for_a_tenth_of_a_second_or_are_six_hundred(lasts, width):
    """Of blocks of 10 ms; from the first one on, whatever the clock."""
    time = 5.0 + 0.01 * np.arange(round(lasts / 0.01)) + 1e-6
    starts = _starts(time)
    assert len(starts) == pytest.approx(lasts / width, abs=1)
    assert starts[0] == 0
    np.testing.assert_allclose(np.diff(time[starts]), width, atol=0.011)
    # a cell whose time holds no block is none
    gap = time[(time < 6.0) | (time > 6.0 + 3.0 * width)]
    assert len(_starts(time)) - len(_starts(gap)) in (2, 3)


def test_a_spike_is_twelve_median_distances_from_the_median_of_its_cell():
    """Of its cell, or of all where that is more; one channel is enough."""
    time = np.append(-0.005, 0.01 * np.arange(1, 100))
    wrench = np.tile(np.array((-1.0, 1.0))[:, None], (50, 6))
    wrench += (np.arange(100) // 10)[:, None]
    for far, good in ((11.9, True), (12.1, False)):
        for channel in (0, 5):
            spoilt = wrench.copy()
            spoilt[35, channel] = 3.0 + far  # the cell's median is 3, the distances 1
            kept = _without_spikes(time, spoilt, np.ones(100, dtype=bool))
            assert kept[35] == good
            assert kept.sum() == 99 + good
    # what is left out already stays so, and counts for nothing
    left = np.ones(100, dtype=bool)
    left[[5, 34]] = False
    np.testing.assert_array_equal(_without_spikes(time, wrench, left), left)


@pytest.mark.parametrize(("count", "long"), [(70, False), (72, True)])
def test_a_contact_of_seven_tenths_of_a_second_is_long(count, long):
    contact = np.arange(200) // 100 * (np.arange(200) % 100 < count) > 0
    none = no_outliers(200)
    samples = cast(Any, SimpleNamespace(time=0.01 * np.arange(200)))
    found = Outliers(contact, none.spike, none.saturation)
    assert has_long_contact(samples, found) is long
    assert not has_long_contact(samples, none)


@pytest.mark.parametrize(
    ("force", "torque", "suspicious"),
    [(1.0, 14.0, True), (14.0, 1.0, True), (10.0, 10.0, False)],
)
def test_a_body_that_leaves_twelve_times_the_noise_is_suspicious(
    force, torque, suspicious
):
    """Of force or torque alone; white noise tells of no change."""
    cells = random_cells(np.random.default_rng(8), 300)
    variance = JointModel(cells, [(0, 300)]).fit([0]).variance
    scale = np.sqrt(variance / (force, torque))
    assert is_suspicious(replace(cells, scale=scale)) is suspicious


def test_the_best_change_is_where_two_bodies_explain_most():
    """Of all cells, five from the ends or more, by a fit of each."""
    cells = random_cells(np.random.default_rng(9), 60, change=22)

    def square(at: int) -> float:
        return JointModel(cells, [(0, at), (at, 60)]).fit([0, 1]).squares.sum()

    assert _best_change(cells) == min(range(5, 55), key=square) == 22
    for change, found in ((3, 5), (57, 54)):
        late = random_cells(np.random.default_rng(9), 60, change=change)
        assert _best_change(late) == found


def stretches(cells, intervals, labels):
    model = JointModel(cells, intervals)
    return Assignment(cells, model, labels, model.fit(labels), 1.0).stretches


def test_a_stretch_lasts_until_the_next_body_or_what_its_own_does_not_explain():
    """One body all the time, whatever its intervals are called."""
    cells = random_cells(np.random.default_rng(10), 90)
    parts = [(2, 20), (25, 45), (46, 60), (70, 88)]
    apart = stretches(cells, parts, [0, 1, 2, 3])
    assert apart == [(0, 25, 0), (25, 46, 1), (46, 70, 2), (70, 90, 3)]
    assert stretches(cells, parts, [0, 0, 0, 0]) == [(0, 90, 0)]
    # an interval of no body is explained all the same
    assert stretches(cells, parts, [0, NO_BODY, 2, 2]) == [(0, 46, 0), (46, 90, 2)]
    # up to three cells, of a tenth of a second, are a transition
    for count, whole in ((3, True), (4, False)):
        spoilt = replace(cells, wrench=cells.wrench.copy())
        spoilt.wrench[45 : 45 + count] += 40.0
        found = stretches(spoilt, [(0, 45), (45 + count, 90)], [0, 0])
        ends = [(0, 90, 0)] if whole else [(0, 45, 0), (45 + count, 90, 0)]
        assert found == ends


@pytest.mark.parametrize(("size", "good"), [(55.0, True), (65.0, False)])
def test_a_cell_is_explained_up_to_sixty_variances(size, good):
    """Of the sum of its six squares; no variance is below that of the noise."""
    cells = random_cells(np.random.default_rng(11), 60)
    wrench = cells.regressor @ np.full(10, 0.1)
    wrench[55] += (size / 6.0) ** 0.5
    cells = replace(cells, wrench=wrench)
    (found,) = stretches(cells, [(0, 50)], [0])
    assert found == (0, 60 if good else 55, 0)


def test_runs_of_intervals_are_taken_for_contacts_but_for_one_interval():
    """Of one to six."""
    for held, others in (
        ([True], []),
        ([True, True], [[False, True], [True, False]]),
        ([False, True], [[True, True]] * 2),
    ):
        assert _with_a_run_changed(np.array(held)).tolist() == others
    found = _with_a_run_changed(np.ones(9, dtype=bool))
    runs = {tuple(np.flatnonzero(~each)) for each in found}
    assert runs == {
        tuple(range(i, j)) for i in range(9) for j in range(i + 1, min(i + 6, 9) + 1)
    }
    assert len(found) == len(runs)


@pytest.mark.parametrize("reference", [1.0, 2.5])
def test_costs_without_a_body_are_those_of_joint_fits(reference):
    """Every choice of intervals, the bodies eliminated, beside a fit of each choice."""
    rng = np.random.default_rng(13)
    cells = random_cells(rng, 120, change=50)
    cells.wrench[70:90] += 2.0 * rng.normal(size=(20, 6))
    model = JointModel(cells, [(0, 30), (31, 50), (50, 70), (70, 90), (92, 120)])
    choices = np.array([k >> np.arange(5) & 1 for k in range(1, 32)], dtype=bool)
    expected = []
    for held in choices:
        labels = [i if kept else NO_BODY for i, kept in enumerate(held)]
        fit = model.fit(labels)
        variances = fit.squares / np.maximum(fit.equations, 1.0)[:, None]
        variances = np.maximum(variances / reference, 1.0)
        each = fit.equations * np.log(variances).sum(axis=1)
        contact = 6.0 * model.lengths * np.log(16.0)
        expected.append(np.where(held, each, contact).sum())
    found = SeparateBodies(model).costs(choices, reference)
    # the joint fits invert the unknowns of all bodies, of very different sizes
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("size", "held"), [(3.0, True), (5.0, False)])
def test_a_contact_is_four_times_as_large_as_noise(size, held):
    """A body with a push of white noise, from 20 to 50 of 90 cells."""
    rng = np.random.default_rng(12)
    cells = random_cells(rng, 90)
    cells.wrench[20:50] += (size**2 - 1.0) ** 0.5 * rng.normal(size=(30, 6))
    model = JointModel(cells, [(0, 20), (20, 50), (50, 90)])
    alone = np.ones(3, dtype=bool)
    assert without_contacts(model, 1.0, alone).tolist() == [True, held, True]
    # of noisier bodies a larger push is none
    assert without_contacts(model, 4.0, alone).all()
    found = assign(cells)
    assert found is not None
    assert len({label for label in found.labels if label != NO_BODY}) == 1


def test_what_is_held_between_two_contacts_is_a_body():
    """A hand, a pick and a placing of a second each with pushes of 200 times the
    noise, and the hand again: beside both contacts as bodies the object has a large residual,
    as bias and clock offset are misled."""
    rng = np.random.default_rng(14)
    cells = random_cells(rng, 200)
    cells.wrench[80:150] += cells.regressor[80:150] @ body(5.0, 0.1, 0.2, 0.3)
    for begin in (75, 145):
        cells.wrench[begin : begin + 10] += 200.0 * rng.normal(size=(10, 6))
    intervals = [(0, 75), (75, 85), (85, 145), (145, 155), (155, 200)]
    model, alone = JointModel(cells, intervals), np.ones(5, dtype=bool)
    held = without_contacts(model, 1.0, alone)
    assert held.tolist() == [True, False, True, False, True]


@pytest.mark.parametrize(("cost", "kept"), [(1.0, "1010"), (20.0, "1111")])
def test_contacts_that_mislead_together_are_left_out_together(cost, kept, monkeypatch):
    """Each of two contacts costs more alone, and both less, or more."""

    class Costs:
        def __init__(self, model):
            pass

        def costs(self, held, reference):
            found = [10.0 if each.all() else 30.0 for each in held]
            both = (held == (True, False, True, False)).all(axis=1)
            return np.where(both, cost, found)

    monkeypatch.setattr(assignment, "SeparateBodies", Costs)
    alone = np.array((True, False, True, False))
    held = without_contacts(None, 1.0, alone)
    assert "".join(map(str, held.astype(int))) == kept
    # from bodies in all of them no run alone lowers the cost
    assert without_contacts(None, 1.0, np.ones(4, dtype=bool)).all()


def test_an_object_that_is_placed_again_and_again_is_two_bodies():
    """Every five seconds of a minute; so many events within ten seconds are none."""
    cells = random_cells(np.random.default_rng(4), 600)
    held = np.arange(600) // 50 % 2 == 1
    cells.wrench[held] += cells.regressor[held] @ body(5.0, 0.1, 0.2, 0.3)
    found = assign(cells)
    assert found is not None
    assert found.model.intervals == [(50 * i, 50 * i + 50) for i in range(12)]
    assert found.labels == [0, 1] * 6
    hurried = replace(cells, time=cells.time / 6.0)
    assert assign(replace(hurried, first=hurried.time, last=hurried.time)) is None
