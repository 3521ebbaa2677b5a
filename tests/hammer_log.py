"""A log of a hammer for the command line, with its shape and the truth."""

import json

import numpy as np

from hefting.core.measurements import Noise
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids, truth

POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
POSE_TEXT = "0,-0.08,0.06,-0.7071067811865476,0,0,0.7071067811865476"


def log_folder(tmp_path_factory):
    """A folder with a log of five seconds, the mesh in millimetres, and the truth."""
    folder = tmp_path_factory.mktemp("cli")
    held = hammer()
    body = held.parameters.moved(POSE)
    motion = UR5.motion(sinusoids(5.0, 100.0, 1.5))
    write_log(
        simulate(
            motion, body, noise=Noise(0.1, 0.005), pose_noise=(1e-4, 3.5e-4), seed=3
        ),
        folder / "log.csv",
    )
    surface = held.mesh()
    surface.copy().apply_scale(1e3).export(folder / "mesh.stl")
    facts = truth(body, surface.extents, POSE, mesh_unit="mm", name=held.name)
    (folder / "truth.json").write_text(json.dumps(facts))
    return folder


def shape_options(folder):
    return ["--shape", folder / "mesh.stl", "--unit", "mm", "--object-pose", POSE_TEXT]


def edited(folder, tmp_path, change):
    """The log with `change` applied to its lines (header first), as a file."""
    lines = (folder / "log.csv").read_text().splitlines()
    path = tmp_path / "bad.csv"
    path.write_text("\n".join(change(lines)) + "\n")
    return path
