"""What is expected of a wrench sensor's recording."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from problems import NOISE

from hefting.planning import sensors
from hefting.planning.held import Held
from hefting.planning.sensors import NOISES, WristSensor
from hefting.simulation.arm import UR5E
from plans import random_plan


def test_the_end_is_the_mean_over_draws_of_the_noise(monkeypatch):
    """One draw may be lucky: what is expected must not hang on it."""
    seen = []

    def identify(recording, shape, duration, **_):
        seen.append((duration, recording["wrench"].values))
        C = len(seen) * 1e-6 * np.eye(10)
        return SimpleNamespace(estimate=SimpleNamespace(covariance=C))

    monkeypatch.setattr(sensors, "identify", identify)
    trajectory, robot = random_plan(6).trajectory, UR5E.robot
    gravity = np.array((0.0, 0.0, -9.81))
    sensor = WristSensor.of(robot, gravity, NOISE, None, 100.0)
    own = sensor.forecast(trajectory, 2, Held.of(None, None), 5)
    assert [duration for duration, _ in seen] == [1.0] + NOISES * [2.0]
    wrenches = [wrench for _, wrench in seen[1:]]
    for one, other in pairwise(wrenches):
        assert np.abs(one - other).max() > NOISE.force
    mean = np.mean(np.arange(2, 2 + NOISES))
    assert own.mass[-1] == pytest.approx(1.96 * (1e-6 * mean) ** 0.5, rel=1e-3)
