"""What the tests of the viewer look at: a hammer on the simulated arm, with its joint
positions, and the arm's URDF with one mesh."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.ingest.ingest import ingest
from hefting.shapes import Shape
from hefting.simulation import UR5, Assembly, hammer, simulate, sinusoids
from hefting.viewer import Playback, Session
from urdfs import SIX, UR5_URDF

POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
"""Of the hammer in the sensor frame."""
HOSTILE = "<img src=x onerror=alert(1)>"
"""Text that is markup where it is not escaped."""
ARM = UR5_URDF.replace(
    "<link name='forearm'/>",
    "<link name='forearm'><visual><origin xyz='0 0 0.01'/><geometry>"
    "<mesh filename='package://ur5/meshes/forearm.stl' scale='2 2 2'/></geometry>"
    "</visual></link>",
)
"""The arm, of which one link has a mesh."""


def held() -> Assembly:
    """What is held."""
    return hammer()


def recorded() -> Recording:
    """Five seconds of the arm wielding it, at 100 Hz, with the joint positions."""
    joints = sinusoids(5.0, 100.0, 1.5)
    body = held().parameters.moved(POSE)
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4), "seed": 3}
    log = simulate(UR5.motion(joints), body, **noise)
    stream = Stream(log["position"].time, joints.position)
    streams = {**log.streams, "joint_positions": stream}
    return replace(log, streams=streams, joint_names=SIX)


def write_arm(folder: Path) -> Path:
    """The arm's URDF, and its mesh in a folder below."""
    (folder / "meshes").mkdir()
    held().mesh().export(folder / "meshes" / "forearm.stl")
    path = folder / "ur5.urdf"
    path.write_text(ARM)
    return path


def shape() -> Shape:
    """Its mesh, filled with points."""
    return Shape.from_mesh(held().mesh(), pose=POSE, points=56)


def viewed(**given: object) -> tuple[Session, Playback, Recording]:
    """A session on the recording, with the shape unless another is given."""
    recording = recorded()
    found = ingest(recording)
    given = {"shape": shape()} | given
    return Session(found, **given), Playback(recording, found), recording  # type: ignore[arg-type]
