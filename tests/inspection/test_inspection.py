"""Inspection: what is advised, found and printed of a recording."""

from dataclasses import replace

import numpy as np
import pytest

from hefting import identify
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.inspection import inspect
from hefting.inspection.inspect import advice
from inspected import BODY, RATE, found_of, log_of, with_wrench

pytestmark = pytest.mark.usefixtures("same_poses")


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
    assert beside(1.0).missing["object"] == "nothing but the tool is held"


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
    assert found.advice == ("correct what the verdict names, and inspect again",)


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
