"""Poses are of another form than they were read in.

Orientations: three angles of other axes, one of which may be in radians, or a quaternion
whose real part was logged first, or that was composed of angles in another form.
Positions: in other axes than the orientations, by columns swapped or of the wrong sign, or
another frame of the world. Both: those of the world in the sensor frame.
"""

import itertools
import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.core.recording import Stream
from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import fit_rows, is_hopeless
from hefting.ingest.rivals.explanation import (
    Explanation,
    Undone,
    likeliest,
    newton_euler,
    over_offsets,
    with_poses,
)
from hefting.logs.orientations import quaternions

INVERSE = "pose-inverse"


def explain_inverse(case: Case) -> Explanation | None:
    """The likelier of inverse poses and inverse orientations."""
    return likeliest(inverse_undone(case))


def inverse_undone(case: Case) -> Iterator[Undone]:
    """The inverse poses, then the inverse orientation alone."""
    from scipy.spatial.transform import Rotation

    recording = case.recording
    orientation = recording["orientation"]
    q = orientation.values * np.array((-1.0, -1.0, -1.0, 1.0))
    streams = {**recording.streams, "orientation": replace(orientation, values=q)}
    tried = [("orientation", streams)]
    position = recording.streams.get("position")
    if position is not None and len(position) == len(orientation):
        p = -Rotation.from_quat(q).apply(np.array(position.values))
        tried.insert(0, ("pose", {**streams, "position": replace(position, values=p)}))
    for name, streams in tried:
        what = f"the logged {name} seems to be that of the world in the sensor frame"
        other = with_poses(case, what, replace(recording, streams=streams))
        if other is not None:
            yield Undone(
                INVERSE,
                what,
                "log that of the sensor in the world, which is its inverse",
                other,
            )


CODE = "orientation-form"
FORMS = (
    ("rotation-vector", ""),
    ("rpy", ""),
    *(("euler", order) for order in ("XYZ", "ZYX", "ZYZ")),
)
"""Forms, and orders of Euler angles, in which controllers of robots give orientations."""

ORDERS = {"wxyz": "put the real part last, as qw", "xyzw": "name them qx, qy, qz, qw"}
"""Orders of a quaternion's parts that are confused, and what to do."""

EULER = {"xyz": "roll, pitch, yaw", "XYZ": "angles about turning axes x, y, z"}
"""Angles about fixed and turning axes, as one capital letter distinguishes them, that
are confused when quaternions or matrices are composed."""


def explain(case: Case) -> Explanation | None:
    """The likeliest form of the logged angles."""
    return likeliest(_forms(case))


def explain_order(case: Case) -> Explanation | None:
    """Quaternions with their parts in the other order."""
    return likeliest(_orders(case))


def explain_composed(case: Case) -> Explanation | None:
    """Quaternions composed from their angles about the other axes, fixed or turning."""
    return likeliest(_composed(case))


def undone(case: Case) -> Iterator[Undone]:
    """All forms."""
    yield from _orders(case)
    yield from _forms(case)
    yield from _composed(case)


def _forms(case: Case) -> Iterator[Undone]:
    angles = case.recording.angles
    if angles is None or case.recording.sensor_pose is not None:
        return
    recording = case.recording
    within = (recording.start, recording.start + recording.duration)
    first, last = np.searchsorted(angles.time, within)
    angles = angles[first : last + 1]
    read = angles.values
    # degrees that may have been radians
    small = np.abs(read).max(axis=0, initial=0.0) <= np.radians(np.pi)
    radians = np.where(small, np.degrees(read), read)
    for logged in (read, radians) if small.any() != small.all() else (read,):
        in_radians = logged is radians
        for form, order in FORMS:
            said = f'form = "{form}"' + (f', order = "{order}"' if order else "")
            seem, give = "of another form than they are read in", said
            if in_radians:
                seem = f"in degrees, but number {np.argmax(small) + 1} in radians"
                give = f"all in degrees, and {said}"
            what = f"the angles of the orientation seem to be {seem}"
            fix = f"give {give} of the orientation in a column map"
            values = quaternions(logged, form, order)
            other = _with_orientation(case, what + fix, replace(angles, values=values))
            if other is not None:
                yield Undone(
                    CODE,
                    what,
                    fix,
                    other,
                    argument="column_map",
                    is_grave=in_radians,
                )


