"""Inspection: figures beside independent ones, what is said of them, and that no log
makes it fail."""

import io
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from scipy.spatial.transform import Rotation

from hefting import identify
from hefting.cli import main
from hefting.cli.report.inspection import inspection_report
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.ingest.ingest import ingest
from hefting.inspection import Inspection, inspect
from hefting.inspection.facts import movement, stream_facts, time_above, wrench_facts
from hefting.inspection.inspect import advice
from hefting.logs import read_log, write_log
from hefting.motion import measure
from hefting.simulation import UR5, hammer, random_smooth, simulate, wield
from recordings import DATA, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")

RATE, DURATION = 50.0, 8.0
NOISE = Noise(force=0.1, torque=0.005)
BODY = hammer().parameters


@cache
def wielded(speed=1.0):
    return UR5.motion(random_smooth(DURATION, RATE, speed, seed=4))


def log_of(
    bias=None, on_sensor=False, gravity=(0.0, 0.0, -9.80665), speed=1.0
) -> Recording:
    return simulate(
        wielded(speed), BODY, gravity, NOISE, bias=bias, on_sensor=on_sensor, seed=5
    )


@cache
def found_of(**settings) -> Inspection:
    return inspect(log_of(**settings))


def with_wrench(log: Recording, values=None, time=None) -> Recording:
    wrench = log["wrench"]
    changed = Stream(
        wrench.time if time is None else time,
        wrench.values if values is None else values,
    )
    return replace(log, streams={**log.streams, "wrench": changed})


def printed(found: Inspection, width=200, verbose=True) -> str:
    page = io.StringIO()
    Console(width=width, file=page).print(inspection_report(found, verbose))
    return page.getvalue()


# streams


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


# movement


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


# wrench


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
    assert any("ms late: identify shifts it by itself" in line for line in found.advice)
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


# advice


