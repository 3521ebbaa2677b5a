"""Plausibility: errors for results that are impossible for a held object, warnings for
unlikely ones."""

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, codes, error, note, warning
from hefting.core.quantity import decimals, rounded, significant
from hefting.core.spatial import Array
from hefting.ingest.free_fit import FreeFit, lever
from hefting.ingest.ingest import Ingested
from hefting.ingest.tool import left_open
from hefting.shapes import Shape
from hefting.shapes.winding import sides_with_walls

LONGEST_OBJECT = 10.0
"""[m] Longer shapes, and longer distances of shape or COM from the sensor, indicate a
wrong unit or pose."""
HEAVIEST_OBJECT = 1000.0
"""[kg] Larger masses indicate a wrong unit of force."""
UNUSUALLY_HEAVY = 100.0
"""[kg] Mass above which the unit of force is in doubt: a wrench in mN fits as well."""
UNUSUALLY_LIGHT = 0.01
"""[kg] Mass below which it is so too, if noise is as small as of a wrench in kN."""
LEAST_NOISE = 1e-3
"""[N] Noise below any sensor's: one of the finest, ATI's Nano17, resolves 3 mN."""
LEAST_INERTIA = -4.0
"""Standard deviations from which on the sum of the moments of inertia is negative: in 110
right simulated recordings it is -1.9 at least."""
OTHER_SIGN = 'has the torque the other sign ("-tx", "-ty", "-tz" in a column map)'
MOMENTS = [4, 7, 9]
"""Indices of the moments in the ten parameters."""
SHORTEST_RECORDING = 0.2
"""[s] Duration below which a wrong unit of time is likely."""
DENSEST_MATERIAL = 23_000.0
"""[kg/m³] Upper bound on the density of a material (osmium: 22,590)."""

LIGHTEST_OBJECT = 5.0
"""[kg/m³] Least mass over the volume of an object's bounding box: a hammer has 500, a
tennis racket 50, an empty bottle 30, foam 15, an empty carton 7 to 10. A length unit
ten times too large divides it by a thousand, which shows for bodies of up to 5,000
kg/m³."""
DENSEST_OBJECT = 12_000.0
"""[kg/m³] Largest mass over the volume of an object's shape: lead has 11,340."""
DENSEST_WALL = 3_000.0
"""[kg/m³] Mass over the volume of walls around a space above which the space may be
filled: walls of glass, ceramics and aluminium have less, those of steel more."""
STEEL = 7_000.0, 8_200.0
"""[kg/m³] Walls of steel, cast iron and zinc: a vessel of these may well be empty."""
WALLS_SHARE = 0.3
"""Largest volume of a shape that may be walls, over that of its bounding box."""
UNEXPLAINED_RESIDUAL_RATIO = 3.0
"""Ratio of an estimate's residual to that of unconstrained least squares above which a
warning is given."""
COM_OUTSIDE_SHARE = 0.75
"""Distance of the COM from the mean of the shape's points, as a share of the shape's
sides, beyond which the COM is well outside. The surface of a box is at half its
side."""
FARTHEST_COM = 0.4
"""[m] Distance of a COM from the sensor, without a shape, above which units are in
doubt: in static poses a force in kgf fits like one of a tenth of the mass, ten times as
far away."""
LARGEST_FOUND_TILT_STD = np.radians(10.0)
"""[rad] Standard deviation of gravity's direction above which the direction counts as
undetermined."""

UNSEEN_MASS = 3.0
"""Standard deviations of a mass beside a tool up to which it may be zero."""
WELL_KNOWN_SHARE = 0.1
"""Standard deviation of that mass over the tool's, below which it is well known."""


