"""Tool: the body between sensor and object, identified from a recording of its own and
subtracted with its uncertainty.

Inertial parameters in the same frame add, and so do the wrenches of object and tool.
The wrench minus the predicted wrench of the tool is that of the object. The error of
the tool's parameters becomes an error of the object's, independent of that of the
recording: the covariances add.
"""

from dataclasses import replace
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, warning
from hefting.core.regressor import predict_wrench


def without_tool(measurements: Measurements, tool: Estimate) -> Measurements:
    """Measurements of the object alone: the wrench minus that of the tool for the same
    motion.

    `tool` is an estimate in the same sensor frame, from a recording of the tool without
    an object.
    """
    wrench = predict_wrench(measurements, tool.parameters.vector)
    return replace(
        measurements,
        force=measurements.force - wrench[:, :3],
        torque=measurements.torque - wrench[:, 3:],
    )


def tool_warnings(tool: Estimate) -> list[Message]:
    """A warning if the tool's uncertainty is not known."""
    if tool.covariance is not None:
        return []
    what = (
        f"the tool's estimate ({tool.method}) has no standard deviations, so the object's leave it out: make it with "
        "hefting calibrate"
    )
    return [warning("tool-without-spread", what, "tool")]


def load_tool(path: str | Path) -> Estimate:
    """Load the estimate of a tool, as `hefting calibrate` or `hefting identify` writes
    it.

    Raises `InputError` if the file holds no estimate, or one without mass.
    """
    tool = Estimate.load(path)
    if not tool.parameters.mass > 0.0:
        raise InputError(
            f"the tool has a mass of {tool.parameters.mass:.3g} kg",
            path,
            "leave it out",
        )
    return tool
