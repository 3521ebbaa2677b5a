"""What tests compute of the same input, computed once: simulated motions, points of a
shape and, in a file, poses that recordings share and recordings that are identified in
several ways."""

import pickle
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from hashlib import sha256
from importlib import import_module
from typing import Any
from unittest.mock import patch

SMOOTHING = "hefting.motion.inertial", "fit_poses"
"""What `hefting.motion.smooth_poses` calls of poses."""
CONDITIONING = "hefting.ingest.ingest", "condition"
"""What `hefting.ingest.ingest` calls of a recording."""
JUDGING = "hefting.ingest.chosen_part", "doubt_of"
"""What `hefting.ingest.ingest` calls of a recording to find mistakes in it."""
INGESTING = "hefting.ingest.joint", "ingest"
"""What `hefting.identify` calls of a recording."""
OF_RUNS = (
    ("hefting.identification.by_torques", "samples_of"),
    ("hefting.identification.by_torques", "of_rivals"),
    ("hefting.identification.by_torques", "without_delay"),
    ("hefting.torques.runs", "_rows"),
)
"""What identification calls of runs of joint torques."""
SAMPLING = "hefting.shapes.shape", "sample"
"""What `hefting.shapes.Shape` calls of a solid."""
MOVING = "hefting.simulation.joints", "_at_speed"
"""What the simulation's motions call of their speed."""


@contextmanager
def computed_once(
    *functions: tuple[str, str], known: dict[bytes, Any] | None = None
) -> Iterator[None]:
    """Within it functions, each by its module and name, return what they returned before
    of equal arguments. They depend on nothing else, and nobody changes what they
    return. `known` is what they returned in blocks before this."""
    known = {} if known is None else known
    with ExitStack() as stack:
        for place, name in functions:
            module = import_module(place)
            kept = _kept(getattr(module, name), known)
            stack.enter_context(patch.object(module, name, kept))
        yield


def _kept(function: Callable[..., Any], known: dict[bytes, Any]) -> Callable[..., Any]:
    """The function with a memory."""

    def kept(*given: Any, **named: Any) -> Any:
        asked = pickle.dumps((function.__name__, given, sorted(named.items())))
        key = sha256(asked).digest()
        if key not in known:
            known[key] = function(*given, **named)
        return known[key]

    return kept
