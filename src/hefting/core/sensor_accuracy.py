"""SensorAccuracy: errors of a force-torque sensor as on a data sheet, and the data
sheets of makers.

The measured wrench is (1 + M) w + b + noise, with w the true one, M (6, 6) the errors
of gain and cross-talk, and b an offset. More samples do not reduce their effect on an
estimate. The figures here are limits that hold in 95 % of the cases, as on data sheets;
over `Z95` they are standard deviations.

A sheet states percentages of the range, or limits in N and N m. For some sensors only
the ranges are here, and where to find the accuracy. Figures are the largest of all
axes; ranges are those across the sensor's axis, Fx, Fy and Tx, Ty, as in ATI's names of
calibrations (SI-130-10: 130 N, 10 N m).
"""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.quantity import UNITS, Kind, quantity
from hefting.core.spatial import Array

_OWN_CERTIFICATE = "its calibration certificate states it, in percent of full scale"
_ATI = "ATI Industrial Automation's catalogue of F/T transducers"
_AXIA = "ATI manual 9610-05-Ethernet Axia, F/T Sensor"
_NOISE_ONLY = "its manual states noise"


@dataclass(frozen=True)
class Sheet:
    """Data sheet of a sensor."""

    model: str
    """name of the sensor"""
    document: str
    """name of the data sheet"""
    ranges: tuple[float, float]
    """of force [N] and torque [N m]"""
    of_full_scale: float | None = None
    """limit of the errors over the range; None if it is not stated"""
    absolute: tuple[float, float] | None = None
    """limits of the errors of force [N] and torque [N m]; None if not stated"""
    remark: str = ""
    """where to find the accuracy, if not here"""

    @property
    def states_accuracy(self) -> bool:
        """Whether its accuracy is here."""
        return self.of_full_scale is not None or self.absolute is not None


def sheet_name(text: str) -> str:
    """A sensor's name as in `SHEETS`: lower case, without spaces, hyphens and marks."""
    return "".join(letter for letter in text.lower() if letter.isalnum())


def _sheets(*sheets: Sheet) -> dict[str, Sheet]:
    return {sheet_name(sheet.model): sheet for sheet in sheets}


SHEETS = _sheets(
    Sheet("Mini40", _ATI, (80.0, 4.0), remark=_OWN_CERTIFICATE),
    Sheet("Mini45", _ATI, (290.0, 10.0), remark=_OWN_CERTIFICATE),
    Sheet("Gamma", _ATI, (130.0, 10.0), remark=_OWN_CERTIFICATE),
    Sheet("Delta", _ATI, (330.0, 30.0), remark=_OWN_CERTIFICATE),
    Sheet("Axia80-M20", _AXIA, (500.0, 20.0), remark=_OWN_CERTIFICATE),
    Sheet(
        "FT 300",
        "Robotiq FT 300 Force Torque Sensor, Instruction Manual",
        (300.0, 30.0),
        remark=_NOISE_ONLY,
    ),
    Sheet("HEX-E", "OnRobot HEX-E QC, Datasheet", (200.0, 10.0), of_full_scale=0.05),
    Sheet("HEX-H", "OnRobot HEX-H QC, Datasheet", (200.0, 20.0), of_full_scale=0.05),
    Sheet(
        "UR3e",
        "Universal Robots UR3e, Technical Specifications",
        (30.0, 10.0),
        absolute=(3.5, 0.1),
    ),
    Sheet(
        "UR5e",
        "Universal Robots UR5e, Technical Specifications",
        (50.0, 10.0),
        absolute=(4.0, 0.3),
    ),
    Sheet(
        "UR10e",
        "Universal Robots UR10e, Technical Specifications",
        (100.0, 10.0),
        absolute=(5.5, 0.5),
    ),
)
"""Data sheets by `sheet_name`."""


Z95 = 1.959963984540054
"""Half-width of a Gaussian's central 95 % interval, in standard deviations."""
TYPICAL_LEVER = 0.07
"""[m] Range of torque over range of force of an unknown six-axis sensor; of those in
`SHEETS` it is 0.03 to 0.33 m."""
TYPICAL_SHARE = 0.005
"""Share for an unknown sensor: half a percent, at the lower end of data sheets of
six-axis sensors (0.5 to 2 % of full scale). No recording shows the gain of its sensor.
"""
LARGEST_SLOW_STD = TYPICAL_SHARE
"""Largest standard deviation of slow errors over the load. With it the intervals of
bodies added to recordings of three real sensors hold (`benchmarks.injection`), whatever
the limit of gain and cross-talk."""
OWN_GAIN_RATIO = 0.5**0.5
"""Error of a channel's own gain over that of the gain common to all. Data sheets do not
state it: all channels share the weights and the voltage reference of a calibration, not
the strain gauges. A common gain shows in no residual and keeps its full size."""
EXAMPLE = "0.5% 0.3N 0.01Nm"
"""An accuracy as text."""

_KINDS: dict[str, Kind] = {
    unit: kind for kind in ("share", "force", "torque") for unit in UNITS[kind] if unit
}
"""What a figure with one of these units is."""


