"""Mistakes that people make with recordings: each turns a correct recording into what a
mistaken user would give."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.signal import butter, lfilter
from scipy.spatial.transform import Rotation

from benchmarks.bodies import Body, random_body
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.shapes import Shape
from hefting.simulation import UR5, random_smooth, sinusoids, stop_and_go
from hefting.simulation.faults import WRENCH_NOISE, Faults, Rates
from hefting.simulation.physics import wield_analytically
from hefting.simulation.record import record

RATE = 100.0
DURATION = 10.0
BIAS = np.array((2.0, 2.0, 2.0, 0.1, 0.1, 0.1))
"""Typical bias of the sensor [N, N m]."""
KINDS = ("homogeneous", "hollow", "materials", "hammer", "insert")


@dataclass(frozen=True, eq=False)
class Given:
    """What a user gives to `hefting.identify`, and the truth."""

    recording: Recording
    shape: Shape
    truth: InertialParameters
    options: dict[str, Any] = field(default_factory=dict)
    """arguments of `hefting.identify` besides"""
    body: Body | None = None
    exact: Measurements | None = None
    """exact motion, from which the wrench of any other body follows"""

    def wrench_of(self, body: Array) -> Array:
        """(K, 6) exact wrench of the ten parameters of a body on the same motion."""
        assert self.exact is not None
        return predict_wrench(self.exact, body)

    def wrench(self, change: Callable[[Array, Array], Array]) -> "Given":
        """With the wrench changed, as a function of time (K,) and wrench (K, 6)."""
        return self.stream("wrench", change)

    def stream(self, name: str, change: Callable[[Array, Array], Array]) -> "Given":
        """With one stream's values changed."""
        stream = self.recording[name]
        changed = Stream(
            stream.time, change(np.array(stream.time), np.array(stream.values))
        )
        streams = {**self.recording.streams, name: changed}
        return replace(self, recording=replace(self.recording, streams=streams))

    def clock(self, change: Callable[[Array], Array], *names: str) -> "Given":
        """With the times of some streams changed."""
        streams = dict(self.recording.streams)
        for name in names:
            streams[name] = Stream(change(streams[name].time), streams[name].values)
        return replace(self, recording=replace(self.recording, streams=streams))


def correct(seed: int, imu: bool = False, noise: str = "moderate") -> Given:
    """A recording without any mistake: a random body of 0.2 to 2.5 kg, ten seconds of
    one of three kinds of motion."""
    rng = np.random.default_rng([15, seed])
    body = random_body(KINDS[seed % len(KINDS)], 90_000 + seed)
    mass = float(np.exp(rng.uniform(np.log(0.2), np.log(2.5))))
    thing = InertialParameters(body.parameters.vector * mass / body.parameters.mass)
    speed = float(rng.uniform(0.7, 2.0))
    joints = (
        sinusoids(DURATION, RATE, speed),
        random_smooth(DURATION, RATE, speed, seed),
        stop_and_go(DURATION, RATE, seed=seed),
    )[seed % 3]
    wielding = wield_analytically(UR5, joints, thing, STANDARD_GRAVITY)
    wrong = Faults(
        wrench_noise=WRENCH_NOISE[noise],
        bias=tuple(BIAS * rng.uniform(-1.0, 1.0, 6)),  # type: ignore[arg-type]
    )
    rates = Rates(imu=RATE if imu else 0.0)
    recording = record(wielding, wrong, rates, seed)
    return Given(recording, body.shape, thing, {}, body, wielding.measurements)


Change = Callable[[Given, np.random.Generator], Given]


@dataclass(frozen=True)
class Mistake:
    """One mistake in one strength."""

    name: str
    strength: str
    make: Change
    codes: frozenset[str]
    """codes of messages that name it rightly; empty where no data can tell it"""
    needs_shape: bool = False
    """whether it is a mistake about the shape, so that there is none without one"""
    imu: bool = False


def _turned(axis: Array, degrees: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        R = Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))

        def turn(_: Array, w: Array) -> Array:
            return np.hstack((R.apply(w[:, :3]), R.apply(w[:, 3:])))

        return given.wrench(turn)

    return make


