"""What an estimate shows at a prompt, and what is at hand on it."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import error, warning
from hefting.core.summary import sign_told
from hefting.core.undetermined import Undetermined

BODY = InertialParameters.from_com(
    0.51234, [0.0123, -0.08, 0.06], np.diag([3e-3, 2e-3, 1e-3])
)


def around(value, half):
    """Ends of an interval."""
    return np.array((value - half, value + half))


def estimate(half_inertia=2e-4, **changes) -> Estimate:
    """An estimate with intervals."""
    intervals = {
        "mass": around(BODY.mass, 0.0021),
        "center_of_mass": around(BODY.center_of_mass, 0.001),
        "inertia_at_origin": around(BODY.inertia_at_origin, half_inertia),
        "inertia_at_com": around(BODY.inertia_at_com, half_inertia),
    }
    whole = Estimate("Bayes", BODY, 100, 2.0, intervals=intervals)
    return replace(whole, **changes)


def test_the_text_has_the_numbers_and_what_they_are_worth():
    text = repr(estimate())
    assert "Estimate by Bayes, verdict: good" in text
    assert "mass           0.5123 ± 0.0021 kg" in text
    assert "center of mass 12.3 ± 1.0, -80.0 ± 1.0, 60.0 ± 1.0 mm" in text
    assert "xx 3.00 ± 0.20, xy 0.00 ± 0.20, xz 0.00 ± 0.20" in text
    assert "-0.00" not in text
    assert "100 samples, 2 s" in text
    assert "from           1 sample, 2 s" in repr(estimate(samples=1))


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (0.0021, 0.0021, "0.5123 ± 0.0021"),
        (0.0012, 0.0030, "0.5123 ± 0.0030"),  # at the farther end
        (0.0010, 0.0031, "0.5123 [0.5113, 0.5154]"),
        (0.0, 0.0042, "0.5123 [0.5123, 0.5165]"),
    ],
)
def test_ends_of_a_lopsided_interval_are_shown(low, high, shown):
    """From three to one on: ± would show as much again where there is nothing."""
    ends = np.array((BODY.mass - low, BODY.mass + high))
    intervals = estimate().intervals | {"mass": ends}
    assert f"mass           {shown} kg" in repr(estimate(intervals=intervals))


def test_open_quantities_and_none_at_all():
    assert "xx open, xy open" in repr(estimate(half_inertia=np.inf))
    without = repr(estimate(intervals=None, duration=None))
    assert "mass           0.51234 kg" in without
    assert "±" not in without
    assert "100 samples\n" in without + "\n"


def test_what_is_undetermined_is_open_whatever_its_interval():
    """An interval of a prior has ends, but does not come from the recording."""
    mask = np.eye(3, dtype=bool)
    text = repr(estimate(undetermined=Undetermined(inertia_at_com=mask)))
    assert "xx open, xy 0.00 ± 0.20, xz 0.00 ± 0.20" in text
    assert "yy open, yz 0.00 ± 0.20, zz open" in text
    assert "mass           0.5123 ± 0.0021 kg" in text
    text = repr(estimate(undetermined=Undetermined(mass=True), intervals=None))
    assert "mass           open kg" in text


@pytest.mark.parametrize(("half", "level"), [(0.49, "good"), (0.51, "do not use")])
def test_a_mass_that_is_as_wide_as_half_of_it_is_not_to_be_used(half, level):
    """Also of an estimator by itself, whose estimate has no warnings."""
    ends = estimate().intervals | {"mass": around(BODY.mass, half * BODY.mass)}
    found = estimate(intervals=ends)
    assert found.verdict.level == level
    assert ("does not determine the mass" in repr(found)) == (level != "good")
    # what identify has said is not said again
    assert replace(found, warnings=found.verdict.reasons).verdict == found.verdict


def test_it_stays_short_whatever_is_to_be_said():
    warnings = tuple(error("some-code", "x" * 5000) for _ in range(40))
    text = repr(estimate(warnings=warnings, half_inertia=1e-300))
    assert len(text) < 1500
    assert "and 37 more in .warnings" in text
    assert "verdict: do not use" in text


def test_the_gravest_warning_comes_first_and_has_more_room():
    warnings = (
        warning("no-shape", "what is no doubt"),
        warning("some-doubt", "doubtful"),
        error("some-error", "x" * 290),
    )
    *_, first, second, third = repr(estimate(warnings=warnings)).splitlines()
    assert first == f"  warning: {'x' * 290}"
    assert second == "  warning: doubtful"
    assert third == "  warning: what is no doubt"


def test_values_are_at_hand():
    found = estimate()
    assert found.mass == BODY.mass
    np.testing.assert_array_equal(found.center_of_mass, BODY.center_of_mass)
    np.testing.assert_array_equal(found.inertia, BODY.inertia_at_com)
    low, high = found.interval("mass")
    assert (low, high) == (found.mass - 0.0021, found.mass + 0.0021)
    assert found.interval("center_of_mass").shape == (2, 3)
    assert found.intervals is not None
    assert found.interval("inertia") is found.intervals["inertia_at_com"]


def test_an_interval_that_is_not_there():
    with pytest.raises(InputError, match="did you mean 'mass'") as refused:
        estimate().interval("masss")
    assert "center_of_mass" in str(refused.value)
    with pytest.raises(InputError, match="by Bayes has no intervals"):
        estimate(intervals=None).interval("mass")


@pytest.mark.parametrize(
    ("found", "code", "told"),
    [
        (False, "sign-uncertain", "as given"),
        (True, "sign-uncertain", "uncertain"),
        (True, "no-shape", "found from gravity"),
    ],
)
def test_a_sign_that_is_uncertain_is_not_found(found, code, told):
    assert sign_told({"wrench_found": found}, ("other", warning(code, ""))) == told
