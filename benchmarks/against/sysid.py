"""mujoco.sysid: least squares over a MuJoCo model, its motion replayed by inverse
dynamics.

The package identifies a model from trajectories that it rolls out. An object on a
sensor whose motion is known is not rolled out: the hook `custom_rollout` sets velocity
and acceleration of each sample and reads the model's own force and torque sensors
(`mj_inverse`); gravity is part of the acceleration, so the sensor's axes are the
world's. The hook `modify_residual` divides by the noise: without it the package divides
each channel by the size of its signal.

The guess is the homogeneous body of the shape, as heavy as the median force says. Two
parametrisations (docs/peers.md has what else was tried):

- ``MassIpos``, the package's default, scaling the inertia with the mass: four numbers;
  the inertia stays that of the guess but for its scale and where it is.
- ``Pseudo``, ten numbers, log-Cholesky. Its own modifier raises an error in 4.0.0, as it
  leaves the diagonal inertia zero, so another one writes the same numbers. The bounds of
  COM and shear are the shape's, those of mass and stretch the package's.

Both scale the parameters by the Jacobian (``x_scale="jac"``), which takes half the time
of none, and stop at steps of 1e-5, where the default 1e-8 finds the same to three digits
in twice the time.
"""

import io
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid

from benchmarks.against.party import Answer, NoAnswerError, Party, Task
from benchmarks.bodies import sixteen
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array

MODEL = """<mujoco><option gravity="0 0 0"/><worldbody><body name="object"><freejoint/>
<inertial pos="0 0 0" mass="1" fullinertia="1 1 1 0 0 0"/><site name="sensor"/>
</body></worldbody><sensor><force name="force" site="sensor"/>
<torque name="torque" site="sensor"/></sensor></mujoco>"""
GRAVITY = 9.80665
"""By which the guess of the mass is found [m/s²]."""
TOLERANCE = 1e-5
"""Of the steps."""
SIDES = 0.5, 0.25
"""Bounds of COM and shear about the guess, of the longest side: the COM stays in the
shape's box, and the shear is at most that of a body in it."""
STEP = 1e-6
"""Of the numerical derivative of ten numbers by the package's parameters."""


def homogeneous(task: Task) -> InertialParameters:
    """The guess."""
    mass = float(np.median(np.linalg.norm(task.z.force, axis=1))) / GRAVITY
    return InertialParameters(mass * task.shape.homogeneous.vector)


def write_body(spec: Any, body: InertialParameters) -> None:
    """Into the model's object."""
    J = body.inertia_at_com
    target = spec.body("object")
    target.explicitinertial = True
    target.mass, target.ipos = body.mass, body.center_of_mass
    target.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]


def log_cholesky(theta: Array) -> InertialParameters:
    """The body of ``InertiaType.Pseudo``'s numbers: alpha, d1, d2, d3, s12, s23, s13,
    t1, t2, t3 (Rucker & Wensing 2022)."""
    alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3 = theta
    U = np.array(
        (
            (np.exp(d1), s12, s13, t1),
            (0.0, np.exp(d2), s23, t2),
            (0.0, 0.0, np.exp(d3), t3),
            (0.0, 0.0, 0.0, 1.0),
        )
    )
    return InertialParameters.from_pseudo_inertia(np.exp(2.0 * alpha) * U @ U.T)


def replay(z: Measurements) -> Callable[..., Sequence[Any]]:
    """A hook that finds what the model's sensors read along the motion of z."""
    acceleration = np.hstack(
        (z.linear_acceleration - z.gravity, z.angular_acceleration)
    )
    velocity = np.hstack((np.zeros((len(z), 3)), z.angular_velocity))
    resting = np.column_stack((z.time, np.zeros((len(z), 13))))

    def rolled_out(models, control_signal, initial_states, **mappings):
        found = []
        for model in models:
            data, read = mujoco.MjData(model), np.empty((len(z), 6))
            for k in range(len(z)):
                data.qvel[:] = velocity[k]
                data.qacc[:] = acceleration[k]
                mujoco.mj_inverse(model, data)
                read[k] = data.sensordata
            signals = sysid.TimeSeries(z.time, read, mappings["rollout_signal_mapping"])
            states = sysid.TimeSeries(z.time, resting)
            found.append(
                sysid.SystemTrajectory(
                    model, control_signal[0], signals, initial_states[0], states
                )
            )
        return found

    return rolled_out


