"""From an assignment of bodies to what is told of changes: limits from both sides."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.ingest.changes import find
from hefting.ingest.changes.assignment import NO_BODY, Part
from hefting.ingest.changes.find import (
    _best_offset,
    _changes,
    _events,
    _is_change,
    _is_contact,
    _is_explained,
    _mass_is_open,
    _times,
    _touches,
    _unexplained,
)
from hefting.ingest.changes.stretches import Changes, Stretch, Touch, change_warnings

TIME = 5.0 + 0.1 * np.arange(100)


def assigned(variance: float = 1.0, **more: Any) -> Any:
    """Of a hundred cells of a tenth of a second."""
    cells = SimpleNamespace(first=TIME, last=TIME + 0.09, time=TIME + 0.045)
    cells = type("Cells", (), {"__len__": lambda _: 100, **vars(cells)})()
    return cast(Any, SimpleNamespace(cells=cells, variance=variance, **more))


@pytest.mark.parametrize(
    ("otherwise", "variance", "change", "contact"),
    [
        (0.81, 1.0, True, False),
        (0.79, 1.0, False, False),
        (2.9, 1.0, True, False),
        (3.1, 1.0, True, True),
        (3.1, 0.5, True, True),
        (2.9, 0.5, True, False),  # of no less than the noise
        (23.9, 7.9, True, True),
        (23.6, 7.9, True, False),
        (99.0, 8.1, True, False),
    ],
)
def test_what_is_wrong_all_the_time_is_neither_change_nor_contact(
    otherwise, variance, change, contact, monkeypatch
):
    """Where any linear function explains the wrench as well, or nearly."""
    monkeypatch.setattr(
        find,
        "variance_of_any_linear_function",
        lambda cells: np.array((0.0, otherwise)),
    )
    found = assigned(variance)
    assert _is_change(found, [Part(0, 50, 0), Part(50, 100, 1)]) is change
    assert not _is_change(found, [Part(0, 50, 0), Part(60, 100, 0)])
    assert _is_contact(found) is contact


def test_touches_are_what_lasts_between_the_stretches():
    """And before and after them; since the start, for seven tenths of a second."""
    touches = _touches(
        assigned(), [Part(0, 20, 0), Part(28, 60, 0), Part(67, 90, 1)], 5.0
    )
    found = [(t.start, t.end) for t in touches]
    np.testing.assert_allclose(found, [(2.0, 2.79), (9.0, 9.99)], atol=1e-9)
    (whole,) = _touches(assigned(), [Part(8, 100, 0)], 5.0)
    assert (whole.start, whole.end) == pytest.approx((0.0, 0.79))
    assert _touches(assigned(), [Part(0, 100, 0)], 5.0) == []


def test_stretches_have_a_margin_at_a_change():
    cells = assigned().cells
    assert _times(cells, 0, 100, 5.0) == pytest.approx((0.0, 9.99))
    assert _times(cells, 20, 100, 5.0) == pytest.approx((2.05, 9.99))
    assert _times(cells, 0, 50, 5.0) == pytest.approx((0.0, 4.94))


def test_a_mass_is_open_within_three_deviations_of_the_heaviest():
    for mass, open_ in ((2.9, True), (3.1, False), (-3.1, False)):
        bodies = np.zeros((2, 10))
        bodies[:, 0] = 0.1, mass
        covariance = np.zeros((20, 20))
        covariance[0, 0], covariance[10, 10] = 100.0, 1.0
        fit = SimpleNamespace(bodies=bodies, covariance=covariance)
        assert _mass_is_open(cast(Any, fit)) is open_


def test_an_assignment_is_worse_for_residuals_and_then_for_time_without_a_body():
    model = SimpleNamespace(intervals=[(0, 30), (30, 50), (50, 100)])

    def made(variance, labels):
        return assigned(variance, model=model, labels=labels)

    assert _unexplained(made(3.1, [0, 0, 0])) == (True, 3.1)
    assert _unexplained(made(2.9, [0, 0, 0])) == (False, pytest.approx(-9.9))
    left = _unexplained(made(2.9, [0, NO_BODY, 0]))
    assert left == (False, pytest.approx(1.99 - 9.9))


@pytest.mark.parametrize(
    ("offset", "moves", "first", "variances", "asked"),
    [
        (0.0, True, 1.0, [], []),
        (0.021, True, 1.0, [9.0], [0.0]),
        (0.019, True, 1.0, [], []),
        (0.021, False, 9.0, [], []),
        (0.0, True, 3.1, [9.0] * 8, list(find.OFFSETS)),
        (0.0, True, 2.9, [], []),
        (-0.03, True, 9.0, [2.0], [0.0]),
    ],
)
def test_other_clock_offsets_are_tried_where_bodies_explain_little(
    offset, moves, first, variances, asked, monkeypatch
):
    """None at all, where the one found is not negligible; then those that are usual."""
    model = SimpleNamespace(intervals=[(0, 100)])
    left, tried = iter([first, *variances]), []

    def assign(cells):
        return assigned(next(left), model=model, labels=[0])

    def cells_at(samples, found, offset):
        tried.append(offset)
        return offset

    monkeypatch.setattr(find, "assign", assign)
    monkeypatch.setattr(find, "_cells", cells_at)
    problem = SimpleNamespace(path=SimpleNamespace(moves=moves))
    robust = SimpleNamespace(problem=problem, fit=SimpleNamespace(offset=offset))
    best = _best_offset(cast(Any, None), cast(Any, robust), cast(Any, None))
    assert tried == asked
    assert best is not None
    assert best.variance == min([first, *variances])
    for poor, none in ((30.1, True), (29.9, False)):
        left = iter([poor] * 10)
        found = _best_offset(cast(Any, None), cast(Any, robust), cast(Any, None))
        assert (found is None) is none


def test_bodies_that_explain_less_than_half_of_a_recording_do_not_explain_it():
    """As the rest may be the wrench at another clock offset, not a contact."""
    for middle, explained in ((49, True), (51, False)):
        model = SimpleNamespace(intervals=[(0, 100 - middle), (100 - middle, 100)])
        found = assigned(2.9, model=model, labels=[0, NO_BODY])
        assert _is_explained(found) is explained
    assert not _is_explained(assigned(3.1, model=model, labels=[0, 0]))


def test_nothing_is_told_where_no_stretch_lasts(monkeypatch):
    """For one and a half seconds; nor of one body without a contact."""
    monkeypatch.setattr(find, "_without_excursions", lambda found: [Part(0, 50, 0)])
    for lasts, contact, told in (
        (1.51, True, True),
        (1.49, True, False),
        (1.51, False, False),
    ):
        monkeypatch.setattr(find, "_is_contact", lambda found, so=contact: so)
        one = Stretch(0.0, lasts, 1.0, None, "touched", bare=False)
        short = Stretch(3.0, 3.1, 1.0, None, None, bare=False)
        monkeypatch.setattr(find, "_described", lambda *_, s=(one, short): list(s))
        changes = _changes(assigned(), 5.0)
        assert (changes is not None) is told
        if changes is not None:
            assert changes.duration == pytest.approx(9.99)
            assert len(changes.touches) == 1
    monkeypatch.setattr(find, "_without_excursions", lambda found: [Part(0, 100, 0)])
    assert _changes(assigned(), 5.0) is None


def test_events_are_told_by_the_deviation_of_the_difference():
    """Of correlated residuals, of the size they are; and a touch at the end."""
    bodies = [np.append(m, np.full(9, 0.1)) for m in (2.0, 2.5, 2.5)]

    def ends(labels, variance, tau, touches=()):
        C = np.zeros((10, 10))
        C[0, 0] = 1e-3
        fit = SimpleNamespace(
            difference=lambda i, j: (None, C), variance=np.array((variance, 99.0))
        )
        times = [(0.0, 3.0), (3.1, 6.0), (6.1, 9.0)]
        return _events(cast(Any, fit), labels, bodies, times, list(touches), tau)

    # four deviations of half a kilogram: a variance of 1/64
    assert ends([0, 1, 1], 1.0, 15.0) == ["swapped", "touched", None]
    assert ends([0, 1, 1], 1.0, 16.0)[0] == "slipped"
    assert ends([0, 1, 1], 0.1, 15.0)[0] == "swapped"
    assert ends([0, 1, 1], 4.0, 4.0)[0] == "slipped"
    assert ends([0, 1, 1], 4.0, 3.8)[0] == "swapped"
    late, early = Touch(8.91, 9.9), Touch(8.89, 9.9)
    assert ends([0, 1, 1], 1.0, 1.0, [late])[-1] == "touched"
    assert ends([0, 1, 1], 1.0, 1.0, [early])[-1] is None


@pytest.mark.parametrize(
    ("touch", "zeroed"),
    [(Touch(0.0, 2.0), True), (Touch(7.0, 9.0), True), (Touch(3.0, 4.0), False)],
)
def test_a_touch_to_an_end_may_be_a_sensor_that_was_zeroed(touch, zeroed):
    held = Stretch(touch.end, 9.0, 1.0, None, None, bare=False)
    parts = (
        (held,)
        if touch.start == 0.0
        else (Stretch(0.0, touch.start, 1.0, None, "touched", bare=False),)
    )
    if touch.start == 3.0:
        parts = (*parts, held)
    (said, *_) = change_warnings(Changes(parts, (touch,), 9.0), chosen=True)
    assert ("or was the sensor zeroed" in said) is zeroed
    assert "more than half" not in said
