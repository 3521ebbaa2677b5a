"""The object is no rigid body: a part swings in it, such as a liquid or something loose,
or it changes gradually, as it leaks, is filled, or creeps in the gripper.

The swinging part is a mass m on an isotropic damped spring, driven by the specific force
s of its container: its displacement x obeys x'' + 2 z w x' + w² x = s. Compared with a
rigid mass the force lacks m x'', and the torque of the weight acts at the displaced
place.

For a change mass and first moment are piecewise linear in time, with knots at the start,
the middle and the end of the recording; the inertia is constant. In static poses, which
are seldom many, mass and first moment change once, at one of the poses.
"""

import numpy as np

from hefting.core.spatial import Array, Indices, cross, immutable, skew
from hefting.ingest.drift import HatFunctions
from hefting.ingest.filtering import Complex, Signal
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    NEGLIGIBLE_UNEXPLAINED,
    Fitted,
    LinearPart,
    Rows,
    beside_body,
    fit_rows,
    missing,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    at_offset,
    fit_as_given,
    newton_euler,
    over_offsets,
)

SLOSHING = "sloshing"
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


def explain_sloshing(case: Case) -> Explanation | None:
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
    fitted = fit_rows(case, _swinging_rows(case, driven.swinging(*best)))
    solution = fitted.solution[fitted.best]
    part = -solution[10] / (solution[0] or np.inf)
    if not 0.0 < part < 1.0:  # it is no part of the object's mass
        return None
    what = (
        f"some of the object seems to swing at {best[0]:.2g} Hz, as a liquid or a loose "
        "part does"
    )
    fix = "fix it or empty the object, or move slower and wait between moves"
    return Explanation(SLOSHING, what, fix, fitted, UNKNOWNS, rarity=2.0)


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


def _swinging_rows(case: Case, swinging: Array) -> Rows:
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


CHANGING = "object-changing"
KNOTS = 3
LARGEST_LEFT = 0.8
"""Largest share of what noise does not explain that a change may leave at the clock offset
of the recording as given, for other clock offsets to be tried."""
SMALLEST_MASS_CHANGE = 0.02
"""Smallest relative change of the mass that is reported: gains of sensors drift by less."""
FEWEST_POSES = 4
"""Fewest static poses on each side of a change: fewer may be outliers."""
SMALLEST_MOVE = 0.002
"""[m] Smallest movement of the COM that is reported."""


def explain_change(case: Case) -> Explanation | None:
    """The likeliest change; None where a bias that drifts alike is likelier."""
    if not case.path.moves:
        return _at_a_pose(case)
    hats = HatFunctions.over(case.time, KNOTS).values
    given, offset = fit_as_given(case)
    quick = at_offset(case, lambda motion: _changing_rows(case, motion, hats), offset)
    if missing(case, quick) > LARGEST_LEFT * missing(case, given):
        return None
    fitted, offset = over_offsets(
        case, lambda motion: _changing_rows(case, motion, hats)
    )
    drifting = at_offset(case, lambda motion: _with_drift(case, motion, hats), offset)
    if drifting.likelihood[0] >= fitted.likelihood.max():
        return None
    return _explanation(fitted, KNOTS)


def _at_a_pose(case: Case) -> Explanation | None:
    """The likeliest change between two of the static poses, whose rows are in order."""
    pose = np.arange(len(case.time))
    firsts = pose[FEWEST_POSES : 1 - FEWEST_POSES, None]
    after = pose >= firsts
    parts = np.stack((~after, after), axis=2).astype(float)
    fitted = fit_rows(case, _changing_rows(case, case.motion, parts))
    drifting = fit_rows(case, _with_drift(case, case.motion, parts))
    if drifting.likelihood.max() >= fitted.likelihood.max():
        return None
    first = np.searchsorted(
        case.recording["wrench"].time, case.time[firsts[fitted.best, 0]]
    )
    return _explanation(fitted, 2, f" from row {first + 1} on")


def _explanation(fitted: Fitted, n: int, at: str = "") -> Explanation | None:
    """The change between n successive bodies: of the mass or of the COM, whichever changes
    the wrench more; None if it is too small. `at` says where a sudden change is."""
    inertia, rest = np.split(fitted.solution[fitted.best], [6])
    bodies = rest[: 4 * n].reshape(n, 4)
    if bodies[:, 0].min() <= 0.0 <= bodies[:, 0].max():
        return None
    mass, com = np.abs(bodies[:, 0]), bodies[:, 1:] / bodies[:, :1]
    mass_change = np.ptp(mass)
    moved = float(np.linalg.norm(com - com[0], axis=1).max())
    force_scale, torque_scale = fitted.scale[fitted.best]
    if mass_change / force_scale > mass.max() * moved / torque_scale:
        if mass_change < SMALLEST_MASS_CHANGE * mass.max():
            return None
        fix, what = "close it", _mass_change(mass, at)
    else:
        if moved < SMALLEST_MOVE:
            return None
        fix = "grip it tighter"
        what = f"the object seems to move by {1e3 * moved:.0f} mm in the gripper"
        what += at or ", little by little"
    return Explanation(
        CHANGING,
        what,
        f"{fix} and record again, or give a part in which it does not change with "
        "`start` and `duration`",
        fitted,
        4 * (n - 1) + bool(at),
        argument="start",
        parameters=np.concatenate((bodies[-1], inertia)),
        is_change=True,
    )


def _mass_change(mass: Array, at: str) -> str:
    """A clause on masses (n,) [kg] that are held one after the other."""
    start = f"the object seems to be {mass[0]:.3g} kg at the start of the recording"
    if at:
        return f"{start} and {mass[-1]:.3g} kg {at.strip()}"
    return (
        f"{start}, {mass[1]:.3g} kg in its middle and {mass[-1]:.3g} kg at its end, as one "
        "that leaks or is filled, or by a sensor whose gain drifts"
    )


def _changing_rows(case: Case, motion: Motion, functions: Array) -> Rows:
    """Rows of a constant inertia, of a mass and first moment for each of n functions of
    time (..., K, n), whose sum is one, and of a bias."""
    features, n = case.features(motion), functions.shape[-1]
    known = functions[..., None] * features[..., None, :]
    O, K = known.shape[:2]
    maps = np.zeros((n, FEATURES, 6, 6 + 4 * n))
    maps[..., :6] = REGRESSOR_BY_FEATURE[:, :, 4:]
    for i in range(n):
        maps[i, :, :, 6 + 4 * i : 10 + 4 * i] = REGRESSOR_BY_FEATURE[:, :, :4]
    used = np.broadcast_to(motion.known, (O, K))
    known, maps = known.reshape(O, K, -1), maps.reshape(-1, 6, 6 + 4 * n)
    return with_bias(case, known, maps, used)


def _with_drift(case: Case, motion: Motion, functions: Array) -> Rows:
    """Rows of one constant body, and of a bias composed of the same functions."""
    O = max(functions[..., 0, 0].size, len(motion.known))
    features = case.features(motion)
    known = np.broadcast_to(features, (O, *features.shape[1:]))
    used = np.broadcast_to(motion.known, known.shape[:2])
    return with_bias(case, known, REGRESSOR_BY_FEATURE, used, functions=functions)
