"""Simulated recordings by name of arm, object and motion: the log and the truth."""

from collections.abc import Sequence
from dataclasses import asdict, field, replace
from fractions import Fraction
from math import lcm
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.recording import Recording
from hefting.core.spatial import SPEED_LIMIT, STANDARD_GRAVITY, Array, immutable
from hefting.shapes.reading import MESH_SUFFIXES
from hefting.simulation.arm import UR5, XARM7, Arm, JointMotion
from hefting.simulation.faults import Faults, Rates, record
from hefting.simulation.joints import random_smooth, sinusoids, stop_and_go
from hefting.simulation.modular import MODULAR, held_modular
from hefting.simulation.objects import HAMMER_POSE, HeldObject, hammer
from hefting.simulation.wield import Wielding, mujoco_version, wield_in_mujoco

ARMS = {"ur5": UR5, "xarm7": XARM7}
"""Arms by name."""

MOTIONS = ("sinusoids", "random", "stop-and-go")

JOINER_HAMMER = "joiners-hammer"
OBJECTS = (*MODULAR, JOINER_HAMMER)
"""Objects by name: the modular object's eight configurations, and a hammer of wood and
steel."""

MOST_SAMPLES = 5_000_000
"""Most samples of a simulated motion."""


@immutable
class Simulated:
    """Result of a scenario."""

    wielding: Wielding
    """exact motion and wrench, from MuJoCo"""
    recording: Recording
    """the log with faults"""
    facts: dict[str, Any]
    """the truth for JSON, with keys of `hefting.identification.truth.load_truth`"""
    warnings: tuple[str, ...]
    """limits that the motion exceeds"""


@immutable
class Scenario:
    """Arm, object, motion and faults to simulate; the same for the same `seed`."""

    held: HeldObject
    arm: Arm = UR5
    motion: str = "sinusoids"
    """one of `MOTIONS`"""
    angular_speed: float | None = None
    """mean over the motion [rad/s], by default 1; not for stop-and-go"""
    speed_limit: float | None = None
    """of the sensor's origin [m/s]"""
    duration: float = 10.0
    """[s]"""
    rates: Rates = field(default_factory=lambda: Rates(wrench=100.0, pose=100.0))
    """[Hz], each given"""
    gravity: ArrayLike = STANDARD_GRAVITY
    """(3,) in the axes of the arm's base [m/s²]"""
    faults: Faults = field(default_factory=Faults)
    seed: int = 0

    def joints(self) -> JointMotion:
        """The motion of the joints, at the lowest rate that all `rates` divide.

        Raises `InputError` for an unknown motion, numbers out of range, less than two
        samples, and more than `MOST_SAMPLES`.
        """
        rate = _common_rate(self.rates)
        if not self.duration * rate <= MOST_SAMPLES:
            what = f"{self.duration:g} s at {rate:g} Hz are more than {MOST_SAMPLES:,} samples"
            fix = "simulate less, or choose rates of which one is a multiple of the others"
            raise InputError(what, fix=fix)
        if 0.0 < self.duration * rate < 2.0:
            what = f"{self.duration:g} s at {rate:g} Hz are less than two samples"
            raise InputError(what, fix="simulate longer")
        own = {"arm": self.arm, "speed_limit": self.speed_limit}
        if self.motion == "stop-and-go":
            if self.angular_speed is not None:
                what = "stop-and-go has no speed to choose"
                raise InputError(what, fix="leave it out, or give a speed limit")
            return stop_and_go(self.duration, rate, seed=self.seed, **own)
        speed = 1.0 if self.angular_speed is None else self.angular_speed
        if self.motion == "sinusoids":
            return sinusoids(self.duration, rate, speed, **own)
        if self.motion == "random":
            return random_smooth(self.duration, rate, speed, self.seed, **own)
        what = f"there is no motion '{self.motion}'{nearest(self.motion, MOTIONS)}"
        raise InputError(what, fix=f"choose one of {', '.join(MOTIONS)}")

    def run(self) -> Simulated:
        """Wield the object in MuJoCo and record it.

        Raises `MissingDependencyError` without MuJoCo, and `InputError` as `joints`.
        """
        joints = self.joints()
        wielding = wield_in_mujoco(self.arm, joints, self.held.parameters, self.gravity)
        recording = record(wielding, self.faults, self.rates, self.seed)
        angular, linear = wielding.motion.mean_speeds
        fastest = float(wielding.motion.linear_speed().max())
        warnings = list(self.arm.exceeded(joints))
        if fastest > SPEED_LIMIT:
            warnings.append(
                f"the sensor moves at up to {fastest:.2f} m/s; ISO 10218-1 allows {SPEED_LIMIT} m/s"
            )
        facts = self.held.truth(self.gravity, self.faults.on_sensor)
        facts["simulation"] = {
            "engine": f"MuJoCo {mujoco_version()}",
            "arm": self.arm.robot.source,
            "sensor_frame": self.arm.robot.sensor_frame,
            "motion": self.motion,
            "duration": self.duration,
            "mean_angular_speed": angular,
            "mean_linear_speed": linear,
            "largest_linear_speed": fastest,
            "rates": asdict(self.rates),
            "faults": asdict(self.faults),
            "seed": self.seed,
        }
        return Simulated(wielding, recording, facts, tuple(warnings))


