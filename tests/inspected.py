"""Recordings of a hammer that is wielded, and what inspection finds of them."""

import io
from dataclasses import replace
from functools import cache

from rich.console import Console

from hefting.cli.report.inspection import inspection_report
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.inspection import Inspection, inspect
from hefting.simulation import UR5, hammer, random_smooth, simulate

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