@dataclass(frozen=True)
class SensorAccuracy:
    """Limits of a sensor's errors, each of which 95 % of the errors are within.

    Raises `InputError` for limits that are negative or not finite, a share above one,
    and a lever that is not positive.

    Examples
    --------
    >>> hefting.SensorAccuracy.of("0.5% 0.3N 0.01Nm").force
    0.3
    >>> found = hefting.identify("demo/log.csv", sensor_accuracy="0.5% 0.3N 0.01Nm")
    """

    share: float = 0.0
    """of gain over a channel's reading; cross-talk goes with it (`channel_stds`)"""
    force: float = 0.0
    """[N] of the offset of each force, which may vary with time and load"""
    torque: float = 0.0
    """[N m] of the offset of each torque"""
    lever: float = TYPICAL_LEVER
    """[m] range of torque over that of force: what cross-talk between them scales by"""

    def __post_init__(self):
        limits = (self.share, self.force, self.torque, self.lever)
        try:
            good = all(0.0 <= float(limit) < np.inf for limit in limits)
        except (TypeError, ValueError):
            good = False
        if not good or not self.lever > 0.0 or self.share > 1.0:
            what = f"a sensor's accuracy is a share from 0 to 1, newtons and newton-metres, not {limits}"
            raise InputError(what, fix=f"as in {EXAMPLE}")

    @classmethod
    def of(cls, value: "SensorAccuracy | str | None") -> "SensorAccuracy | None":
        """From an accuracy or its text; None for None."""
        if value is None or isinstance(value, SensorAccuracy):
            return value
        if not isinstance(value, str):  # pyright: ignore[reportUnnecessaryIsInstance]
            what = f"a sensor's accuracy is a text or a SensorAccuracy, not {value}"
            raise InputError(what, fix=f"as in '{EXAMPLE}', or a sensor's name")
        return cls.parse(value)

    @classmethod
    def parse(cls, text: str) -> Self:
        """From a text like ``0.5% 0.3N 0.01Nm``, with any of the three, or the name of
        a sensor in `SHEETS`. By default the share is the typical one, an offset none.
        Raises `InputError` for anything else, and for a sensor of unknown accuracy."""
        if re.match(r"\s*[\d.]", text) is None:
            return cls._of_sheet(text)
        found: dict[Kind, float] = {}
        for part in re.split(r"[,\s]+(?=[\d.])", text.strip()):
            unit = part.lstrip("0123456789.e+- ")
            kind = _KINDS.get(unit)
            if kind is None:
                raise InputError(
                    f"'{part}' is no share, force or torque", fix=f"as in {EXAMPLE}"
                )
            if kind in found:
                raise InputError(
                    f"the {kind} is given twice in '{text}'", fix=f"as in {EXAMPLE}"
                )
            found[kind] = quantity(part, kind)
        return cls(**({"share": TYPICAL_SHARE} | found))  # type: ignore[arg-type]

    @classmethod
    def _of_sheet(cls, text: str) -> Self:
        name = sheet_name(text)
        sheet = SHEETS.get(name)
        if sheet is None:
            fix = f"use {', '.join(SHEETS)}, or figures as in {EXAMPLE}"
            raise InputError(f"unknown sensor '{text}'{nearest(name, SHEETS)}", fix=fix)
        if not sheet.states_accuracy:
            what = f"the accuracy of a {sheet.model} is not known here: {sheet.remark}"
            raise InputError(what, fix=f"give figures, as in {EXAMPLE}")
        return cls(*_limits(sheet))

    def __str__(self) -> str:
        """A text for `parse`, without the lever."""
        parts = [f"{100.0 * self.share:g}%"]
        parts += [f"{self.force:g}N"] if self.force else []
        parts += [f"{self.torque:g}Nm"] if self.torque else []
        return " ".join(parts)

    @property
    def none(self) -> bool:
        """Whether there are no errors."""
        return not (self.share or self.force or self.torque)

    @cached_property
    def scale(self) -> Array:
        """(6,) Loads of the channels that are the same share of their ranges: 1 N, and
        newton-metres by the lever."""
        return np.repeat((1.0, self.lever), 3)

    @property
    def gain_std(self) -> float:
        """Standard deviation of the gain that all channels share."""
        return self.share / Z95

    @property
    def slow_std(self) -> float:
        """Standard deviation of errors that change within a recording (hysteresis,
        creep, cables), over the load.

        It is the share itself, about twice that of gain, up to `LARGEST_SLOW_STD`.
        """
        return min(self.share, LARGEST_SLOW_STD)

    @cached_property
    def offset_std(self) -> Array:
        """(6,) Standard deviations of the offset [N, N m]."""
        return np.repeat((self.force, self.torque), 3) / Z95

    @cached_property
    def channel_stds(self) -> Array:
        """(6, 6) Standard deviations of the entries of M, without the gain that all
        channels share.

        Entries between two forces, or two torques, have that of a channel's own gain,
        so that the orientation of the sensor's axes makes no difference. The three
        between a force and the torques, or a torque and the forces, together have as
        much again.
        """
        own = self.share / Z95 * OWN_GAIN_RATIO
        stds = np.full((6, 6), own / 3.0**0.5)
        stds[:3, :3] = stds[3:, 3:] = own
        return stds * np.outer(self.scale, 1.0 / self.scale)

    def reading_std(self, wrench: Array) -> Array:
        """(K, 6) standard deviations [N, N m] of the sensor's readings of wrenches (K, 6),
        by gain, cross-talk and offset, without noise and bias."""
        variance = np.square(wrench) @ np.square(self.channel_stds).T
        variance += np.square(self.gain_std * wrench)
        variance += np.square(self.slow_std * wrench) + np.square(self.offset_std)
        return np.sqrt(variance)


def _limits(sheet: Sheet) -> tuple[float, float, float, float]:
    """Share, force, torque and lever by a data sheet.

    Percentages of full scale are taken as shares of the load: errors of gain,
    cross-talk, linearity and hysteresis grow with it.
    """
    force, torque = sheet.ranges
    lever = torque / force
    if sheet.of_full_scale is not None:
        return sheet.of_full_scale, 0.0, 0.0, lever
    assert sheet.absolute is not None
    return 0.0, *sheet.absolute, lever


TYPICAL = SensorAccuracy(TYPICAL_SHARE)
"""An unknown sensor whose noise is found in the residuals."""
EXACT = SensorAccuracy()
"""A sensor without errors except noise."""
