"""Force and torque in units that do not belong together.

The torque shows the first moment, and so does the force, by the accelerations of a turning
body. With a wrong unit the two differ by the ratio of the units. A pair that belongs
together, such as kgf and kgf m, only changes the mass, which no recording shows.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
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
    over_offsets,
)

CODE = "force-unit"
FIX = (
    "give force in newtons and torque in newton-metres, or their units in a column map"
)
UNITS = {
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
COMMON = (
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


def explain(case: Case) -> Explanation | None:
    """The likeliest pair of units."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    if explains_nothing(case, partial(_with_maps, case, _maps_of_two_moments())):
        return None
    likelihoods, masses = _held_objects(case)
    if not likelihoods:
        return None
    what = max(likelihoods, key=lambda name: round(likelihoods[name], 6))
    force, torque = UNITS[what]
    fitted = over_offsets(case, _builder(case, torque / force))[0]
    least = likelihoods[what] - ALIKE * correlation(fitted) / len(case.time)
    alike = [name for name in likelihoods if likelihoods[name] > least and name != what]
    fix = FIX
    if not alike:
        fix += f', unit = ["{force:g} N", "{torque:g} N m"]'
    said = [f"{name} (then {masses[name]:.3g} kg)" for name in (what, *alike)]
    return Explanation(
        CODE,
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
    for what, (force, torque) in UNITS.items():
        ratio = torque / force
        fitted = fit_rows(case, _builder(case, ratio)(motion))
        mass = force * abs(float(fitted.solution[fitted.best][0]))
        if LEVERS[0] <= _lever(fitted, ratio) <= LEVERS[1] and mass <= HEAVIEST_HELD:
            likelihoods[what], masses[what] = float(fitted.likelihood.max()), mass
    return likelihoods, masses


def undone(case: Case) -> Iterator[Undone]:
    """Each of the `COMMON` pairs of units."""
    if not case.path.moves or case.path.kind == "orientation":
        return
    for what in COMMON:
        force, torque = UNITS[what]
        fix = f'{FIX}, unit = ["{force:g} N", "{torque:g} N m"]'
        sizes = np.repeat((force, torque), 3)
        yield Undone(
            CODE,
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


def _builder(case: Case, ratio: float) -> Build:
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