def by_noise(task: Task) -> Callable[..., Any]:
    """A hook that makes residuals in standard deviations."""
    levels = np.repeat((task.noise.force, task.noise.torque), 3)

    def residual(params, predicted, measured, model, return_all, **_):
        return (predicted.data - measured.data) / levels, measured, measured

    return residual


def found_by(task: Task, spec: Any, parameter: Any) -> tuple[Array, Array]:
    """The parameter's values (n,) and their covariance (n, n)."""
    z, model = task.z, spec.compile()
    signals = sysid.TimeSeries.from_names(z.time, z.wrench, model)
    still = sysid.TimeSeries(z.time, np.zeros((len(z), 0)))
    start = sysid.create_initial_state(model, model.qpos0)
    sequences = sysid.ModelSequences("object", spec, "recording", start, still, signals)
    residual = sysid.build_residual_fn(
        models_sequences=[sequences],
        custom_rollout=replay(z),
        modify_residual=by_noise(task),
        n_threads=1,
        resample_true=False,
    )
    parameters = sysid.ParameterDict()
    parameters.add(parameter)
    try:
        found, result = sysid.optimize(
            parameters,
            residual,
            optimizer="mujoco",
            verbose=False,
            x_scale="jac",
            xtol=TOLERANCE,
            output=io.StringIO(),
        )
    except ValueError as error:  # a body that MuJoCo refuses to compile
        raise NoAnswerError(str(error)) from error
    left, _, _ = residual(result.x.ravel(), found)
    covariance, _ = sysid.calculate_intervals(left, result.jac)
    return found.as_vector(), covariance


def answered(
    body_of: Callable[[Array], InertialParameters],
    values: Array,
    covariance: Array,
    known: int,
) -> Answer:
    """With intervals of the first `known` of ten numbers, their covariance that of the
    values carried on to first order; NaN for the others."""
    body = body_of(values)
    J = np.empty((10, len(values)))
    for i in range(len(values)):
        step = STEP * np.eye(len(values))[i]
        pair = (sixteen(body_of(values + s * step))[:10] for s in (1.0, -1.0))
        J[:, i] = np.subtract(*pair) / (2.0 * STEP)
    middle = sixteen(body)[:10]
    half = 1.96 * np.sqrt(np.einsum("ij,jk,ik->i", J, covariance, J))
    half[known:] = np.nan
    return Answer(body, middle - half, middle + half)


def mass_and_com(task: Task, _: None) -> Answer:
    """Four numbers: the inertia about the COM is the guess's, scaled with the mass."""
    guess, spec = homogeneous(task), mujoco.MjSpec.from_string(MODEL)
    write_body(spec, guess)
    parameter = sysid.body_inertia_param(
        spec, spec.compile(), "object", scale_rot_inertia=True
    )

    def body_of(values: Array) -> InertialParameters:
        scale = values[0] / guess.mass
        return InertialParameters.from_com(
            values[0], values[1:], scale * guess.inertia_at_com
        )

    return answered(body_of, *found_by(task, spec, parameter), known=4)


def ten_numbers(task: Task, _: None) -> Answer:
    """Log-Cholesky, bounded by the shape."""
    spec = mujoco.MjSpec.from_string(MODEL)
    write_body(spec, homogeneous(task))
    side = float(task.shape.extents.max())
    com, shear = (share * side * np.array((-1.0, 1.0)) for share in SIDES)
    parameter = sysid.body_inertia_param(
        spec.copy(),
        spec.compile(),
        "object",
        inertia_type=sysid.InertiaType.Pseudo,
        ipos_bound_off=com,
        shear_bound_off=shear,
        modifier=lambda s, p: write_body(s, log_cholesky(p.value)),
    )
    return answered(log_cholesky, *found_by(task, spec, parameter), known=10)


def parties() -> list[Party]:
    """Both parametrisations."""
    return [
        Party(
            f"mujoco.sysid, {name}",
            identify,
            beside="Hefting Bayes",
            peer=True,
            method=f"mujoco.sysid, {name}",
        )
        for name, identify in (
            ("mass and COM", mass_and_com),
            ("ten parameters", ten_numbers),
        )
    ]
