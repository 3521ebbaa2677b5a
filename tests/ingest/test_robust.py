"""Conditioning against simulated truth: what each disturbance costs beside a clean
recording and beside an oracle.

Forty seeds and both masses: `python -m benchmarks.robustness`. Here fewer, for the same
bounds.
"""

from functools import cache
from importlib import import_module

import numpy as np
import pytest

from disturbances import (
    GRAVITY,
    NOISE,
    SCALE,
    body,
    disturbed,
    errors,
    identified,
    identified_after,
    rms,
    with_wrench,
)
from hefting.core.recording import Recording, Stream
from hefting.ingest import condition
from hefting.simulation import UR5, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_poses")
SEEDS = range(6)
MASSES = {"light": 0.3, "heavy": 1.5}


def clean(mass):
    """RMS errors of clean recordings."""
    return rms(oracle("clean", mass))


@cache
def oracle(kind, mass):
    """Errors of recordings as an oracle repairs them, a row for each of `SEEDS`."""
    made = [disturbed(kind, mass, seed) for seed in SEEDS]
    return [errors(identified(d.repaired, d.gravity)[0], d.body) for d in made]


def repaired(kind, mass):
    """The same: a delay and a sign leave nothing behind once they are put right."""
    return oracle("clean" if kind in ("offset", "flipped") else kind, mass)


@cache
def fast():
    """Half a minute at 1 kHz."""
    joints = random_smooth(27.5, 1000.0, 1.0, 3)
    return simulate(UR5.motion(joints), body(1.5), noise=NOISE, seed=3)


@pytest.mark.parametrize(
    ("kind", "mass", "bound"),
    [  # RMS error of mass, COM and inertia over those of the clean recordings
        ("clean", "light", 1.1),
        ("drift", "heavy", 1.25),
        ("offset", "light", 1.25),
        ("offset", "heavy", 1.25),
        ("flipped", "light", 1.25),
        ("tilt", "heavy", 1.25),
        ("spikes", "light", 1.25),
        ("dropped", "heavy", 1.5),
        ("contact", "light", 1.7),
        ("contact", "heavy", 1.7),
        ("all", "light", 2.2),
        ("all", "heavy", 2.2),
    ],
)
def test_a_disturbance_costs_little(kind, mass, bound):
    base, rows, offsets = clean(MASSES[mass]), [], []
    for seed in SEEDS:
        d = disturbed(kind, MASSES[mass], seed)
        found = condition(d.recording, tilt=kind in ("tilt", "all"), changes=False)
        assert found.sign.on_object == (d.sign > 0.0)
        rows.append(errors(identified_after(found, d.recording)[0], d.body))
        offsets.append(abs(found.offset - d.offset))
    cost, least = rms(rows) / base, rms(repaired(kind, MASSES[mass])) / base
    print(
        f"{kind}, {mass}: {cost.round(2)}, oracle {least.round(2)}, offset {1e3 * np.median(offsets):.2f} ms"
    )
    assert np.all(cost <= bound)
    # 1.3 over forty seeds; the ratio over six is uncertain by a tenth
    assert np.all(cost <= 1.4 * least)
    # 1 ms over forty
    assert np.median(offsets) <= (1e-3 if mass == "heavy" else 1.5e-3)
    assert np.median(np.array(rows)[:, 0]) <= 0.005


@pytest.mark.parametrize("kind", ["contact", "coloured"])
def test_standard_deviations_are_true(kind):
    """0.8 to 1.3 over forty seeds; the RMS of 10 normal masses is uncertain by 0.22, so
    two of those more."""
    z, after = [], []
    for mass in MASSES.values():
        for seed in range(5):
            d = disturbed(kind, mass, round(100 * (1 + mass)) + seed)
            found = condition(d.recording, changes=False)
            vector, std = identified_after(found, d.recording)
            z.append((found.parameters - d.body.vector) / found.std)
            after.append((vector - d.body.vector) / std)
    for values in (np.array(z), np.array(after)):
        for part in (slice(1), slice(1, 4), slice(4, 10)):
            assert 0.8 - 0.44 < rms(values[:, part].ravel()) < 1.3 + 0.44


def test_a_slow_drift_does_not_leak_into_the_mass():
    """3 N and 0.15 N m, exponentially within a minute, over three: unnoticed it costs
    ten times the clean error."""
    d = disturbed("clean", 0.3, 1, duration=180.0)
    wrench = d.recording["wrench"]
    drift = 3.0 * SCALE / np.sqrt(3.0) * (1.0 - np.exp(-wrench.time / 60.0))[:, None]
    drifting = with_wrench(d.recording, wrench.time, wrench.values + drift)
    found = condition(drifting, changes=False)
    vector, std = identified_after(found, drifting)
    assert found.bias.kind == "random walk"
    assert abs(vector[0] - 0.3) < 3.0 * std[0]
    assert abs(identified(drifting, GRAVITY)[0][0] - 0.3) > 5.0 * std[0]
    # straight lines 22 s long bend 22² / 8 / 60² of 1.7 N beside the curve
    assert (
        np.abs(found.bias.change(wrench.time) - (drift - drift.mean(axis=0)))[
            :, :3
        ].max()
        < 0.06
    )


@pytest.mark.parametrize("in_part", [False, True])
def test_a_fast_recording_is_corrected_whole(in_part, monkeypatch):
    """Half a minute at 1 kHz: offset, spikes anywhere and noise are found from
    averages, or from every other one."""
    if in_part:
        monkeypatch.setattr(
            import_module("hefting.ingest.condition"), "MOST_FITTED_SAMPLES", 25_000
        )
        monkeypatch.setattr(
            import_module("hefting.ingest.condition"), "MOST_FITTED_BLOCKS", 1_375
        )
    recording = fast()
    time, values = recording["wrench"].time, recording["wrench"].values.copy()
    rng = np.random.default_rng(0)
    spikes = rng.random(len(time)) < 0.01
    values[spikes] += (
        20.0 * SCALE * rng.choice([-1.0, 1.0], size=(int(spikes.sum()), 6))
    )
    touched = (time > 20.0) & (time < 21.0)
    values[touched] += (5.0, 0.0, 0.0, 0.0, 0.4, 0.0)
    late = Recording({**recording.streams, "wrench": Stream(time + 0.03, values)})
    found = condition(late, changes=False)
    assert found.offset == pytest.approx(0.03, abs=3e-4)
    assert np.mean(found.rejected[spikes | touched]) > 0.99
    assert np.mean(found.rejected[~(spikes | touched)]) < 0.005
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]
    assert len(found.corrected(late)["wrench"]) == int(np.sum(~found.rejected))
    # of one sample, however many were averaged: 4,000 values of each tell it within
    # 1.1 %
    assert found.noise.force == pytest.approx(NOISE.force, rel=0.03)
    assert found.noise.torque == pytest.approx(NOISE.torque, rel=0.03)
