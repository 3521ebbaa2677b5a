"""Frames: an estimate in that of the object, or in another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import NORMAL_95, Answered, Estimate, estimate_of
from hefting.core.inertia import InertialParameters, misplaced, moving
from hefting.core.spatial import inverse_pose, vector_to_tensor
from hefting.core.undetermined import mapped
from hefting.shapes import as_pose


def in_frame(
    estimate: Estimate | Answered,
    pose: ArrayLike | str | Path | None = None,
    *,
    frame: str = "object",
    pose_std: Sequence[float] = (0.0, 0.0),
) -> Estimate:
    """The same estimate in another frame that is fixed to the sensor.

    Parameters
    ----------
    estimate
        An estimate, or what `hefting.identify` returned.
    pose
        The frame in the sensor's, as for `identify`; by default the object's, which the
        command keeps in the estimate.
    frame
        Its name.
    pose_std
        Standard deviations of the pose [m, rad], along and about each axis.

    Returns
    -------
    Estimate
        Covariance and intervals follow to first order, so that these are symmetric.

    Raises
    ------
    InputError
        Without a pose.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv")
    >>> hefting.in_frame(found, "0,0,0.1,0,0,0,1").frame
    'object'
    """
    old = estimate_of(estimate)
    pose = old.provenance.get("object_pose") if pose is None else pose
    if pose is None:
        what = "the estimate does not say where the object is"
        fix = "identify with `shape` and `object_pose`, or give the pose"
        raise InputError(what, fix=fix)
    to_new = inverse_pose(as_pose(pose))
    move = moving(to_new)
    new = replace(
        old,
        parameters=InertialParameters(move @ old.parameters.vector),
        intervals=None,
        undetermined=old.undetermined.turned(to_new[:3, :3]),
        bias=None,
        frame=frame,
    )
    if old.covariance is None:
        return new
    covariance = mapped(old.covariance, move)
    covariance += misplaced(new.parameters.vector, pose_std)
    new = replace(new, covariance=covariance)
    half = {"inertia_at_origin": vector_to_tensor(np.sqrt(covariance.diagonal()[4:]))}
    half |= new.std or {}
    ends = {
        name: getattr(new.parameters, name) + NORMAL_95 * np.stack((-std, std))
        for name, std in half.items()
    }
    return replace(new, intervals=ends if old.intervals else None)
