"""Plans for joint torques: what runs of them give, against random motions, and what is
refused."""

import sys
from functools import cache
from unittest.mock import patch

import numpy as np
import pytest

import hefting
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import by_torques
from hefting.identification.by_torques import ByTorques
from hefting.planning.held import Held
from hefting.planning.sensors import JointTorques
from hefting.simulation.torque_scenario import TorqueRobot

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

from benchmarks.planning_runs import Bench, width_ratios

BOX = hefting.Shape.from_box(-0.05, 0.05, -0.05, 0.05, 0.02, 0.22)
BODY = InertialParameters(BOX.homogeneous.vector / BOX.homogeneous.mass)
QUICK = {"shape": BOX, "torques": True, "effort": "quick"}


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return Bench("ur5e", tmp_path_factory.mktemp("torques"))


@pytest.fixture(scope="module")
def planned(bench):
    return bench.plan(**QUICK)[0]


def played(bench, plans, seed):
    """By runs of the plans on another robot of the kind, without the object and a minute
    later with it: friction, rotors, offsets and warm-up as by default. Joints in another
    order or of another sign are not looked for, which changes no interval."""
    robot = TorqueRobot(bench.massive, seed=seed)
    runs = [
        [
            robot.record(plan.motion, body, 60.0 * i + 120.0 * k, seed=2 * k + i)
            for k, plan in enumerate(plans)
        ]
        for i, body in enumerate((None, BODY))
    ]
    with patch.object(by_torques, "of_rivals", lambda *_: []):
        found = ByTorques.of(runs[1], bench.urdf, "flange", empty=runs[0])
    return found.estimate(BOX)


@pytest.fixture(scope="module")
def found_of(bench, planned):
    """The estimate from runs of the plan, by seed; each is made once."""
    return cache(lambda seed: played(bench, [planned], seed))


@pytest.mark.parametrize("seed", [0, 1])
def test_runs_give_the_half_widths_that_were_expected(planned, found_of, seed):
    found = found_of(seed)
    ratios = width_ratios(planned, found)
    # 0.8 to 1.25 each on three arms: the noise is found anew, and is coloured by friction
    assert 0.75 < np.median(ratios) < 1.33
    assert 0.5 < ratios.min() < ratios.max() < 2.0
    # half-widths are of 95 % intervals, of ten quantities
    off = abs(found.mass - BODY.mass) / planned.forecast.mass[-1]
    assert off < 2.0


def test_it_beats_random_motions_of_the_same_time(bench, planned):
    """In what is expected after each of six Fourier series that fill the limits."""
    gravity = np.array(STANDARD_GRAVITY)
    sensor = JointTorques.of(True, None, 100.0, bench.urdf, "flange", gravity)
    found = [
        sensor.forecast(own, 2, Held.of(None, BOX), 0).accuracy[-1]
        for own in bench.random(10.0, 6, BOX)
    ]
    last = planned.forecast.accuracy[-1]
    # 0.58, 0.21 and 0.50 as measured once
    for name, most in (("mass", 0.75), ("center_of_mass", 0.4), ("inertia", 0.7)):
        median = np.median([getattr(own, name) for own in found])
        assert getattr(last, name) < most * median


def test_the_next_plan_takes_noise_and_certainty_from_the_estimate(
    bench, planned, found_of
):
    estimate = found_of(0)
    plan, _ = bench.plan(**QUICK, estimate=estimate, duration=4.0)
    noise = estimate.provenance["torque_noise"]
    np.testing.assert_allclose(plan.settings["noise"]["joint_torques"], noise)
    assert any("as of the estimate" in own for own in plan.notes)
    before, width = plan.forecast.mass[0], estimate.half_widths["mass"]
    assert before == pytest.approx(width, rel=1e-4)  # 1.96 with its further digits
    both = width_ratios(plan, played(bench, [planned, plan], 0))
    # noise and its colour are found anew from both, and the arm from more motion
    assert 0.7 < np.median(both) < 1.4
    first, last = plan.forecast.inertia[[0, -1]]
    assert np.linalg.norm(last) < np.linalg.norm(first)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"shape": None}, "hardly determine an inertia without a shape"),
        ({"noise": hefting.Noise(0.1, 0.1)}, "`noise`: it is of a wrench sensor"),
        ({"force": 10.0}, "`force`: it is of a wrench sensor"),
        ({"torque": 1.0}, "`torque`: it is of a wrench sensor"),
        ({"stop_and_go": True}, "torques of joints at rest are of no use"),
        ({"torques": [0.1, 0.1]}, "of all or of 6 joints"),
        ({"torques": -0.1}, "not positive"),
        ({"torques": np.nan}, "not positive"),
        ({"torques": "much"}, "not made of numbers"),
    ],
)
def test_what_cannot_be_planned_is_one_line(bench, wrong, said):
    with pytest.raises(InputError) as error:
        bench.plan(**(QUICK | wrong))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_without_pinocchio_the_error_says_what_to_install(bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(MissingDependencyError, match=r"hefting\[robot\]"):
        bench.plan(**QUICK)
