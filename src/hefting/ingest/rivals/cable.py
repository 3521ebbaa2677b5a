"""A cable or hose pulls at the sensor, with a force that depends on the sensor's place.

The pull is that of an isotropic spring between a point of the world and a point of the
sensor frame, -k (p - p0), or the weight of a hanging cable, which grows with the height
of the sensor. Only changes of its part along gravity are distinguished from the
object's weight: a hanging cable is taken to have no weight where it is lightest.
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array, skew
from hefting.ingest.model import tangents_of
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    beside_body,
    fit_rows,
    with_bias,
)
from hefting.ingest.rivals.explanation import Explanation

CODE = "cable-force"
UNKNOWNS = 12
"""Stiffness, constant pull across gravity, and the moments of all three about the
sensor."""
BODY_AND_PULLS = 22
"""Number of unknowns of the body and the pulls, before those of the bias."""
PULL = 18
"""Index of the pull that depends on the place."""
GRAVE_CHANGE = 0.03
"""Change of a hanging cable's weight, over the object's, from which on the answer is
wrong: the weight where it is lightest is unknown."""


def explain(case: Case) -> Explanation | None:
    """The likeliest law, at no clock offset or the one that conditioning found."""
    if not case.recording.has("position"):
        return None
    times = case.time - case.likely_offsets[:, None]
    place = _place(case, times)
    rows = _rows(case, case.motion_at(times), place)
    fitted = _of_weights_that_pull_down(fit_rows(case, rows), len(times))
    solution = fitted.solution[fitted.best]
    how, grave = "as a cable or a hose does", False
    if fitted.best >= len(times):
        how = "as the weight of a cable that hangs"
        g = float(np.linalg.norm(case.gravity))
        change = solution[PULL] * np.ptp(place @ case.gravity) / g  # of the weight
        grave = abs(change) > GRAVE_CHANGE * g * abs(solution[0])
    force, torque = _largest_pull(fitted)
    pull = f"{force:.2g} N" if force > case.floor[0] else f"{torque:.2g} N m"
    what = (
        f"something pulls at the sensor by up to {pull}, depending on where it "
        f"is, {how}"
    )
    fix = "fix it to the arm with slack, or off the arm, and record again"
    return Explanation(
        CODE,
        what,
        fix,
        fitted,
        UNKNOWNS,
        rarity=1.0,
        is_grave=grave,
        of_many_laws=True,
    )


def pulling_columns(case: Case) -> list[Array]:
    """(K, 6, 4) derivatives of the wrench by the pull of a spring, and of a hanging
    cable, and by the pull times the place (3,) where it acts; at the clock offset that
    conditioning found."""
    place = _place(case, case.time[None] - case.offset)
    axes, maps = case.motion_as_found.axes, _maps(1)
    spring, hanging, _ = _laws(case, place)
    return [
        np.einsum("okij,okj,icp->kcp", axes, pull, maps) for pull in (spring, hanging)
    ]


def _place(case: Case, times: Array) -> Array:
    """(O, K, 3) [m] place of the sensor at times (O, K), relative to its mean."""
    place = case.places(times)
    return place - place.mean(axis=(0, 1))


def _rows(case: Case, motion: Motion, place: Array) -> Rows:
    """Rows of a body, a bias and a pull, for each of the laws in turn."""
    across = tangents_of(case.gravity)
    sides = [np.broadcast_to(side, place.shape) for side in across]
    body = case.features(motion)
    known = [
        np.concatenate(
            [body]
            + [
                np.einsum("okij,okj->oki", motion.axes, pull) for pull in (*sides, last)
            ],
            axis=2,
        )
        for last in _laws(case, place)
    ]
    used = np.tile(motion.known, (len(known), 1))
    maps = beside_body(_maps(len(sides) + 1))
    return with_bias(case, np.concatenate(known), maps, used)


def _laws(case: Case, place: Array) -> tuple[Array, Array, Array]:
    """Pulls (O, K, 3) in world axes as functions of the place: of a spring; and of a
    hanging cable that has no weight at the lowest or at the highest place."""
    up = case.gravity / -np.linalg.norm(case.gravity)
    height = place @ up
    lengths = height - height.min(), height.max() - height
    above_lowest, below_highest = (each[:, :, None] * up for each in lengths)
    return place, above_lowest, below_highest


def _of_weights_that_pull_down(fitted: Fitted, offsets: int) -> Fitted:
    """The fits at `offsets` clock offsets of each law, without hanging cables that pull
    upwards."""
    wrong = fitted.solution[:, PULL] * fitted.solution[:, 0] < 0.0
    wrong[:offsets] = False  # of a spring
    return replace(fitted, likelihood=np.where(wrong, -np.inf, fitted.likelihood))


def _maps(pulls: int) -> Array:
    """(3 pulls, 6, 4 pulls) columns of each pull, and of the pull times the place (3,)
    where it acts."""
    maps = np.zeros((3 * pulls, 6, 4 * pulls))
    for i in range(pulls):
        for axis, unit in enumerate(np.eye(3)):
            maps[3 * i + axis, axis, 4 * i] = 1.0
            # r x e is -skew(e) r
            maps[3 * i + axis, 3:, 4 * i + 1 : 4 * i + 4] = -skew(unit)
    return maps


def _largest_pull(fitted: Fitted) -> Array:
    """(2,) force [N], and torque [N m]."""
    best, rows = fitted.best, fitted.rows
    solution = fitted.solution[best, :BODY_AND_PULLS].copy()
    solution[:10] = 0.0
    pull = rows.predict(solution)[best].reshape(-1, 2, 3)
    return np.linalg.norm(pull, axis=2).max(axis=0)
