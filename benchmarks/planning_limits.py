"""Whether plans keep random limits, by MuJoCo alone: its own reading of the URDF, its
kinematics, velocities and distances; see `benchmarks.planning`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.planning import Plan, plan
from hefting.planning.space import HalfSpace
from hefting.shapes import Shape
from hefting.simulation.arm import Arm
from hefting.simulation.torque_scenario import TORQUE_ARMS

FINE = 1000.0
"""[Hz] of the grid on which limits are checked; every tenth instant for distances."""
RADIUS = 0.04
"""[m] of the cylinders that the links are."""
GAP = 0.08
"""[m] from each end of a link to its cylinder, so that an elbow can bend."""
SHORTEST = 0.25
"""[m] of a link with a cylinder."""
SLACK = 1e-6
"""Share of a limit that is rounding."""


@dataclass(frozen=True, eq=False)
class Case:
    """Random limits for one plan."""

    arm: str
    box: tuple[float, float, float, float, float, float]
    """x0, x1, y0, y1, z0, z1 [m] of the object in the tip's frame"""
    keep: tuple[str, ...]
    """a table and a wall"""
    numbers: dict[str, float]
    """duration, speed, acceleration, jerk"""
    seed: int

    @classmethod
    def random(cls, arms: Sequence[str], seed: int) -> Case:
        """The same for the same seed."""
        rng = np.random.default_rng([seed, 52])
        sides = rng.uniform((0.04, 0.04, 0.05), (0.2, 0.2, 0.35))
        (x, y), (a, b, height) = rng.uniform(-0.04, 0.04, 2), 0.5 * sides
        box = (x - a, x + a, y - b, y + b, 0.0, 2.0 * height)
        heading = rng.uniform(-np.pi, np.pi)
        wall = np.cos(heading), np.sin(heading), 0.0
        factors = ",".join(f"{-x:.4f}" for x in wall)
        keep = (
            f"z>={rng.uniform(0.0, 0.15):.3f}",
            f"{factors}>={-rng.uniform(0.35, 0.7):.3f}",
        )
        numbers = {
            "duration": rng.uniform(2.0, 5.0),
            "speed": rng.uniform(0.1, 0.6),
            "acceleration": np.exp(rng.uniform(np.log(1.0), np.log(10.0))),
            "jerk": np.exp(rng.uniform(np.log(15.0), np.log(300.0))),
        }
        own = {name: float(value) for name, value in numbers.items()}
        return cls(arms[seed % len(arms)], box, keep, own, seed)

    def plan(self, folder: Path) -> Plan:
        """The plan, of a short search. Raises `InputError` where there is none."""
        path = folder / f"{self.arm}-solid.urdf"
        path.write_text(solid_urdf(TORQUE_ARMS[self.arm].arm))
        shape = Shape.from_box(*self.box)
        return plan(
            path,
            "flange",
            shape=shape,
            keep=self.keep,
            effort="quick",
            seed=self.seed,
            **self.numbers,  # pyright: ignore[reportArgumentType]
        )


def solid_urdf(arm: Arm, box: Sequence[float] = ()) -> str:
    """A URDF of an arm whose links are cylinders, with the object as a box on its
    flange where there is one."""
    text = TORQUE_ARMS[_name_of(arm)].urdf
    points = [screw.point for screw in arm.robot.screws]
    ends = [*points[1:], arm.robot.home_position]
    for i, (point, end) in enumerate(zip(points, ends, strict=True), 1):
        along = end - point
        length = float(np.linalg.norm(along))
        if length < SHORTEST:
            continue
        axis = along / length
        turns = 0.0, np.arccos(np.clip(axis[2], -1.0, 1.0)), np.arctan2(*axis[1::-1])
        rpy = " ".join(repr(float(turn)) for turn in turns)
        middle = " ".join(map(repr, (0.5 * along).tolist()))
        solid = (
            f'<collision><origin xyz="{middle}" rpy="{rpy}"/><geometry><cylinder '
            f'radius="{RADIUS}" length="{length - 2.0 * GAP}"/></geometry></collision>'
        )
        head = f'<link name="link{i}">'
        text = text.replace(head, head + solid)
    if len(box):
        low, high = np.reshape(box, (3, 2)).T
        middle = " ".join(map(repr, (0.5 * (low + high)).tolist()))
        sides = " ".join(map(repr, (high - low).tolist()))
        text = text.replace(
            '<link name="flange"/>',
            f'<link name="flange"><collision><origin xyz="{middle}"/><geometry><box '
            f'size="{sides}"/></geometry></collision></link>',
        )
        text = text.replace(
            '<robot name="arm">',
            '<robot name="arm"><mujoco><compiler fusestatic="false"/></mujoco>',
        )
    return text


