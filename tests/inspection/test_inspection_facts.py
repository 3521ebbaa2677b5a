"""Inspection's figures of streams, motion and wrench beside independent ones, and what
is said of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.recording import Recording, Stream
from hefting.ingest.ingest import ingest
from hefting.inspection import inspect
from hefting.inspection.facts import movement, stream_facts, time_above, wrench_facts
from hefting.motion import measure
from hefting.simulation import wield
from inspected import BODY, RATE, found_of, log_of, printed, wielded, with_wrench

pytestmark = pytest.mark.usefixtures("same_poses")


def test_a_stream_of_known_faults():
    """100 Hz for 100 s: every tenth sample lost, 0.3 s without any, 3 % jitter, a value
    that is held for three."""
    rng = np.random.default_rng(1)
    kept = np.arange(10_000) % 10 != 7
    kept[5000:5030] = False
    time = 0.01 * np.flatnonzero(kept) + 3e-4 / np.sqrt(2.0) * rng.normal(
        size=kept.sum()
    )
    values = np.repeat(rng.normal(size=(3400, 2)), 3, axis=0)[: len(time)]
    facts = stream_facts(Stream(time, values), static=False)
    assert facts.samples == len(time)
    assert facts.rate == pytest.approx(100.0, rel=0.002)  # the median errs by 0.04 %
    assert facts.gaps == 1
    assert facts.longest_gap == facts.gap_time == pytest.approx(0.31, abs=0.002)
    assert facts.missing == pytest.approx(1.0 - kept.mean(), abs=0.002)
    # of 9,000 steps: 1 %; and of the median
    assert facts.jitter == pytest.approx(3e-4, rel=0.05)
    assert facts.jitter_share == pytest.approx(facts.jitter * facts.rate)
    assert facts.repeated == pytest.approx(2.0 / 3.0, abs=0.001)


def test_a_perfect_stream_and_one_sample():
    facts = stream_facts(
        Stream(np.arange(500) / 128.0, np.arange(500.0)[:, None]), static=False
    )
    assert (facts.rate, facts.gaps, facts.missing, facts.jitter, facts.repeated) == (
        128.0,
        0,
        0.0,
        0.0,
        0.0,
    )
    one = stream_facts(Stream(np.array([3.0]), np.ones((1, 2))), static=False)
    assert (one.samples, one.rate, one.start, one.end) == (1, 0.0, 3.0, 3.0)
    assert (
        stream_facts(Stream(np.arange(4.0), np.ones((4, 1))), static=True).rate == 0.0
    )


def test_time_above_a_limit():
    """A rectified sine of 1 m/s is above 0.5 m/s for two thirds of its time; a gap
    counts as one step."""
    time = np.arange(10_001) / 1000.0
    # 40 crossings
    assert time_above(time, np.abs(np.sin(2 * np.pi * time)), 0.5) == pytest.approx(
        20 / 3, abs=0.02
    )
    assert time_above(time, np.full(len(time), 0.3), 0.25) == pytest.approx(10.0)
    assert time_above(
        np.array([0.0, 1.0, 2.0, 60.0]), np.ones(4), 0.5
    ) == pytest.approx(3.0)
    assert time_above(time, np.full(len(time), 0.25), 0.25) == 0.0


def test_speeds_are_those_of_the_motion():
    motion = wielded()
    m = found_of().movement
    for (mean, largest), vectors in (
        (m.linear_speed, motion.linear_velocity),
        (m.angular_speed, motion.angular_velocity),
    ):
        truth = np.linalg.norm(vectors, axis=1)
        # smoothing poses of 0.1 mm and 0.02° at 50 Hz leaves velocities known to about
        # 1 mm/s and 3 mrad/s
        assert mean == pytest.approx(truth.mean(), rel=0.01)
        assert largest == pytest.approx(truth.max(), rel=0.02)
    truth = np.linalg.norm(motion.linear_velocity, axis=1)
    assert m.above_limit == pytest.approx(np.sum(truth > 0.25) / RATE, abs=0.1)


def test_the_speed_limit_of_iso_10218():
    fast, slow = found_of(), found_of(speed=0.3)
    # the first motion exceeds the limit by far, the other keeps it
    assert np.linalg.norm(wielded().linear_velocity, axis=1).max() > 0.3
    assert np.linalg.norm(wielded(0.3).linear_velocity, axis=1).max() < 0.24
    assert not fast.movement.keeps_limit
    assert slow.movement.keeps_limit
    assert fast.to_dict()["speed_limit"]["above"] > 0.0
    assert slow.to_dict()["speed_limit"] == {"limit": 0.25, "kept": True, "above": 0.0}
    assert "ISO 10218: exceeded for" in printed(fast)
    assert "ISO 10218: kept" in printed(slow)
    assert any("slow down" in line for line in fast.advice)
    assert not any("slow down" in line for line in slow.advice)
    blind = replace(
        log_of(), streams={k: s for k, s in log_of().streams.items() if k != "position"}
    )
    assert movement(blind, measure(blind)).keeps_limit is None


@pytest.mark.parametrize("seed", range(5))
def test_how_far_gravity_turned(seed):
    """Against all pairs; the ends are looked for in 200 directions, so may be missed by
    some degrees."""
    rng = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(rng.uniform(0.1, 2.0) * rng.normal(size=(60, 3)))
    rows = np.arange(60.0)
    streams = {
        "orientation": Stream(rows, turns.as_quat()),
        "wrench": Stream(rows, rng.normal(size=(60, 6))),
    }
    log = Recording(streams, static=True)
    down = turns.inv().apply((0.0, 0.0, -1.0))
    widest = np.arccos(np.clip(down @ down.T, -1.0, 1.0)).max()
    assert widest - np.radians(6.0) <= movement(log, measure(log)).turn <= widest + 1e-6


def test_signal_to_noise_is_that_of_the_simulation():
    exact = wield(wielded(), BODY).wrench
    channels = found_of().facts.channels
    for name, part, level in (
        ("force", slice(0, 3), 0.1),
        ("torque", slice(3, 6), 0.005),
    ):
        signal = np.sqrt(np.mean(exact[:, part] ** 2, axis=0))
        # a bias is free and takes up to 0.05 N (three standard deviations) of a signal
        # of 3 to 5 N; 0.002 of 0.2 N m
        np.testing.assert_allclose(
            channels[name].signal, signal, atol=0.02 * signal.max()
        )
        # 400 samples show a standard deviation to 3.5 %; errors of the motion, of the
        # angular above all, add to it
        assert (0.85 * level < channels[name].noise).all()
        assert (channels[name].noise < 1.3 * level).all()
        np.testing.assert_allclose(
            channels[name].snr, (channels[name].signal / channels[name].noise) ** 2
        )
    out = found_of().to_dict()["signal_to_noise"]
    assert set(out) == {
        "force",
        "torque",
        "linear acceleration",
        "angular velocity",
        "angular acceleration",
    }
    assert out["force"]["snr"] == pytest.approx(list(channels["force"].snr))


def test_gravity_dominance_and_quick_mass():
    z = wield(wielded(), BODY)
    still = replace(
        z,
        **{
            n: np.zeros_like(z.force)
            for n in ("linear_acceleration", "angular_velocity")
        },
    )
    still = replace(still, angular_acceleration=np.zeros_like(z.force))
    weight = -BODY.mass * still.gravity
    weight = np.hstack((weight, np.cross(BODY.center_of_mass, weight)))
    rest = z.wrench - weight
    f = found_of().facts
    for ratio, part in zip(
        f.gravity_dominance, (slice(0, 3), slice(3, 6)), strict=True
    ):
        truth = np.sqrt(np.mean(weight[:, part] ** 2) / np.mean(rest[:, part] ** 2))
        # the torque of motion is known to a few percent
        assert ratio == pytest.approx(truth, rel=0.05)
    quick = np.linalg.norm(z.force, axis=1).mean() / 9.80665
    assert found_of().quick_mass == pytest.approx(quick, rel=0.005)
    biased = found_of(bias=(20.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert biased.quick_mass > 2.0 * quick
    assert biased.facts.quick_mass_less_bias == pytest.approx(quick, rel=0.02)
    assert biased.facts.mass == pytest.approx(BODY.mass, rel=0.02)


def wrench_facts_of(log: Recording, scale: float):
    found = ingest(with_wrench(log, scale * log["wrench"].values), bias="estimate")
    return wrench_facts(found, found.fit, True)


def test_ratios_do_not_depend_on_unit_or_sign():
    one = wrench_facts_of(log_of(), 1.0)
    for scale in (-1.0, 1e3):
        other = wrench_facts_of(log_of(), scale)
        for name, channels in one.channels.items():
            # rounding of the solve
            np.testing.assert_allclose(
                other.channels[name].snr, channels.snr, rtol=1e-6
            )
        np.testing.assert_allclose(
            other.gravity_dominance, one.gravity_dominance, rtol=1e-6
        )
        assert other.mass == pytest.approx(abs(scale) * one.mass, rel=1e-9)


def test_sign_bias_and_offset_are_found_and_said():
    bias = np.array((3.0, -2.0, 5.0, 0.1, 0.2, -0.3))
    log = log_of(bias=tuple(bias), on_sensor=True)
    late = with_wrench(log, time=log["wrench"].time + 0.03)
    found = inspect(late)
    assert not found.sign.on_object
    assert found.to_dict()["wrench"] == "on-sensor"
    # 400 samples: five standard deviations of the bias that fit_freely finds
    std = np.abs(found.facts.bias / found.facts.bias_t)
    assert (np.abs(found.facts.bias - bias) < 5.0 * std).all()
    assert std[:3].max() < 0.1
    assert found.conditioned.offset == pytest.approx(0.03, abs=0.004)
    # the offset left in would add 0.2 N: 30 ms at 1 rad/s and 6.6 N
    assert found.facts.noise[0] < 0.13
    assert found.to_dict()["clock_offset"]["offset"] == found.conditioned.offset
    assert any("ms late: identify corrects that" in line for line in found.advice)
    text = printed(found)
    for part in (
        "on-sensor (certain",
        "ms late",
        "bias as recorded (",
        "signal-to-noise",
        "least squares",
        "next: ",
    ):
        assert part in text


def test_a_tilted_base_gives_doubt_and_a_hint():
    tilt = np.radians(12.0)
    tilted = 9.80665 * np.array((np.sin(tilt), 0.0, -np.cos(tilt)))
    found = found_of(gravity=tuple(tilted))
    assert np.degrees(found.gravity_hint.angle) == pytest.approx(12.0, abs=2.0)
    assert found.gravity_hint.serious
    assert found.verdict.reasons[0].code == "base-tilted"  # as of identify
    np.testing.assert_array_equal(found.gravity, (0.0, 0.0, -9.80665))  # only a hint
    level = found_of()
    assert not level.gravity_hint.serious
    assert not any("`gravity`" in line for line in level.advice)
    estimated = inspect(log_of(gravity=tuple(tilted)), "estimate")
    assert estimated.gravity_hint.adopted
    assert np.degrees(np.arccos(estimated.gravity @ tilted / 9.80665**2)) < 2.0
    assert not any("`gravity`" in line for line in estimated.advice)
