"""The next motion from a live estimate: it aims at what is open."""

from functools import partial

import numpy as np
import pytest

import hefting
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.planning import plan, tours
from hefting.planning.tours import best_tour
from hefting.robots.joint_motion import sensor_motion
from hefting.simulation import simulate
from hefting.simulation.torque_scenario import TORQUE_ARMS, UR5E
from plans import search_briefly

BODY = InertialParameters.from_com(0.9, (0.01, 0.0, 0.12), np.diag((5e-3, 5e-3, 1e-3)))
NOISE = Noise(force=0.1, torque=0.005)


@pytest.fixture(scope="module")
def urdf(tmp_path_factory):
    path = tmp_path_factory.mktemp("next") / "ur5e.urdf"
    path.write_text(TORQUE_ARMS["ur5e"].urdf)
    return path


@pytest.fixture(scope="module")
def first(urdf):
    """A motion for mass and COM, played, and what is known live after it."""
    with pytest.MonkeyPatch.context() as patch:  # any tour will do, found soon
        patch.setattr(tours, "best_tour", partial(best_tour, steps=50))
        rests = plan(urdf, "flange", stop_and_go=True, duration=5.0, effort="quick")
    log = simulate(sensor_motion(UR5E.robot, rests.motion), BODY, noise=NOISE, seed=1)
    *_, now = hefting.live(log, speed=float("inf"))
    assert now.estimate is not None
    return rests, now.estimate


def test_it_aims_at_what_is_open(urdf, first):
    rests, estimate = first
    start = rests.motion.position[-1]
    given = {"start": start, "duration": 3.0, "effort": "quick"}
    found = plan(urdf, "flange", estimate=estimate, until="inertia=60%", **given)
    np.testing.assert_allclose(found.motion.position[0], start, atol=1e-12)
    before, after = found.forecast.accuracy[0], found.forecast.accuracy[-1]
    # half of what it was and more: rests tell no inertia
    assert after.inertia < 0.5 * before.inertia
    assert after.mass <= before.mass


def test_the_same_posterior_gives_the_same_plan(urdf, first, monkeypatch):
    """By a brief search; that of a quick one is tested in `test_plan`."""
    search_briefly(monkeypatch)
    given = {"estimate": first[1], "duration": 2.0, "effort": "quick"}
    one, other = (plan(urdf, "flange", **given).motion.position for _ in range(2))
    np.testing.assert_array_equal(one, other)
