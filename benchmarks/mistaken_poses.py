"""Mistakes with poses, clocks, gravity and shapes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.bodies import random_body
from benchmarks.given import (
    KINDS,
    RATE,
    Change,
    Given,
    orientation,
)
from hefting.core.recording import Stream
from hefting.core.spatial import Array
from hefting.logs import orientations
from hefting.shapes import Shape


def quaternions(order: Callable[[Array], Array]) -> Change:
    return lambda given, rng: given.stream("orientation", lambda _, q: order(q))


def inverse_pose(given: Given, rng: np.random.Generator) -> Given:
    R = orientation(given)
    p = -R.inv().apply(np.array(given.recording["position"].values))
    turned = given.stream("orientation", lambda _, q: R.inv().as_quat())
    return turned.stream("position", lambda _, __: p)


def angles(logged: str, *read: str) -> Change:
    """Angles of one order of axes, read in another form, with an order."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        three = orientation(given).as_euler(logged)
        turned = orientations.quaternions(three, *read)
        given = given.stream("orientation", lambda _, __: turned)
        stream = Stream(given.recording["orientation"].time, three)
        return replace(given, recording=replace(given.recording, angles=stream))

    return make


def positions(scale: float) -> Change:
    return lambda given, rng: given.stream("position", lambda _, p: scale * p)


def position_axes(*rows: tuple[float, float, float]) -> Change:
    """Positions in other axes than the orientations."""
    return lambda given, rng: given.stream(
        "position", lambda _, p: p @ np.array(rows).T
    )


def lever(metres: float) -> Change:
    """The pose is that of a flange behind the sensor, with the same axes."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        R = orientation(given)
        back = R.apply(np.array((0.0, 0.0, metres)))
        return given.stream("position", lambda _, p: p - back)

    return make


def pose_clock(rate: float) -> Change:
    return lambda given, rng: given.clock(
        lambda t: t[0] + (t - t[0]) * (1.0 + rate), "position", "orientation"
    )


def rows_lost(share: float) -> Change:
    """Rows are lost at random, and time is made of their number."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        streams = given.recording.streams
        kept = rng.random(len(streams["wrench"])) >= share
        time = np.arange(kept.sum()) / RATE
        left = {n: Stream(time, stream.values[kept]) for n, stream in streams.items()}
        return replace(given, recording=replace(given.recording, streams=left))

    return make


def late(seconds: float) -> Change:
    return lambda given, rng: given.clock(lambda t: t + seconds, "wrench")


def time_scaled(factor: float) -> Change:
    """Time in another unit, or of samples at another rate."""
    return lambda given, rng: given.clock(
        lambda t: factor * t, "wrench", "position", "orientation"
    )


def composed(meant: str, took: str) -> Change:
    """Quaternions of angles of one order of axes, taken for another."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        q = Rotation.from_euler(took, orientation(given).as_euler(meant)).as_quat()
        return given.stream("orientation", lambda _, __: q)

    return make


def along_y(other: Change) -> Change:
    """Another mistake, in a world whose y points up."""
    R = Rotation.from_euler("x", -90.0, degrees=True)

    def make(given: Given, rng: np.random.Generator) -> Given:
        given = other(given, rng)
        q = R * orientation(given)
        given = given.stream("orientation", lambda _, __: q.as_quat())
        return given.stream("position", lambda _, p: R.apply(p))

    return make


def tilted(degrees: float) -> Change:
    """The base is tilted, so that the logged poses are turned against gravity."""

    def make(given: Given, rng: np.random.Generator) -> Given:
        heading = rng.uniform(0.0, 2.0 * np.pi)
        axis = np.radians(degrees) * np.array((np.cos(heading), np.sin(heading), 0.0))
        R = Rotation.from_rotvec(axis)
        q = R * orientation(given)
        p = R.apply(np.array(given.recording["position"].values))
        return given.stream("orientation", lambda _, __: q.as_quat()).stream(
            "position", lambda _, __: p
        )

    return make


def gravity(*vector: float) -> Change:
    return lambda given, rng: replace(given, options={"gravity": list(vector)})


def position_glitches(size: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        def jump(_: Array, p: Array) -> Array:
            wrong = rng.random(len(p)) < 1e-3
            wrong[rng.integers(len(p) // 4, len(p) // 2)] = True
            return p + wrong[:, None] * size * rng.normal(size=p.shape)

        return given.stream("position", jump)

    return make


def starts_with_identity(samples: int) -> Change:
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


def frozen(seconds: float) -> Change:
    def make(given: Given, rng: np.random.Generator) -> Given:
        first = int(rng.uniform(2.0, 6.0) * RATE)
        last = first + int(seconds * RATE)

        def hold(_: Array, v: Array) -> Array:
            v = v.copy()
            v[first:last] = v[first]
            return v

        return given.stream("orientation", hold).stream("position", hold)

    return make


def shape(change: Callable[[Given, np.random.Generator], Shape]) -> Change:
    return lambda given, rng: replace(given, shape=change(given, rng))


def moved_shape(metres: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        direction = rng.normal(size=3)
        pose = np.array(given.shape.pose)
        pose[:3, 3] += metres * direction / np.linalg.norm(direction)
        return placed(given, pose)

    return shape(change)


def turned_shape(degrees: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        axis = rng.normal(size=3)
        R = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
        pose = np.array(given.shape.pose)
        pose[:3, :3] = pose[:3, :3] @ R.as_matrix()
        return placed(given, pose)

    return shape(change)


def scaled_shape(factor: float) -> Change:
    def change(given: Given, rng: np.random.Generator) -> Shape:
        assert given.body is not None
        mesh = given.body.mesh.copy()
        mesh.apply_scale(factor)
        return Shape.from_mesh(mesh, pose=given.shape.pose)

    return shape(change)


def another_shape(given: Given, rng: np.random.Generator) -> Given:
    other = random_body(KINDS[rng.integers(len(KINDS))], int(rng.integers(1 << 30)))
    return replace(given, shape=other.shape)


def placed(given: Given, pose: Array) -> Shape:
    assert given.body is not None
    return Shape.from_mesh(given.body.mesh, pose=pose)


def imu(name: str, factor: float) -> Change:
    return lambda given, rng: given.stream(name, lambda _, v: factor * v)
