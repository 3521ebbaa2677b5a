"""What is said of a mistake, and of what nothing explains: limits from both sides."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.core.spatial import Array
from hefting.ingest.rivals import consequence
from hefting.ingest.rivals.consequence import _changes, doubt_of
from hefting.ingest.rivals.judge import Judged


def body(mass: float, x: float = 0.0) -> np.ndarray:
    """With its COM at x and 0.1 m beside."""
    return np.array((mass, mass * x, 0.1 * mass, *np.zeros(7)))


def said(
    monkeypatch,
    after,
    *,
    certain: bool = True,
    whole: bool = False,
    unexplained: float = 0.5,
    tool: bool = False,
    answer: Array | None = None,
    **other: Any,
):
    """Of a mistake that makes 2 kg into another body."""
    named = SimpleNamespace(
        **{
            "vector": after,
            "what": "it is wrong",
            "fix": "right it",
            "code": "axes-turned",
            "argument": None,
            "unknowns": 2,
            "is_grave": False,
            "is_change": False,
        }
        | other
    )
    given = SimpleNamespace(vector=body(2.0))
    judged = Judged(unexplained, cast(Any, named), cast(Any, given), certain, whole)
    monkeypatch.setattr(consequence, "judge", lambda case: judged)
    case = SimpleNamespace(path=SimpleNamespace(moves=True), noise=np.zeros(2))
    case.floor, case.parameters = np.ones(2), answer
    monkeypatch.setattr(consequence.Vibration, "of", lambda case: None)
    return doubt_of(cast(Any, case), with_tool=tool)


@pytest.mark.parametrize(
    ("after", "sure", "possible"),
    [
        (body(2.058), False, False),  # three hundredths of the larger
        (body(2.065), True, False),
        (body(2.2), True, False),  # a tenth of it
        (body(2.25), True, True),
        (body(-1.79), True, True),
        (body(2.0, 0.0049), False, False),
        (body(2.0, 0.0051), True, False),
        (body(2.0, 0.0099), True, False),
        (body(2.0, 0.0101), True, True),
        (body(1e-3), True, True),
    ],
)
def test_a_mistake_is_fatal_by_what_it_does_to_mass_and_com(
    after, sure, possible, monkeypatch
):
    """More where it is possible only than where it is beyond doubt."""
    for certain, fatal in ((True, sure), (False, possible)):
        found = said(monkeypatch, after, certain=certain)
        assert found.is_fatal is fatal
        assert found.names_mistake
        assert str(found.message).startswith("it is wrong: right it")
    grave = said(monkeypatch, body(2.0), is_grave=True)
    assert grave.is_fatal
    assert not said(monkeypatch, body(2.0), is_grave=True, certain=False).is_fatal


def test_a_filter_is_fatal_too_by_what_it_does_to_the_answer(monkeypatch):
    """A filter of 4 Hz and a trembling hand: corrected for the filter, the search's own
    fit had the mass, and the answer was 24 to 54 % light, *usable with care*."""
    filtered = {"answer": body(1.5), "code": "wrench-filtered"}
    for how, fatal in (
        (filtered, True),
        (filtered | {"answer": body(2.0)}, False),
        (filtered | {"code": "play"}, False),  # nothing is corrected
    ):
        found = said(monkeypatch, body(2.0), **how)
        assert found.is_fatal is fatal
        assert str(found.message).endswith("(it would have 2 kg)") is fatal


def test_effects_are_told_that_are_large(monkeypatch):
    heavy = said(monkeypatch, body(-3.0))
    assert str(heavy.message).endswith("(it would have 3 kg)")
    away = said(monkeypatch, body(2.0, 0.02), tool=True)
    expected = "(object and tool would have its centre of mass at (20, 100, 0) mm)"
    assert str(away.message).endswith(expected)
    both = said(monkeypatch, body(1.0, 0.02))
    assert "1 kg and its centre of mass at (20, 100, 0) mm" in both.message
    assert "centre of mass" not in said(monkeypatch, body(1e-4)).message
    assert "kg" not in said(monkeypatch, body(3.0), unknowns=7).message


def test_a_mistake_is_whole_that_is_simple_or_leaves_nothing(monkeypatch):
    for unknowns, whole in ((6, True), (7, False)):
        found = said(monkeypatch, body(3.0), unknowns=unknowns)
        assert found.needs_no_change is whole
    assert said(monkeypatch, body(3.0), unknowns=9, whole=True).needs_no_change
    assert not said(monkeypatch, body(2.0)).needs_no_change  # no matter
    changes = said(monkeypatch, body(3.0), whole=True, is_change=True)
    assert not changes.needs_no_change


@pytest.mark.parametrize(
    ("after", "unknowns", "unexplained", "told"),
    [
        (body(2.0), 7, 0.009, False),
        (body(2.0), 6, 0.009, True),
        (body(2.0), 7, 0.011, True),
        (body(2.0025), 7, 0.009, True),
        (body(2.0015), 7, 0.009, False),
        (body(2.0, 0.0006), 7, 0.009, True),
        (body(2.0, 0.0004), 7, 0.009, False),
    ],
)
def test_a_mistake_of_many_unknowns_that_does_nothing_is_not_told(
    after, unknowns, unexplained, told, monkeypatch
):
    found = said(monkeypatch, after, unknowns=unknowns, unexplained=unexplained)
    assert (found is not None) is told


def test_changes_are_of_sizes_and_of_places():
    assert _changes(body(2.0), body(-1.5)) == pytest.approx((0.25, 0.0))
    assert _changes(body(1.0), body(1.0, 0.03))[1] == pytest.approx(0.03)
    assert _changes(body(2.0), body(2.1e-3))[1] == pytest.approx(0.0)
    assert _changes(body(2.0), body(1.9e-3))[1] == np.inf


def unexplained(
    monkeypatch,
    share,
    moves=True,
    multiple=0.0,
    vibration=None,
    noise=1.0,
    left=None,
    zeros=0,
    biased=True,
):
    fitted = SimpleNamespace(best=0, scale=np.array([[1.0, 2.0 * multiple]]))
    given = cast(Any, SimpleNamespace(fitted=fitted)) if multiple else None
    judged = Judged(share, None, given)
    monkeypatch.setattr(consequence, "judge", lambda case: judged)
    monkeypatch.setattr(consequence.Vibration, "of", lambda case: vibration)
    wrench = np.random.default_rng(0).normal(size=(100, 6))
    wrench[:zeros] = 0.0
    coloured, level = (share, 2.0) if left is None else left
    monkeypatch.setattr(consequence, "unexplained_share", lambda *_: coloured)
    case = SimpleNamespace(
        recording={"wrench": SimpleNamespace(values=wrench)},
        path=SimpleNamespace(moves=moves),
        noise=np.full(2, noise),
        floor=np.full(2, 2.0),
        level=np.full(2, level),
        biased=biased,
    )
    return doubt_of(cast(Any, case))


@pytest.mark.parametrize(
    ("share", "moves", "level"),
    [
        (0.124, True, None),
        (0.126, True, "warning"),
        (0.299, True, "warning"),
        (0.301, True, "error"),
        (0.249, False, None),
        (0.251, False, "warning"),
        (0.599, False, "warning"),
        (0.601, False, "error"),
    ],
)
def test_what_nothing_explains_is_told_by_its_share(share, moves, level, monkeypatch):
    """Twice as much of static poses."""
    found = unexplained(monkeypatch, share, moves)
    assert (found.message.severity if found else None) == level
    if found:
        assert not found.names_mistake
        assert not found.needs_no_change
        assert f"{100.0 * share:.0f} % of the wrench's changes" in found.message


@pytest.mark.parametrize("biased", [True, False])
def test_a_bias_that_was_given_may_be_what_nothing_explains(biased, monkeypatch):
    """None is looked for beside it, so that it hides what another mistake leaves."""
    found = unexplained(monkeypatch, 0.2, biased=biased)
    assert found is not None
    assert ("`bias`" in found.message) is not biased


@pytest.mark.parametrize(("zeros", "told"), [(1, False), (2, True)])
def test_readings_of_zero_are_told_beside_what_is_unexplained(zeros, told, monkeypatch):
    found = unexplained(monkeypatch, 0.2, zeros=zeros)
    assert found is not None
    assert ("2 % of the readings are 0" in found.message) is told


def test_torque_that_is_eight_times_its_noise_is_in_doubt(monkeypatch):
    """Where noise is known: not of a quantised wrench."""
    assert unexplained(monkeypatch, 0.0, multiple=7.9) is None
    found = unexplained(monkeypatch, 0.0, multiple=8.1)
    assert found is not None
    assert not found.is_fatal
    for noise, told in ((1.9e-3, False), (2.1e-3, True)):
        found = unexplained(monkeypatch, 0.0, multiple=9.0, noise=noise)
        assert (found is not None) is told
    assert unexplained(monkeypatch, 0.0, moves=False, multiple=15.9) is None
    assert unexplained(monkeypatch, 0.0, moves=False, multiple=16.1) is not None


def test_coloured_noise_is_taken_from_what_is_told(monkeypatch):
    """From the share, and from the multiple of the torque's noise."""
    for left, level in (((0.124, 2.5), None), ((0.126, 2.5), "warning")):
        found = unexplained(monkeypatch, 0.4, multiple=9.0, left=left)
        assert (found.message.severity if found else None) == level
    assert "13 % of" in found.message
    assert unexplained(monkeypatch, 0.4, multiple=9.0, left=(0.0, 2.2)) is not None


