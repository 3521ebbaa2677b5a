"""Where mistakes of clocks are looked for, and which of them are tried: limits from both
sides, without the fits."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from benchmarks.given import correct

from given_cases import case_of
from hefting.ingest.rivals import bias, timing, units
from hefting.ingest.rivals.timing import _times


class AskedError(Exception):
    """A fit was asked for."""


def asked(*_: Any, **__: Any) -> Any:
    raise AskedError


def lasting(seconds: float, moves: bool = True, biased: bool = True) -> Any:
    path = SimpleNamespace(moves=moves, first=0.0, last=10.0 + seconds)
    time = np.linspace(5.0, 5.0 + seconds, 40)
    return cast(Any, SimpleNamespace(time=time, path=path, biased=biased))


@pytest.mark.parametrize(
    ("explain", "name", "seconds", "tried"),
    [
        (timing.explain_clock_rate, "_coarse", 2.9, False),
        (timing.explain_clock_rate, "_coarse", 3.1, True),
        (bias.explain_drift, "over_offsets", 1.8, False),
        (bias.explain_drift, "over_offsets", 2.0, True),
        (bias.explain_drift, "over_offsets", 3.7, True),
        (bias.explain_drift, "over_offsets", 7.8, True),
        (bias.explain_drift, "over_offsets", 8.0, False),
    ],
)
def test_a_clock_takes_three_seconds_and_a_drift_two_to_eight(
    explain, name, seconds, tried, monkeypatch
):
    """And motion; a drift a bias, too."""
    monkeypatch.setitem(explain.__globals__, name, asked)
    assert explain(lasting(seconds, moves=False)) is None
    if tried:
        with pytest.raises(AskedError):
            explain(lasting(seconds))
    else:
        assert explain(lasting(seconds)) is None
    if explain is bias.explain_drift:
        assert explain(lasting(seconds, biased=False)) is None


def test_a_fast_clock_of_the_poses_is_right_in_the_middle_of_the_recording():
    """But for the offset."""
    case = lasting(10.0)
    times = _times(case, np.array((0.0, 0.02, -0.02)), np.array((0.0, 0.1, 0.0)))
    middle = case.time.mean()
    np.testing.assert_allclose(times[0], case.time, atol=1e-12)
    np.testing.assert_allclose(times.mean(axis=1) - middle, (0.0, -0.1, 0.0), atol=1e-9)
    np.testing.assert_allclose(np.ptp(times, axis=1), (10.0, 10.2, 9.8))


@pytest.mark.parametrize(
    ("unit", "interval", "said"),
    [
        (2.0, 0.01, "run 2 times too slow"),
        (2.5, 0.01, "run 2.5 times too slow"),
        (3.0, 0.01, "run 3 times too slow"),
        (4.0, 0.01, "run 4 times too slow"),
        (5.0, 0.01, "run 5 times too slow, or"),
        (8.0, 0.01, "run 8 times too slow, or"),
        (10.0, 0.01, "run 10 times too slow, or"),
        (0.5, 1e-4, "run 2 times too fast, or the controller to subtract 75 %"),
        (0.4, 0.06, "run 2.5 times too fast, or the controller to subtract 84 %"),
        (0.4, 0.04, "run 2 times too fast"),
        (0.1, 0.06, "run 10 times too fast, or the controller to subtract 99 %"),
        (1e-3, 0.21, "be in milliseconds"),
        (1e-3, 0.19, "run 10 times too fast"),
    ],
)
def test_the_unit_of_time_is_the_likeliest_of_usual_rates(
    unit, interval, said, monkeypatch
):
    """Of less than a second where samples are as far apart as none are."""
    monkeypatch.setattr(units, "_with_time_in", lambda case, unit: lambda motion: unit)
    monkeypatch.setattr(
        units,
        "fit_rows",
        lambda case, tried: SimpleNamespace(likelihood=[-abs(np.log(tried / unit))]),
    )
    monkeypatch.setattr(units, "over_offsets", lambda case, build: (None, 0.0))
    monkeypatch.setattr(units, "explains_nothing", lambda case, build: False)
    case = SimpleNamespace(
        path=SimpleNamespace(kind="smooth", gravity_measured=False),
        recording={"wrench": SimpleNamespace(time=interval * np.arange(20.0))},
        likely_offsets=np.zeros(1),
        motion_late=lambda offsets: None,
    )
    found = units.explain_time(cast(Any, case))
    assert found is not None
    assert f"time seems to {said}" in found.what
    what_else = unit > 4.0 if unit > 1.0 else "milli" not in said
    assert (", or" in found.what) is what_else
    assert (found.alternative is None) == (unit < 1.0)
    case.path.kind = "columns"
    assert units.explain_time(cast(Any, case)) is None


def test_accelerations_go_with_the_inverse_square_of_the_unit(monkeypatch):
    monkeypatch.setattr(units, "newton_euler", lambda case, motion: motion)
    monkeypatch.setattr(units, "replace", lambda given, **new: SimpleNamespace(**new))
    motion = SimpleNamespace(a=np.ones(3), rest=np.full(9, 2.0))
    found = units._with_time_in(cast(Any, None), 4.0)(cast(Any, motion))
    np.testing.assert_array_equal(found.a, 1.0 / 16.0)
    np.testing.assert_array_equal(found.rest, 1.0 / 8.0)


def test_another_clock_leaves_no_sample_out():
    """Those beyond the last pose had not counted, so that what was grasped at the end of
    a recording had been a clock that is 5 % fast."""
    case = case_of(correct(0))
    fitted, _ = timing._fit(case, 0.05, 0.3, None)
    assert (fitted.weights[fitted.best] > 0.0).all()
