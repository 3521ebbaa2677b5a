"""Mistakes with the wrench: axes, units, bias, filters, and what else pulls at the
sensor."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.signal import butter, lfilter
from scipy.spatial.transform import Rotation

from benchmarks.given import DURATION, RATE, Change, Given, gravity_of, orientation
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array


def turned(axis: Array, degrees: float, only: int | None = None) -> Change:
    """Both turned about an axis; the force alone where `only` is 0, the torque where it
    is 1."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        R = Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))

        def turn(_: Array, w: Array) -> Array:
            parts = (w[:, :3], w[:, 3:])
            return np.hstack(
                [p if only == 1 - i else R.apply(p) for i, p in enumerate(parts)]
            )

        return given.wrench(turn)

    return make


def mapped(matrix: Array) -> Change:
    """The wrench multiplied by a constant matrix (6, 6)."""
    return lambda given, rng: given.wrench(lambda _, w: w @ matrix.T)


def signs(*signs: float) -> Change:
    return mapped(np.diag(signs))


def units(force: float, torque: float) -> Change:
    return signs(*(force,) * 3, *(torque,) * 3)


def dead(channel: int) -> Change:
    """A channel that shows nothing but its noise and bias."""
    hidden = np.arange(6) == channel

    def make(given: Given, rng: np.random.Generator) -> Given:
        load = given.wrench_of(given.truth.vector)
        return given.wrench(lambda _, w: w - hidden * load)

    return make


def compensated(share: float) -> Change:
    """The controller subtracts the weight of a share of the object."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        weight = share * given.truth.mass * gravity_of(given)
        away = np.hstack((weight, np.cross(given.truth.center_of_mass, weight)))
        return given.wrench(lambda _, w: w + away)

    return make


def unbiased_options(bias: float) -> Change:
    """`bias` none on a log with a bias of that many newtons."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        direction = rng.normal(size=6) * np.array((1, 1, 1, 0.05, 0.05, 0.05))
        extra = bias * direction / np.linalg.norm(direction[:3])
        biased = given.wrench(lambda _, w: w + extra)
        return replace(biased, options={"bias": "none"})

    return make


def anothers_bias(size: float) -> Change:
    """The bias of another run, so many newtons off."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        direction = rng.normal(size=6) * np.array((1, 1, 1, 0.05, 0.05, 0.05))
        bias = size * direction / np.linalg.norm(direction[:3])
        return replace(given, options={"bias": bias})

    return make


def contact(share: float) -> Change:
    """The object rests on something for a share of the time, in one stretch."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        start = rng.uniform(0.05, 0.95 - share) * DURATION
        weight = given.truth.mass * 9.81
        force = np.array((0.0, 0.0, 1.0)) * rng.uniform(0.5, 1.0) * weight
        R = orientation(given)
        held = R.inv().apply(force)
        where = given.truth.center_of_mass + rng.uniform(-0.05, 0.05, 3)
        push = np.hstack((held, np.cross(where, held)))

        def touch(t: Array, w: Array) -> Array:
            since = t - t[0] - start
            ramp = np.clip(np.minimum(since, share * DURATION - since) / 0.1, 0.0, 1.0)
            sway = 1.0 + 0.3 * np.sin(2.0 * np.pi * 0.7 * t)
            return w - (ramp * sway)[:, None] * push

        return given.wrench(touch)

    return make


def gains(share: float) -> Change:
    """A gain of its own for each channel."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        return mapped(np.diag(1.0 + share * rng.normal(size=6)))(given, rng)

    return make


def play(share: float) -> Change:
    """Hysteresis: each channel follows only when the load has moved by a share of its
    range."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        load = given.wrench_of(given.truth.vector)
        half = 0.5 * share * np.ptp(load, axis=0)
        shown = load.copy()
        for k in range(1, len(load)):
            shown[k] = np.clip(shown[k - 1], load[k] - half, load[k] + half)
        return given.wrench(lambda _, w: w + shown - load)

    return make


def vibrating(hertz: float, newtons: float) -> Change:
    """A compliant arm: the wrench vibrates."""
    amplitude = newtons * np.array((1.0, 0.5, 0.7, 0.05, 0.06, 0.02))

    def shake(t: Array, w: Array) -> Array:
        return w + np.sin(2.0 * np.pi * hertz * t + 1.0)[:, None] * amplitude

    return lambda given, rng: given.wrench(shake)


