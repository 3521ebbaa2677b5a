"""Parts of conditioning: which numbers of knots are tried, what is fitted of a long
recording, and what the noise of one sample is."""

from importlib import import_module
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest.blocks import Blocks, within_blocks
from hefting.ingest.condition import (
    _estimate_noise,
    _mean_squared_residual,
    _numbers_of_knots,
    _sign,
    _thinned,
)
from hefting.ingest.drift import candidates
from hefting.ingest.outliers import no_outliers
from hefting.ingest.samples import Samples
from hefting.motion.state import effect_of_acceleration_errors

conditioning = import_module("hefting.ingest.condition")  # not the function
GRAVITY = np.array(STANDARD_GRAVITY)


def swinging(hertz: float, kind: str = "smooth", known: bool = True) -> Any:
    """A path about x that swings by half a radian."""

    def at(time, spread):
        angle = 0.5 * np.sin(2.0 * np.pi * hertz * time)
        one, none = np.ones_like(angle), np.zeros_like(angle)
        c, s = np.cos(angle), np.sin(angle)
        R = np.array(((one, none, none), (none, c, s), (none, -s, c)))
        rows = np.hstack((np.zeros((len(time), 12)), R.reshape(9, -1).T))
        mask = np.full(len(time), known) & (time < 1e3)
        return SimpleNamespace(value=rows, known=mask)

    return cast(Any, SimpleNamespace(kind=kind, at=at))


def test_a_bias_may_drift_no_faster_than_gravity_turns():
    """A swing of an hour's recording: knots are three of its correlation times apart, or
    12 s."""
    time = np.linspace(0.0, 800.0, 4000)
    fast = _numbers_of_knots(swinging(1.0 / 7.0), time, GRAVITY)
    assert fast == candidates(800.0, 12.0)
    slow = _numbers_of_knots(swinging(1.0 / 160.0), time, GRAVITY)
    # correlations of a sine are positive for a quarter of its period: twice their sum is
    # a third of that; one component swings twice as fast
    closest = 3.0 * 0.75 * 160.0 / np.pi
    assert max(slow) < max(fast)
    assert max(slow) in {int(800.0 / (closest * s)) + 1 for s in (0.9, 1.0, 1.1)}
    for kind, known, expected in (
        ("static", True, (1,)),
        ("smooth", False, (1,)),
    ):
        found = _numbers_of_knots(swinging(0.1, kind, known), time, GRAVITY)
        assert found == expected
    short = cast(Any, SimpleNamespace(kind="smooth"))
    assert _numbers_of_knots(short, time[:39], GRAVITY) == (1,)
    assert _numbers_of_knots(short, np.array((3.0, 11.0)), GRAVITY) == (1, 2)


@pytest.mark.parametrize(
    ("duration", "closest", "numbers"),
    [
        (7.8, 0.0, (1,)),
        (7.9, 0.0, (1, 2)),
        (23.9, 0.0, (1, 2)),
        (24.0, 0.0, (1, 2, 3)),
        (36.0, 12.0, (1, 2, 3, 4)),
        (50.0, 0.0, (1, 2, 3, 5)),
        (100.0, 20.0, (1, 2, 3, 5, 6)),
        (1e4, 0.0, (1, 2, 3, 5, 9, 17, 33, 65, 81)),
    ],
)
def test_numbers_of_knots_double_their_intervals_up_to_the_most(
    duration, closest, numbers
):
    assert candidates(duration, closest) == numbers