def require_object(found: Ingested, shape: Shape | None = None) -> None:
    """Raise unless the recording determines the mass of an object that can be held, and
    the direction of gravity if it was to be found.

    By the `shape` a wrong unit or pose is detected. Raises `NotIdentifiableError` if the
    motion is not sufficient, or no positive mass explains the wrench, and `InputError` if
    only a wrong unit explains the wrench or the shape.
    """
    if shape is not None and float(shape.extents.max()) > LONGEST_OBJECT:
        what = f"the shape is {shape.extents.max():.3g} m long"
        if shape.known == "object" and shape.warnings:
            raise InputError(shape.warnings[0])
        raise InputError(what, fix="give it in metres, or with its unit")
    away = 0.0 if shape is None else np.linalg.norm(shape.positions, axis=1).min()
    if away > LONGEST_OBJECT:
        what = f"the shape is {away:.3g} m away from the sensor"
        raise InputError(what, fix="check the unit and pose of the object")
    tilt = found.conditioned.tilt_std
    if tilt is not None and tilt > LARGEST_FOUND_TILT_STD:
        known = (
            f" (known to {np.degrees(tilt):.0f}° at best)" if np.isfinite(tilt) else ""
        )
        what = f"the motion does not determine the direction of gravity{known}"
        fix = "turn the sensor about two axes (static poses: twelve or more), or give `gravity` X,Y,Z"
        raise NotIdentifiableError(what, found.log, fix)
    try:
        _require_mass(found, shape)
    except InputError as obstacle:
        raise named_instead(obstacle, found) from None


def named_instead(obstacle: InputError, found: Ingested) -> InputError:
    """An error that names the mistake in the recording, or the only wrong one of
    several, in place of an error that follows from it."""
    own = [mistake_in(part) for part in found.recordings]
    if all(own) and found.doubt is not None and found.doubt.is_fatal:
        return type(obstacle)("; ".join(found.doubt.messages), found.log)
    wrong = next(filter(None, own), obstacle)
    return obstacle if all(own) else wrong


def mistake_in(found: Ingested) -> InputError | None:
    """The reason why a recording is wrong whatever others show: a named mistake, or a
    wrench that no object explains."""
    if found.doubt is not None and found.doubt.is_fatal:
        return NotIdentifiableError("; ".join(found.doubt.messages), found.log)
    try:
        if not found.fit.mass_is_open:
            _require_mass(found, None)
    except InputError as obstacle:
        return obstacle
    return None


def _require_mass(found: Ingested, shape: Shape | None) -> None:
    fit = found.fit
    also = "" if found.given_bias is None else " and `bias`"
    if found.tool is not None and (fit.mass_is_open or fit.mass_t < 0.0):
        what, fix = _beside_tool(found), f"check `tool`{also}: was it in the hand?"
        if holds_nothing(found):
            fix = "nothing is held"
        raise NotIdentifiableError(f"there is {what} beside the tool", found.log, fix)
    check_wrench(found, shape)  # first, as in a wrong unit the mass may look like zero
    if "nothing-held" in codes(found.warnings):
        return  # a message of the answer
    if fit.mass_is_open:
        raise NotIdentifiableError(*_why_mass_is_open(found))
    if fit.mass_t < 0.0:
        fix = f"check the wrench's sign (`sign`){also} and `gravity`"
        raise NotIdentifiableError(
            "no positive mass explains the wrench", found.log, fix
        )


def _beside_tool(found: Ingested) -> str:
    mass, std = found.fit.mass, found.fit.mass_std
    known = float(rounded(mass, decimals(std, abs(mass))))
    return f"{known:g} ± {std:.2g} kg" if np.isfinite(std) else "nothing certain"


def _why_mass_is_open(found: Ingested) -> tuple[str, str, str]:
    """What is wrong, where, and what to do."""
    beside = hint = ""
    if found.given_bias is not None:
        hint = "; or is `bias` wrong?"
    elif found.bias == "estimate":
        beside, hint = " beside a bias", ", or give `bias` none"
    duration = found.duration
    if duration is not None and duration < SHORTEST_RECORDING:
        what = f"the recording lasts {duration:.3g} s, too short to determine even the mass{beside}"
        return what, found.log, "is its time in seconds?"
    what = f"the motion is too poor to determine even the mass{beside}"
    return what, found.log, f"turn the sensor to other orientations{hint}"


def holds_nothing(found: Ingested) -> bool:
    """Whether the wrench is significantly that of the tool alone, or of nothing."""
    if found.tool is None:
        return "nothing-held" in codes(found.warnings)
    mass, std = found.fit.mass, found.fit.mass_std
    known = std < WELL_KNOWN_SHARE * found.tool.parameters.mass
    return known and abs(mass) < UNSEEN_MASS * std


