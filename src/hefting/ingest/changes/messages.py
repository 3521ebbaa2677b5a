"""What is said of changes: when they were, what happened, and which part to use."""

from itertools import pairwise

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array
from hefting.ingest.changes.stretches import Changes, Stretch

LONG_TOUCH_SHARE = 0.5
"""Share of a recording above which it is said that a contact lasts so long."""


def change_warnings(changes: Changes | None, *, chosen: bool) -> list[Message]:
    """Warnings of changes of the object; `chosen` is whether a stretch was chosen, or the
    part was given."""
    if changes is None:
        return []
    said = [_change(changes)] if _events(changes) else []
    if changes.touches:
        said.append(_touch(changes))
    parts = ", ".join(_part(stretch) for stretch in changes.stretches)
    if not chosen:
        what = f"the part that was given is used, though not one free body explains it; for one: {parts}"
        return [*said, error("change-left-in", what, "start")]
    used = changes.chosen
    what = f"only {used.start:.2f} to {used.end:.2f} s is used; to choose: {parts}"
    return [*said, warning("change-part-used", what, "start")]


def _events(changes: Changes) -> list[str]:
    """What happened, and when."""
    return [
        f"{one.event} at {0.5 * (one.end + other.start):.1f} s"
        for one, other in pairwise(changes.stretches)
        if one.event not in (None, "touched")
    ]


def _change(changes: Changes) -> Message:
    what = f"the object changes: {', '.join(_events(changes))}"
    return warning("change-point", what)


def _touch(changes: Changes) -> Message:
    """That something touches the object, and when."""
    when = ", ".join(f"{t.start:.1f} to {t.end:.1f} s" for t in changes.touches)
    long = changes.touched > LONG_TOUCH_SHARE * changes.duration
    much = ", more than half of the recording" if long else ""
    parts = (*changes.touches, *changes.stretches)
    first, last = min(p.start for p in parts), max(p.end for p in parts)
    # a sensor that is zeroed stays so to the end of the recording
    lasts = any(first == t.start or t.end == last for t in changes.touches)
    also = ", or was the sensor zeroed" if lasts else ""
    what = f"no free body explains the wrench from {when}{much}: touched{also}?"
    return warning("change-touched", what)


def _part(stretch: Stretch) -> str:
    """Start and duration of a stretch, as one gives them, and the body in it."""
    com = stretch.center_of_mass
    where = "" if com is None else f", COM {_millimetres(com)} mm"
    numbers = f"`start` {stretch.start:.2f} `duration` {stretch.duration:.2f}"
    return f"{numbers} ({stretch.mass:.3g} kg{where})"


def _millimetres(com: Array) -> str:
    return f"({', '.join(f'{1e3 * x:.0f}' for x in com)})"
