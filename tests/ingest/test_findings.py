"""What is said of conditioning: thresholds from both sides, and the words."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.core.messages import codes
from hefting.ingest.findings import RejectedOffset, findings_of, warnings_of
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.systematic import offset_error


def found(**more: Any) -> Any:
    """A thousand samples of which nothing was found."""
    return cast(
        Any,
        SimpleNamespace(
            **{
                "offset": 0.0,
                "offset_std": 1e-3,
                "offset_left": 0.0,
                "sign": SimpleNamespace(t=5.0, certain=False, name="on-object"),
                "bias": SimpleNamespace(kind="constant", range=np.zeros(6)),
                "biased": True,
                "tilt_std": None,
                "gravity": np.array((0.0, 0.5, -9.79)),
                "rejected": np.zeros(1000, dtype=bool),
                "reasons": {},
                "path": SimpleNamespace(kind="smooth"),
            }
            | more
        ),
    )


def said(given, outliers=None, rejected=None, static=False) -> str:
    recording = type(
        "Log",
        (),
        {
            "static": static,
            "__getitem__": lambda _, name: SimpleNamespace(time=0.01 * np.arange(1000)),
        },
    )()
    masks = no_outliers(1000) if outliers is None else outliers
    return "; ".join(findings_of(given, cast(Any, recording), masks, rejected))


def test_findings_are_told_in_their_units():
    assert said(found()) == ""
    late = found(offset=0.0213, offset_std=4e-4)
    assert said(late) == "the wrench is 21.3 ± 0.4 ms late against the motion; shifted"
    early = found(offset=-0.00213, offset_std=9e-5)
    assert "2.13 ± 0.09 ms early" in said(early)
    sign = SimpleNamespace(t=-12.4, certain=True, name="on-sensor")
    assert said(found(sign=sign)) == "the wrench is on-sensor (12 standard deviations)"
    exact = SimpleNamespace(t=2e6, certain=True, name="on-object")
    assert "(2e+06 standard deviations)" in said(found(sign=exact))
    for kind, how in (("linear", "linearly"), ("random walk", "slowly wandering")):
        bias = SimpleNamespace(kind=kind, range=np.array((3, 0, 4, 0.0, 0.6, 0.8)))
        expected = f"the bias drifts by 5 N and 1 N m, {how}"
        assert said(found(bias=bias)) == expected
    tilted = found(tilt_std=np.radians(0.5))
    assert said(tilted).endswith("(0.00, 0.50, -9.79) m/s², known to 0.5°")
    assert said(found(tilt_std=np.inf)) == ""


def test_what_was_left_out_is_counted():
    contact, spike, saturation = np.zeros((3, 1000), dtype=bool)
    contact[100:200] = contact[300:350] = True
    spike[7] = True
    saturation[[8, 9]] = True
    told = said(found(), Outliers(contact, spike, saturation))
    assert "contact: 1.5 s in 2 stretches left out" in told
    assert "1 spike (0.1 %) left out" in told
    assert "2 saturated samples (0.2 %) left out" in told
    contact[300:350] = False
    told = said(found(), Outliers(contact, spike, saturation), static=True)
    assert "1.0 s in 1 stretch left out" in told
    assert "1 odd pose (0.1 %)" in told


def warned(given, rejected=None, *, tilt=False, enough=True) -> set[str]:
    return set(codes(warnings_of(given, rejected, tilt=tilt, enough=enough)))


@pytest.mark.parametrize(
    ("saturated", "code", "severity"),
    [
        (4, None, None),
        (5, "saturated", "warning"),
        (50, "saturated", "warning"),
        (51, "saturated", "error"),
    ],
)
def test_saturation_is_told_from_half_a_percent_on(saturated, code, severity):
    """And is not to be used beyond five."""
    given = found(reasons={"saturation": saturated})
    told = warnings_of(given, None, tilt=False, enough=True)
    assert [m.code for m in told] == ([code] if code else [])
    assert [m.severity for m in told] == ([severity] if code else [])


def test_what_cannot_be_found_is_told():
    assert warned(found()) == set()
    assert warned(found(), enough=False) == {"too-few-samples"}
    assert warned(found(biased=False)) == {"bias-unknown"}
    assert warned(found(offset_std=np.inf)) == {"clock-offset-unknown"}
    many = np.arange(1000) < 400
    assert warned(found(rejected=many)) == set()
    many[400] = True
    assert warned(found(rejected=many)) == {"many-outliers"}
    assert warned(found(rejected=many[:0])) == set()
    for std, code in (
        (None, "gravity-measured"),
        (np.inf, "gravity-unknown"),
        (np.radians(2.01), "gravity-uncertain"),
    ):
        assert warned(found(tilt_std=std), tilt=True) == {code}
        assert warned(found(tilt_std=std)) == set()
    assert warned(found(tilt_std=np.radians(1.99)), tilt=True) == set()


@pytest.mark.parametrize(
    ("value", "std", "finding", "warning"),
    [
        (0.001, 0.001, "no clock offset: 1 ± 1 ms", None),
        (0.0, 0.049, "no clock offset: 0 ± 49 ms", None),
        (0.0, 0.051, "", "clock-offset-unknown"),
        (0.0029, 0.001, "no clock offset: 2.9 ± 1 ms", None),
        (-0.0031, 0.001, "", "clock-offset-contradictory"),
        (0.9e-5, 0.0, "no clock offset: 0.009 ± 0 ms", None),
        (1.1e-5, 0.0, "", "clock-no-offset"),
    ],
)
def test_a_clock_offset_that_was_rejected_is_none_or_contradictory(
    value, std, finding, warning
):
    rejected = RejectedOffset(value, std)
    assert said(found(), rejected=rejected) == finding
    assert warned(found(), rejected) == ({warning} if warning else set())
    assert rejected.left == value
    if warning == "clock-offset-contradictory":
        alone = found(path=SimpleNamespace(kind="orientation"))
        assert warned(alone, rejected) == {"clock-offset-unknown"}
        assert warned(found(path=None), rejected) == set()
    open_ = warned(found(biased=False), rejected)
    assert open_ == {"bias-unknown", "clock-offset-unknown"}


@pytest.mark.parametrize(
    ("doubt", "code", "words"),
    [
        ("edge", "clock-offset-at-edge", "at a clock offset of -60 ms, at the edge"),
        (
            "several",
            "clock-several-offsets",
            "of -60 ms and 150 ms explain the wrench equally well (they gain 30 and 27)",
        ),
        ("gain", "clock-offset-contradictory", "gain 30, and 144 are asked for"),
        (
            "share",
            "clock-offset-contradictory",
            "it leaves 70 % of the squared residual",
        ),
    ],
)
def test_a_profile_says_why_an_offset_is_not_believed(doubt, code, words):
    """Of what it was only so much may be left as drivers leave."""
    profile = SimpleNamespace(
        doubt=lambda: doubt,
        rival=(0.15, 3.0),
        gain=30.0,
        share_left=0.7,
        required_gain=144.0,
    )
    rejected = RejectedOffset(-0.06, 1e-3, cast(Any, profile))
    (told,) = warnings_of(found(), rejected, tilt=False, enough=True)
    assert told.code == code
    assert words in told
    assert rejected.left == 0.05
    assert RejectedOffset(0.03, 1e-3, cast(Any, profile)).left == 0.03


@pytest.mark.parametrize(("offset", "severity"), [(49e-5, "note"), (-51e-5, "warning")])
def test_a_trifle_of_an_offset_that_was_rejected_is_a_note(offset, severity):
    rejected = RejectedOffset(offset, 1e-5)
    (told,) = warnings_of(found(), rejected, tilt=False, enough=True)
    assert told.severity == severity


def test_an_offset_may_be_off_by_five_of_its_deviations_and_what_was_left():
    assert offset_error(found()) == pytest.approx(5e-3)
    assert offset_error(found(offset_left=0.012)) == pytest.approx(0.013)
    assert offset_error(found(offset_std=np.inf)) == pytest.approx(0.02)
    assert offset_error(found(offset_std=None)) == 0.0
