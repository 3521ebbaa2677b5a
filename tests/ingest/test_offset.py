"""The coarse scan of clock offsets: near the truth past whatever disturbs a recording,
as the fit begins there."""

from types import SimpleNamespace

import numpy as np
import pytest

from disturbances import GRAVITY, NOISE, SCALE, disturbed, with_wrench
from hefting.ingest.blocks import Blocks
from hefting.ingest.model import Problem, _extrapolate
from hefting.ingest.offset import ALIKE, _to_start_from, scan_offsets
from hefting.ingest.path import Reading, path_of


def scanned(recording, late, free_gravity):
    path, wrench = path_of(recording), recording["wrench"]
    assert path is not None
    blocks = Blocks.of(wrench.time + late, wrench.values)
    return scan_offsets(Problem(path, blocks, True, free_gravity, (1,)), GRAVITY, 1)


@pytest.mark.parametrize("late", [0.0, 0.5])
@pytest.mark.parametrize("kind", ["clean", "tilt", "spikes", "contact", "all"])
def test_it_is_near_whatever_disturbs(kind, late):
    """By 200 samples with noise of 0.1 N: offset within its step, gravity within a
    degree, the mass within a tenth."""
    d = disturbed(kind, 1.5, 1)
    found = scanned(d.recording, late, True)
    assert found.offset == pytest.approx(late + d.offset, abs=0.0201)
    assert found.gravity @ d.gravity / (GRAVITY @ GRAVITY) > np.cos(np.radians(1.0))
    assert found.phi[0] == pytest.approx(d.sign * 1.5, rel=0.1)


@pytest.mark.parametrize("part", [0.1, 0.3])
def test_a_third_of_the_samples_may_be_anything(part):
    """The scale it ends with is that of the others, up to their share: far from the 20
    N of these."""
    clean, rng = disturbed("clean", 0.3, 2).recording, np.random.default_rng(0)
    values = clean["wrench"].values.copy()
    bad = rng.random(len(values)) < part
    values[bad] += 20.0 * SCALE * rng.normal(size=(int(bad.sum()), 6))
    found = scanned(with_wrench(clean, clean["wrench"].time, values), 0.3, False)
    assert found.offset == pytest.approx(0.3, abs=0.0201)
    assert found.phi[0] == pytest.approx(0.3, rel=0.1)
    assert found.scale[0] < 5.0 * NOISE.force


def test_a_reading_is_continued_by_its_taylor_series():
    """Of a motion that is quadratic in time it is exact: its values, averaged over times
    of some variance, and its rates."""
    rng = np.random.default_rng(8)
    rows, at = np.linspace(0.0, 3.0, 7), np.linspace(0.0, 3.0, 7) + 0.02
    a, b, c = rng.normal(size=(3, 1, 21))

    def motion(t):
        return a + b * t[:, None] + c * t[:, None] ** 2

    known = np.ones(len(rows), dtype=bool)
    reading = Reading(
        time=rows,
        value=motion(rows),
        rate=b + 2.0 * c * rows[:, None],
        curvature=np.repeat(2.0 * c, len(rows), axis=0),
        variances=np.zeros((2, len(rows))),
        in_gap=~known,
        known=known,
    )
    values, rates = _extrapolate(reading, at, np.full(len(rows), 4e-6))
    np.testing.assert_allclose(values, motion(at) + c * 4e-6, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(rates, b + 2.0 * c * at[:, None], rtol=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_search_starts_nearer_to_zero_where_that_is_as_likely(side):
    offsets, samples = 0.02 * np.arange(-3.0, 4.0), 100
    for lost, start in ((0.5, 0.02), (1.5, 0.04)):
        likelihood = np.full(7, -9.0)
        likelihood[3 + int(2 * side)] = 0.0
        likelihood[3 + int(side)] = -lost * ALIKE / samples
        likelihood[3] = 0.0  # nor further, as another maximum may be there
        fits = SimpleNamespace(likelihood=likelihood, best=3 + int(2 * side))
        found = _to_start_from(fits, offsets, samples)
        assert offsets[found] == pytest.approx(side * start)
    likelihood[3] = 1.0
    assert (
        _to_start_from(SimpleNamespace(likelihood=likelihood, best=3), offsets, 9) == 3
    )
