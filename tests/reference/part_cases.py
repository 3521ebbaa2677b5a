"""Cases of more parts of `hefting.ingest`: outliers, blocks, changes of the object, and
least squares."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from disturbances import body
from hefting.core.measurements import Noise
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest import outliers
from hefting.ingest.blocks import Blocks, block_starts, medians, within_blocks
from hefting.ingest.changes import bodies as screening
from hefting.ingest.changes.assignment import assign
from hefting.ingest.changes.bodies import (
    JointModel,
    autocorrelation,
    log_ratio,
    variance_of_any_linear_function,
)
from hefting.ingest.changes.cells import (
    Cells,
    Intervals,
    cells_of,
    has_long_contact,
    partition,
)
from hefting.ingest.changes.find import _is_change, _unexplained
from hefting.ingest.changes.stretches import center_of_mass, event_between
from hefting.ingest.channels import step_beyond_noise
from hefting.ingest.findings import _milliseconds
from hefting.ingest.free_fit import free_fit, lever, wrench_sign
from hefting.ingest.left_out import _missing
from hefting.ingest.model import invert
from hefting.ingest.outliers import find_odd_poses, find_outliers, saturated
from hefting.ingest.samples import find_outliers_piecewise
from hefting.ingest.uncertainty import (
    _average_over_neighbours,
    _segments,
    _taper,
)
from hefting.simulation import Faults
from reference.fit_cases import CHANGES, robust
from reference.held import biased, dynamic, slow
from reference.recorded import (
    fast,
    recorded,
    short,
    wielding,
)


def noise(K: int, seed: int) -> Array:
    """Of a wrench (K, 6), larger in some parts."""
    rng = np.random.default_rng([70, seed])
    size = np.repeat((0.1, 0.005), 3) * (1.0 + np.arange(K) / K)[:, None]
    return size * rng.normal(size=(K, 6))


def of_outliers() -> Any:
    """Spikes, short and weak contacts, and limits, of any rate."""
    found = {}
    for rate in (50.0, 400.0):
        K = int(4.0 * rate)
        time = np.arange(K) / rate
        rng = np.random.default_rng(71)
        predicted = 9.0 * np.sin(time[:, None] * np.linspace(1.0, 4.0, 6))
        wrench = predicted + noise(K, 1)
        wrench[(time > 1.0) & (time < 1.2)] += (3.0, 0, 0, 0.1, 0, 0)
        wrench[(time > 2.0) & (time < 2.5)] += (0.0, 0.55, 0, 0, 0.01, 0.0)
        wrench[(time > 3.0) & (time < 3.06)] += (0.0, 0.0, 0.9, 0, 0.03, 0.0)
        wrench[rng.integers(K, size=9)] += (2.0, 1.0, -2.0, 0.1, 0.1, 0.0)
        wrench = np.minimum(wrench, np.array((8.7, 20, 20, 9, 9, 8.9)))
        known = (time < 3.7) | (time > 3.8)
        spread = 1.0 + 0.3 * np.sin(time)
        sizes = np.array((0.15, 0.008)), np.array((0.3, 0.02))
        each = find_outliers(time, wrench, predicted, spread, known, *sizes)
        found[str(rate)] = {
            name: np.flatnonzero(mask) / K for name, mask in vars(each).items()
        }
        found[f"limits {rate}"] = saturated(wrench, predicted, np.repeat(sizes[0], 3))
        poses = find_odd_poses(wrench[::9], predicted[::9], sizes[1])
        found[f"poses {rate}"] = poses.spike
        cell = np.arange(K) // 7
        found[f"parts {rate}"] = (
            outliers._nearby(wrench - predicted, cell)[cell],
            outliers._cell_medians(wrench, cell),
            outliers._imperfection(time, predicted, cell, sizes[1]),
            outliers._spread(wrench - predicted, np.zeros(2)),
            outliers._contact_cells(np.abs(wrench[:, 0])),
            outliers._running(wrench, (wrench[:, 0] > 0).astype(float), 4),
        )
    samples, fit = robust("fast")
    found["pieces"] = find_outliers_piecewise(samples, fit.problem, fit.fit)
    return found


def of_blocks() -> Any:
    """Averages, of all samples and of some."""
    wrench = recorded(fast)["wrench"]
    time, values = np.array(wrench.time), np.array(wrench.values)
    time = time + 2e-4 * np.sin(99.0 * time)
    kept = np.random.default_rng(72).random(len(time)) < 0.5
    kept[200:212] = False
    starts = block_starts(time)
    found = {"starts": starts, "slow": block_starts(time[::9]) is None}
    for name, mask in {"all": None, "some": kept}.items():
        each = Blocks.of(time, values, mask)
        found[name] = each
        found[f"{name} within"] = within_blocks(each, time, values, mask)
        found[f"{name} each third"] = each.every(-(-len(each) // 3))
        found[f"{name} count"] = each.mean_count
    return found | {"medians": medians(values, starts)}


def cells_held(kind: str) -> Cells:
    """Cells of a recording in which the object changes."""
    samples, found = robust(kind)
    cells = cells_of(samples, found.problem, found.fit, found.outliers, 0.01)
    assert cells is not None
    return screening.with_noise_scale(cells, np.zeros(2))


def of_changes(kind: str) -> Any:
    """From cells to bodies."""
    samples, found = robust(kind)
    cells = cells_held(kind)
    intervals = Intervals(cells)
    begin, end = np.array((0, 10, 30, 0)), np.array((20, 60, 80, 80))
    model = JointModel(cells, [(0, 30), (32, 50), (50, len(cells))])
    apart, one, some = model.fit([0, 1, 2]), model.fit([0, 0, 0]), model.fit([0, -1, 1])
    assigned = assign(cells)
    assert assigned is not None
    return {
        "cells": cells,
        "interval": cells.interval,
        "contact": has_long_contact(samples, found.outliers),
        "costs": intervals.cost(begin, end),
        "partition": np.array(partition(cells)),
        "drift": model.drift,
        "three": {**vars(apart), "combinations": None},
        "one": one.squares,
        "some": (
            some.bodies,
            some.variance,
            some.squares / np.maximum(some.equations, 1.0)[:, None],
        ),
        "increase": [apart.increase(*pair) for pair in ((0, 1), (0, 2), (1, 2))],
        "ratio": log_ratio(one, apart),
        "tau": autocorrelation(model.residuals(apart)),
        "best": screening._best_change(cells),
        "suspicious": screening.is_suspicious(cells),
        "any": variance_of_any_linear_function(cells),
        "labels": assigned.labels,
        "stretches": np.array(assigned.stretches),
        "variance": (assigned.variance, assigned.tau),
        "unexplained": _unexplained(assigned),
        "change": _is_change(assigned, assigned.stretches),
    }


def of_free_fits() -> Any:
    """Least squares without a bias and beside one."""
    found = {}
    for name, z in {"dynamic": dynamic(), "biased": biased(), "slow": slow()}.items():
        state = SampleState.of(z)
        fits = free_fit(state, True, np.linspace(0.8, 3.0, 16)), free_fit(state, False)
        found[name] = {
            "fits": fits,
            "t": [(fit.mass_t, fit.mass_is_open, fit.autocorrelation) for fit in fits],
            "bias t": fits[0].bias_t,
            "open": [fit.open_parameters(0.1) for fit in fits],
            "sign": wrench_sign(*fits),
            "lever": [lever(state, free) for free in (True, False)],
            "less": fits[0].less(0.2 * fits[0].vector, np.eye(10) * 1e-4),
            "flipped": fits[1].flipped(),
        }
    return found


def small() -> Any:
    """Functions of a few numbers."""
    rng = np.random.default_rng(74)
    bodies = [body(mass).vector for mass in (0.05, 0.19, 0.21, 1.0, 1.04, 1.06, 1.5)]
    F = rng.normal(size=(8, 6))
    power, count = rng.exponential(size=(2, 70))
    count[20:30] = 0.0
    gaps = np.delete(np.linspace(0.0, 5.9, 60), [9, 20, 21, 22, 23, 24, 40, 41, 42, 43])
    values = np.round(np.cumsum(rng.normal(size=80)), 1)
    return {
        "events": [
            event_between(one, other, std)
            for one in bodies
            for other in bodies
            for std in (1e-3, 0.1)
        ],
        "places": [center_of_mass(each, 2.5) for each in bodies],
        "inverse": [*invert(F @ F.T), *invert(F[:5] @ F[:5].T)],
        "segments": [(s.start, s.stop) for s in _segments(50_000)],
        "taper": _taper(35),
        "average": _average_over_neighbours(power, count),
        "missing": _missing(gaps),
        "steps": [
            step_beyond_noise(x) for x in (values, values + 1e-3 * rng.random(80))
        ],
        "milliseconds": [_milliseconds(s) for s in (0.0123, 1e-4, 2e-6, 0.3)],
        "noise": Noise(*noise(4, 3)[0, :4] ** 2),
        "faults": Faults(),
        "exact": wielding(short).measurements.wrench,
    }


CASES: dict[str, Callable[[], Any]] = {
    "outliers": of_outliers,
    "blocks": of_blocks,
    **{f"changes, {kind}": partial(of_changes, kind) for kind in CHANGES},
    "free fits": of_free_fits,
    "small": small,
}
"""By name."""
