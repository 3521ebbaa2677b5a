"""Demonstration: a simulated arm wields a hammer, which is identified from the log."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.accuracy import Errors, errors_between
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.files import write_atomically
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS
from hefting.export import export
from hefting.identification import identify
from hefting.logs import write_log
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids, truth
from hefting.simulation.objects import HAMMER_POSE
from hefting.simulation.wield import POSE_NOISE

DURATION, RATE, ANGULAR_SPEED = 10.0, 100.0, 1.0
"""Length [s], samples per second and mean angular speed [rad/s] of the recording."""
NOISE = "moderate"
SEED = 2022
POSE = HAMMER_POSE


@dataclass(frozen=True)
class Demo:
    """Truth, estimate and files of the demonstration."""

    log: Path
    """Recording of the robot."""
    mesh: Path
    """Surface of the hammer [mm], without materials."""
    truth_file: Path
    """True parameters."""
    exports: tuple[Path, ...]
    """The estimate as JSON and URDF."""
    pictures: tuple[Path, ...]
    """PNG and SVG; none without matplotlib."""
    speeds: tuple[float, float]
    """Mean angular [rad/s] and linear [m/s] speed of the sensor."""
    truth: InertialParameters
    """True parameters in the sensor frame."""
    estimate: Estimate
    errors: Errors
    """Of the estimate [%]."""

    @property
    def files(self) -> tuple[Path, ...]:
        """Every file written."""
        return (self.log, self.mesh, self.truth_file, *self.exports, *self.pictures)


def run(folder: str | Path, pictures: bool = True) -> Demo:
    """Simulate, write the log, identify from the files as a user would, and write
    results to `folder`; the same every time.

    A UR5 moves as in the paper (`hefting.simulation.sinusoids`), with the paper's
    moderate noise of the wrench. Raises `InputError` if the folder cannot be written or
    contains another log, and `MissingDependencyError` for pictures without matplotlib.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be made a folder ({error.strerror})", where=folder
        ) from error
    log = folder / "log.csv"
    mesh_file = folder / "hammer.stl"
    truth_file = folder / "truth.json"
    if log.exists() and not mesh_file.exists():
        raise InputError("holds a log of something else", log, "name another folder")

    held = hammer()
    body = held.parameters.moved(POSE)
    motion = UR5.motion(sinusoids(DURATION, RATE, ANGULAR_SPEED))
    write_log(
        simulate(
            motion, body, noise=NOISE_LEVELS[NOISE], pose_noise=POSE_NOISE, seed=SEED
        ),
        log,
    )
    surface = held.mesh()
    extents = surface.extents
    write_atomically(mesh_file, surface.copy().apply_scale(1e3).export(file_type="stl"))
    facts = truth(body, extents, POSE, mesh_unit="mm", name=held.name)
    write_atomically(truth_file, json.dumps(facts, indent=1) + "\n")

    shape = Shape.from_mesh(mesh_file, unit="mm", pose=POSE)
    result = identify(log, shape)
    estimate = result.estimate
    exports = (folder / "estimate.json", folder / "estimate.urdf")
    estimate.save(exports[0])
    write_atomically(exports[1], export(estimate, "urdf", name=held.name).text)

    drawn: tuple[Path, ...] = ()
    if pictures:
        from hefting.plots import plot_object, plot_wrench, save_figure

        drawn = save_figure(
            plot_wrench(result.measurements, estimate), folder / "wrench"
        )
        drawn += save_figure(plot_object(estimate, shape, body), folder / "object")
    axes = np.asarray(POSE)[:3, :3]
    return Demo(
        log=log,
        mesh=mesh_file,
        truth_file=truth_file,
        exports=exports,
        pictures=drawn,
        speeds=motion.mean_speeds,
        truth=body,
        estimate=estimate,
        errors=errors_between(estimate.parameters, body, extents, axes),
    )
