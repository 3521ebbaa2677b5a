"""Tool: the body between sensor and object, identified from a recording of its own and
subtracted with its uncertainty.

Inertial parameters in the same frame add, and so do the wrenches of object and tool.
The wrench minus the predicted wrench of the tool is that of the object. The error of
the tool's parameters becomes an error of the object's, independent of that of the
recording: the covariances add.
"""

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Answered, Estimate, estimate_given
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, warning
from hefting.core.quantity import MassReading
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Mask
from hefting.logs.registry import find_format

UNDETERMINED_TOOL_INERTIA = 1.0
"""[m²] Standard deviation per kilogram of a tool's parameter that its own recording
left undetermined: that of the whole mass at a distance of one metre."""


def without_tool(measurements: Measurements, tool: Estimate) -> Measurements:
    """Measurements of the object alone: the wrench less that of the tool for the same
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


def with_tool(estimate: Estimate, tool: Estimate) -> Estimate:
    """Estimate of object and tool together. The tool's errors count twice if it was
    subtracted for the object's: intervals are no narrower than right."""
    covariance, added = estimate.covariance, tool_covariance(tool)
    if covariance is not None and added is not None:
        covariance = covariance + added
    return replace(
        estimate,
        method=f"{estimate.method} with the tool of {tool.parameters.mass:.4g} kg",
        parameters=InertialParameters(
            estimate.parameters.vector + tool.parameters.vector
        ),
        covariance=covariance,
        provenance={k: v for k, v in estimate.provenance.items() if k != "tool"},
    )


def left_open(tool: Estimate | None) -> Mask:
    """(10,) parameters that the estimate of a tool leaves open."""
    if tool is None or tool.covariance is None:
        return np.zeros(10, dtype=bool)
    return np.isinf(tool.covariance.diagonal())


def tool_covariance(tool: Estimate | None) -> Array | None:
    """(10, 10) covariance of a tool that was subtracted, with
    `UNDETERMINED_TOOL_INERTIA` for undetermined parameters; None if it has none."""
    if tool is None or tool.covariance is None:
        return None
    undetermined = left_open(tool)
    covariance = np.where(np.isinf(tool.covariance), 0.0, tool.covariance)
    covariance[undetermined, undetermined] = np.square(
        UNDETERMINED_TOOL_INERTIA * tool.parameters.mass
    )
    return covariance


def tool_warnings(tool: Estimate) -> list[Message]:
    """A warning if the tool's uncertainty is not known."""
    if tool.covariance is not None:
        return []
    what = (
        f"the tool's estimate ({tool.method}) has no standard deviations, so the object's lack its errors: "
        "make it with hefting calibrate"
    )
    return [warning("tool-without-spread", what, "tool")]


def _refuse_other(text: str) -> None:
    """`InputError` for a recording, or a mass, in place of an estimate."""
    if find_format(text):
        make = shlex.join(["hefting", "calibrate", text, "-o", "gripper.json"])
        fix = f"{make} makes one from it, for --tool gripper.json"
        raise InputError("is a recording, not an estimate of the tool", text, fix)
    try:
        MassReading.parse(text)
    except InputError:
        return
    what = "a tool's mass alone does not tell its torque"
    fix = (
        "record it empty: hefting calibrate EMPTY.csv -o gripper.json, then --tool "
        "gripper.json; docs/howto/tare.md has what to do with a data sheet"
    )
    raise InputError(what, text, fix)


def load_tool(given: Estimate | Answered | str | Path) -> Estimate:
    """Estimate of a tool from what `hefting calibrate` or `hefting identify` returns or
    writes. Raises `InputError` for what is no estimate, or has no mass; of a recording,
    or a mass, it says how an estimate is made."""
    try:
        tool = estimate_given(given)
    except InputError:
        if isinstance(given, str | Path):
            _refuse_other(str(given))
        raise
    if not tool.parameters.mass > 0.0:
        what = f"the tool has a mass of {tool.parameters.mass:.3g} kg"
        fix = "leave it out"
        raise InputError(what, given if isinstance(given, str | Path) else None, fix)
    return tool