def check_wrench(found: Ingested, shape: Shape | None) -> None:
    """`InputError` for a wrench that only a wrong unit explains, judged by
    unconstrained least squares."""
    fit, source = found.fit, found.log
    mass = 0.0 if fit.mass_is_open else abs(fit.mass)
    if mass > HEAVIEST_OBJECT:
        what = f"the force would need {mass:.3g} kg"
        raise InputError(what, source, "give it in newtons; check `gravity`")
    reach = LONGEST_OBJECT
    if shape is not None:
        volume = float(np.prod(shape.extents))
        if 0.0 < DENSEST_MATERIAL * volume < mass:
            what = f"the force would need {mass:.3g} kg in a shape of at most {1e6 * volume:.3g} cm³"
            fix = "check the shape's `unit`, and give force in newtons"
            raise InputError(what, source, fix)
        reach = 1.5 * float(
            np.linalg.norm(shape.positions, axis=1).max()
        ) + 2.0 * float(np.linalg.norm(shape.extents))
    distance = lever(found.state, fit.bias is not None)
    if distance > reach:
        what = f"the torque puts the centre of mass {distance:.3g} m from the sensor"
        raise InputError(
            what,
            source,
            "give torque in newton-metres; check the shape's unit and pose",
        )


def com_warnings(
    fit: FreeFit, shape: Shape | None, inertia: float = np.inf
) -> list[Message]:
    """A warning if the COM by unconstrained least squares is well outside the shape, or
    without one farther away than in most objects; an error if its mirror image is inside
    and the `inertia` (`sum_of_moments`) does not show the sign of the torques."""
    spread = float(np.sqrt(fit.covariance.diagonal()[1:4].max())) / max(
        abs(fit.mass), 1e-12
    )
    if not fit.mass_t > 10.0 or not np.isfinite(spread):
        return []
    com = fit.vector[1:4] / fit.mass
    if shape is None:
        distance = float(np.linalg.norm(com))
        if distance <= FARTHEST_COM + 3.0 * spread:
            return []
        what = (
            f"the COM would be {distance:.2g} m from the sensor: is the force in kgf or "
            "lbf, or the torque in N cm? Of an object that is so long give `shape`"
        )
        return [warning("com-far-from-sensor", what, "shape")]
    middle, limit = shape.positions.mean(axis=0), COM_OUTSIDE_SHARE * shape.extents
    out, mirrored = (
        float(np.max(np.abs((place - middle) @ shape.pose[:3, :3]) - limit))
        for place in (com, -com)
    )
    if out <= 3.0 * spread:
        return []
    say, so = (
        warning,
        ": check the shape's pose and unit, whether a gripper is held, too (`tool`), the "
        "units of force and torque, and the wrench's sign and bias",
    )
    if mirrored < 0.0 and inertia < -LEAST_INERTIA:
        say, so = error, f", and mirrored inside: {OTHER_SIGN}, or is the pose inverse?"
    place = _millimetres(com)
    what = f"without the shape the COM would be at ({place}) mm, well outside it{so}"
    return [say("com-outside-shape", what, "shape")]


def mass_warnings(found: Ingested) -> list[Message]:
    """A warning of a mass that robots seldom hold, as force and torque in a unit a
    thousand times too large or small fit equally well. There is none beside a tool, as
    very little may be held with it."""
    fit = found.fit
    if found.tool is not None or not fit.mass_t > 10.0:
        return []
    mass = fit.mass
    if mass > UNUSUALLY_HEAVY:
        told, unit = f"{mass:.3g} kg", "mN"
    elif mass < UNUSUALLY_LIGHT and found.noise.force < LEAST_NOISE:
        told, unit = f"{1e3 * mass:.2g} g", "kN"
    else:
        return []
    what = f"the object would weigh {told}: is the wrench in newtons and newton-metres, not {unit} and {unit} m?"
    return [warning("mass-unusual", what)]


def torque_sign_messages(found: Ingested, told: bool) -> list[Message]:
    """An error if the moments of inertia have a negative sum, and a warning if they do
    not show the sign of the torques and nothing else has `told` it; none beside a tool."""
    fit, deviations = found.fit, sum_of_moments(found)
    if found.tool is not None:
        return []
    if deviations < LEAST_INERTIA:
        total = float(fit.vector[MOMENTS].sum())
        what = (
            f"the moments of inertia about the sensor add up to {total:.2g} kg m², which "
            f"no body has: {OTHER_SIGN}, or is it about another point (`sensor_pose_in_log`)?"
        )
        return [error("inertia-negative", what)]
    if told or deviations > -LEAST_INERTIA or not fit.mass_t > 10.0:
        return []
    place = _millimetres(-fit.vector[1:4] / fit.vector[0])
    what = (
        "this motion does not tell whether the torques have the sign of the forces: "
        f"assumed; if not, the COM is at ({place}) mm"
    )
    return [warning("torque-sign-assumed", what)]


