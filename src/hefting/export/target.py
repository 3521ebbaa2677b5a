"""Target: all that `hefting.export.export` knows of a simulator, a controller or a
table.

Each target is one file that ends with its `TARGET`; `hefting.export` lists the files,
one line each.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hefting.core.messages import Message
from hefting.export.body import Body
from hefting.export.splice import Place

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate


def _no_warnings(of: Body | str) -> list[Message]:
    return []


@dataclass(frozen=True)
class Target:
    """What an estimate can be written as. It has either `write` or `write_estimate`."""

    name: str
    """As given to `hefting.export.export` and ``hefting export --to``."""
    description: str
    """What it is, in half a line."""
    suffixes: tuple[str, ...] = ()
    """File name endings, with their dot, that ask for this target."""
    write: Callable[[Body], str] | None = None
    """Text of a file of its own, or lines to paste, of a body."""
    write_estimate: Callable[["Estimate", str], str] | None = None
    """Text of the estimate itself in sensor axes, whether or not a body can have it,
    and of its name."""
    is_read_back: bool = False
    """Whether `Estimate.load` reads the text; its suffixes are then named first."""
    wants_flange: bool = False
    """Whether its numbers must be in flange axes, about the flange's origin; otherwise
    any frame will do."""
    needs_inertia: bool = False
    """Whether a point mass cannot be written."""
    takes_inertia: bool = True
    """Whether an inertia has a place in the text at all."""
    in_sensor_axes: bool = False
    """Whether its numbers are in sensor axes, wherever the sensor is on the flange."""
    place: Place | None = None
    """Where in an existing file of the format an inertial goes; None: it cannot be put
    into one."""
    inertial: Callable[[Body], str] | None = None
    """Text of that inertial; there is one wherever there is a `place`."""
    warnings: Callable[[Body], list[Message]] = _no_warnings
    """What to know of a body written so."""
    file_warnings: Callable[[str], list[Message]] = _no_warnings
    """What to know of the text of an existing file that an inertial was put into."""
