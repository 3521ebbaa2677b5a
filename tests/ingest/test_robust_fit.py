"""The robust fit: when outliers are found once more, and when a clock offset counts."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.ingest import robust_fit
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.robust_fit import (
    RobustFit,
    _differ,
    fastest_frequency,
    fit_without_outliers,
    offset_is_significant,
)
from hefting.ingest.samples import Samples


def spikes(*places: int, K: int = 2000) -> Outliers:
    spike = np.isin(np.arange(K), places)
    return replace(no_outliers(K), spike=spike)


def test_masks_differ_in_more_than_a_thousandth_of_the_samples():
    """Whatever the cause."""
    for count, differ in ((0, False), (2, False), (3, True), (1000, True)):
        other = spikes(*range(count))
        assert _differ(spikes(), other) is differ
        assert _differ(other, spikes()) is differ
    moved = Outliers(spikes().contact, spikes().contact, spikes(1, 2, 3, 4).spike)
    assert not _differ(spikes(1, 2, 3, 4), moved)


class Fits:
    """Fits and outliers in place of those of a recording; what was asked for."""

    def __init__(self, monkeypatch, masks):
        self.asked: list[tuple[int, bool, int]] = []
        self.masks = iter(masks)
        monkeypatch.setattr(robust_fit, "gauss_newton", self.fit)
        monkeypatch.setattr(robust_fit, "find_outliers_of_fit", self.find)
        monkeypatch.setattr(robust_fit, "replace", lambda problem, **new: new["blocks"])
        time = np.arange(2000.0)
        self.samples = Samples(time, np.zeros((2000, 6)), static=False, smooth=False)
        monkeypatch.setattr(Samples, "blocks", lambda _, outliers: self.problem)
        self.problem = cast(
            Any, SimpleNamespace(knots=(1, 2, 5), blocks=time, free_offset=True)
        )

    def fit(self, problem, start, knots, robust=False, steps=12):
        self.asked.append((knots, robust, steps))
        return SimpleNamespace(start=start)

    def find(self, samples, problem, fit):
        return next(self.masks)

    def start(self, count: int = 2000, offset: int | None = 10):
        model = SimpleNamespace(layout=SimpleNamespace(offset=offset))
        return cast(
            Any, SimpleNamespace(start=None, weights=np.ones(count), model=model)
        )


def test_outliers_are_found_until_they_stay(monkeypatch):
    """A start of the same blocks and unknowns is no new fit; of others it is fitted
    robustly first. The bias has the most knots there are."""
    plain, first = (5, False, 5), (5, True, 2)
    for start, asked in (
        ({}, [plain, plain]),
        ({"count": 100}, [first, plain, plain]),
        ({"offset": None}, [first, plain, plain]),
    ):
        masks = spikes(1, 2, 3), spikes(*range(7)), spikes(*range(8))
        fits = Fits(monkeypatch, masks)
        found = fit_without_outliers(fits.samples, fits.problem, fits.start(**start))
        assert fits.asked == asked
        assert found.outliers is masks[1]
    # none at first: it is fitted all the same
    fits = Fits(monkeypatch, [spikes(), spikes()])
    fit_without_outliers(fits.samples, fits.problem, fits.start())
    assert fits.asked == [plain]


def test_of_masks_that_alternate_both_are_rejected_in_the_end(monkeypatch):
    one, other = spikes(*range(10)), spikes(*range(20, 30))
    fits = Fits(monkeypatch, [one, other] * 10)
    found = fit_without_outliers(fits.samples, fits.problem, fits.start())
    np.testing.assert_array_equal(
        np.flatnonzero(found.outliers.rejected), [*range(10), *range(20, 30)]
    )
    assert len(fits.asked) == 8


def test_of_few_samples_none_is_rejected(monkeypatch):
    """Of 39 samples, or of 11 poses."""
    for count, static, enough in (
        (39, False, False),
        (40, False, True),
        (11, True, False),
        (12, True, True),
    ):
        fits = Fits(monkeypatch, [spikes(1, K=count), spikes(1, K=count)])
        samples = Samples(np.arange(count), np.zeros((count, 6)), static, False)
        assert samples.enough is enough
        found = fit_without_outliers(samples, fits.problem, fits.start())
        assert found.outliers.rejected.sum() == enough


def robust(
    mass: float = 2.0,
    offset: float = 0.02,
    deviation: float = 1e-3,
    explained: float = 0.9,
    functions: float = 1.0,
) -> RobustFit:
    """A fit of 60 blocks that explains such a share of the wrench."""
    rng = np.random.default_rng(1)
    scale = np.array((2.0, 0.1))
    wrench = rng.normal(size=(60, 6))
    weights = rng.uniform(size=60)
    wrench -= weights @ wrench / weights.sum()
    fit = SimpleNamespace(
        scale=scale,
        weights=weights,
        residual=(1.0 - explained) ** 0.5 * wrench,
        phi=np.array([mass]),
        offset=offset,
        hats=SimpleNamespace(functions=np.full(60, functions), n=1),
        known=np.ones(60, dtype=bool),
    )
    # a wrench of any mean explains no more
    problem = SimpleNamespace(wrench=wrench + np.arange(6.0))
    return RobustFit(
        cast(Any, problem),
        cast(Any, fit),
        no_outliers(60),
        cast(Any, SimpleNamespace(mass_std=0.5, offset_std=deviation, slow=2.0)),
    )


def test_the_explained_share_is_that_of_the_weighted_variance():
    for share in (0.0, 0.3, 1.0):
        assert robust(explained=share).explained == pytest.approx(share)
    assert robust().biased
    assert not robust(functions=0.0).biased
    for mass, open_ in ((1.49, True), (1.51, False), (-1.49, True), (-1.51, False)):
        assert robust(mass).mass_is_open is open_


@pytest.mark.parametrize(
    ("change", "significant"),
    [
        ({}, True),
        ({"offset": -0.02}, True),
        ({"functions": 0.0}, False),
        ({"mass": 1.0}, False),
        ({"explained": 0.49}, False),
        ({"explained": 0.51}, True),
        ({"offset": 0.049, "explained": 0.7}, True),
        ({"offset": 0.051, "explained": 0.7}, False),
        ({"offset": -0.051, "explained": 0.79}, False),
        ({"offset": -0.051, "explained": 0.81}, True),
        ({"deviation": 0.0066}, True),
        ({"deviation": 0.0067}, False),
        ({"offset": 0.9e-5, "deviation": 0.0}, False),
        ({"offset": 1.1e-5, "deviation": 0.0}, True),
    ],
)
def test_an_offset_counts_where_the_recording_tells_it(
    change, significant, monkeypatch
):
    """From three deviations and 10 us on, of a fit with a bias and a mass that explains
    half of the wrench, or 0.8 for more than 50 ms; where it explains far more than
    none."""
    found = robust(**change)
    assert judged(found, monkeypatch, "smooth", 100.0) is significant


def judged(found, monkeypatch, kind: str, more: float) -> bool:
    """Whether its offset counts where without one the squared residuals are larger by
    `more`."""
    fit = found.fit
    unit = np.repeat(fit.scale, 3)
    square = float(np.sum(fit.weights[:, None] * (fit.residual / unit) ** 2))
    factor = (1.0 + more / max(square, 1e-300)) ** 0.5
    zero = SimpleNamespace(known=fit.known, residual=factor * fit.residual)
    monkeypatch.setattr(robust_fit, "gauss_newton", lambda *_, **__: zero)
    monkeypatch.setattr(robust_fit, "replace", lambda given, **_: given)
    found.problem.path = SimpleNamespace(kind=kind)
    fit.start = None
    return offset_is_significant(found)


def test_an_offset_counts_that_explains_nine_independent_squares(monkeypatch):
    """By the residuals' spectrum, of two; of orientations alone half of them all."""
    found = robust()
    assert not judged(found, monkeypatch, "smooth", 17.9)
    assert judged(found, monkeypatch, "smooth", 18.1)
    unit = np.repeat(found.fit.scale, 3)
    square = np.sum(found.fit.weights[:, None] * (found.fit.residual / unit) ** 2)
    assert square > 20.0
    assert not judged(found, monkeypatch, "orientation", 0.99 * square)
    assert judged(found, monkeypatch, "orientation", 1.01 * square)


@pytest.mark.parametrize(
    ("kind", "measured", "interval", "fastest"),
    [
        ("smooth", False, 0.01, 0.15),
        ("smooth", False, 0.02, 0.3),
        ("smooth", False, 0.05, 0.5),
        ("smooth", True, 0.01, 0.5),
        ("static", False, 0.01, 0.5),
    ],
)
def test_a_rigid_body_moves_at_fifteen_hertz_at_most(kind, measured, interval, fastest):
    """Over the rate of the blocks; at half of it all of them are."""
    path = SimpleNamespace(kind=kind, gravity_measured=measured)
    time = interval * np.arange(20.0)
    problem = cast(Any, SimpleNamespace(path=path, time=np.append(time, 99.0)))
    assert fastest_frequency(problem) == pytest.approx(fastest)
    problem.time = time[:1]
    assert fastest_frequency(problem) == 0.5
