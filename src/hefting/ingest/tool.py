"""Tool: what the sensor holds besides the object, known from a recording of its own,
taken away with its uncertainty.

Parameters in the same frame add, so the wrench of object and tool is the sum of theirs:
less the tool's predicted wrench, what is left is the object's. The tool's error then is
the object's error, independent of that of the recording: the covariances add.
"""

from dataclasses import replace
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, warning
from hefting.core.regressor import predict_wrench


def without_tool(measurements: Measurements, tool: Estimate) -> Measurements:
    """Measurements of the object alone: the wrench less what the tool needs for the
    same motion.

    `tool` is an estimate in the same sensor frame, made from a recording of the bare
    tool.
    """
    wrench = predict_wrench(measurements, tool.parameters.vector)
    return replace(
        measurements,
        force=measurements.force - wrench[:, :3],
        torque=measurements.torque - wrench[:, 3:],
    )


def tool_warnings(tool: Estimate) -> list[Message]:
    """A message when the tool's uncertainty is not known."""
    if tool.covariance is not None:
        return []
    what = (
        f"the tool's estimate ({tool.method}) has no standard deviations, so the object's leave it out: make it with "
        "hefting calibrate"
    )
    return [warning("tool-without-spread", what, "tool")]


def load_tool(path: str | Path) -> Estimate:
    """The estimate of a bare tool, as `hefting calibrate` or `hefting identify` writes
    it.

    Raises `InputError` when the file holds none, or one without mass.
    """
    tool = Estimate.load(path)
    if not tool.parameters.mass > 0.0:
        raise InputError(
            f"the tool has a mass of {tool.parameters.mass:.3g} kg",
            path,
            "leave it out",
        )
    return tool
