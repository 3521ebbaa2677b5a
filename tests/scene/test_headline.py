"""Headline: verdict and numbers as they stand over a picture."""

import re

import numpy as np
import pytest

from hefting.core.estimate import Estimate
from hefting.core.messages import error, warning
from hefting.core.undetermined import Undetermined
from hefting.scene import headline_of, plus_minus, vector_text
from hefting.simulation import hammer

BODY = hammer().parameters


def intervals(mass=0.01, com=(1e-3, 2e-3, 3e-3), inertia=1e-4):
    return {
        name: np.array((value - half, value + half))
        for name, value, half in (
            ("mass", BODY.mass, mass),
            ("center_of_mass", BODY.center_of_mass, np.array(com)),
            ("inertia_at_com", BODY.inertia_at_com, np.full((3, 3), inertia)),
        )
    }


def headline(**more):
    return headline_of(Estimate("test", BODY, samples=10, **more))


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [
        (172.2413, 0.8256, "172.24 ± 0.83"),
        (-6.72, 16.2, "−7 ± 16"),
        (0.67035, 0.0046, "0.6704 ± 0.0046"),
        (-0.001, 0.3, "0.00 ± 0.30"),
        (1234.0, 456.0, "1234 ± 456"),
        (1.5, np.inf, "open"),
        (1.5, None, "1.5"),
        (1.5, np.nan, "1.5"),
        (-1.5, 0.0, "−1.5 ± 0"),
    ],
)
def test_a_number_has_the_digits_that_its_interval_allows(value, half, text):
    assert plus_minus(value, half) == text


def test_the_lines_hold_values_and_half_widths():
    lines = headline(intervals=intervals()).numbers
    expected = (
        ((BODY.mass, 0.01),),
        tuple(zip(1e3 * BODY.center_of_mass, (1.0, 2.0, 3.0), strict=True)),
        tuple((1e3 * J, 0.1) for J in BODY.inertia_at_com.diagonal()),
    )
    for line, pairs in zip(lines, expected, strict=True):
        read = re.findall(r"(−?[\d.]+) ± ([\d.]+)", line)
        assert len(read) == len(pairs)
        for (value, half), (true, width) in zip(read, pairs, strict=True):
            assert float(half) == pytest.approx(width, rel=0.05)  # two digits
            assert float(value.replace("−", "-")) == pytest.approx(
                true, abs=0.05 * width + 1e-12
            )
    assert lines[0].endswith("kg")
    assert lines[1].endswith("mm")
    assert "10⁻³ kg m²" in lines[2]


def test_what_is_shown_holds_a_lopsided_interval():
    """As of a moment at the bound of what the shape allows: 1.26 [1.26, 3.07]."""
    ends = intervals()
    ends["mass"] = BODY.mass + np.array((0.0, 0.4))
    [(value, far)] = re.findall(
        r"([\d.]+) ± ([\d.]+)", headline(intervals=ends).numbers[0]
    )
    assert float(far) == pytest.approx(0.4)
    assert float(value) == pytest.approx(BODY.mass, abs=0.01)


def test_without_intervals_the_covariance_serves_and_without_both_nothing_is_claimed():
    covariance = np.diag(np.full(10, 1e-4))
    assert f"± {1.96 * 0.01:.3f} kg" in headline(covariance=covariance).numbers[0]
    bare = headline().numbers
    assert "no intervals" in bare[0]
    assert "±" not in "".join(bare)


def test_what_is_open_has_no_number():
    found = headline(intervals=intervals(com=(1e-3, np.inf, 3e-3), inertia=np.inf))
    assert "y open" in found.numbers[1]
    assert found.numbers[2] == "inertia at the COM: open"


def test_components_have_the_digits_of_the_largest():
    assert vector_text((0.8912, -3.57e-5, -0.046)) == "(0.891, 0, −0.046)"
    assert vector_text((-9.084, 1.02, 0.0)) == "(−9.08, 1.02, 0)"
    assert vector_text((0.0, -0.0, 0.0)) == "(0, 0, 0)"
    assert vector_text((1234.5, -9.8, 0.2)) == "(1230, −10, 0)"
    assert vector_text((0.0, 0.0, -9.80665), 4) == "(0, 0, −9.807)"


def test_what_is_wide_is_not_open():
    """As wide as the largest moment: a number, as on the terminal and in JSON."""
    wide = headline(intervals=intervals(inertia=BODY.inertia_at_com.max()))
    assert "open" not in wide.numbers[2]
    assert wide.numbers[2].count("±") == 3


def test_the_verdict_and_its_gravest_reason():
    said = warning("toy-doubt", "doubt"), error("toy-mistake", "mistake")
    found = headline(warnings=said)
    assert (found.usable, found.reason) == (False, "mistake")
    assert found.verdict.startswith("verdict: do not use")
    good = headline()
    assert (good.usable, good.reason) == (True, "")
    assert good.verdict.startswith("verdict: good")


def test_what_is_undetermined_has_no_number_whatever_its_interval():
    """A prior gives a finite interval to what nothing determines."""
    open_ = Undetermined.of_parameters(["mcz", "Jxx", "Jyy", "Jzz"], "the prior")
    for known in (intervals(), None):
        found = headline(intervals=known, undetermined=open_)
        assert found.numbers[1].endswith("z open mm")
        assert found.numbers[2] == "inertia at the COM: open"
