"""Errors of a sensor as on its data sheet are no mistake, however clearly they show."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.clean import simulated

from hefting import identify
from hefting.core.spatial import Array
from hefting.ingest.rivals.sensor_calibration import RANGES


def mixed(number: int, std: float) -> Array:
    """(6, 6) calibration matrix whose entries are off by `std` of the ranges."""
    rng = np.random.default_rng([31, number])
    entries = std * rng.normal(size=(6, 6))
    return np.eye(6) + entries * np.divide.outer(RANGES, RANGES)


def named(number: int, std: float, accuracy: str | None = None) -> set[str]:
    """What is named of a right recording of 6 s by such a sensor, of which an accuracy may
    be given."""
    made, *_ = simulated(number, 6.0)
    wrench = made["wrench"]
    streams = dict(made.streams)
    streams["wrench"] = replace(wrench, values=wrench.values @ mixed(number, std).T)
    made = replace(made, streams=streams)
    estimate = identify(made, sensor_accuracy=accuracy).estimate
    said = {getattr(message, "code", "") for message in estimate.warnings}
    return said & {"cross-talk", "gain-uneven", "axes-turned"}


@pytest.mark.parametrize("number", [1, 2, 17, 20])
def test_what_is_usual_is_not_named(number):
    """Of 0.3 %, where sheets have 0.5; these, and four others of 52, had been named."""
    assert not named(number, 0.003)


@pytest.mark.parametrize("number", [1, 2])
def test_three_times_as_much_as_on_sheets_is(number):
    assert named(number, 0.015)


@pytest.mark.parametrize("number", [1, 2])
def test_what_the_given_accuracy_allows_is_not_named(number):
    """The intervals contain it."""
    assert not named(number, 0.015, "2%")


def test_what_is_far_beyond_the_given_accuracy_is():
    assert named(2, 0.05, "2%")
