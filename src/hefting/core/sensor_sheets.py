"""Data sheets of force-torque sensors: what their makers state of the accuracy.

A sheet states percentages of the range, or limits in N and N m. Of some sensors only the
ranges are here, and where to find the accuracy. Figures are
the largest of all axes; ranges are those across the sensor's axis, Fx, Fy and Tx, Ty,
as the ends of ATI's names of a calibration say them (SI-130-10: 130 N, 10 N m).
"""

from dataclasses import dataclass

_OWN_CERTIFICATE = "its calibration certificate states it, in percent of full scale"
_ATI = "ATI Industrial Automation's catalogue of F/T transducers"
_AXIA = "ATI manual 9610-05-Ethernet Axia, F/T Sensor"
_NOISE_ONLY = "its manual states noise"


@dataclass(frozen=True)
class Sheet:
    """What the data sheet of a sensor states."""

    model: str
    """name of the sensor"""
    document: str
    """name of the data sheet"""
    ranges: tuple[float, float]
    """of force [N] and torque [N m]"""
    of_full_scale: float | None = None
    """limit of the errors over the range; None where it is not stated so"""
    absolute: tuple[float, float] | None = None
    """limits of the errors of force [N] and torque [N m]; None where they are not
    stated so"""
    remark: str = ""
    """where to find the accuracy, if it is not here"""

    @property
    def states_accuracy(self) -> bool:
        """Whether its accuracy is here."""
        return self.of_full_scale is not None or self.absolute is not None


def sheet_name(text: str) -> str:
    """A sensor's name as `SHEETS` spells it: lower case, without spaces, hyphens and
    marks."""
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
"""By name; `sheet_name` says how that is spelled."""
