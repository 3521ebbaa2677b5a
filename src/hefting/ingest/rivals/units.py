"""Units that are others than assumed: of positions, of time, and of force and torque that
do not belong together.

Accelerations from poses are proportional to the unit of length and to the inverse square
of that of time, and gravity is not: the object seems to have another mass by its
acceleration than by its weight. If it seems heavier by acceleration, a payload that the
controller subtracts does the same: time is named beside it, or alone if samples are
unusually far apart.

The torque shows the first moment, and so does the force, by the accelerations of a
turning body. With a wrong unit the two differ by the ratio of the units. A pair that
belongs together, such as kgf and kgf m, only changes the mass, which no recording shows.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.spatial import Array, median
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals import wrench_compensated
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    correlation,
    fit_rows,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    HEAVIEST_HELD,
    Build,
    Explanation,
    Undone,
    explains_nothing,
    likeliest,
    newton_euler,
    over_offsets,
)

POSITION = "position-unit"
LENGTHS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}
"""Units of length [m] in which positions may be logged."""


def explain_position(case: Case) -> Explanation | None:
    """The likeliest unit."""
    return likeliest(_positions_in(case, *LENGTHS))


def position_undone(case: Case) -> Iterator[Undone]:
    """Each common unit."""
    return _positions_in(case, "millimetres", "centimetres")


def _positions_in(case: Case, *units: str) -> Iterator[Undone]:
    """Each of the units, if accelerations are derivatives of positions."""
    if not case.recording.has("position") or case.path.kind != "smooth":
        return
    for unit in units:
        size = LENGTHS[unit]
        yield Undone(
            POSITION,
            f"the positions seem to be in {unit}",
            f'give them in metres, or unit = "{size:g} m" of them in a column map',
            case.with_accelerations(size, 1.0),
            argument="column_map",
            is_linear=True,
        )


TIME = "time-unit"
MILLISECONDS = 1e-3
"""[s]"""
RATIOS = (2.0, 2.5, 3.0, 4.0, 5.0, 8.0, 10.0)
"""Ratios of the rates at which arms and sensors are usually sampled: 50, 100, 125, 200,
250, 400, 500 and 1000 Hz. Smaller ones are like a payload that the controller
subtracts."""
COMMON_TIMES = frozenset((2.0, 5.0, 10.0, 0.5, MILLISECONDS))
"""[s] Units that are first mistakes of a pair."""
SHORTEST_INTERVALS = {MILLISECONDS: 0.2, 0.5: 0.0}
"""[s] Least recorded interval between samples for a unit of less than a second to be
tried; for the others it is `RARE_INTERVAL`."""
LARGEST_INERTIAL = 4.0
"""Ratio above which the object has less than 1/16 of its mass by acceleration, as one
lighter than the payload that is subtracted."""
RARE_INTERVAL = 0.05
"""[s] Interval that samples rarely exceed."""


def explain_time(case: Case) -> Explanation | None:
    """The likeliest unit [s] of the recorded time."""
    if not _is_from_poses(case) or explains_nothing(
        case, partial(wrench_compensated.freed, case)
    ):
        return None
    units = _time_units(case)
    motion = case.motion_late(case.likely_offsets)
    found = [
        fit_rows(case, _with_time_in(case, unit)(motion)).likelihood for unit in units
    ]
    unit = units[int(np.argmax(np.max(found, axis=1)))]
    fitted, _ = over_offsets(case, _with_time_in(case, unit))
    return Explanation(
        TIME,
        f"time seems to {_said_of_time(unit)}",
        _time_fix(unit),
        fitted,
        0,
        rarity=1.0,
        alternative=None if unit < 1.0 else lambda: wrench_compensated.explain(case),
        is_grave=True,
    )


def time_undone(case: Case) -> Iterator[Undone]:
    """Each unit."""
    if not _is_from_poses(case):
        return
    for unit in COMMON_TIMES.intersection(_time_units(case)):
        other = case.with_accelerations(unit**-2.0, unit**-2.0)
        yield Undone(
            TIME,
            f"time seems to {_said_of_time(unit)}",
            _time_fix(unit),
            other,
            rarity=1.0,
            is_grave=True,
            is_linear=True,
        )


def _is_from_poses(case: Case) -> bool:
    """Whether all accelerations are derivatives of poses."""
    return case.path.kind == "smooth" and not case.path.gravity_measured


def _time_units(case: Case) -> list[float]:
    """Units [s] in which time may be, given the intervals between samples."""
    interval = median(np.diff(case.recording["wrench"].time))
    faster = (MILLISECONDS, *(1.0 / ratio for ratio in RATIOS))
    return [
        *RATIOS,
        *(u for u in faster if interval >= SHORTEST_INTERVALS.get(u, RARE_INTERVAL)),
    ]


def _said_of_time(unit: float) -> str:
    """Clause that time is in a unit [s]."""
    if unit == MILLISECONDS:
        return "be in milliseconds"
    size, way = max(unit, 1.0 / unit), "fast" if unit < 1.0 else "slow"
    what = f"run {size:g} times too {way}"
    if unit < 1.0:
        share = 100.0 * (1.0 - unit**2)
        return f"{what}, or the controller to subtract {share:.0f} % of the object's weight"
    return what + wrench_compensated.OR_HEAVIER if unit > LARGEST_INERTIAL else what


def _time_fix(unit: float) -> str:
    """Advice for time in a unit [s]."""
    if unit == MILLISECONDS:
        return 'give time in seconds, or unit = "ms" of it in a column map'
    return "give time in seconds, of samples at the rate at which they were taken"


def _with_time_in(case: Case, unit: float) -> Build:
    factor = unit**-2.0
    return lambda motion: newton_euler(
        case, replace(motion, a=factor * motion.a, rest=factor * motion.rest)
    )


FORCE = "force-unit"
FORCE_FIX = (
    "give force in newtons and torque in newton-metres, or their units in a column map"
)
FORCES = {
    "the force seems to be in kgf": (9.80665, 1.0),
    "the force seems to be in daN": (10.0, 1.0),
    "the force seems to be in lbf": (4.4482216, 1.0),
    "the force seems to be in ozf": (0.2780139, 1.0),
    "the force seems to be in grams-force": (9.80665e-3, 1.0),
    "the force seems to be in lbf and the torque in lbf in": (4.4482216, 0.1129848),
    "the force seems to be in lbf and the torque in lbf ft": (4.4482216, 1.3558179),
    "the torque seems to be in N mm": (1.0, 1e-3),
    "the force seems to be in kN": (1e3, 1.0),
    "the torque seems to be in N cm": (1.0, 1e-2),
    "the force seems to be in kgf and the torque in kgf cm": (9.80665, 0.0980665),
    "the torque seems to be in lbf in": (1.0, 0.1129848),
    "the torque seems to be in lbf ft": (1.0, 1.3558179),
    "the torque seems to be in ozf in": (1.0, 7.061552e-3),
    "the torque seems to be in kgf m": (1.0, 9.80665),
    "the torque seems to be in kgf cm": (1.0, 0.0980665),
}
"""Pairs of units of force [N] and torque [N m]; of pairs with the same ratio the most
usual is first."""
COMMON_FORCES = (
    "the force seems to be in kgf",
    "the force seems to be in lbf",
    "the force seems to be in grams-force",
    "the force seems to be in lbf and the torque in lbf in",
    "the force seems to be in kgf and the torque in kgf cm",
    "the torque seems to be in N mm",
    "the torque seems to be in N cm",
)
"""First mistakes of a pair, see `UNDONE` of `hefting.ingest.rivals`."""
LEVERS = (0.005, 0.5)
"""[m] Usual distances of a held object's COM from the sensor; others exclude a unit."""
ALIKE = 3.0
"""Log-likelihood ratio to the best unit up to which another is reported beside it, as kgf
beside daN. Each is reported with its mass, by which the user can choose."""