def _name_of(arm: Arm) -> str:
    return next(name for name, own in TORQUE_ARMS.items() if own.arm is arm)


def broken(case: Case, found: Plan) -> dict[str, float]:
    """Largest share of each limit that a plan uses, by MuJoCo; of distances the least
    [m]."""
    import mujoco

    text = solid_urdf(TORQUE_ARMS[case.arm].arm, case.box)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    count = round(found.duration * FINE)
    time = np.linspace(0.0, found.duration, count + 1)
    motion = found.at(time)
    step = time[1]
    q = motion.position
    ranges = model.jnt_range
    own = {
        "position": float(
            np.max(np.abs(q - ranges.mean(axis=1)) / (0.5 * np.ptp(ranges, axis=1)))
        )
    }
    # derivatives by differences of the positions alone
    speeds = np.array(TORQUE_ARMS[case.arm].arm.joint_speeds)
    for order, (name, limit) in enumerate(
        {
            "joint speed": speeds,
            "acceleration": case.numbers["acceleration"],
            "jerk": case.numbers["jerk"],
        }.items(),
        1,
    ):
        own[name] = float(
            np.max(np.abs(np.diff(q, order, axis=0)) / step**order / limit)
        )
    corners = corner_points(case.box)
    places, distance = np.empty((len(q), 9, 3)), np.inf
    tip = model.body("flange").id
    pairs = _pairs(mujoco, model, data, q[0])
    fastest = 0.0
    for k in range(len(q)):
        data.qpos[:], data.qvel[:] = q[k], motion.velocity[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        twist = np.empty(6)
        kind = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(model, data, kind, tip, twist, 1)
        velocity = twist[3:] + np.cross(twist[:3], corners)
        fastest = max(fastest, float(np.linalg.norm(velocity, axis=1).max()))
        places[k] = data.xpos[tip] + corners @ data.xmat[tip].reshape(3, 3).T
        if k % 10 == 0:
            for one, other in pairs:
                own_distance = mujoco.mj_geomDistance(
                    model, data, one, other, 0.5, None
                )
                distance = min(distance, own_distance)
    own["corner speed"] = fastest / case.numbers["speed"]
    halves = [HalfSpace.parse(text) for text in case.keep]
    own["walls"] = float(min(half.clearance(places).min() for half in halves))
    own["distance"] = float(distance)
    return own


def corner_points(box: Sequence[float]) -> Array:
    """(9, 3) [m] the tip and the corners of a box."""
    ends = np.reshape(box, (3, 2))
    grid = np.array(np.meshgrid(*ends, indexing="ij")).reshape(3, -1).T
    return np.vstack((np.zeros(3), grid))


def _pairs(mujoco: Any, model: Any, data: Any, start: Array) -> list[tuple[int, int]]:
    """Geometries that are apart at the start and two joints or more from each other."""
    data.qpos[:] = start
    mujoco.mj_kinematics(model, data)
    bodies = model.geom_bodyid
    flange = model.body("flange").id
    depth = [flange - 1 if body == flange else body for body in bodies]
    return [
        (i, j)
        for j in range(model.ngeom)
        for i in range(j)
        if abs(depth[i] - depth[j]) > 1
        and mujoco.mj_geomDistance(model, data, i, j, 0.5, None) > 0.0
    ]


def show_limits(folder: Path, arms: Sequence[str], number: int) -> None:
    """Plans with random limits until there are `number`, and what they use."""
    uses: list[dict[str, float]] = []
    refused = seed = 0
    while len(uses) < number:
        case = Case.random(arms, seed)
        seed += 1
        try:
            found = case.plan(folder)
        except InputError as error:
            refused += 1
            print(f"case {seed - 1}: {error}", file=sys.stderr, flush=True)
            continue
        uses.append(broken(case, found))
        bad = {k: v for k, v in uses[-1].items() if not kept(k, v)}
        if bad:
            print(f"case {seed - 1} breaks {bad}", flush=True)
        print(f"{len(uses)} of {number}", file=sys.stderr, flush=True)
    print(f"\n{number} plans with random limits, {refused} cases refused")
    for name in uses[0]:
        values = np.array([own[name] for own in uses])
        wrong = sum(not kept(name, value) for value in values)
        if name in ("walls", "distance"):
            text = f"least {1e3 * values.min():.1f} mm"
        else:
            text = f"largest share {values.max():.4f}, median {np.median(values):.3f}"
        print(f"{name:13} {text}; broken in {wrong}")


def kept(name: str, value: float) -> bool:
    """Whether a limit is kept."""
    if name in ("walls", "distance"):
        return value >= 0.0
    return value <= 1.0 + SLACK + (1e-4 if name == "jerk" else 0.0)