def low_passed(hertz: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        b, a = butter(2, hertz / (0.5 * RATE))

        def smooth(_: Array, w: Array) -> Array:
            return w[0] + np.asarray(lfilter(b, a, w - w[0], axis=0))

        return given.wrench(smooth)

    return make


def tcp(metres: float) -> Change:
    """The torque is about a point of the tool."""
    point = np.array((0.0, 0.0, metres))

    def move(_: Array, w: Array) -> Array:
        return np.hstack((w[:, :3], w[:, 3:] - np.cross(point, w[:, :3])))

    return lambda given, rng: given.wrench(move)


def in_base_axes(given: Given, rng: np.random.Generator) -> Given:
    R = orientation(given)
    return given.wrench(lambda _, w: np.hstack((R.apply(w[:, :3]), R.apply(w[:, 3:]))))


def about_base(given: Given, rng: np.random.Generator) -> Given:
    """In base axes, with the torque about the base's origin."""
    p = np.array(given.recording["position"].values)

    def move(_: Array, w: Array) -> Array:
        return np.hstack((w[:, :3], w[:, 3:] + np.cross(p, w[:, :3])))

    return in_base_axes(given, rng).wrench(move)


def local_gravity(size: float) -> Change:
    """Made where gravity is of another size: the whole wrench, near enough."""
    return units(size / 9.80665, size / 9.80665)


def quantised(step: float) -> Change:
    steps = np.repeat((step, 0.05 * step), 3)
    return lambda given, rng: given.wrench(lambda _, w: np.round(w / steps) * steps)


def saturated(share: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        def clip(_: Array, w: Array) -> Array:
            most = share * np.abs(w).max(axis=0)
            return np.clip(w, -most, most)

        return given.wrench(clip)

    return make


def blank(share: float) -> Change:
    """-9999 stands for a share of the samples that were lost."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        def lose(t: Array, w: Array) -> Array:
            return np.where(rng.uniform(size=len(t))[:, None] < share, -9999.0, w)

        return given.wrench(lose)

    return make


def cable(stiffness: float) -> Change:
    """A cable from the world pulls at the sensor, by so many N/m."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        p = np.array(given.recording["position"].values)
        R = orientation(given)
        anchor = p.mean(axis=0) + 0.3 * rng.normal(size=3)
        pull = R.inv().apply(stiffness * (anchor - p))
        both = np.hstack((pull, np.cross(np.array((0.0, 0.05, 0.0)), pull)))
        return given.wrench(lambda _, w: w - both)

    return make


def sloshing(share: float) -> Change:
    """A share of the mass swings freely at 1.5 Hz, as the specific force drives it."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        unit = np.zeros(10)
        unit[0] = 1.0
        specific = -given.wrench_of(unit)[:, :3]
        frequency, damping, dt = 2.0 * np.pi * 1.5, 0.05, 1.0 / RATE
        x, v = specific[0] / frequency**2, np.zeros(3)
        places, accelerations = np.empty_like(specific), np.empty_like(specific)
        for k, s in enumerate(specific):
            a = s - frequency**2 * x - 2.0 * damping * frequency * v
            places[k], accelerations[k] = x, a
            v = v + dt * a
            x = x + dt * v
        mass = share * given.truth.mass
        moved = places - specific / frequency**2
        torque = np.cross(moved, -mass * specific)
        extra = np.hstack((mass * accelerations, torque))
        return given.wrench(lambda _, w: w + extra)

    return make


def dropped_while_moving(kind: str, size: float) -> Change:
    """An event in the middle: the object is picked up, put down, swapped or slips."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        exact = given.wrench_of(given.truth.vector)
        when = rng.uniform(0.35, 0.65) * DURATION
        other = None
        if kind == "swapped":
            other = InertialParameters(size * given.truth.vector)
        elif kind == "slipped":
            place = given.truth.center_of_mass + size * np.array((0.0, 0.0, 1.0))
            mass, inertia = given.truth.mass, given.truth.inertia_at_com
            other = InertialParameters.from_com(mass, place, inertia)

        def change(t: Array, w: Array) -> Array:
            share = np.clip((t - t[0] - when) / 0.05, 0.0, 1.0)[:, None]
            if kind == "picked-up":
                return w - (1.0 - share) * exact
            if other is None:
                return w - share * exact
            return w + share * (given.wrench_of(other.vector) - exact)

        changed = given.wrench(change)
        return changed if other is None else replace(changed, others=(other,))

    return make


def changing_gradually(kind: str, size: float) -> Change:
    """The object loses a share of its mass, or creeps by so many metres."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        exact = given.wrench_of(given.truth.vector)
        other = InertialParameters((1.0 - size) * given.truth.vector)
        if kind == "creeps":
            place = given.truth.center_of_mass + size * np.array((0.0, 0.0, 1.0))
            mass, inertia = given.truth.mass, given.truth.inertia_at_com
            other = InertialParameters.from_com(mass, place, inertia)
        change = given.wrench_of(other.vector) - exact

        def gradually(t: Array, w: Array) -> Array:
            return w + ((t - t[0]) / (t[-1] - t[0]))[:, None] * change

        return replace(given.wrench(gradually), others=(other,))

    return make


def yielding(
    metres: float, law: Callable[[Array], Array] = lambda share: share
) -> Change:
    """The grip gives way by so many metres under the object's weight across it, and by a
    tenth of it along it; in between as a law says of the weight's share along each
    axis."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        unit = np.zeros(10)
        unit[0] = 1.0
        specific = given.wrench_of(unit)[:, :3]
        places = -law(specific / 9.81) * metres * np.array((1.0, 1.0, 0.1))
        torque = np.cross(places, given.truth.mass * specific)
        truth = given.truth
        mean = InertialParameters.from_com(
            truth.mass,
            truth.center_of_mass + places.mean(axis=0),
            truth.inertia_at_com,
        )
        extra = np.hstack((np.zeros_like(torque), torque))
        return replace(given.wrench(lambda _, w: w + extra), others=(mean,))

    return make


def gripper(mass: float) -> Change:
    """A gripper that nobody mentioned."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        # a ball of 3 cm
        place, inertia = np.array((0.0, 0.0, 0.05)), 0.4 * mass * 0.03**2 * np.eye(3)
        gripper = InertialParameters.from_com(mass, place, inertia)
        return given.wrench(lambda _, w: w + given.wrench_of(gripper.vector))

    return make


def cross_talk(share: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        scale = np.repeat((1.0, 0.1), 3)
        M = share * rng.normal(size=(6, 6)) * scale[:, None] / scale
        return given.wrench(lambda _, w: w + w @ M.T)

    return make