def explain_force(case: Case) -> Explanation | None:
    """The likeliest pair of units."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    if explains_nothing(case, partial(_with_maps, case, _maps_of_two_moments())):
        return None
    likelihoods, masses = _held_objects(case)
    if not likelihoods:
        return None
    what = max(likelihoods, key=lambda name: round(likelihoods[name], 6))
    force, torque = FORCES[what]
    fitted = over_offsets(case, _with_torque_in(case, torque / force))[0]
    least = likelihoods[what] - ALIKE * correlation(fitted) / len(case.time)
    alike = [name for name in likelihoods if likelihoods[name] > least and name != what]
    fix = FORCE_FIX
    if not alike:
        fix += f', unit = ["{force:g} N", "{torque:g} N m"]'
    said = [f"{name} (then {masses[name]:.3g} kg)" for name in (what, *alike)]
    return Explanation(
        FORCE,
        ", or ".join(said) if alike else what,
        fix,
        fitted,
        0,
        rarity=1.0,
        argument="column_map",
        is_grave=True,
        parameters=fitted.solution[fitted.best, :10] * ((force,) + (torque,) * 9),
    )


def _held_objects(case: Case) -> tuple[dict[str, float], dict[str, float]]:
    """Log-likelihood per sample, and mass [kg], for each pair of units with which a robot
    could hold the object, at the clock offset that conditioning found or at none."""
    motion = case.motion_late(case.likely_offsets)
    likelihoods: dict[str, float] = {}
    masses: dict[str, float] = {}
    for what, (force, torque) in FORCES.items():
        ratio = torque / force
        fitted = fit_rows(case, _with_torque_in(case, ratio)(motion))
        mass = force * abs(float(fitted.solution[fitted.best][0]))
        if LEVERS[0] <= _lever(fitted, ratio) <= LEVERS[1] and mass <= HEAVIEST_HELD:
            likelihoods[what], masses[what] = float(fitted.likelihood.max()), mass
    return likelihoods, masses


def force_undone(case: Case) -> Iterator[Undone]:
    """Each of the `COMMON_FORCES` pairs of units."""
    if not case.path.moves or case.path.kind == "orientation":
        return
    for what in COMMON_FORCES:
        force, torque = FORCES[what]
        fix = f'{FORCE_FIX}, unit = ["{force:g} N", "{torque:g} N m"]'
        sizes = np.repeat((force, torque), 3)
        yield Undone(
            FORCE,
            what,
            fix,
            case.with_wrench(np.diag(sizes)),
            argument="column_map",
            rarity=1.0,
            is_grave=True,
            log_scale=float(np.log(sizes).sum()),
            is_linear=True,
        )


def _lever(fitted: Fitted, ratio: float) -> float:
    """[m] Distance of the COM from the sensor, for the `ratio` of the torque's unit to the
    force's."""
    solution = fitted.solution[fitted.best]
    size = abs(float(solution[0]))
    return ratio * float(np.linalg.norm(solution[1:4])) / max(size, 1e-12)


def _with_torque_in(case: Case, ratio: float) -> Build:
    """Rows of a body whose first moment is in the recorded torque's unit, which is `ratio`
    times the force's."""
    maps = REGRESSOR_BY_FEATURE.copy()
    maps[:, :3, 1:4] *= ratio
    return partial(_with_maps, case, maps)


def _with_maps(case: Case, maps: Array, motion: Motion) -> Rows:
    return with_bias(case, case.features(motion), maps, motion.known)


def _maps_of_two_moments() -> Array:
    """(12, 6, 13) columns of the ten parameters, whose first moment acts on the force
    alone, and of another first moment, which acts on the torque alone."""
    maps = np.concatenate(
        (REGRESSOR_BY_FEATURE, REGRESSOR_BY_FEATURE[:, :, 1:4]), axis=2
    )
    maps[:, 3:, 1:4] = maps[:, :3, 10:] = 0.0
    return maps
