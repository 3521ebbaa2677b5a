"""Messages on mistakes that are fitted together with the payload
(`hefting.torques.suspects`), and the iteration to their size."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hefting.core.messages import Message, codes, error, note, warning
from hefting.core.spatial import Array, angle_between
from hefting.core.torque_moments import PAYLOAD
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.suspects import Suspect, Suspects

WRONG_SHIFT = 0.5, 1.0
"""Change of mass or first moments by a suspect, over the half-widths of their intervals,
above which its message is a warning, and an error."""
SUSPECTS = frozenset(
    {
        "part-contradicts",
        "torques-delayed",
        "arm-tilted",
        "joint-zeros",
        "torque-gain",
        "weight-contradicts",
    }
)
"""Codes of messages on suspects."""
RIVAL = "torques-of-other-arm"
EXPLAINED_BY_RIVAL = SUSPECTS | {
    "empty-run-contradicts",
    "joints-changed",
    "mass-undetermined",
    "no-load-seen",
    "no-positive-mass",
    "torque-unit",
}
"""Codes of consequences of another order or sign of joints, or another gravity."""
MOST_STEPS = 8
"""Largest number of steps to the size of a tilt or of zeros."""
SMALL_STEP = 0.05
"""Relative size of the last step."""


def of_suspect(
    dynamics: JointDynamics,
    suspect: Suspect | None,
    half: Array,
    sources: Sequence[str],
    calibrated: bool = False,
) -> list[Message]:
    """The message on a suspect, as severe as its change of the payload's parameters
    relative to `half` (10,), the half-widths of their intervals. `sources` are the names
    of the loaded runs. A `calibrated` arm keeps the gravity of its calibration."""
    if suspect is None:
        return []
    # open parameters have infinite half-widths
    shift = float(np.abs(suspect.shift / np.maximum(half, 1e-9))[:4].max())
    # a controller's payload reduces the weight; more weight is due to other lengths
    is_heavier = suspect.kind == "weight" and suspect.theta[0] > 0.0
    is_grave = suspect.kind == "part" or is_heavier
    say = warning
    if shift > WRONG_SHIFT[1]:
        say = error
    elif shift < WRONG_SHIFT[0] and not is_grave:
        say = note
    runs = _runs_with(suspect)
    return [_suspect_message(say, suspect, dynamics, runs, sources, calibrated)]


def _runs_with(suspect: Suspect) -> str:
    if suspect.loaded is None:
        return "the empty runs"
    if suspect.loaded:
        return "the loaded runs, not the empty ones,"
    return "all runs"


def of_empty_runs(
    dynamics: JointDynamics, delays: Sequence[Suspect], suspect: Suspect | None
) -> list[Message]:
    """Messages on delays and a suspect of the empty runs of a calibration."""
    messages = of_delays(delays, empty=False)
    if suspect is not None:
        messages.append(
            _suspect_message(warning, suspect, dynamics, "the empty runs", ())
        )
    return messages


def of_delays(delays: Sequence[Suspect], empty: bool) -> list[Message]:
    """A note on delays that were removed, separately for loaded and empty runs if there
    are `empty` ones too."""
    if not delays:
        return []
    loaded, every = (
        1e3 * sum(float(each.theta[0]) for each in delays if own or not each.loaded)
        for own in (True, False)
    )
    apart = f" in loaded runs, and {every:.0f} ms in empty ones" if empty else ""
    what = f"torques come {loaded:.0f} ms after the positions{apart}, because of clocks or a filter: corrected"
    return [note("torques-late", what)]


def without_explained(messages: Sequence[str]) -> list[str]:
    """The messages without consequences of a named mistake; the verdict stays."""
    coded = [each for each in messages if isinstance(each, Message)]
    explained: set[str] = set()
    if any(each.code in SUSPECTS and each.severity != "note" for each in coded):
        explained |= {"joints-changed"}
    if RIVAL in codes(coded):
        explained |= EXPLAINED_BY_RIVAL
    if "no-load-seen" in codes(coded):
        explained |= {"no-positive-mass"}
    return [each for each in messages if getattr(each, "code", "") not in explained]


def _suspect_message(
    say: Callable[..., Message],
    suspect: Suspect,
    dynamics: JointDynamics,
    runs: str,
    sources: Sequence[str],
    calibrated: bool = False,
) -> Message:
    """The message on a suspect in `runs`, of the severity of `say`; other arguments as
    in `of_suspect`."""
    if suspect.part is not None:
        return _part_message(say, suspect, suspect.part, sources)
    if suspect.kind == "delay":
        what = f"torques of {runs} are late by times that differ: use one clock"
        return say("torques-delayed", what)
    if suspect.kind == "tilt":
        can_change = not (suspect.loaded or calibrated)
        return _tilt_message(say, suspect, dynamics, runs, can_change)
    if suspect.kind == "weight":
        more = "more" if suspect.theta[0] > 0.0 else "less"
        what = (
            f"in {runs} what is held weighs {more} than its inertia says: is a payload "
            "configured in the controller in some runs only, or has the arm other "
            "lengths than the URDF?"
        )
        return say("weight-contradicts", what)
    return _joints_message(say, suspect, dynamics, runs)


def _part_message(
    say: Callable[..., Message],
    suspect: Suspect,
    part: tuple[int, float | None, float | None],
    sources: Sequence[str],
) -> Message:
    """The message on a `Suspect.part` of a run; `sources` are the names of the runs."""
    number, first, last = part
    when = (f"from {first:.1f} s" if first else "", f"to {last:.1f} s" if last else "")
    span = " ".join(filter(None, when)) or "all of it"
    what = (
        f"{sources[number]}: {span} its torques contradict the rest, as if "
        f"{abs(suspect.theta[0]):.2g} kg were added or missing: is the object picked up, put down or "
        "turned, or does something touch it? Identify from one part alone (`start`, "
        "`duration`)"
    )
    return say("part-contradicts", what, "start")


def _tilt_message(
    say: Callable[..., Message],
    suspect: Suspect,
    dynamics: JointDynamics,
    runs: str,
    can_change: bool,
) -> Message:
    gravity = _turned(dynamics.gravity, suspect.theta)
    angle = np.degrees(angle_between(dynamics.gravity, gravity))
    how = "level the base, free the cable, or record an empty run like it"
    if can_change:
        how = give_gravity(gravity.round(3))
    what = (
        f"in {runs} gravity seems to be tilted by {angle:.1f}°, as by a base that is "
        f"not level or a cable that pulls: {how}"
    )
    return say("arm-tilted", what, "gravity")


def _joints_message(
    say: Callable[..., Message], suspect: Suspect, dynamics: JointDynamics, runs: str
) -> Message:
    """The message on wrong zeros [rad], or gains, of the joints with the largest."""
    theta = suspect.theta
    large = np.flatnonzero(np.abs(theta) > 0.5 * np.abs(theta).max())
    if suspect.kind == "zeros":
        each = (f"{dynamics.names[j]} by {-np.degrees(theta[j]):.1f}°" for j in large)
        what = (
            f"in {runs} joint angles seem to be too large, {', '.join(each)}: check "
            "their zeros; elastic gears look the same"
        )
        return say("joint-zeros", what)
    each = (f"{dynamics.names[j]} {1.0 + theta[j]:.3g}" for j in large)
    what = f"in {runs} torques seem to be too large by a factor, {', '.join(each)}: check `torque_gains` and units"
    return say("torque-gain", what, "torque_gains")


def _turned(gravity: Array, theta: Array) -> Array:
    """(3,) gravity changed by a tilt `theta` (3,), of the same size [m/s²]."""
    g = gravity + theta
    return g * (np.linalg.norm(gravity) / np.linalg.norm(g))


def give_gravity(gravity: Array) -> str:
    """Advice to give `gravity` (3,) [m/s²]."""
    return f"give `gravity`='{','.join(f'{x:.6g}' for x in gravity + 0.0)}'"


def levelled(runs: LoadedRuns) -> Array:
    """(3,) gravity with which all runs show no tilt [m/s²]."""
    none = Suspect("tilt", False, np.zeros(3), 0.0, np.zeros(PAYLOAD))
    return _turned(runs.dynamics.gravity, _stepped(runs, none).theta)


def refined(runs: LoadedRuns, suspect: Suspect | None) -> Suspect | None:
    """A tilt in all runs, or zeros, iterated to convergence; other suspects, and all if
    the arm is calibrated, unchanged."""
    if suspect is None or runs.calibration is not None:
        return suspect
    if suspect.kind != "zeros" and (suspect.kind != "tilt" or suspect.loaded):
        return suspect
    return _stepped(runs, suspect)


def _stepped(runs: LoadedRuns, suspect: Suspect) -> Suspect:
    """The suspect with its size, of which the first step falls short, and the resulting
    change of the payload, iterated with runs that are corrected for it."""
    kind = (suspect.kind, suspect.loaded)
    before = runs.fit().common[-PAYLOAD:]
    for _ in range(MOST_STEPS):
        corrected = _without(runs, suspect)
        fit = corrected.fit()
        tried = Suspects(corrected, fit).all()
        step = next(each for each in tried if (each.kind, each.loaded) == kind).theta
        shift = fit.common[-PAYLOAD:] - before
        suspect = replace(suspect, theta=suspect.theta + step, shift=shift)
        if np.abs(step).max() < SMALL_STEP * np.abs(suspect.theta).max():
            break
    return suspect


def _without(runs: LoadedRuns, suspect: Suspect) -> LoadedRuns:
    if suspect.kind == "tilt":
        turned = _turned(runs.dynamics.gravity, suspect.theta)
        return replace(runs, dynamics=runs.dynamics.under(turned))
    loaded, empty = (
        tuple(replace(run, position=run.position + suspect.theta) for run in each)
        for each in (runs.loaded, runs.empty)
    )
    return replace(runs, loaded=loaded, empty=runs.empty if suspect.loaded else empty)
