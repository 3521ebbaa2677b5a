"""What ingest found cannot be changed by whoever holds it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from disturbances import body
from hefting.ingest import condition
from hefting.ingest.drift import Drift
from hefting.simulation import UR5, Faults, random_smooth, record
from hefting.simulation.wield import wield_analytically


def test_arrays_of_what_was_found_are_read_only():
    wielding = wield_analytically(UR5, random_smooth(9.0, 50.0, 1.2, seed=5), body(1.2))
    found = condition(record(wielding, Faults(drift=(0.5, 0, 0, 0, 0, 0)), seed=1))
    held = np.ones(10)
    again = replace(found, parameters=held)
    held[0] = 5.0
    assert again.parameters[0] == 1.0
    assert isinstance(found.bias, Drift)
    arrays = [
        (each, field.name)
        for each in (found, found.bias)
        for field in fields(each)
        if isinstance(getattr(each, field.name), np.ndarray)
    ]
    assert len(arrays) >= 8
    for each, name in arrays:
        with pytest.raises(ValueError, match="read-only"):
            getattr(each, name).flat[0] = 0
