"""A part of the object swings in it, such as a liquid or something loose.

The part is a mass m on an isotropic damped spring, driven by the specific force s of its
container: its displacement x obeys x'' + 2 z w x' + w² x = s. Compared with a rigid mass
the force lacks m x'', and the torque of the weight acts at the displaced place.
"""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, cross, skew
from hefting.ingest.filtering import Complex, Signal
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    NEGLIGIBLE_UNEXPLAINED,
    LinearPart,
    Rows,
    beside_body,
    fit_rows,
    missing,
    with_bias,
)
from hefting.ingest.rivals.explanation import Explanation, at_offset, newton_euler

CODE = "sloshing"
FREQUENCIES = np.geomspace(0.6, 4.0, 20)
"""[Hz] Frequencies that are tried first."""
USUAL_DAMPING = 0.1
"""Damping ratio z with which they are tried."""
WIDTHS = (1.08, 1.02)
"""Factors by which the best frequency is then varied, and the damping by their eighth
powers."""
RATE = 100.0
"""[Hz] Rate at which the motion of the loose mass is computed."""
MOST_INSTANTS = 12_000
"""Largest number of instants of that motion."""
SMALLEST_PART = 0.05
"""Share of the weighted squared residuals that one of the first frequencies must explain.
In 200 recordings with mistakes it was 0.2 and more where something swung."""
UNKNOWNS = 6
"""Mass, place (3), frequency and damping of the loose part."""


def explain(case: Case) -> Explanation | None:
    """The frequency and damping at which a loose mass improves the fit of a rigid body
    most."""
    if not case.path.moves:
        return None
    driven = _Driven.of(case)
    fitted = at_offset(case, lambda motion: newton_euler(case, motion), case.offset)
    rigid = LinearPart.of(fitted)
    pairs = [(frequency, USUAL_DAMPING) for frequency in FREQUENCIES]
    scores = [_score(rigid, driven.swinging(*pair)) for pair in pairs]
    unexplained = missing(case, fitted) > 2.0 * NEGLIGIBLE_UNEXPLAINED
    if unexplained and max(scores) < SMALLEST_PART * rigid.square:
        return None
    best = pairs[int(np.argmax(scores))]
    for width in WIDTHS:
        near = [
            (best[0] * width**i, best[1] * width ** (8 * j))
            for i in (-1.0, -0.5, 0.0, 0.5, 1.0)
            for j in (-1, 0, 1)
        ]
        best = max(near, key=lambda pair: _score(rigid, driven.swinging(*pair)))
    fitted = fit_rows(case, _rows(case, driven.swinging(*best)))
    solution = fitted.solution[fitted.best]
    part = -solution[10] / (solution[0] or np.inf)
    if not 0.0 < part < 1.0:  # it is no part of the object's mass
        return None
    what = (
        f"some of the object seems to swing at {best[0]:.2g} Hz, as a liquid or a loose "
        "part does"
    )
    fix = "fix it or empty the object, or move slower and wait between moves"
    return Explanation(CODE, what, fix, fitted, UNKNOWNS, rarity=2.0)


@immutable
class _Driven:
    """The specific force that drives a loose mass, on a grid of G even instants."""

    specific: Signal
    """(G, 3) in sensor axes [m/s²]"""
    before: Indices
    """(K,) index of the last instant before each sample of the wrench"""
    beyond: Array
    """(K, 1) time from that instant to the sample, in intervals of the grid"""

    @classmethod
    def of(cls, case: Case) -> "_Driven":
        """Of a case, at the clock offset that conditioning found."""
        time = case.time - case.offset
        count = int(np.clip((time[-1] - time[0]) * RATE, 8, MOST_INSTANTS)) + 2
        grid = np.linspace(time[0], time[-1], count)
        features = case.features(case.motion_at(grid[None]))
        rate = (count - 1) / (grid[-1] - grid[0])
        places = (time - time[0]) * rate
        before = np.clip(places.astype(int), 0, count - 2)
        specific = Signal(-features[0, :, :3], rate)
        return cls(specific, before, (places - before)[:, None])

    def swinging(self, frequency: float, damping: float) -> Array:
        """(K, 6) acceleration of a loose mass [m/s²] and, per kilogram, torque of its
        weight by its displacement, for a frequency [Hz] and a damping ratio."""
        place, acceleration = swing(self.specific, frequency, damping)
        ends = []
        for instant in (self.before, self.before + 1):
            torque = cross(place[instant].T, self.specific.values[instant].T)
            ends.append(np.hstack((acceleration[instant], torque.T)))
        return ends[0] + self.beyond * (ends[1] - ends[0])


def _score(rigid: LinearPart, swinging: Array) -> float:
    """Decrease of the weighted squared residuals of a rigid body's fit by a loose mass of
    the motion `swinging` (K, 6)."""
    columns = swinging @ _maps().reshape(6, -1)
    S, g = rigid.beside(columns.reshape(len(swinging), 6, 4))
    length = np.sqrt(np.maximum(S.diagonal(), 1e-300))
    S, g = S / length / length[:, None] + 1e-9 * np.eye(4), g / length
    return float(g @ np.linalg.solve(S, g))


def _rows(case: Case, swinging: Array) -> Rows:
    """Rows of a body, a bias and a loose mass."""
    motion = case.motion_as_found
    features = case.features(motion)
    known = np.concatenate((features, swinging[None]), axis=2)
    return with_bias(case, known, beside_body(_maps()), motion.known)


def swing(specific: Signal, frequency: float, damping: float) -> tuple[Array, Array]:
    """Displacement (K, 3) [m] and acceleration (K, 3) [m/s²] of a loose mass that is at
    rest at the start, for a frequency [Hz] and a damping ratio."""
    w = 2.0 * np.pi * frequency

    def response(s: Complex) -> Complex:
        return 1.0 / (s * s + 2.0 * damping * w * s + w * w)

    lasting = 1.0 / (damping * w)
    place = specific.values[0] / w**2 + specific.change_through(response, lasting)
    return place, specific.change_through(lambda s: s * s * response(s), lasting)


def _maps() -> Array:
    """(6, 6, 4) derivatives of the wrench by a loose mass and by its first moment, per
    unit of its acceleration (3,) and of the torque (3,) of its weight."""
    maps = np.zeros((6, 6, 4))
    for axis, unit in enumerate(np.eye(3)):
        maps[axis, axis, 0] = -1.0
        maps[axis, 3:, 1:] = skew(unit)
        maps[3 + axis, 3 + axis, 0] = 1.0
    return maps
