"""The orientation is of another form than it was read in: three angles, one of which may
be in radians, or a quaternion whose real part was logged first, or that was composed of
angles in another form."""

import itertools
import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.core.recording import Stream
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, Undone, likeliest, with_poses
from hefting.logs.orientations import quaternions

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
    """Each other form of the logged angles."""
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
    """Quaternions with their parts in the other order."""
    orientation = case.recording["orientation"]
    for shift, (form, fix) in zip((-1, 1), ORDERS.items(), strict=True):
        q = np.roll(orientation.values, shift, axis=1)
        what = f"the quaternions seem to be logged as {', '.join(form)}"
        other = _with_orientation(case, what, replace(orientation, values=q))
        if other is not None:
            fix = f'{fix}, or give form = "{form}" in a column map'
            yield Undone("quaternion-order", what, fix, other)


def _composed(case: Case) -> Iterator[Undone]:
    """The quaternions composed of their angles about the other axes."""
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
    """As of `with_poses`, of other orientations."""
    streams = {**case.recording.streams, "orientation": orientation}
    return with_poses(case, what, replace(case.recording, streams=streams))