@pytest.mark.parametrize(("left", "told"), [(0.13, True), (0.12, False)])
def test_what_a_little_more_noise_would_explain_is_not_told(left, told, monkeypatch):
    """Of 1.3 times as much; the share that is told is of the noise itself."""
    fitted = SimpleNamespace(best=0, scale=np.ones((1, 2)))
    judged = Judged(0.2, None, cast(Any, SimpleNamespace(fitted=fitted)))
    monkeypatch.setattr(consequence, "judge", lambda case: judged)
    monkeypatch.setattr(consequence.Vibration, "of", lambda case: None)
    monkeypatch.setattr(
        consequence,
        "unexplained_share",
        lambda case, fitted, level: 0.2 if level[0] <= 1.0 else left,
    )
    case = SimpleNamespace(path=SimpleNamespace(moves=True), biased=True)
    case.recording = {"wrench": SimpleNamespace(values=np.ones((9, 6)))}
    case.noise = case.floor = case.level = np.ones(2)
    found = doubt_of(cast(Any, case))
    assert (found is not None) == told
    assert found is None or "20 % of" in found.message


def test_a_vibration_is_told_where_little_is_left_beside_it(monkeypatch):
    """Of twice what is noticed three quarters of the variance."""
    for share, told in ((0.76, "vibration"), (0.74, "unexplained")):
        vibration = consequence.Vibration(7.0, 1.5, share)
        found = unexplained(monkeypatch, 0.25, vibration=vibration)
        assert found is not None
        assert found.message.code == told
        assert not found.names_mistake
        assert ("vibrates at 7 Hz, the force by 1.5 N" in found.message) == (
            told == "vibration"
        )
    still = unexplained(
        monkeypatch, 0.26, moves=False, vibration=consequence.Vibration(7.0, 1.0, 0.99)
    )
    assert still is not None
    assert still.message.code == "unexplained"
