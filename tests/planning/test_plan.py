"""Plans as a whole: limits by MuJoCo, what is found with them, and what is refused."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.planning import tours
from hefting.planning.limits import CLEARANCE
from hefting.planning.result import time_needed
from hefting.planning.sensors import GAIN
from hefting.planning.tours import STEPS, best_tour
from hefting.simulation.torque_scenario import TORQUE_ARMS

pytest.importorskip("mujoco")

from benchmarks.planning_limits import Case, broken, kept
from benchmarks.planning_runs import Bench, bodies, width_ratios

from plans import brief_forecast, search_briefly

ARM = TORQUE_ARMS["ur5e"].arm


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return Bench("ur5e", tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def quick(bench):
    return bench.plan(duration=4.0, effort="quick", seed=3)[0]


@pytest.fixture(scope="module")
def first(bench):
    """What a random motion told, before a plan."""
    return bench.play(next(bench.random(10.0, 1, seed=1)), bodies(2)[1], 0)


@pytest.fixture
def _briefly(monkeypatch):
    """Where it does not matter how good a plan is."""
    search_briefly(monkeypatch)


@pytest.fixture
def _told_twice(monkeypatch):
    """Where what is expected of a plan does not matter."""
    brief_forecast(monkeypatch)


def refused(bench, **arguments):
    given = {"start": ARM.start, "effort": "quick", "duration": 4.0} | arguments
    with pytest.raises(InputError) as error:
        hefting.plan(bench.urdf, "flange", **given)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.usefixtures("_told_twice")
@pytest.mark.parametrize("seed", [3, 5, 10])
def test_no_random_limit_is_broken_by_mujocos_own_account(seed, tmp_path):
    """With cylinders for links, a table and a wall; MuJoCo reads the URDF itself."""
    pytest.importorskip("coal")
    case = Case.random(("ur5e", "panda", "xarm7"), seed)
    uses = broken(case, case.plan(tmp_path))
    assert not {name: own for name, own in uses.items() if not kept(name, own)}


def test_the_same_seed_gives_the_same_plan(bench, quick):
    again, _ = bench.plan(duration=4.0, effort="quick", seed=3)
    np.testing.assert_array_equal(again.trajectory.points, quick.trajectory.points)
    assert again.to_dict() == quick.to_dict()


@pytest.mark.usefixtures("_briefly")
def test_another_seed_gives_another_plan(bench):
    one, other = (
        bench.plan(duration=4.0, effort="quick", seed=seed)[0].trajectory.points
        for seed in (3, 4)
    )
    assert np.abs(other - one).max() > 0.1


def test_it_starts_where_it_is_told_and_ends_at_rest(quick):
    motion = quick.motion
    np.testing.assert_allclose(motion.position[0], ARM.start, atol=1e-12)
    for name in ("velocity", "acceleration"):
        ends = getattr(motion, name)[[0, -1]]
        np.testing.assert_allclose(ends, 0.0, atol=1e-8)
    assert quick.duration == 4.0


def test_a_quick_plan_too_tells_when_what_is_asked_is_expected(quick):
    """By the middle of the motion, where that suffices; the end alone was told."""
    forecast = quick.forecast
    k = int(np.searchsorted(forecast.time, 0.5 * quick.duration))
    assert 0 < k < len(forecast.time) - 2
    needed = time_needed(forecast, forecast.accuracy[k])
    assert forecast.time[k - 1] < needed <= forecast.time[k]


def test_usage_is_near_its_limits_and_binding_says_which(quick):
    assert 0.97 < max(quick.usage.values()) <= 1.0
    assert {own.code for own in quick.binding} == {"plan-limit-binds"}
    assert any("corner" in own for own in quick.binding)


def test_a_planned_motion_beats_random_ones_of_more_than_twice_its_time(bench, quick):
    """In inertia, as identified without a shape from MuJoCo's recordings. Plans of 4 s
    have a tenth of the error of random motions of 10 s on average, so that chance does
    not decide."""
    body = bodies(2)[1]
    planned = [bench.play(quick.trajectory, body, k).errors[2] for k in range(3)]
    others = bench.random(10.0, 3)
    random = [bench.play(own, body, k).errors[2] for k, own in enumerate(others)]
    assert np.median(planned) < 0.5 * np.median(random)


def test_the_next_motion_finds_what_the_first_left_open_and_says_how_sure(bench, first):
    body = bodies(2)[1]
    plan, _ = bench.plan(estimate=first.estimate, duration=4.0, effort="quick")
    pair = [first.recording, bench.recording(plan.trajectory, body, 1)]
    found = hefting.identify(pair).estimate
    before = np.linalg.norm(first.estimate.half_widths["inertia_at_com"])
    after = np.linalg.norm(found.half_widths["inertia_at_com"])
    assert after < 0.3 * before
    # one recording: half-widths themselves scatter by a tenth, and noise is found anew
    assert 0.7 < np.median(width_ratios(plan, found)) < 1.4


@pytest.mark.usefixtures("_briefly")
def test_no_motion_tells_the_mass_beside_a_tool_better_than_the_sensors_gain(
    bench, first
):
    """A tool as heavy as the object: the gain acts on both, and acted on the tool."""
    first = first.estimate
    tool = first.parameters.vector.tolist()
    beside = replace(first, provenance={**first.provenance, "tool": tool})
    plan, _ = bench.plan(estimate=beside, duration=2.0, effort="quick")
    # a quantile of draws is off by a few percent
    assert plan.forecast.accuracy[-1].mass > 0.93 * 1.96 * GAIN * np.hypot(2.0, 1.0)


@pytest.mark.usefixtures("_briefly")
def test_the_sensors_range_holds_object_and_tool(bench, first):
    """As heavy as the object, in its place: of a range of 1.5 weights nothing is left."""
    first = first.estimate
    tool = first.parameters.vector.tolist()
    beside = replace(first, provenance={**first.provenance, "tool": tool})
    force = 1.5 * 9.81 * first.mass
    plan, _ = bench.plan(estimate=first, duration=2.0, effort="quick", force=force)
    assert plan.usage["force"] <= 1.0
    assert "range of force" in refused(bench, estimate=beside, force=force)


@pytest.mark.usefixtures("_briefly")
def test_a_short_motion_is_expected_to_tell_less_beside_a_bias(bench, first):
    """Of 2 s, by a brief plan: after an estimate without bias, and after one with it."""
    first = first.estimate
    C = 1e4 * first.covariance
    masses = []
    for bias in ("none", "estimate"):
        known = {**first.provenance, "bias": bias}
        known = replace(first, covariance=C, provenance=known)
        plan, _ = bench.plan(estimate=known, duration=2.0, effort="quick")
        masses.append(plan.forecast.accuracy[-1].mass)
    assert masses[1] > 1.2 * masses[0]


@pytest.mark.usefixtures("_briefly")
def test_what_is_asked_is_reached_and_told_when(bench):
    plan, _ = bench.plan(until="inertia=20%,com=3mm", duration=4.0, effort="quick")
    assert plan.reached
    assert plan.forecast.accuracy[-1].inertia < 0.2
    assert 0.0 < plan.time_needed < 4.0


@pytest.mark.usefixtures("_briefly")
def test_out_of_reach_says_how_long_it_would_take(bench):
    text = refused(bench, until="inertia=20%", duration=1.0)
    assert "out of reach within 1 s" in text
    assert "plan for about" in text


@pytest.mark.usefixtures("_briefly")
def test_what_no_motion_tells_is_said(bench):
    text = refused(bench, until="mass=0.05%", duration=1.0)
    assert "nor by any longer motion" in text


@pytest.mark.usefixtures("_briefly")
def test_a_long_motion_is_a_shorter_one_there_and_back(bench):
    """Which keeps its limits, and leaves no more than it does once."""
    given = {"effort": "quick", "until": "inertia=100%"}
    short, long = (bench.plan(duration=T, **given)[0] for T in (4.0, 60.0))
    assert long.duration == pytest.approx(60.0)
    q = long.motion.position
    np.testing.assert_allclose(q[:1501], q[1500:3001][::-1], atol=1e-9)
    assert max(long.usage.values()) <= 1.0
    assert long.forecast.accuracy[-1].inertia < short.forecast.accuracy[-1].inertia


def test_a_start_out_of_range_is_named(bench):
    start = np.array(ARM.start)
    start[2] = 7.0
    text = refused(bench, start=start)
    assert "joint 'joint3' starts at 7 rad, outside" in text
    assert "in radians, not degrees" in text


def test_a_start_that_touches_is_refused(bench):
    text = refused(bench, keep=["z>=1.0"])
    assert "z>=1.0" in text


@pytest.mark.usefixtures("_briefly")
@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"start": [0.0, 1.0]}, "6 finite joint positions"),
        ({"duration": 0.2}, "0.2 s"),
        ({"duration": np.nan}, "nan s"),
        ({"duration": "5"}, "`duration` is '5', not a number of seconds"),
        ({"speed": None}, "`speed` is 'None', not a number of m/s"),
        ({"rate": [100.0]}, "not a number of Hz"),
        ({"seed": "first"}, "not a number"),
        ({"rate": 0.0}, "0 Hz"),
        ({"effort": "most"}, "effort"),
        ({"until": "mass=1%", "stop_and_go": True, "duration": 1.0}, "plan for longer"),
        ({"until": "inertia=1%", "stop_and_go": True}, "rests do not show"),
        ({"noise": hefting.Noise(0.0, 0.1)}, "must be positive"),
    ],
)
def test_what_cannot_be_planned_is_one_line(bench, wrong, said):
    assert said in refused(bench, **wrong)


def test_an_unknown_tip_is_named(bench):
    with pytest.raises(InputError, match="no frame is named 'flanje'"):
        hefting.plan(bench.urdf, "flanje")


@pytest.mark.usefixtures("_briefly")
def test_a_sensor_too_weak_for_the_object_says_so(bench):
    text = refused(bench, force=5.0)
    assert "range of force" in text


@pytest.mark.usefixtures("_briefly")
def test_a_sensors_range_is_kept(bench):
    # 1 kg is expected: 9.8 N at rest, and up to 10.2 N where nothing holds it back
    plan, _ = bench.plan(duration=2.0, effort="quick", force=10.0)
    assert plan.usage["force"] <= 1.0


@pytest.mark.usefixtures("_briefly")
def test_without_a_start_it_chooses_one_that_is_free(bench):
    plan = hefting.plan(
        bench.urdf, "flange", duration=2.0, effort="quick", keep=["z>=0.05"]
    )
    assert plan.clearance >= 0.5 * CLEARANCE
    assert max(plan.usage.values()) <= 1.0


@pytest.mark.usefixtures("_told_twice")
def test_rests_tell_mass_and_com(bench, monkeypatch):
    """Of a tour that was found in a quarter of the usual steps."""
    monkeypatch.setattr(tours, "best_tour", partial(best_tour, steps=STEPS // 4))
    plan, _ = bench.plan(stop_and_go=True, duration=8.0, effort="quick")
    body = bodies(1)[0]
    found = bench.play(plan.trajectory, body, 0)
    # of random motions of 10 s the median is 0.06 % and 0.3 mm
    assert found.errors[0] < 0.5
    assert found.errors[1] < 1.5
