"""JointDynamics: the torques of an arm's joints as a linear map of the inertial
parameters of its links and of the payload.

    tau = W(q, dq, ddq) pi + Y(q, dq, ddq) phi

W holds ten columns per link and comes from Pinocchio (extra `robot`). The payload is
fixed to the last moving link, so Y is the ten columns of that link times the constant
map from the payload's parameters, in sensor axes about the sensor's origin, to those of
the link. The arm's parameters are identifiable only up to base parameters: a set of
columns of W that spans the others in any motion is kept (Gautier & Khalil 1990).
"""

from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, needing
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    Indices,
    check_gravity,
    immutable,
    rotation_matrices,
    skew,
    tensor_to_vector,
    vector_to_tensor,
)
from hefting.robots import Robot
from hefting.robots.urdf import SCALAR, read_urdf

DRAWS = 200
"""Number of random states at which W is tested for independent columns: each gives n
equations for the 10 n columns of an arm of n joints."""
DEPENDENT = 1e-8
"""A column depends on those before it if the part of it that they do not span is
shorter than this, relative to the column."""
ORDER = np.array((0, 1, 2, 3, 4, 5, 7, 6, 8, 9))
"""Index in Pinocchio's order (m, mc, Jxx, Jxy, Jyy, Jxz, Jyz, Jzz) of each parameter in
the order of `core.spatial`."""


@immutable
class JointDynamics:
    """Rigid-body columns of the n joints that move a sensor frame; all other joints of
    the robot stay at zero."""

    robot: Robot
    """Kinematics, by `hefting.robots`"""
    model: Any = field(repr=False)
    """Pinocchio's model with these joints only"""

    @classmethod
    def from_urdf(
        cls, path: str | Path, sensor_frame: str, gravity: ArrayLike = STANDARD_GRAVITY
    ) -> Self:
        """Dynamics of a URDF whose link `sensor_frame` holds the payload; `gravity` (3,)
        is in root axes [m/s²].

        Raises `InputError` as `Robot.from_urdf` and `check_gravity`, for a frame that
        no joint moves, and for a mimic joint, or one with several positions, between
        root and frame; `MissingDependencyError` without Pinocchio.
        """
        tree = read_urdf(path)
        robot = Robot.from_tree(tree, sensor_frame)
        chain = [j for j in tree.chain(sensor_frame) if j.kind != "fixed"]
        if not chain:
            what = f"no joint moves the frame '{sensor_frame}'"
            raise InputError(what, path, "choose the link that holds the payload")
        for joint in chain:
            if joint.mimic is not None or joint.kind not in SCALAR:
                what = "it has no torque of its own"
                fix = "choose a frame that revolute or prismatic joints alone move"
                raise InputError(what, f"{path}, joint '{joint.name}'", fix)
        return cls(robot, _reduced(Path(path), robot.joints)).under(
            check_gravity(gravity)
        )

    def under(self, gravity: ArrayLike) -> Self:
        """The same arm under another `gravity` (3,), in root axes [m/s²]."""
        model = self.model.copy()
        model.gravity.linear = np.array(gravity, dtype=float)
        return type(self)(self.robot, model)

    @property
    def gravity(self) -> Array:
        """(3,) in root axes [m/s²]."""
        return np.array(self.model.gravity.linear)

    @property
    def efforts(self) -> Array:
        """(n,) effort limits of the joints in the URDF [N m], infinite if not given."""
        limits = np.array(self.model.effortLimit, dtype=float)
        return np.where(limits > 0.0, limits, np.inf)

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.robot.joints)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints, from the base to the sensor frame."""
        return self.robot.joints

    def regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """(K, n, 10 n) W: ten columns per link from the base on, in the axes of the
        link's joint; `q`, `dq` and `ddq` are (K, n) [rad, rad/s, rad/s²]."""
        import pinocchio as pin  # pyright: ignore[reportMissingImports]

        data = self.model.createData()
        values = self._configurations(q), dq, ddq
        W = np.empty((len(q), self.joints, 10 * self.joints))
        for k, (a, b, c) in enumerate(zip(*values, strict=True)):
            W[k] = pin.computeJointTorqueRegressor(self.model, data, a, b, c)
        by_link = W.reshape(len(q), self.joints, self.joints, 10)
        by_link[..., 6:8] = by_link[..., ORDER[6:8]]
        return W

    @cached_property
    def arm(self) -> Array:
        """(10 n,) parameters of the links in the URDF, in the order of W's columns."""
        inertias = list(self.model.inertias)[1:]
        return np.concatenate([each.toDynamicParameters()[ORDER] for each in inertias])

    @cached_property
    def base(self) -> Indices:
        """Indices of the columns of W that span the others in any motion."""
        return independent_columns(self._drawn)

    @cached_property
    def _drawn(self) -> Array:
        """(DRAWS n, 10 n) W at random states."""
        rng = np.random.default_rng(0)
        q, dq, ddq = rng.uniform(-1.5, 1.5, (3, DRAWS, self.joints))
        return self.regressor(q, dq, ddq).reshape(-1, 10 * self.joints)

    @cached_property
    def links(self) -> Array:
        """(b, 10 n) map of the links' parameters to base parameters, which give the same
        torques by the `base` columns alone."""
        W = self._drawn
        to_base = np.linalg.lstsq(W[:, self.base], W, rcond=None)[0]
        return np.asarray(to_base, dtype=float)

    @cached_property
    def payload(self) -> Array:
        """(10, 10) map T of a payload's parameters, in sensor axes about the sensor's
        origin, to those of the last link: Y = W[:, :, -10:] T."""
        import pinocchio as pin  # pyright: ignore[reportMissingImports]

        # pose of the sensor frame in the frame of Pinocchio's last joint, at q = 0
        zero = np.zeros((1, self.joints))
        position, orientation = self.robot.poses(zero)
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, self._configurations(zero)[0])
        joint = data.oMi[self.joints]
        R = np.asarray(joint.rotation)
        place = R.T @ (position[0] - np.asarray(joint.translation))
        return transfer(place, R.T @ rotation_matrices(orientation[0]))

    def _configurations(self, q: Array) -> Array:
        """(K, nq) joint positions for Pinocchio: continuous ones as cosine and sine."""
        columns: list[Array] = []
        for j, joint in enumerate(list(self.model.joints)[1:]):
            own = q[:, j]
            columns += [np.cos(own), np.sin(own)] if joint.nq == 2 else [own]
        return np.column_stack(columns)


