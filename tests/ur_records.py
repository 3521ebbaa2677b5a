"""Real-time records of Universal Robots, from known flange poses and wrenches by their
definitions."""

from pathlib import Path

import numpy as np

from hefting.core.spatial import Array
from hefting.logs.ur_csv import FIELDS

COUNT = 20
RNG = np.random.default_rng(7)


def rotation(vector: Array) -> Array:
    """Rodrigues' formula: rotation vector to matrix."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle if angle else vector
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def rotation_vector(matrix: Array) -> Array:
    """The vector of a rotation by less than pi, from its skew part and trace."""
    skew = (
        np.array(
            [
                matrix[2, 1] - matrix[1, 2],
                matrix[0, 2] - matrix[2, 0],
                matrix[1, 0] - matrix[0, 1],
            ]
        )
        / 2
    )
    sine = np.linalg.norm(skew)
    return skew / sine * np.arctan2(sine, (np.trace(matrix) - 1) / 2)


VECTORS = RNG.uniform(-1, 1, (COUNT, 3))
FLANGE = np.array([rotation(vector) for vector in VECTORS])
ORIGIN = RNG.uniform(-0.5, 0.5, (COUNT, 3))
WRENCH = RNG.normal(size=(COUNT, 6)) * 10  # flange axes
TURNING, MOVING = RNG.normal(size=(2, COUNT, 3))  # of the flange, base axes
TIME = 1234.5 + np.arange(COUNT) * 0.008
OFFSET = np.array([0.01, -0.02, 0.15, 0.3, -0.2, 0.5])
NO_OFFSET = np.zeros(6)


def record(
    path: Path,
    *fields: str,
    offset: Array = NO_OFFSET,
    separator: str = " ",
    **changes: Array,
) -> Path:
    """A record of these fields, for a TCP at `offset` in the flange; some fields
    changed."""
    lever = FLANGE @ offset[:3]
    tcp = FLANGE @ rotation(offset[3:])
    base = np.concatenate(
        [
            np.einsum("nij,nj->ni", FLANGE, part)
            for part in (WRENCH[:, :3], WRENCH[:, 3:])
        ],
        axis=1,
    )
    joints = RNG.uniform(-3, 3, (COUNT, 12))
    values = {
        "timestamp": TIME[:, None],
        "actual_TCP_pose": np.concatenate(
            [ORIGIN + lever, [rotation_vector(matrix) for matrix in tcp]], axis=1
        ),
        "actual_TCP_speed": np.concatenate(
            [MOVING + np.cross(TURNING, lever), TURNING], axis=1
        ),
        "tcp_offset": np.tile(offset, (COUNT, 1)),
        "ft_raw_wrench": WRENCH,
        "actual_TCP_force": base,
        "payload": np.zeros((COUNT, 1)),
        "actual_q": joints[:, :6],
        "actual_qd": joints[:, 6:],
        "robot_mode": np.full((COUNT, 1), 7),
        **changes,
    }
    chosen = [name for name in ("timestamp", *fields) if name in values]
    names = [
        f"{name}_{j}" if values[name].shape[1] > 1 else name
        for name in chosen
        for j in range(values[name].shape[1])
    ]
    table = np.concatenate([values[name] for name in chosen], axis=1)
    lines = [separator.join(map(repr, row)) for row in table.tolist()]
    path.write_text("\r\n".join([separator.join(names), *lines, ""]))
    return path


ALL = (*FIELDS, "robot_mode")
FORCE_ONLY = ("actual_TCP_pose", "actual_TCP_force", "payload", "tcp_offset")
