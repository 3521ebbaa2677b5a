"""A bias that the motion cannot tell from the object's weight."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting import identify
from hefting.core.errors import NotIdentifiableError
from hefting.core.messages import codes
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest.sign_and_bias import choose_bias

COUNT = 600
MASS, COM = 1.2, np.array((0.02, 0.08, 0.07))


def at_rest(bias):
    """A sensor that stands still with an object, turned a little from the vertical."""
    rng = np.random.default_rng(5)
    turn = Rotation.from_rotvec((0.2, 0.1, 0.0))
    force = turn.inv().apply((0.0, 0.0, -MASS * STANDARD_GRAVITY[2]))
    wrench = np.concatenate((force, np.cross(COM, force))) + bias
    shaken = Rotation.from_rotvec(5e-5 * rng.normal(size=(COUNT, 3)))
    return {
        "time": 0.01 * np.arange(COUNT),
        "position": 2e-5 * rng.normal(size=(COUNT, 3)),
        "orientation": turn * shaken,
        "wrench": wrench + rng.normal(size=(COUNT, 6)) * np.repeat((0.1, 0.005), 3),
    }


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.3), (0.0, -1.0, 1.0)])
def test_one_that_shows_across_gravity_leaves_no_mass_to_be_used(direction):
    bias = 5.0 * np.array((*direction, 0.0, 0.0, 0.0)) / np.linalg.norm(direction)
    found = identify(**at_rest(bias))
    (message,) = [m for m in found.warnings if m.code == "bias-undetermined"]
    assert message.severity == "error"
    assert "turn the sensor to other orientations" in message
    assert found.verdict.level == "do not use"


def test_without_one_the_mass_is_right():
    found = identify(**at_rest(np.zeros(6)))
    (message,) = [m for m in found.warnings if m.code == "bias-unknown"]
    assert message.severity == "warning"
    low, high = found.interval("mass")
    assert low < MASS < high
    assert found.verdict.level == "usable with care"


def turning(bias, mass=0.0, turn=1.0):
    """A sensor that turns in place for 10 s, up to `turn` [rad], and holds `mass`."""
    rng = np.random.default_rng(7)
    time = 0.01 * np.arange(1000)
    swing = turn * np.sin(np.outer(time, (0.9, 0.7, 0.5)))
    attitude = Rotation.from_rotvec(swing)
    force = attitude.inv().apply((0.0, 0.0, -mass * STANDARD_GRAVITY[2]))
    wrench = np.hstack((force, np.cross(COM, force))) + bias
    return {
        "time": time,
        "position": 2e-5 * rng.normal(size=(1000, 3)),
        "orientation": attitude,
        "wrench": wrench + rng.normal(size=(1000, 6)) * np.repeat((0.1, 0.005), 3),
    }


BIAS = np.array((3.0, -5.0, 8.0, 0.2, 0.1, -0.1))


@pytest.mark.parametrize("bias", [BIAS, 0.0 * BIAS], ids=["biased", "none"])
def test_a_wrench_that_does_not_change_with_gravity_is_of_nothing(bias):
    """With the bias it had been some 0.5 kg, and to be turned to other orientations."""
    found = identify(**turning(bias))
    assert found.verdict.level == "do not use"
    first = found.verdict.reasons[0]
    assert (first.code, first.severity) == ("nothing-held", "error")
    assert "turn the sensor" not in " ".join(found.verdict.reasons)
    low, high = found.interval("mass")
    assert low == 0.0
    assert high < 0.005


def test_nothing_is_told_as_such_where_least_squares_find_less():
    """And not that the sign may be wrong."""
    log, refused = turning(BIAS), []
    for sign in ("on-object", "on-sensor"):
        try:
            found = identify(**log, method="OLS", sign=sign)
            assert found.verdict.reasons[0].code == "nothing-held"
        except NotIdentifiableError as error:
            refused.append(str(error))
    (one,) = refused
    assert "nothing is held" in one


@pytest.mark.parametrize(("mass", "turn"), [(0.05, 1.0), (0.0, 0.01)])
def test_nothing_is_held_only_where_gravity_turns_and_shows_it(mass, turn):
    """Of 50 g, or where gravity turns by half a degree."""
    found = identify(**turning(BIAS, mass, turn))
    assert "nothing-held" not in codes(found.warnings)


@pytest.mark.parametrize(("samples", "told"), [(19, False), (20, True)])
def test_what_a_bias_would_explain_is_told_of_twenty_samples_and_more(samples, told):
    """Of fewer it may be noise."""
    alone = SimpleNamespace(noise=SimpleNamespace(force=3.0), mass=1.0)
    beside = SimpleNamespace(
        noise=SimpleNamespace(force=0.1), bias_is_significant=False, mass_is_open=True
    )
    found = SimpleNamespace(
        bias=SimpleNamespace(kind="constant"),
        gravity=np.array((0.0, 0.0, -9.81)),
        rejected=np.zeros(samples, dtype=bool),
    )
    fits = SimpleNamespace(alone=alone, beside_bias=beside)
    free, (message,) = choose_bias(
        cast(Any, found), cast(Any, fits), may_be_biased=True, is_auto=True
    )
    assert not free
    assert message.code == ("bias-undetermined" if told else "bias-unknown")
