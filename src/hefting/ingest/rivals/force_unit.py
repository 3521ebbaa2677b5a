"""Force and torque in units that do not belong together.

The torque gives the first moment; the force gives it too, by the accelerations of a
turning body. With a wrong unit the two differ by its ratio. Both in units that do belong
together, as in kgf and kgf m, only change the mass, which no recording can tell.
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
"""Units of force [N] and torque [N m] that sensors give together; of those of one ratio
the usual first."""
COMMON = (
    "the force seems to be in kgf",
    "the force seems to be in lbf",
    "the force seems to be in grams-force",
    "the force seems to be in lbf and the torque in lbf in",
    "the force seems to be in kgf and the torque in kgf cm",
    "the torque seems to be in N mm",
    "the torque seems to be in N cm",
)
"""Those beside which another mistake is looked for."""
LEVERS = (0.005, 0.5)
"""[m] Distances of a held object's COM from the sensor that are usual; others count
against a unit."""
ALIKE = 3.0
"""Log-likelihood up to which a unit is told beside the best, as kgf beside daN; with the
mass by each, which alone tells them apart."""


def explain(case: Case) -> Explanation | None:
    """The likeliest pair of units."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    if explains_nothing(case, partial(_with_maps, case, _maps_of_two_moments())):
        return None
    found = {what: torque / force for what, (force, torque) in UNITS.items()}
    # at the clock offset of the recording as given, and at none
    motion = case.motion_late(case.likely_offsets)
    quick = {
        what: fit_rows(case, _builder(case, ratio)(motion))
        for what, ratio in found.items()
    }
    masses = {
        what: UNITS[what][0] * abs(float(fitted.solution[fitted.best][0]))
        for what, fitted in quick.items()
    }
    usual = {
        what: fitted.likelihood.max()
        for what, fitted in quick.items()
        if LEVERS[0] <= _lever(fitted, found[what]) <= LEVERS[1]
        and masses[what] <= HEAVIEST_HELD
    }
    if not usual:
        return None
    what = max(usual, key=lambda name: round(usual[name], 6))
    fitted = over_offsets(case, _builder(case, found[what]))[0]
    force, torque = UNITS[what]
    least = usual[what] - ALIKE * correlation(fitted) / len(case.time)
    alike = [name for name in usual if usual[name] > least and name != what]
    fix = FIX
    if not alike:
        fix += f', unit = ["{force:g} N", "{torque:g} N m"]'
    told = [f"{name} (then {masses[name]:.3g} kg)" for name in (what, *alike)]
    return Explanation(
        CODE,
        ", or ".join(told) if alike else what,
        fix,
        fitted,
        0,
        rarity=1.0,
        argument="column_map",
        is_grave=True,
        parameters=fitted.solution[fitted.best, :10] * ((force,) + (torque,) * 9),
    )


def undone(case: Case) -> Iterator[Undone]:
    """Each pair of units that are common."""
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
    """[m] Distance of the COM from the sensor in SI units."""
    solution = fitted.solution[fitted.best]
    size = abs(float(solution[0]))
    return ratio * float(np.linalg.norm(solution[1:4])) / max(size, 1e-12)


def _builder(case: Case, ratio: float) -> Build:
    maps = REGRESSOR_BY_FEATURE.copy()
    # the first moment of the columns is that of the recorded torque
    maps[:, :3, 1:4] *= ratio
    return partial(_with_maps, case, maps)


def _with_maps(case: Case, maps: Array, motion: Motion) -> Rows:
    return with_bias(case, case.features(motion), maps, motion.known)


def _maps_of_two_moments() -> Array:
    """Columns of the ten parameters, with the force's first moment, and of the
    torque's."""
    maps = np.concatenate(
        (REGRESSOR_BY_FEATURE, REGRESSOR_BY_FEATURE[:, :, 1:4]), axis=2
    )
    maps[:, 3:, 1:4] = maps[:, :3, 10:] = 0.0
    return maps