def sum_of_moments(found: Ingested) -> float:
    """Sum of the moments of inertia about the sensor over its standard deviation."""
    common = found.common_errors
    covariance = found.fit.covariance[:10, :10] + (0.0 if common is None else common)
    variance = float(covariance[np.ix_(MOMENTS, MOMENTS)].sum())
    return (
        float(found.fit.vector[MOMENTS].sum())
        / max(variance, np.finfo(float).tiny) ** 0.5
    )


def _millimetres(place: Array) -> str:
    return ", ".join(f"{1e3 * x:.0f}" for x in place)


def density_warnings(fit: FreeFit, shape: Shape | None) -> list[Message]:
    """A warning if the shape is far too large or too small for the mass, or is that of a
    vessel without its content."""
    if shape is None or shape.known == "reach" or not fit.mass_t > 10.0:
        return []
    mass, space = fit.mass, float(np.prod(shape.extents))
    sides = " x ".join(map(significant, shape.extents))
    if mass > DENSEST_OBJECT * shape.volume > 0.0:
        what = (
            f"the shape of {sides} m would hold {significant(mass / shape.volume)} kg/m³, more than "
            "lead: check its size (`unit`), whether it is all of the object, and whether a "
            "gripper is held, too (`tool`)"
        )
        return [warning("shape-too-small", what, "unit")]
    density = mass / shape.volume
    if density > DENSEST_WALL and _is_walls(shape):
        what = (
            f"the shape is walls around a space, of {significant(density)} kg/m³ if nothing is in "
            "it: if something is, take the convex hull (`hull`)"
        )
        if STEEL[0] <= density <= STEEL[1]:
            return [note("shape-hollow", what, "hull")]
        return [warning("shape-hollow", what, "hull")]
    if shape.known != "object" or mass >= LIGHTEST_OBJECT * space:
        return []
    what = (
        f"the shape of {sides} m would hold {significant(mass / space)} kg/m³, less than what "
        "robots hold: check its unit (`unit`), and for stray points or parts"
    )
    return [warning("shape-too-large", what, "unit")]


def _is_walls(shape: Shape) -> bool:
    """Whether a shape is walls around its own middle, with one opening at most."""
    if shape.faces is None or shape.volume > WALLS_SHARE * np.prod(shape.extents):
        return False
    away = shape.hull - shape.homogeneous.center_of_mass
    return sides_with_walls((away @ shape.pose[:3, :3])[shape.faces]) >= 5


def misfit_warnings(
    estimate: Estimate, residual: Array, found: Ingested
) -> list[Message]:
    """A warning if the estimate's residual is much larger than that of unconstrained
    least squares, and an error if it is not tied to a shape that may be wrong: then it is
    of no body that has this wrench. `residual` (2,) is the root-mean-square residual of
    force [N] and torque [N m]."""
    free = np.array((found.noise.force, found.noise.torque))
    over = residual > np.maximum(
        UNEXPLAINED_RESIDUAL_RATIO * free, 0.01 * found.wrench_rms
    )
    if not over[: 1 if left_open(found.tool).any() else 2].any():  # its inertia is open
        return []
    cause = "the shape or its pose does not fit"
    if "c1" in estimate.provenance:
        cause += ", or c1 is too large for this motion"
    if "max_acceleration" in estimate.provenance and not found.static:
        cause = (
            "the motion is too fast for gravity alone (move slower, stop and go, or use "
            f"another method), or {cause}"
        )
    say = warning
    if estimate.hull_margin is None:
        say, cause = error, "do not trust it"
    what = (
        f"{estimate.method} leaves {residual[0]:.2g} N and {residual[1]:.2g} N m of the wrench unexplained, "
        f"unconstrained least squares {free[0]:.2g} and {free[1]:.2g}: {cause}"
    )
    return [say("misfit", what, "shape")]