def named_arm(name: str, sensor_frame: str | None) -> Arm:
    """One of `ARMS`, or the arm of a URDF file whose link `sensor_frame` carries the
    sensor.

    Raises `InputError` for another name, for a URDF without `sensor_frame`, and as
    `Arm.from_urdf`.
    """
    if name.lower() in ARMS:
        if sensor_frame is not None:
            what = f"the {name} has its sensor at its flange"
            raise InputError(what, fix="give a frame for a URDF only")
        return ARMS[name.lower()]
    if Path(name).suffix.lower() not in (".urdf", ".xml"):
        what = f"there is no arm '{name}'{nearest(name, ARMS)}"
        raise InputError(what, fix=f"choose {', '.join(ARMS)} or a .urdf file")
    if sensor_frame is None:
        raise InputError(
            "which link holds the sensor?", name, "give `sensor_frame`=NAME"
        )
    return Arm.from_urdf(name, sensor_frame)


def named_object(
    name: str,
    densities: Sequence[float] = (),
    unit: str | None = None,
    pose: ArrayLike | None = None,
) -> HeldObject:
    """One of `OBJECTS`, or mesh files separated by commas, each with its density
    [kg/m³].

    `pose` (4, 4) is that of the object in the sensor frame: by default the pose of the
    named object, or the identity for meshes. Raises `InputError` for another name, for
    another number of densities than of meshes, and as `HeldObject.from_meshes`.
    """
    lower = name.lower()
    if lower in OBJECTS:
        if densities or unit is not None:
            fix = "give density and unit for meshes only"
            raise InputError(f"what '{name}' is made of is known", fix=fix)
        if lower == JOINER_HAMMER:
            return HeldObject.of(hammer(), HAMMER_POSE if pose is None else pose)
        held = held_modular(lower)
        return held if pose is None else replace(held, pose=np.asarray(pose, float))
    paths = [part.strip() for part in name.split(",")]
    if any(Path(path).suffix.lower() not in MESH_SUFFIXES for path in paths):
        fix = f"choose one of {', '.join(OBJECTS)}, or give mesh files ({', '.join(MESH_SUFFIXES)})"
        raise InputError(
            f"there is no object '{name}'{nearest(name, OBJECTS)}", fix=fix
        )
    if len(densities) != len(paths):
        what = f"{len(densities)} densities for {len(paths)} mesh(es)"
        raise InputError(what, name, "give one for each, separated by commas [kg/m³]")
    return HeldObject.from_meshes(list(zip(paths, densities, strict=True)), unit, pose)


def random_six(force: float, torque: float, seed: int | Sequence[int]) -> Array:
    """(6,) force [N] and torque [N m] of these magnitudes in random directions."""
    directions = np.random.default_rng(seed).normal(size=(2, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate((force * directions[0], torque * directions[1]))


def _common_rate(rates: Rates) -> float:
    """The lowest rate [Hz] that all rates divide."""
    wanted = []
    for name, rate in asdict(rates).items():
        if rate is None or not (np.isfinite(rate) and rate >= 0.0):
            what = f"the {name} rate is {rate} Hz"
            raise InputError(what, fix="give a number that is not negative, 0 for none")
        if rate > 0.0:
            wanted.append(Fraction(rate).limit_denominator(1000))
    if not wanted or min(wanted) <= 0:
        raise InputError("nothing is to be recorded", fix="give rates above 0.001 Hz")
    denominator = lcm(*(rate.denominator for rate in wanted))
    return float(
        Fraction(lcm(*(int(rate * denominator) for rate in wanted)), denominator)
    )