def _mapped(matrix: Array) -> Change:
    """The wrench multiplied by a constant matrix (6, 6)."""
    return lambda given, rng: given.wrench(lambda _, w: w @ matrix.T)


def _signs(*signs: float) -> Change:
    return _mapped(np.diag(signs))


def _units(force: float, torque: float) -> Change:
    return _signs(*(force,) * 3, *(torque,) * 3)


def _quaternions(order: Callable[[Array], Array]) -> Change:
    return lambda given, rng: given.stream("orientation", lambda _, q: order(q))


def _orientation(given: Given) -> Rotation:
    return Rotation.from_quat(np.array(given.recording["orientation"].values))


def _inverse_pose(given: Given, rng: np.random.Generator) -> Given:
    R = _orientation(given)
    p = -R.inv().apply(np.array(given.recording["position"].values))
    turned = given.stream("orientation", lambda _, q: R.inv().as_quat())
    return turned.stream("position", lambda _, __: p)


def _positions(scale: float) -> Change:
    return lambda given, rng: given.stream("position", lambda _, p: scale * p)


def _gravity_of(given: Given) -> Array:
    """(K, 3) gravity in sensor axes at the wrench's samples, on the same clock."""
    R = _orientation(given)
    return R.inv().apply(np.array(STANDARD_GRAVITY))


def _compensated(share: float) -> Change:
    """The controller subtracts the weight of a share of the object."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        weight = share * given.truth.mass * _gravity_of(given)
        away = np.hstack((weight, np.cross(given.truth.center_of_mass, weight)))
        return given.wrench(lambda _, w: w + away)

    return make


def _unbiased_options(bias: float) -> Change:
    """`bias` none on a log with a bias of that many newtons."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        direction = rng.normal(size=6) * np.array((1, 1, 1, 0.05, 0.05, 0.05))
        extra = bias * direction / np.linalg.norm(direction[:3])
        biased = given.wrench(lambda _, w: w + extra)
        return replace(biased, options={"bias": "none"})

    return make


def _anothers_bias(size: float) -> Change:
    """The bias of another run, so many newtons off."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        direction = rng.normal(size=6) * np.array((1, 1, 1, 0.05, 0.05, 0.05))
        bias = size * direction / np.linalg.norm(direction[:3])
        return replace(given, options={"bias": bias})

    return make


def _contact(share: float) -> Change:
    """The object rests on something for a share of the time, in one stretch."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        start = rng.uniform(0.05, 0.95 - share) * DURATION
        weight = given.truth.mass * 9.81
        force = np.array((0.0, 0.0, 1.0)) * rng.uniform(0.5, 1.0) * weight
        R = _orientation(given)
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


def _play(share: float) -> Change:
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


