"""Condensed recordings: sums over samples stand for the samples."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from disturbances import NOISE, body
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest.blocks import residual_size
from hefting.ingest.condensed import Condensed, Excitation
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.simulation import UR5, random_smooth, simulate


@cache
def found() -> Ingested:
    """Five seconds at 1 kHz: averages of ten samples with weights of their own."""
    motion = UR5.motion(random_smooth(5.0, 1000.0, 1.2, seed=2))
    bias = (5.0, -3.0, 8.0, 0.2, 0.1, -0.3)
    return ingest(simulate(motion, body(1.3), noise=NOISE, bias=bias, seed=3))


def squares(rows: Array) -> Array:
    return rows.T @ rows


def test_the_residual_is_that_of_the_samples():
    z, vector = found().measurements, 1.01 * found().fit.vector
    for bias in (None, found().fit.bias):
        left = z.wrench - predict_wrench(z, vector) - (0.0 if bias is None else bias)
        direct = residual_size(left, found().counts, found().within)
        for whole in (found(), found().without_samples()):
            # rounding of factors of a wrench a hundred times as large
            np.testing.assert_allclose(whole.residual(vector, bias), direct, rtol=1e-11)


def test_what_is_told_without_samples_is_told_of_all():
    alone = found().without_samples()
    assert len(alone.measurements) == len(alone.counts) == 0
    bases = (alone.measurements.time.base, alone.measurements.force.base)
    assert all(base is None or not base.size for base in bases)  # no view of all
    assert not alone.has_samples
    assert found().has_samples
    for name in ("rows", "samples", "duration", "motion_noise", "provenance"):
        assert str(getattr(alone, name)) == str(getattr(found(), name)), name
    assert alone.rows == len(found().measurements)
    assert alone.samples == found().counts.sum()
    wrench = found().measurements.wrench.reshape(-1, 2, 3)
    rms = np.sqrt(np.mean(wrench**2, axis=(0, 2)))
    np.testing.assert_allclose(alone.wrench_rms, rms, rtol=1e-12)


@pytest.mark.parametrize("weight", [0.01, 7.0])
def test_a_weight_of_all_samples_in_closed_form(weight):
    """Against the sums over samples with these weights; of the time record too, whose
    buffer and open stretch hold samples of odd numbers."""
    z = found().measurements[:467]
    heavy = replace(z, weights=weight * z.weights)
    state = SampleState.empty(with_record=True).fold(z).scaled(weight)
    true = SampleState.empty(with_record=True).fold(heavy)
    pairs = [(state.full.factor, true.full.factor)]
    record, known = state.record, true.record
    scales, stretches = record.complete
    pairs += list(zip(scales.factors, known.complete[0].factors, strict=True))
    pairs += list(zip(stretches.factors, known.complete[1].factors, strict=True))
    pairs += [(stretches.open_factor, known.complete[1].open_factor)]
    for mine, theirs in pairs:
        size = np.abs(squares(theirs)).max()
        np.testing.assert_allclose(squares(mine), squares(theirs), atol=1e-12 * size)
    np.testing.assert_allclose(record.motion, known.motion, rtol=1e-12)
    waiting = [row for row in scales.pending if row is not None]
    theirs = [row for row in known.complete[0].pending if row is not None]
    np.testing.assert_allclose(waiting, theirs, rtol=1e-12)
    kept = Condensed.of(z, found().counts[:467]).weighed(weight)
    direct = Condensed.of(heavy, found().counts[:467])
    np.testing.assert_allclose(
        squares(kept.directions), squares(direct.directions), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_array_equal(kept.counted.factor, direct.counted.factor)


def test_excitation_is_that_of_the_samples():
    z = found().measurements
    motion, w = Excitation.of(z), z.weights
    g = z.gravity / np.linalg.norm(z.gravity, axis=1, keepdims=True)
    mean = np.average(g, axis=0, weights=w)
    for about, rows in ((False, g), (True, g - mean)):
        true = (w[:, None] * rows).T @ rows / w.sum()
        mine = squares(motion.directions_about(mean=about))
        np.testing.assert_allclose(mine, true, atol=1e-12)
    alpha = z.angular_acceleration
    true = (w[:, None] * alpha).T @ alpha / w.sum()
    np.testing.assert_allclose(
        squares(motion.angular_acceleration), true, atol=1e-12 * np.abs(true).max()
    )
    force = np.sqrt(np.average(np.sum(z.force**2, axis=1), weights=w))
    assert motion.force == pytest.approx(force, rel=1e-12)
    halves = [z[:200], z[200:]]
    each = [Excitation.of(half) for half in halves]
    both = Excitation.of_all(each, motion.moments)
    np.testing.assert_allclose(
        squares(both.directions), squares(motion.directions), rtol=1e-9, atol=1e-9
    )
