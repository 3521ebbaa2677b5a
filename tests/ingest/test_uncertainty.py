"""Uncertainty of the fit: the residuals' spectrum where the fit takes part of it, and
where it takes all."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.signal import lfilter

from disturbances import GRAVITY, NOISE, SCALE, body
from hefting.ingest.blocks import Blocks
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import Fit, Start, gauss_newton
from hefting.ingest.model import Layout, Problem
from hefting.ingest.path import path_of
from hefting.ingest.uncertainty import FEWEST_AVERAGED_BINS as AVERAGED
from hefting.ingest.uncertainty import _average_over_neighbours, estimate_uncertainty
from hefting.simulation import UR5, random_smooth, simulate, wield


@cache
def exact_problem() -> tuple[Problem, np.ndarray]:
    """The motion without errors of its own, its offset free, and the wrench without
    noise (K, 6)."""
    motion = UR5.motion(random_smooth(10.4, 100.0, 1.0, 0))
    path = path_of(simulate(motion, body(1.5), exact=True))
    assert path is not None
    clean = wield(motion, body(1.5)).wrench
    return Problem(
        replace(path, bandwidth=np.inf),
        Blocks.of(motion.time, clean),
        True,
        False,
        (1,),
    ), clean


def fit_of(wrench: np.ndarray, knots: int) -> Fit:
    problem, _ = exact_problem()
    start = Start(
        body(1.5).vector,
        0.0,
        GRAVITY,
        NOISE.force * SCALE[::3],
        problem.time[:1],
        np.zeros((1, 6)),
    )
    return gauss_newton(
        replace(problem, blocks=replace(problem.blocks, wrench=wrench)),
        start,
        knots,
        steps=3,
    )


@pytest.mark.parametrize("knots", [9, 33])
def test_a_bias_that_wanders_hides_no_noise(knots):
    """White noise beside a bias of many knots: it takes what is slow, but the noise
    there is that of the rest."""
    slow, white = [], []
    for seed in range(6):
        noise = (
            0.1
            * SCALE
            * np.random.default_rng(seed).normal(size=exact_problem()[1].shape)
        )
        found = estimate_uncertainty(fit_of(exact_problem()[1] + noise, knots))
        slow.append(found.slow)
        white.append(found.covariance.diagonal()[:10] / found.naive[:10])
    # of some dozen powers of each type, six times: a deviation of 0.06; what the bias
    # leaves of them is 0.4 at most
    assert 0.75 < np.mean(slow) < 1.25
    assert 0.75 < np.mean(white) < 1.25


def test_forces_and_torques_have_colours_of_their_own():
    """Forces that err by a first-order process, torques by white noise: slow and fast
    ends of both spectra."""
    rho, found = 0.9, []
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(size=exact_problem()[1].shape)
        noise[:, :3] = lfilter(
            [np.sqrt(1.0 - rho**2)], [1.0, -rho], noise[:, :3], axis=0
        )
        S = estimate_uncertainty(
            fit_of(exact_problem()[1] + 0.1 * SCALE * noise, 1)
        ).spectrum
        found.append((S[:4].mean(axis=0), S[-len(S) // 4 :].mean(axis=0)))
    slow, fast = np.mean(found, axis=0)
    # slow: of some twenty powers four times, a deviation of 0.1; the process is not
    # quite white among the slowest
    # (1 + rho) / (1 - rho)
    assert np.all((slow[:3] > 0.6 * 19.0) & (slow[:3] < 1.3 * 19.0))
    np.testing.assert_allclose(slow[3:], 1.0, atol=0.4)
    # a little more at 3/8 of the rate
    np.testing.assert_allclose(fast[:3], (1.0 - rho) / (1.0 + rho), rtol=0.3)
    np.testing.assert_allclose(fast[3:], 1.0, atol=0.1)


def test_what_the_fit_takes_whole_is_no_lack_of_noise():
    """Columns that fill a band: the spectrum beside it is the noise's, and in it none
    is divided by nothing.

    Against the definition, written out sample by sample: power over what of it is left,
    at least a fifth.
    """
    K, band = 241, range(20, 60)
    phase = 2.0 * np.pi * np.arange(K)[:, None] / K * np.array(band)
    # (K, 80) orthonormal
    waves = np.concatenate((np.cos(phase), np.sin(phase)), axis=1) * np.sqrt(2.0 / K)
    q = 6 * waves.shape[1]
    # each wave in each channel; the wrench behind them is in no column
    maps = np.eye(q + 36, q).reshape(-1, 6, q)
    noise = np.random.default_rng(0).normal(size=(K, 6))
    residual = noise - waves @ (waves.T @ noise)
    inverse = np.zeros((q + 6, q + 6))
    inverse[:q, :q] = np.eye(q)
    time = 0.01 * np.arange(K)
    fit = SimpleNamespace(
        model=SimpleNamespace(
            layout=Layout(None, None, q),
            known=np.hstack((waves, noise)),
            maps=lambda phi: maps,
        ),
        phi=None,
        solution=SimpleNamespace(
            inverse=inverse, undetermined=np.zeros(q + 6, dtype=bool)
        ),
        weights=np.ones(K),
        scale=np.ones(2),
        hats=HatFunctions.over(time, 1),
        residual=residual,
    )
    found = estimate_uncertainty(cast(Any, fit)).spectrum
    # a tenth of the samples at each end tapered by a quarter of a sine, at the samples'
    # middles
    ends = np.minimum(
        (np.minimum(np.arange(K), np.arange(K)[::-1]) + 0.5) / (0.1 * K), 1.0
    )
    taper = np.sin(0.5 * np.pi * ends)[:, None]
    F = K // 2 + 1
    # frequencies stand for their negatives too
    both = np.where(np.arange(F) == 0, 1.0, 2.0)
    power = both * (np.abs(np.fft.rfft(residual * taper, axis=0)) ** 2 / K)[:, :3].sum(
        axis=1
    )
    full = both * 3.0 * np.mean(taper**2)
    taken = (
        both * 3.0 * (np.abs(np.fft.rfft(waves * taper, axis=0)) ** 2 / K).sum(axis=1)
    )
    left = np.maximum(full - taken, 0.2 * full)
    power[:2], left[:2] = 0.0, 0.0  # a constant bias takes the lowest
    expected = np.empty(F)
    for i in range(F):
        half = max(5, i // 3)
        near = slice(max(i - half, 0), i + half + 1)
        expected[i] = power[near].sum() / left[near].sum()
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-9)  # rounding
    # well inside the band: leakage, not what is left of it made large
    assert found[35:45].max() < 0.3


def test_a_spectrum_is_averaged_over_its_neighbours():
    """Power over what is expected is the same where each is; where nothing is expected
    nearby, that of all."""
    count = np.linspace(1.0, 3.0, 100)
    np.testing.assert_allclose(_average_over_neighbours(2.0 * count, count), 2.0)
    few = np.where(np.arange(100) < 10, count, 0.0)
    power = np.random.default_rng(6).exponential(size=100) * few
    average = _average_over_neighbours(power, few)
    assert average[-1] == pytest.approx(power.sum() / few.sum())
    assert average[0] == pytest.approx(
        power[: AVERAGED + 1].sum() / few[: AVERAGED + 1].sum()
    )
