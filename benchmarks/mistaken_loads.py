"""Mistakes that depend on the load, or on the height, as changes of the wrench."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.given import RATE, Change, Given, gravity_of
from hefting.core.spatial import Array


def hanging(per_metre: float) -> Change:
    """A cable hangs down to the floor, 0.3 m below the lowest place: so many kg of each
    metre."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        height = np.array(given.recording["position"].values)[:, 2]
        length = 0.3 + height - height.min()
        pull = -per_metre * length[:, None] * gravity_of(given)
        both = np.hstack((pull, np.cross((0.0, 0.06, -0.02), pull)))
        return given.wrench(lambda _, w: w + both)

    return make


def gain_by_load(law: Callable[[Array], Array]) -> Change:
    """The force that is shown is a function of what would be, by axes [N]."""
    return lambda given, rng: given.wrench(
        lambda _, w: np.hstack((law(w[:, :3]), w[:, 3:]))
    )


def elastic_mount(degrees: float) -> Change:
    """The sensor is turned by so many degrees for each N m of its load; what turns with
    it is the specific force alone."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        unit = np.zeros(10)
        unit[0] = 1.0
        specific = given.wrench_of(unit)[:, :3]
        load = given.wrench_of(given.truth.vector)
        turn = Rotation.from_rotvec(np.radians(degrees) * load[:, 3:])
        change = turn.inv().apply(specific) - specific
        moment = np.cross(given.truth.vector[1:4], change)
        extra = np.hstack((given.truth.mass * change, moment))
        return given.wrench(lambda _, w: w + extra)

    return make


def sliding(share: Array) -> Array:
    """How far something is on its way to a stop, by axes (K, 3), of the specific force's
    share of gravity's: it gets there in 0.2 s under gravity."""
    place, places = np.zeros(3), np.empty_like(share)
    for k, each in enumerate(share):
        place = places[k] = np.clip(place + each / (0.2 * RATE), -1.0, 1.0)
    return places
