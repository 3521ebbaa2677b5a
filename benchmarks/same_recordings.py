"""Simulated recordings for `benchmarks.same_answers`, made once and kept, so that every
version reads the same bytes.

Random bodies of `benchmarks.bodies` from 60 g to 3 kg, three kinds of motion, 100, 250
and 1,000 Hz, poses with noise, and one thing wrong with each, or everything.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

RECORDINGS = 200
KINDS = (
    "clean",
    "little noise",
    "much noise",
    "late",
    "bias",
    "drift",
    "spikes",
    "contact",
    "dropped",
    "flipped",
    "coloured",
    "tilted",
    "few poses",
    "imu",
    "static",
    "all",
)
RATES = (100.0, 250.0, 1000.0)
INDEX = "index.json"
SCALE = np.repeat((1.0, 0.05), 3)
"""N m for each N."""


def made(folder: Path, recordings: int = RECORDINGS) -> list[dict[str, Any]]:
    """What is said of every recording in `folder`; they are simulated first where the
    folder is not there yet."""
    index = folder / INDEX
    if not index.exists():
        folder.mkdir(parents=True, exist_ok=True)
        facts = [simulated(folder, number) for number in range(recordings)]
        index.write_text("\n".join(json.dumps(each) for each in facts) + "\n")
    return [json.loads(line) for line in index.read_text().splitlines()]


def simulated(folder: Path, number: int) -> dict[str, Any]:
    """Write one recording and its mesh to `folder`, and say what is in it."""
    from benchmarks.bodies import FILLINGS, random_body
    from hefting.core.inertia import InertialParameters
    from hefting.core.spatial import STANDARD_GRAVITY
    from hefting.simulation import (
        UR5,
        random_smooth,
        sinusoids,
        stop_and_go,
        wield_analytically,
    )

    rng = np.random.default_rng([77, number])
    kind, rate = KINDS[number % len(KINDS)], float(rng.choice(RATES))
    body = random_body(list(FILLINGS)[number % len(FILLINGS)], 50_000 + number)
    mass = float(np.exp(rng.uniform(np.log(0.06), np.log(3.0))))
    thing = InertialParameters(body.parameters.vector * mass / body.parameters.mass)
    duration, speed = float(rng.uniform(4.0, 10.0)), float(rng.uniform(0.6, 2.0))
    motion = ("sinusoids", "random", "stop-and-go")[rng.integers(3)]
    joints = {
        "sinusoids": lambda: sinusoids(duration, rate, speed),
        "random": lambda: random_smooth(duration, rate, speed, number),
        "stop-and-go": lambda: stop_and_go(duration, rate, seed=number),
    }[motion]()
    gravity = tilted(rng) if kind == "tilted" else np.array(STANDARD_GRAVITY)
    wielding = wield_analytically(UR5, joints, thing, gravity)
    streams = (
        static_poses(wielding, rng)
        if kind == "static"
        else logged(wielding, kind, rate, rng, number)
    )
    stem = f"{number:03d}"
    np.savez_compressed(folder / f"{stem}.npz", **streams)  # type: ignore[arg-type]
    body.mesh.export(folder / f"{stem}.ply")
    corners = body.mesh.vertices @ body.shape.pose[:3, :3].T + body.shape.pose[:3, 3]
    sides = np.ravel((corners.min(axis=0), corners.max(axis=0)), order="F")
    return {
        "name": stem,
        "kind": kind,
        "rate": rate,
        "motion": motion,
        "duration": duration,
        "gravity": "estimate" if kind == "tilted" else gravity.tolist(),
        "box": "box:" + ",".join(f"{side:.5f}" for side in sides),
        "pose": body.shape.pose.tolist(),
        "truth": thing.vector.tolist(),
    }


def logged(
    wielding: Any, kind: str, rate: float, rng: np.random.Generator, seed: int
) -> dict[str, np.ndarray]:
    """Time and values of each stream, with what is wrong with this kind."""
    from hefting.simulation import WRENCH_NOISE, Faults, Rates, record

    noise = {"little noise": "low", "much noise": "high"}.get(kind, "moderate")
    wrong: dict[str, Any] = {"wrench_noise": WRENCH_NOISE[noise]}
    rates = Rates()
    every = kind == "all"
    if every or kind == "late":
        wrong["wrench_delay"] = float(rng.uniform(-0.02, 0.05))
    if every or kind in ("bias", "drift"):
        wrong["bias"] = tuple(20.0 * SCALE * rng.uniform(-1.0, 1.0, 6))
    if every or kind == "drift":
        wrong["drift"] = tuple(0.5 * SCALE * rng.uniform(-1.0, 1.0, 6))
        wrong["drift_kind"] = ("linear", "exponential")[rng.integers(2)]
    if every or kind == "spikes":
        wrong["spikes"] = float(rng.uniform(0.01, 0.06))
    if every or kind == "contact":
        wrong["contacts"] = float(rng.uniform(0.1, 0.3))
    if every or kind == "dropped":
        wrong["dropped"] = 0.1
    if every or kind == "flipped":
        wrong["on_sensor"] = True
    if kind == "coloured":
        wrong["noise_correlation"] = float(rng.uniform(0.6, 0.95))
    if kind == "few poses":
        rates = Rates(pose=rate / (2.0 if rate == 100.0 else 5.0))
    if kind == "imu":
        rates = Rates(imu=rate)
    recording = record(wielding, Faults(**wrong), rates, seed)
    return arrays(recording.streams)


def static_poses(wielding: Any, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Twenty poses at rest: turned any way, with the body's weight, noise and a
    bias."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.random(20, rng=rng)
    body, index = wielding.body, np.arange(20.0)
    force = turned.inv().apply(-body.mass * wielding.gravity)
    torque = np.cross(body.center_of_mass, force)
    wrench = np.hstack((force, torque)) + SCALE * (
        rng.normal(size=6) * 5.0 + rng.normal(size=(20, 6)) * 0.05
    )
    return {
        "orientation.time": index,
        "orientation.values": turned.as_quat(),
        "wrench.time": index,
        "wrench.values": wrench,
    }


def tilted(rng: np.random.Generator) -> np.ndarray:
    """Gravity (3,) [m/s²] in the axes of a base tilted by up to 15°."""
    from hefting.simulation import tilted_gravity

    return tilted_gravity(
        float(np.radians(rng.uniform(3.0, 15.0))), float(rng.uniform(0.0, 2.0 * np.pi))
    )


def arrays(streams: Any) -> dict[str, np.ndarray]:
    """Streams as arrays by name."""
    found = {}
    for name, stream in streams.items():
        found[f"{name}.time"] = np.array(stream.time)
        found[f"{name}.values"] = np.array(stream.values)
    return found


def read(folder: Path, facts: dict[str, Any]) -> Any:
    """One of the recordings."""
    from hefting import Recording, Stream

    with np.load(folder / f"{facts['name']}.npz", allow_pickle=False) as kept:
        names = [
            key.removesuffix(".time") for key in kept.files if key.endswith(".time")
        ]
        streams = {
            name: Stream(kept[f"{name}.time"], kept[f"{name}.values"]) for name in names
        }
    return Recording(streams, static=facts["kind"] == "static", source=facts["name"])
