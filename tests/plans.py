"""Plans for tests of what is done with one: not found by any optimisation, or by a
brief one."""

from functools import partial

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.messages import note, warning
from hefting.planning.kinematics import Trajectory, knots_of
from hefting.planning.limits import Limits
from hefting.planning.result import INSTANTS, Forecast, Plan
from hefting.planning.search import EFFORTS, Effort
from hefting.planning.tours import best_tour

BRIEF = Effort(candidates=4, starts=1, rounds=2, steps=8, polish=0)
"""A tenth of a quick search: the motion keeps its limits, but is not a good one."""
BRIEF_STEPS = 100
"""Of a search for poses, in place of 600."""


def search_briefly(monkeypatch):
    """Quick searches are brief ones, with a `brief_forecast`. How good quick plans are
    is tested in planning/."""
    monkeypatch.setitem(EFFORTS, "quick", BRIEF)
    brief_forecast(monkeypatch)
    brief = partial(best_tour, steps=BRIEF_STEPS)
    monkeypatch.setattr("hefting.planning.tours.best_tour", brief)


def brief_forecast(monkeypatch):
    """Accuracies are expected at two instants alone, of one draw of the noise: that of
    several the mean is told is tested in planning/test_sensors.py."""
    monkeypatch.setitem(INSTANTS, "quick", 2)
    monkeypatch.setattr("hefting.planning.sensors.NOISES", 1)


def random_plan(n, duration=2.0, source="arm.urdf", tip="tool", size=2.0, asked=None):
    """A plan of n joints between random positions up to `size` [rad], at rest at both
    ends."""
    knots = knots_of(duration, max(int(4 * duration), 4))
    rng = np.random.default_rng(n)
    points = rng.uniform(-size, size, (len(knots) - 6, n))
    points[:3], points[-3:] = points[0], points[-1]
    trajectory = Trajectory(knots, points)
    motion = trajectory.sampled(100.0)
    return Plan(
        joints=tuple(f"joint_{i + 1}" for i in range(n)),
        tip=tip,
        source=str(source),
        trajectory=trajectory,
        limits=Limits(
            1.1 * size * np.array([[-1.0, 1.0]] * n),
            1.1 * np.abs(motion.velocity).max(axis=0),
            1.1 * np.abs(motion.acceleration).max(axis=0),
            np.full(n, 1e3),
        ),
        corners=0.1 * np.array([[0, 0, 0], [1, 1, 0], [-1, 0, 2.0]]),
        forecast=forecast(duration),
        asked=asked,
        time_needed=None if asked is None else 0.6 * duration,
        usage={"corner_speed": 0.99, "speed": 0.4, "acceleration": 0.8},
        binding=(note("plan-corner-speed", "the corners' speed binds in 62 % of it"),),
        notes=(note("plan-noise-assumed", "noise assumed: 0.1 N and 0.005 N m"),),
        warnings=(warning("plan-limits-assumed", "acceleration 5 rad/s² assumed"),),
    )


def forecast(duration, body_mass=0.8):
    """Half-widths that fall with the root of time, the inertia open at first."""
    time = np.linspace(0.0, duration, 8)
    later = 1.0 / np.sqrt(np.maximum(time, 0.05 * duration))
    inertia = np.where(time == 0.0, np.inf, 0.2 * later)
    accuracy = tuple(
        Accuracy(0.002 * width, 0.001 * width, open_)
        for width, open_ in zip(later, inertia, strict=True)
    )
    return Forecast(
        time,
        0.002 * body_mass * later,
        0.0005 * later[:, None] * np.array([1.0, 1.2, 1.5]),
        1e-3 * inertia[:, None, None] * np.ones((3, 3)),
        accuracy,
    )