def _orders(case: Case) -> Iterator[Undone]:
    orientation = case.recording["orientation"]
    for shift, (form, fix) in zip((-1, 1), ORDERS.items(), strict=True):
        q = np.roll(orientation.values, shift, axis=1)
        what = f"the quaternions seem to be logged as {', '.join(form)}"
        other = _with_orientation(case, what, replace(orientation, values=q))
        if other is not None:
            fix = f'{fix}, or give form = "{form}" in a column map'
            yield Undone("quaternion-order", what, fix, other)


def _composed(case: Case) -> Iterator[Undone]:
    from scipy.spatial.transform import Rotation

    if case.recording.angles is not None or case.recording.sensor_pose is not None:
        return
    orientation = case.recording["orientation"]
    turns = Rotation.from_quat(np.array(orientation.values))
    for took, meant in itertools.permutations(EULER):
        with warnings.catch_warnings():  # where two axes coincide an angle is arbitrary
            warnings.simplefilter("ignore")
            values = quaternions(turns.as_euler(took), "euler", meant)
        what = (
            f"the orientation seems to be composed of {EULER[meant]} as if they were "
            f"{EULER[took]}"
        )
        other = _with_orientation(case, what, replace(orientation, values=values))
        if other is not None:
            yield Undone(
                CODE,
                what,
                f"compose it as scipy's Rotation.from_euler('{meant}', ...), or log the "
                "angles",
                other,
            )


def _with_orientation(case: Case, what: str, orientation: Stream) -> Case | None:
    streams = {**case.recording.streams, "orientation": orientation}
    return with_poses(case, what, replace(case.recording, streams=streams))


POSITION_AXES = "position-axes"
THIRD = 3
"""Step between the samples on which axes are first compared."""
FIRST_ITERATIONS = 2
"""Number of reweightings of that comparison."""
SMALL_ADVANTAGE = 5.0
"""Log likelihood ratio of all samples by which other axes must exceed simpler ones."""
SIGNED_PERMUTATIONS = np.array(
    [
        np.array(signs)[:, None] * np.array(order)
        for order in itertools.permutations(np.eye(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
)
"""(48, 3, 3) ways to name and to direct three axes, the identity first."""
OTHER_AXES = SIGNED_PERMUTATIONS[1:]


def explain_position_axes(case: Case) -> Explanation | None:
    """The likeliest axes."""
    if not case.recording.has("position") or case.path.kind != "smooth":
        return None
    thin = case.every(THIRD)
    motion = thin.motion_as_found
    rows = newton_euler(thin, _in_axes(motion, OTHER_AXES))
    quick = fit_rows(thin, rows, FIRST_ITERATIONS)
    given = fit_rows(thin, newton_euler(thin, motion), FIRST_ITERATIONS)
    if quick.likelihood.max() <= given.likelihood[0] or is_hopeless(thin, quick, given):
        return None
    # where positions hardly vary along an axis its sign is open: the fewest changes
    best = quick.likelihood > quick.likelihood.max() - SMALL_ADVANTAGE / len(case.time)
    kept = np.trace(OTHER_AXES, axis1=1, axis2=2)
    axes = OTHER_AXES[int(np.argmax(np.where(best, kept, -np.inf)))]
    fitted, _ = over_offsets(
        case, lambda motion: newton_euler(case, _in_axes(motion, axes[None]))
    )
    logged = ", ".join(
        f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}"
        for row in axes
    )
    return Explanation(
        POSITION_AXES,
        f"the positions seem to be in other axes than the orientations: ({logged}) of "
        "those logged in place of (x, y, z)",
        "give both in the same axes of the world, with positions as they are measured",
        fitted,
        0,
        rarity=float(np.log(len(OTHER_AXES))),
        is_grave=True,
    )


def _in_axes(motion: Motion, axes: Array) -> Motion:
    """The motion with positions in each of other axes of the world (A, 3, 3), at one
    clock offset or at one for each."""
    in_world = np.swapaxes(motion.axes, -1, -2) @ motion.a[..., None]
    a = (motion.axes @ (axes[:, None] @ in_world))[..., 0]
    count = len(a)
    return replace(
        motion,
        a=a,
        rest=np.broadcast_to(motion.rest, (count, *motion.rest.shape[1:])),
        axes=np.broadcast_to(motion.axes, (count, *motion.axes.shape[1:])),
        known=np.broadcast_to(motion.known, (count, *motion.known.shape[1:])),
    )