def _low_passed(hertz: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        b, a = butter(2, hertz / (0.5 * RATE))

        def smooth(_: Array, w: Array) -> Array:
            return w[0] + np.asarray(lfilter(b, a, w - w[0], axis=0))

        return given.wrench(smooth)

    return make


def _lever(metres: float) -> Change:
    """The pose is that of a flange behind the sensor, with the same axes."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        R = _orientation(given)
        back = R.apply(np.array((0.0, 0.0, metres)))
        return given.stream("position", lambda _, p: p - back)

    return make


def _tcp(metres: float) -> Change:
    """The torque is about a point of the tool."""
    point = np.array((0.0, 0.0, metres))

    def move(_: Array, w: Array) -> Array:
        return np.hstack((w[:, :3], w[:, 3:] - np.cross(point, w[:, :3])))

    return lambda given, rng: given.wrench(move)


def _in_base_axes(given: Given, rng: np.random.Generator) -> Given:
    R = _orientation(given)
    return given.wrench(lambda _, w: np.hstack((R.apply(w[:, :3]), R.apply(w[:, 3:]))))


def _pose_clock(rate: float) -> Change:
    return lambda given, rng: given.clock(
        lambda t: t[0] + (t - t[0]) * (1.0 + rate), "position", "orientation"
    )


def _late(seconds: float) -> Change:
    return lambda given, rng: given.clock(lambda t: t + seconds, "wrench")


def _tilted(degrees: float) -> Change:
    """The base is tilted, so that the logged poses are turned against gravity."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        heading = rng.uniform(0.0, 2.0 * np.pi)
        axis = np.radians(degrees) * np.array((np.cos(heading), np.sin(heading), 0.0))
        R = Rotation.from_rotvec(axis)
        q = R * _orientation(given)
        p = R.apply(np.array(given.recording["position"].values))
        return given.stream("orientation", lambda _, __: q.as_quat()).stream(
            "position", lambda _, __: p
        )

    return make


def _gravity(*vector: float) -> Change:
    return lambda given, rng: replace(given, options={"gravity": list(vector)})


def _local_gravity(size: float) -> Change:
    """Made where gravity is of another size: the whole wrench, near enough."""
    return _units(size / 9.80665, size / 9.80665)


def _position_glitches(size: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        def jump(_: Array, p: Array) -> Array:
            wrong = rng.random(len(p)) < 1e-3
            wrong[rng.integers(len(p) // 4, len(p) // 2)] = True
            return p + wrong[:, None] * size * rng.normal(size=p.shape)

        return given.stream("position", jump)

    return make


def _starts_with_identity(samples: int) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        def turn(_: Array, q: Array) -> Array:
            q = q.copy()
            q[:samples] = (0.0, 0.0, 0.0, 1.0)
            return q

        def place(_: Array, p: Array) -> Array:
            p = p.copy()
            p[:samples] = 0.0
            return p

        return given.stream("orientation", turn).stream("position", place)

    return make


def _frozen(seconds: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        first = int(rng.uniform(2.0, 6.0) * RATE)
        last = first + int(seconds * RATE)

        def hold(_: Array, v: Array) -> Array:
            v = v.copy()
            v[first:last] = v[first]
            return v

        return given.stream("orientation", hold).stream("position", hold)

    return make


def _quantised(step: float) -> Change:
    steps = np.repeat((step, 0.05 * step), 3)
    return lambda given, rng: given.wrench(lambda _, w: np.round(w / steps) * steps)


def _saturated(share: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        def clip(_: Array, w: Array) -> Array:
            most = share * np.abs(w).max(axis=0)
            return np.clip(w, -most, most)

        return given.wrench(clip)

    return make


def _cable(stiffness: float) -> Change:
    """A cable from the world pulls at the sensor, by so many N/m."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        p = np.array(given.recording["position"].values)
        R = _orientation(given)
        anchor = p.mean(axis=0) + 0.3 * rng.normal(size=3)
        pull = R.inv().apply(stiffness * (anchor - p))
        both = np.hstack((pull, np.cross(np.array((0.0, 0.05, 0.0)), pull)))
        return given.wrench(lambda _, w: w - both)

    return make


def _sloshing(share: float) -> Change:
    """A share of the mass swings along two axes at 1.5 Hz, driven by gravity's
    change."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        g = _gravity_of(given)
        frequency, damping = 2.0 * np.pi * 1.5, 0.05
        x, v, dt = np.zeros(3), np.zeros(3), 1.0 / RATE
        moved = np.empty_like(g)
        stiffness = frequency**2
        x = g[0] / stiffness
        for k in range(len(g)):
            a = g[k] - stiffness * x - 2.0 * damping * frequency * v
            v = v + dt * a
            x = x + dt * v
            moved[k] = x
        mass = share * given.truth.mass
        torque = np.cross(moved - g / stiffness, -mass * g)
        force = mass * (stiffness * moved - g)
        return given.wrench(lambda _, w: w - np.hstack((force, -torque)))

    return make


def _dropped_while_moving(kind: str, size: float) -> Change:
    """An event in the middle: the object is picked up, put down, swapped or slips."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        exact = given.wrench_of(given.truth.vector)
        when = rng.uniform(0.35, 0.65) * DURATION
        slip = size * np.array((0.0, 0.0, 1.0))

        def change(t: Array, w: Array) -> Array:
            share = np.clip((t - t[0] - when) / 0.05, 0.0, 1.0)[:, None]
            if kind == "picked-up":
                return w - (1.0 - share) * exact
            if kind == "put-down":
                return w - share * exact
            if kind == "swapped":
                return w + share * (size - 1.0) * exact
            moved = np.hstack((np.zeros((len(w), 3)), np.cross(slip, exact[:, :3])))
            return w + share * moved

        return given.wrench(change)

    return make


def _gripper(mass: float) -> Change:
    """A gripper that nobody mentioned."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        # a ball of 3 cm
        place, inertia = np.array((0.0, 0.0, 0.05)), 0.4 * mass * 0.03**2 * np.eye(3)
        gripper = InertialParameters.from_com(mass, place, inertia)
        return given.wrench(lambda _, w: w + given.wrench_of(gripper.vector))

    return make


def _shape(change: Callable[[Given, np.random.Generator], Shape]) -> Change:
    return lambda given, rng: replace(given, shape=change(given, rng))


def _moved_shape(metres: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        direction = rng.normal(size=3)
        pose = np.array(given.shape.pose)
        pose[:3, 3] += metres * direction / np.linalg.norm(direction)
        return _placed(given, pose)

    return _shape(change)


def _turned_shape(degrees: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        axis = rng.normal(size=3)
        R = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
        pose = np.array(given.shape.pose)
        pose[:3, :3] = pose[:3, :3] @ R.as_matrix()
        return _placed(given, pose)

    return _shape(change)


def _scaled_shape(factor: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        assert given.body is not None
        mesh = given.body.mesh.copy()
        mesh.apply_scale(factor)
        return Shape.from_mesh(mesh, pose=given.shape.pose)

    return _shape(change)


def _another_shape(given: Given, rng: np.random.Generator) -> Given:
    other = random_body(KINDS[rng.integers(len(KINDS))], int(rng.integers(1 << 30)))
    return replace(given, shape=other.shape)


def _placed(given: Given, pose: Array) -> Shape:
    assert given.body is not None
    return Shape.from_mesh(given.body.mesh, pose=pose)


def _imu(name: str, factor: float) -> Change:
    return lambda given, rng: given.stream(name, lambda _, v: factor * v)


def _gain(*factors: float) -> Change:
    return _signs(*factors)


def _cross_talk(share: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        scale = np.repeat((1.0, 0.1), 3)
        M = share * rng.normal(size=(6, 6)) * scale[:, None] / scale
        return given.wrench(lambda _, w: w + w @ M.T)

    return make


def _named(*codes: str) -> frozenset[str]:
    return frozenset(codes)


UNSEEN: frozenset[str] = frozenset()
TURNED = _named("axes-turned")


def mistakes() -> list[Mistake]:
    """All mistakes, each strength by itself."""
    z, diagonal = np.array((0, 0, 1.0)), np.array((1, 1, 1)) / np.sqrt(3.0)
    x = np.array((1.0, 0, 0))
    found: list[Mistake] = []

    def add(
        name: str,
        codes: frozenset[str],
        strengths: Mapping[str, Change],
        needs_shape: bool = False,
        imu: bool = False,
    ) -> None:
        for strength, make in strengths.items():
            found.append(Mistake(name, strength, make, codes, needs_shape, imu))

    turns = (5.0, 30.0, 90.0, 180.0)
    add("turned about z", TURNED, {f"{a:.0f}°": _turned(z, a) for a in turns})
    turns = (3.0, 45.0, 120.0)
    add(
        "turned about a diagonal",
        TURNED,
        {f"{a:.0f}°": _turned(diagonal, a) for a in turns},
    )
    add("turned about x", TURNED, {f"{a:.0f}°": _turned(x, a) for a in (10.0, 180.0)})
    add(
        "quaternion order",
        _named("quaternion-order"),
        {
            "w first": _quaternions(lambda q: np.roll(q, 1, axis=1)),
        },
    )
    add(
        "inverse pose",
        _named("pose-inverse"),
        {
            "whole": _inverse_pose,
            "orientation": _quaternions(lambda q: q * np.array((-1, -1, -1, 1))),
        },
    )
    add(
        "axis flipped",
        _named("axis-flipped", "axes-turned", "force-unit"),
        {
            "fx": _signs(-1, 1, 1, 1, 1, 1),
            "fz": _signs(1, 1, -1, 1, 1, 1),
            "ty": _signs(1, 1, 1, 1, -1, 1),
            "tz": _signs(1, 1, 1, 1, 1, -1),
            "all torques": _signs(1, 1, 1, -1, -1, -1),
            "mirrored": _signs(1, -1, 1, 1, -1, 1),
        },
    )
    swap = np.kron(np.array(((0, 1), (1, 0))), np.eye(3))
    xy = np.kron(np.eye(2), np.array(((0, 1, 0), (1, 0, 0), (0, 0, 1))))
    add(
        "columns swapped",
        _named("axis-flipped", "axes-turned", "wrong-unit"),
        {
            "x and y": _mapped(xy),
            "force and torque": _mapped(swap),
        },
    )
    add("wrench in base axes", _named("wrench-in-base-axes"), {"": _in_base_axes})
    add(
        "bias none",
        _named("bias-wrong"),
        {f"{b:g} N": _unbiased_options(b) for b in (1.0, 5.0, 20.0)},
    )
    add(
        "another run's bias",
        _named("bias-wrong"),
        {f"{b:g} N": _anothers_bias(b) for b in (1.0, 3.0, 8.0)},
    )
    add(
        "unit of position",
        _named("position-unit"),
        {
            "mm": _positions(1e3),
            "cm": _positions(1e2),
            "in": _positions(1 / 0.0254),
        },
    )
    wrong_unit = _named(
        "force-unit",
        "torque-unit",
        "wrong-unit",
        "com-outside-shape",
        "com-implausible",
    )
    add(
        "unit of force",
        wrong_unit,
        {
            "kgf": _units(1 / 9.80665, 1.0),
            "lbf": _units(1 / 4.4482, 1.0),
            "g": _units(101.97, 1.0),
        },
    )
    add(
        "unit of torque",
        wrong_unit,
        {
            "N mm": _units(1.0, 1e3),
            "N cm": _units(1.0, 100.0),
            "lbf in": _units(1.0, 8.85),
        },
    )
    add(
        "compensated wrench",
        _named("wrench-compensated"),
        {f"{s:.0%} of the payload": _compensated(s) for s in (0.3, 0.6, 1.0)},
    )
    add(
        "in contact",
        _named("contact", "many-outliers", "change-point", "change-touched"),
        {f"{s:.0%}": _contact(s) for s in (0.15, 0.35, 0.55)},
    )
    add(
        "gain of all channels",
        UNSEEN,
        {"0.5%": _units(1.005, 1.005), "1%": _units(1.01, 1.01)},
    )
    add(
        "gain of one axis",
        _named("gain-uneven"),
        {f"{g:.0%}": _gain(1, 1, 1 + g, 1, 1, 1) for g in (0.03, 0.05, 0.10)},
    )
    add(
        "cross-talk",
        _named("cross-talk", "gain-uneven", "axes-turned", "unexplained"),
        {f"{s:.0%}": _cross_talk(s) for s in (0.01, 0.03, 0.10)},
    )
    add(
        "play",
        _named("hysteresis", "unexplained"),
        {f"{s:.0%}": _play(s) for s in (0.01, 0.03, 0.10)},
    )
    add(
        "local gravity",
        UNSEEN,
        {"9.780": _local_gravity(9.780), "9.832": _local_gravity(9.832)},
    )
    add(
        "low-passed",
        _named("wrench-filtered"),
        {f"{f:g} Hz": _low_passed(f) for f in (5.0, 2.0, 0.7)},
    )
    lever = _named("lever-arm")
    add(
        "flange behind sensor",
        lever,
        {f"{1e3 * d:.0f} mm": _lever(d) for d in (0.02, 0.05, 0.15)},
    )
    add(
        "torque about the TCP",
        lever,
        {f"{1e3 * d:.0f} mm": _tcp(d) for d in (0.02, 0.05, 0.15)},
    )
    add(
        "position glitches",
        _named("pose-glitches", "poses-implausible"),
        {f"{s:g} m": _position_glitches(s) for s in (0.1, 10.0, 1e3)},
    )
    add(
        "starts with the identity",
        _named("poses-held-at-ends", "pose-glitches", "poses-jump"),
        {f"{n}": _starts_with_identity(n) for n in (1, 10, 100)},
    )
    add(
        "frozen poses",
        _named("poses-frozen", "contact"),
        {f"{s:g} s": _frozen(s) for s in (0.2, 0.5, 1.0)},
    )
    add(
        "pose clock fast",
        _named("clock-rate"),
        {f"{r:.1%}": _pose_clock(r) for r in (0.003, 0.01, 0.03)},
    )
    add(
        "late clock",
        _named("clock-offset"),
        {f"{1e3 * s:.0f} ms": _late(s) for s in (0.03, 0.1, 0.3)},
    )
    add(
        "base tilted",
        _named("base-tilted"),
        {f"{a:.0f}°": _tilted(a) for a in (2.0, 5.0, 15.0)},
    )
    add(
        "gravity",
        _named("gravity-reversed", "base-tilted", "wrench-sign"),
        {"upwards": _gravity(0, 0, 9.80665), "along y": _gravity(0, -9.80665, 0)},
    )
    add(
        "quantised",
        _named("quantised", "unexplained"),
        {f"{s:g} N": _quantised(s) for s in (0.5, 2.0)},
    )
    add(
        "saturated",
        _named("saturation"),
        {f"{s:.0%}": _saturated(s) for s in (0.9, 0.6)},
    )
    add(
        "cable",
        _named("unexplained", "base-tilted", "hysteresis"),
        {f"{k:g} N/m": _cable(k) for k in (1.0, 5.0, 20.0)},
    )
    add(
        "sloshing",
        _named("unexplained", "sloshing"),
        {f"{s:.0%}": _sloshing(s) for s in (0.1, 0.3)},
    )
    events = _named(
        "change-point",
        "change-touched",
    )
    add("picked up", events, {"": _dropped_while_moving("picked-up", 0.0)})
    add("put down", events, {"": _dropped_while_moving("put-down", 0.0)})
    add(
        "swapped",
        events,
        {
            "1.5": _dropped_while_moving("swapped", 1.5),
            "0.7": _dropped_while_moving("swapped", 0.7),
        },
    )
    add(
        "slipped",
        events,
        {
            "20 mm": _dropped_while_moving("slipped", 0.02),
            "60 mm": _dropped_while_moving("slipped", 0.06),
        },
    )
    add(
        "gripper not mentioned",
        _named(
            "com-outside-shape", "mass-moved-by-shape", "misfit", "shape-contradicted"
        ),
        {"0.8 kg": _gripper(0.8)},
    )
    wrong_shape = _named(
        "com-outside-shape",
        "mass-moved-by-shape",
        "misfit",
        "shape-contradicted",
        "shape-doubtful",
    )
    add(
        "mesh moved",
        wrong_shape,
        {f"{1e3 * d:.0f} mm": _moved_shape(d) for d in (0.02, 0.05, 0.15)},
        needs_shape=True,
    )
    add(
        "mesh turned",
        wrong_shape,
        {f"{a:.0f}°": _turned_shape(a) for a in (30.0, 90.0)},
        needs_shape=True,
    )
    add(
        "mesh scaled",
        wrong_shape,
        {f"{f:g}": _scaled_shape(f) for f in (0.5, 2.0)},
        needs_shape=True,
    )
    add("another mesh", wrong_shape, {"": _another_shape}, needs_shape=True)
    add(
        "accelerometer in g",
        _named("accelerometer-contradicts-poses"),
        {"": _imu("accelerometer", 1 / 9.80665)},
        imu=True,
    )
    add(
        "gyroscope in °/s",
        _named("gyroscope-contradicts-poses"),
        {"": _imu("gyroscope", 180 / np.pi)},
        imu=True,
    )
    return found
