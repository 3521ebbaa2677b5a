"""Suspects: the least squares of all recordings but one, and which of many differs most
from the rest."""

from functools import cache

import numpy as np
import pytest

from disturbances import NOISE, body
from hefting.core.messages import codes
from hefting.core.sensor_accuracy import TYPICAL
from hefting.estimators.quadratic import Quadratic
from hefting.identification.contradictions import (
    FEW,
    _solved,
    contradictions,
    deviations_from_rest,
    least_squares_of,
    with_contradictions,
)
from hefting.ingest.ingest import ingest
from hefting.ingest.joint import JointIngested, joint, together
from hefting.simulation import UR5, random_smooth, simulate

MASS = 1.347
COUNT = 12
CODES = {"recordings-contradict"}


@cache
def found(seed: int, mass: float = MASS):
    """Three seconds at 100 Hz, with a bias of its own."""
    rng = np.random.default_rng([181, seed])
    motion = UR5.motion(random_smooth(3.0, 100.0, 1.2, seed=seed))
    bias = rng.uniform(-1.0, 1.0, 6) * np.repeat((20.0, 1.0), 3)
    log = simulate(motion, body(mass), noise=NOISE, bias=bias, seed=seed)
    return ingest(log, bias="estimate")


def several(*odd: float) -> JointIngested:
    """Twelve recordings, the last ones of other masses [kg]."""
    parts = [found(i) for i in range(COUNT - len(odd))]
    parts += [found(100 + i, mass) for i, mass in enumerate(odd)]
    together_ = joint(parts, [f"run{i}" for i in range(COUNT)])
    assert isinstance(together_, JointIngested)
    return together_


def test_least_squares_of_all_but_one_in_closed_form():
    """Against that of the others themselves, weighed by the same noise."""
    all_ = several()
    noise = all_.fit.noise
    each = [Quadratic.of(part.state, noise, True) for part in all_.parts]
    G = sum(own.A.T @ own.A for own in each)
    phi = np.linalg.solve(G, sum(own.A.T @ own.b for own in each))
    for i, own in enumerate(each):
        step = _solved(G - own.A.T @ own.A, own.A.T @ (own.A @ phi - own.b))
        rest = [other for j, other in enumerate(each) if j != i]
        A = np.concatenate([other.A for other in rest])
        b = np.concatenate([other.b for other in rest])
        true = np.linalg.lstsq(A, b, rcond=None)[0]
        std = np.sqrt(np.linalg.inv(A.T @ A).diagonal())
        # normal equations of condition 1e8 leave 1e-8 of what noise does
        np.testing.assert_allclose((phi + step - true) / std, 0.0, atol=1e-6)


def test_the_worst_of_many_is_that_of_comparing_each():
    """Against the comparison of each with the rest, identified for itself."""
    from hefting.identification.contradictions import _against_the_rest

    all_ = several(1.25, 1.40)
    parts = dict(zip(all_.names, all_.parts, strict=True))
    alone = {name: least_squares_of(part, TYPICAL) for name, part in parts.items()}
    exact = {
        name: _against_the_rest(
            name, parts, alone, TYPICAL
        ).agreement.largest.deviations
        for name in parts
    }
    about = deviations_from_rest(parts, alone, TYPICAL)
    assert list(about) == sorted(about, key=about.get, reverse=True)
    assert next(iter(about)) == max(exact, key=exact.get) == "run10"
    # leaving out one of twelve changes intervals little; the two that are of other
    # objects widen them
    ratios = np.array([about[name] / exact[name] for name in parts])
    assert (ratios > 0.3).all()
    assert (ratios < 1.5).all()


def test_those_of_other_objects_are_named_among_many():
    assert COUNT > FEW
    named = contradictions(several(1.25, 2.0))
    assert [each.name for each in named] == ["run11", "run10"]
    assert not contradictions(several())


def test_what_contradicts_is_said_once_of_recordings_that_are_weighed():
    """Weights by noise are those of all together, and not given a second time."""
    all_ = several(2.0)
    weights = [part.state.full.ones @ part.state.full.ones for part in all_.parts]
    again = together(all_.parts, all_.names)
    assert isinstance(again, JointIngested)
    for part, weight in zip(again.parts, weights, strict=True):
        assert part.state.full.ones @ part.state.full.ones == pytest.approx(weight)
    said = [m for m in with_contradictions(all_).warnings if codes([m]) & CODES]
    assert len(said) == 1
