"""Steps of a coarsely recorded wrench, and a sensor at its limit."""

import numpy as np
import pytest
from benchmarks.given import correct

from hefting import identify
from hefting.ingest.channels import (
    dead_channel_message,
    quantisation_message,
    step_beyond_noise,
)
from hefting.ingest.ingest import ingest
from hefting.ingest.outliers import saturated


def in_steps(values, step):
    return step * np.round(values / step)


@pytest.mark.parametrize("offset", [0.0, 0.123])
def test_a_step_is_found_beside_any_constant(offset):
    """A motion over 40 steps, with noise of a tenth of one."""
    rng = np.random.default_rng(1)
    motion = 5.0 * np.sin(np.linspace(0.0, 20.0, 2000)) + 0.025 * rng.normal(size=2000)
    assert step_beyond_noise(in_steps(motion, 0.25) + offset) == pytest.approx(0.25)


def test_no_step_is_found_where_noise_is_larger_or_values_are_exact():
    rng = np.random.default_rng(2)
    motion = 5.0 * np.sin(np.linspace(0.0, 20.0, 2000))
    noisy = motion + 0.5 * rng.normal(size=2000)
    assert step_beyond_noise(in_steps(noisy, 0.25)) == 0.0
    assert step_beyond_noise(noisy) == 0.0
    assert step_beyond_noise(np.full(10, 3.0)) == 0.0


@pytest.mark.parametrize(("step", "severity"), [(0.4, "note"), (2.0, "warning")])
def test_coarse_steps_are_told_and_large_ones_give_doubt(step, severity):
    steps = np.repeat((step, 0.05 * step), 3)
    given = correct(0).wrench(lambda _, w: in_steps(w, steps))
    message = quantisation_message(given.recording)
    assert message is not None
    assert (message.code, message.severity) == ("wrench-quantised", severity)
    assert f"{step:g} N" in message
    assert quantisation_message(correct(0).recording) is None


def test_a_limit_that_the_fit_explains_is_found():
    """Noise makes every other value unique; the fit follows the limit."""
    rng = np.random.default_rng(3)
    free = 5.0 * np.sin(np.linspace(0.0, 20.0, 2000))[:, None] * np.ones(6)
    free = free + 0.05 * rng.normal(size=free.shape)
    clipped = np.clip(free, -3.0, 3.0)
    assert (saturated(clipped, clipped, np.ones(6)) == (clipped != free).any(1)).all()


def test_a_wrench_that_rests_without_noise_is_at_no_limit():
    steps = np.repeat(np.arange(10.0), 100)[:, None] * np.ones(6)
    assert not saturated(steps, steps, np.ones(6)).any()


@pytest.mark.parametrize(("rows", "unit"), [((3, 6), "N m"), ((0, 3), "N")])
def test_steps_of_one_of_force_and_torque_are_told_alone(rows, unit):
    steps = np.full(6, 1e-9)
    steps[slice(*rows)] = 0.4 if unit == "N" else 0.1
    given = correct(0).wrench(lambda _, w: in_steps(w, steps))
    message = quantisation_message(given.recording)
    assert message is not None
    assert f"in steps of {steps[rows[0]]:g} {unit}, larger" in message


def test_a_channel_of_two_levels_is_at_no_limit():
    rng = np.random.default_rng(4)
    levels = (rng.random((1000, 1)) < 0.4) * np.ones(6)
    assert not saturated(levels, levels, np.ones(6)).any()


def test_coarse_steps_are_all_that_is_said_of_a_right_recording():
    """An object of 0.2 kg, of which the force has a few levels, and rests on some."""
    steps = np.repeat((1.0, 0.05), 3)
    found = ingest(correct(5).wrench(lambda _, w: in_steps(w, steps)).recording)
    assert [m.code for m in found.warnings] == ["wrench-quantised"]


@pytest.mark.parametrize(
    ("step", "code"), [(0.016, "wrench-quantised"), (0.1, "channel-dead")]
)
def test_torques_that_hardly_exceed_their_step_are_not_to_be_used(step, code):
    """Of a light object they have one to three levels, of which the fit makes a COM
    without any error."""
    steps = np.repeat((0.1, step), 3)
    given = correct(5).wrench(lambda _, w: in_steps(0.1 * w, steps))
    verdict = identify(given.recording).verdict
    assert verdict.level == "do not use"
    assert verdict.reasons[0].code == code
    hidden = "hardly less than the torque changes" in verdict.reasons[0]
    assert hidden == (code == "wrench-quantised")


@pytest.mark.parametrize(("levels", "dead"), [(1, False), (9, True)])
def test_a_channel_that_rounds_to_one_value_is_not_dead(levels, dead):
    """Where those beside it pass many steps, it is."""

    def change(wrench):
        torque = np.clip(in_steps(wrench[:, 3:], 0.02), -0.02 * levels, 0.02 * levels)
        torque[:, 0] = 0.0
        return np.hstack((in_steps(wrench[:, :3], 0.1), torque))

    message = dead_channel_message(correct(5).wrench(lambda _, w: change(w)).recording)
    assert (message is not None) == dead
    assert message is None or message.startswith("tx never changes")