def test_of_long_recordings_medians_of_some_blocks_are_fitted(monkeypatch):
    rng = np.random.default_rng(1)
    time = np.arange(3000) / 1000.0 + 1e-5
    samples = Samples(time, rng.normal(size=(3000, 6)), static=False, smooth=True)
    monkeypatch.setattr(conditioning, "MOST_FITTED_SAMPLES", 3000)
    assert _thinned(samples) is samples
    monkeypatch.setattr(conditioning, "MOST_FITTED_SAMPLES", 2999)
    monkeypatch.setattr(conditioning, "MOST_FITTED_BLOCKS", 100)
    found = _thinned(samples)
    blocks = samples.blocks()
    # three hundred blocks, of which every third
    assert len(blocks) in (300, 301)
    nth = -(-len(blocks) // 100)
    np.testing.assert_array_equal(found.time, blocks.time[::nth])
    parts = np.split(samples.wrench, blocks.starts[1:])[::nth]
    expected = [np.median(part, axis=0) for part in parts]
    np.testing.assert_array_equal(found.wrench, expected)
    assert not found.smooth


def fitted(blocks: Blocks, weights, residual, phi, variances):
    """A fit of blocks, and its problem."""
    reading = SimpleNamespace(variances=variances)
    fit = SimpleNamespace(
        weights=weights,
        residual=residual,
        phi=phi,
        hats=SimpleNamespace(n=2),
        model=SimpleNamespace(reading=reading),
    )
    problem = SimpleNamespace(
        blocks=blocks,
        floor=np.full(2, 1e-9),
        time=blocks.time,
        wrench=blocks.wrench,
    )
    return cast(Any, problem), cast(Any, fit)


@pytest.mark.parametrize("fast", [True, False])
def test_noise_is_that_of_one_sample_without_the_motion_s_errors(fast):
    """Residuals less the unknowns', with what is within averages; blocks of no weight
    are none of it."""
    rng = np.random.default_rng(2)
    rate = 1000.0 if fast else 50.0
    time = np.arange(600) / rate + 1e-5
    wrench = rng.normal(size=(600, 6)) * np.repeat((2.0, 0.1), 3)
    samples = Samples(time, wrench, static=False, smooth=True)
    blocks = samples.blocks()
    assert (blocks.starts is not None) is fast
    B = len(blocks)
    weights = (np.arange(B) % 5 > 0) * rng.uniform(0.5, 2.0, B)
    phi = np.array((1.5, 0.1, 0.0, 0.2, *np.full(6, 1e-2)))
    variances = np.array((0.01, 0.2))[:, None] * np.ones(B)
    problem, fit = fitted(blocks, weights, blocks.wrench, phi, variances)
    outliers = no_outliers(600)
    used = weights > 0.0
    square = np.average(
        np.square(blocks.wrench[used]), axis=0, weights=blocks.count[used]
    )
    square = square.reshape(2, 3).mean(axis=1)
    np.testing.assert_allclose(
        _mean_squared_residual(samples, problem, fit, outliers), square
    )
    square *= used.sum() / (used.sum() - 10.0 / 6.0 - 2.0)
    square += within_blocks(blocks, time, wrench).diagonal().reshape(2, 3).mean(axis=1)
    effect = effect_of_acceleration_errors(phi) @ (0.01, 0.2) / 3.0
    assert (effect > 1e-3 * square).any()
    noise = _estimate_noise(samples, problem, fit, outliers)
    expected = np.sqrt(np.maximum(square - effect, 0.01 * square))
    np.testing.assert_allclose((noise.force, noise.torque), expected)
    assert noise.linear_acceleration == pytest.approx(0.1)
    assert noise.angular_acceleration == pytest.approx(0.2**0.5)
    # a tenth of what is left at least
    problem, fit = fitted(blocks, weights, blocks.wrench, 1e3 * phi, variances)
    noise = _estimate_noise(samples, problem, fit, outliers)
    np.testing.assert_allclose((noise.force, noise.torque), 0.1 * np.sqrt(square))


def test_where_medians_were_fitted_noise_is_that_of_the_samples_beside_them():
    """Without those that are outliers."""
    rng = np.random.default_rng(3)
    time = 0.001 * np.arange(1000)
    samples = Samples(time, rng.normal(size=(1000, 6)), static=False, smooth=True)
    at = np.arange(5, 1000, 10)
    blocks = Blocks(time[at] - 1e-4, np.zeros(100), np.ones(100), np.zeros((100, 6)))
    problem, fit = fitted(
        blocks, np.ones(100), 0.1 * np.ones((100, 6)), np.zeros(10), np.zeros((2, 100))
    )
    outliers = no_outliers(1000)
    outliers.spike[at[::4]] = True
    kept = np.delete(at, np.s_[::4])
    # what was fitted is the wrench less its residual
    left = samples.wrench[kept] + 0.1
    expected = np.square(left).mean(axis=0).reshape(2, 3).mean(axis=1)
    found = _mean_squared_residual(samples, problem, fit, outliers)
    np.testing.assert_allclose(found, expected)


def test_a_sign_is_doubtful_where_the_mass_is_open_or_no_bias_was_found():
    def found(mass, open_=False, biased=True):
        return _sign(
            cast(
                Any,
                SimpleNamespace(
                    fit=SimpleNamespace(phi=np.array([mass])),
                    mass_is_open=open_,
                    biased=biased,
                    uncertainty=SimpleNamespace(mass_std=0.1),
                ),
            )
        )

    assert (found(2.0).on_object, found(2.0).t) == (True, pytest.approx(20.0))
    assert (found(-2.0).on_object, found(-2.0).t) == (False, pytest.approx(-20.0))
    assert (found(-2.0, open_=True).on_object, found(-2.0, open_=True).t) == (False, 0)
    assert found(2.0, biased=False).t == 0.0