def test_advice_names_what_to_do():
    log, found = log_of(), found_of()
    n = len(found.conditioned.rejected)

    def of(**reasons):
        changed = replace(
            found.conditioned, reasons={**found.conditioned.reasons, **reasons}
        )
        return " | ".join(advice(replace(found, conditioned=changed), log))

    assert "does the object touch something" not in of()
    assert (
        "20 % of the samples do not fit one free body: does the object touch something"
        in of(contact=n // 5)
    )
    assert "the sensor reached its limit" in of(saturation=30)
    assert "spikes" in of(spike=n // 10)
    streams = {
        **found.streams,
        "orientation": replace(found.streams["orientation"], rate=10.0, missing=0.3),
    }
    said = advice(replace(found, streams=streams), log)
    assert any("poses come at 10 Hz: record 100 Hz" in line for line in said)
    assert any("30 % of the poses are missing" in line for line in said)
    for line in (*said, *found.advice):
        assert "\n" not in line


def test_an_empty_hand():
    """Noise alone, in many orientations: nothing is held, or the controller has
    subtracted it."""
    log = log_of()
    noise = np.repeat((0.1, 0.005), 3) * np.random.default_rng(8).normal(
        size=log["wrench"].values.shape
    )
    found = inspect(with_wrench(log, noise))
    assert any(
        "is anything held, or does the controller subtract its payload?" in line
        for line in found.advice
    )
    assert found.facts.bias is None


def test_what_is_printed_are_the_verdict_the_findings_and_the_advice():
    found = inspect(log_of())
    first, *others = str(found).split("\n- ")
    assert first == f"{found.log}: {found.verdict}"
    assert tuple(others) == (*found.findings, *found.advice)


def test_a_part_is_inspected_as_it_is_identified():
    log = log_of()
    part = {"start": 2.0, "duration": 5.0}
    found, used = inspect(log, **part), identify(log, method="OLS", **part)
    assert found.duration == pytest.approx(5.0 - 1.0 / RATE)
    assert found.streams["wrench"].samples == 5.0 * RATE
    np.testing.assert_array_equal(
        found.ingested.measurements.wrench, used.measurements.wrench
    )
    with pytest.raises(InputError, match="no sample from 20 s on"):
        inspect(log, start=20.0)


def test_beside_a_tool_the_object_alone_is_told():
    """The tool is half of what is held, or all of it."""
    log = log_of()
    all_of_it = inspect(log).ingested.fit
    covariance = all_of_it.covariance[:10, :10]

    def beside(share):
        own = InertialParameters(share * BODY.vector)
        return inspect(log, tool=Estimate("OLS", own, 100, covariance=covariance))

    found = beside(0.5)
    assert found.facts.mass == pytest.approx(0.5 * BODY.mass, rel=0.02)
    assert found.facts.noise == pytest.approx(inspect(log).facts.noise, rel=0.1)
    assert "--tool TOOL --shape MESH" in found.advice[0]
    assert beside(1.0).missing["object"] == "nothing is held beside the tool"


# whatever the log


def static(log: Recording, rows=slice(None)) -> Recording:
    streams = {k: log[k][rows] for k in ("orientation", "wrench")}
    count = np.arange(float(len(streams["wrench"])))
    return Recording(
        {k: Stream(count, s.values) for k, s in streams.items()},
        static=True,
        source="poses",
    )


def odd_logs() -> dict[str, tuple[Recording, str]]:
    """Logs that lack something, and a word of the advice."""
    log = log_of()
    wrench, orientation, position = log["wrench"], log["orientation"], log["position"]
    joints = Stream(wrench.time, np.random.default_rng(9).normal(size=(len(wrench), 6)))
    held = Stream(wrench.time, np.repeat(orientation.values[:1], len(wrench), axis=0))
    return {
        "joints": (
            Recording({"joint_positions": joints, "wrench": wrench}),
            "`urdf` robot.urdf `sensor_frame` NAME",
        ),
        "wrench": (Recording({"wrench": wrench}), "qx qy qz qw"),
        "poses": (Recording({"orientation": orientation}), "record the wrench"),
        "three poses": (
            Recording({"orientation": orientation[:3], "wrench": wrench[:3]}),
            "too few",
        ),
        "one row": (
            Recording({"orientation": orientation[:1], "wrench": wrench[:1]}),
            "other orientations",
        ),
        "no overlap": (
            with_wrench(log, time=wrench.time + 100.0),
            "while the pose was",
        ),
        "zero wrench": (with_wrench(log, 0.0 * wrench.values), "zero throughout"),
        "a million newtons": (with_wrench(log, 1e9 * wrench.values), "newtons"),
        "one orientation": (
            Recording({"orientation": held, "wrench": wrench}),
            "other orientations",
        ),
        "static": (static(log, slice(None, None, 20)), "--shape"),
        "two static poses": (static(log, slice(0, 400, 399)), "ten static poses"),
        "one static pose": (static(log, slice(1)), "other orientations"),
        "turning only": (
            Recording({"orientation": orientation, "wrench": wrench}),
            "record positions",
        ),
        "eight poses": (
            Recording(
                {
                    "orientation": orientation[:8],
                    "position": position[:8],
                    "wrench": wrench[:8],
                }
            ),
            "",
        ),
    }


PAGE = (Path(__file__).parents[2] / "docs" / "json.md").read_text()
DOCUMENTED = {
    key
    for line in PAGE.split("\n## inspect\n")[1].split("\n## ")[0].splitlines()
    if line.startswith("| `")
    for key in re.findall(r"`(\w+)`", line.split(" | ")[0])
}


@pytest.mark.parametrize("name", list(odd_logs()))
def test_no_log_makes_it_fail(name):
    log, word = odd_logs()[name]
    found = inspect(log)
    assert found.advice
    assert word in " | ".join((*found.advice, *found.warnings))
    out = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert set(out) == DOCUMENTED
    assert set(out["streams"]) == set(log.streams)
    assert (found.facts is None) == ("object" in out["missing"])
    assert (found.movement is None) == ("motion" in out["missing"])
    assert (found.conditioned is None) == ("conditioning" in out["missing"])
    text = printed(found)
    assert text.index("\nmotion") < text.index("\nobject") < text.index("\nnext: ")
    assert "nan" not in text


def test_what_was_there_before_is_still_there():
    keys = (
        "log duration static streams motion linear_speed angular_speed dynamism quick_mass mass bias bias_t noise "
        "identifiability advice warnings undetermined wrench wrench_t"
    )
    out = found_of().to_dict()
    assert set(keys.split()) <= set(out) == DOCUMENTED
    assert out["streams"]["wrench"]["samples"] == RATE * DURATION
    assert out["streams"]["wrench"]["rate"] == pytest.approx(RATE)


def test_notes_of_the_reader_are_printed():
    log = replace(
        log_of(), notes=("wrench from topic /wrench",), warnings=("the file was cut",)
    )
    text = printed(inspect(static(log)))  # a static copy has none
    assert "topic" not in text
    found = inspect(replace(static(log), notes=log.notes, warnings=log.warnings))
    assert found.notes == log.notes
    assert "note: wrench from topic /wrench" in printed(found)
    assert "- the file was cut" in printed(found)


@pytest.mark.parametrize(
    "gravity", [(0.0, 0.0, 0.0), (0.0, 9.8), (np.nan, 0.0, 0.0), "down"]
)
def test_a_gravity_that_is_none(gravity):
    with pytest.raises(InputError, match="gravity"):
        inspect(log_of(), gravity)


def test_a_reversed_gravity_is_not_said_to_agree():
    """Nor is the sign said that was found with it."""
    found = inspect(log_of(gravity=(0.0, 0.0, 9.80665)))
    assert [w.code for w in found.warnings] == ["gravity-reversed"]
    assert found.gravity_hint is None
    assert "the data agree" not in printed(found)
    assert "on-sensor" not in printed(found)


def test_the_command_on_joint_angles(tmp_path, capsys, monkeypatch):
    """Without a URDF there is little to say, but that is said."""
    path = tmp_path / "joints.csv"
    write_log(odd_logs()["joints"][0], path)
    for words in ([], ["--json"]):
        monkeypatch.setattr("sys.argv", ["hefting", "inspect", str(path), *words])
        main()
        assert "give --urdf robot.urdf --sensor-frame NAME" in capsys.readouterr().out


@needs_recordings
@pytest.mark.parametrize(
    ("name", "gravity", "mass"),
    [("kuka-ati/static_poses", 9.82085, 0.9323), ("axia80/poses7", 9.80665, 1.1013)],
)
def test_recorded_static_poses(name, gravity, mass):
    found = inspect(read_log(DATA / f"{name}.csv"), (0.0, 0.0, -gravity))
    assert not found.sign.on_object
    # the published figures have four digits
    assert found.facts.mass == pytest.approx(mass, rel=1e-3)
    assert found.facts.quick_mass_less_bias == pytest.approx(mass, rel=1e-2)
    assert found.undetermined == ("Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")
    assert found.movement.turn > 2.0


def test_beside_a_named_mistake_nothing_else_is_advised():
    """What follows from it is not told, and would not help."""
    log = log_of()
    orientation = log["orientation"]
    q = np.roll(np.array(orientation.values), 1, axis=1)
    streams = {**log.streams, "orientation": replace(orientation, values=q)}
    found = inspect(replace(log, streams=streams))
    codes = {message.code for message in found.verdict.reasons}
    assert "quaternion-order" in codes
    assert not codes & {"sign-uncertain", "unexplained", "many-outliers"}
    assert found.advice == ("put right what the verdict names, and inspect again",)


@pytest.mark.parametrize(
    ("factor", "code", "begin"),
    [(1.0, None, "ready: "), (400.0, "mass-unusual", "ready, with care: ")],
)
def test_ready_is_as_the_verdict_says(factor, code, begin):
    """A wrench in another unit, say, leaves nothing to improve in the recording."""
    log = log_of()
    found = inspect(with_wrench(log, factor * log["wrench"].values))
    assert code in {None, *(message.code for message in found.verdict.reasons)}
    assert found.advice[0].startswith(begin)