def transfer(position: Array, rotation: Array) -> Array:
    """(10, 10) map of a body's parameters in one frame to those in another, in which
    the first has `position` (3,) [m] and `rotation` (3, 3)."""
    unit, P = np.eye(10), skew(position)
    m = unit[:, :1]
    moment = unit[:, 1:4] @ rotation.T
    H = skew(moment)
    J = rotation @ vector_to_tensor(unit[:, 4:]) @ rotation.T
    J = J - P @ H - H @ P - m[:, :, None] * (P @ P)
    columns = (m, moment + m * position, tensor_to_vector(J))
    return np.concatenate(columns, axis=1).T


def independent_columns(A: Array) -> Indices:
    """Increasing indices of columns of A (r, c) that span the others: each column that
    depends on those before it is left out (Gram-Schmidt)."""
    lengths = np.sqrt((A * A).sum(axis=0))
    lengths = np.where(lengths > DEPENDENT * lengths.max(), lengths, np.inf)
    left, kept = A / lengths, []
    for i in range(A.shape[1]):
        length = float(np.sqrt(left[:, i] @ left[:, i]))
        if length > DEPENDENT:
            kept.append(i)
            unit = left[:, i] / length
            left = left - np.outer(unit, unit @ left)
            left = left - np.outer(unit, unit @ left)  # again, against rounding
    return np.array(kept)


def _reduced(path: Path, joints: tuple[str, ...]) -> Any:
    """Pinocchio's model of these joints, with the others fixed at zero."""
    with needing("pinocchio", "robot"):
        import pinocchio as pin  # pyright: ignore[reportMissingImports]
    try:
        model = pin.buildModelFromXML(path.read_text(encoding="utf-8"))
    except (ValueError, RuntimeError) as error:
        first = str(error).splitlines()[0] if str(error) else "no reason given"
        raise InputError(f"Pinocchio does not read it: {first}", path) from None
    others = [model.getJointId(name) for name in model.names[1:] if name not in joints]
    return pin.buildReducedModel(model, others, pin.neutral(model))
