"""Arms with masses, for simulated joint torques.

Published inertias of robots predict their torques poorly. So the true links differ from
those in the URDF of a simulated log.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, tensor_to_vector
from hefting.robots.inertials import ENTRIES
from hefting.simulation.arm import PANDA, UR5E, XARM7, Arm
from hefting.simulation.wield import numbers

RADIUS = 0.06
"""[m] Radius of a link, a rod from one joint to the next."""
LEAST_LENGTH = 0.05
"""[m] Least length of a link."""
WRONG_MASS, WRONG_COM, WRONG_INERTIA = 0.1, 0.008, 0.2
"""Standard deviations of the true links from the published ones: of mass and moments of
inertia relative, of the COM along each axis [m]."""


@immutable
class MassiveArm:
    """An arm with masses of its links and noise of its torques."""

    arm: Arm
    masses: tuple[float, ...]
    """[kg] of the links, published"""
    torque_noise: tuple[float, float]
    """standard deviations [N m] of the torques of the first and the last joint"""

    def __post_init__(self):
        if len(self.masses) != len(self.arm.robot.screws):
            raise InputError(
                f"{len(self.masses)} masses for {len(self.arm.robot.screws)} links"
            )

    @cached_property
    def links(self) -> tuple[InertialParameters, ...]:
        """Published links, in base axes with all joints at zero, each about a point on
        its joint's axis."""
        robot = self.arm.robot
        points = [screw.point for screw in robot.screws]
        ends = [*points[1:], robot.home_position]
        return tuple(
            _rod(mass, end - point)
            for mass, point, end in zip(self.masses, points, ends, strict=True)
        )

    def true_links(self, seed: int) -> tuple[InertialParameters, ...]:
        """Links of the robot of a `seed`, in the same axes."""
        rng = np.random.default_rng([seed, 41])
        return tuple(_changed(link, rng) for link in self.links)

    @property
    def urdf(self) -> str:
        """URDF text with the published links; the last link is ``flange``."""
        return urdf(self.arm, self.links)

    def per_joint(self, first: float, last: float) -> Array:
        """(n,) values from `first` at the base to `last`, in geometric progression."""
        return np.geomspace(first, last, self.arm.n)


def urdf(arm: Arm, links: Sequence[InertialParameters]) -> str:
    """The URDF of an arm, with links as in `MassiveArm.links`."""
    robot = arm.robot
    lines = ['<robot name="arm">', '<link name="base"/>']
    place, parent = np.zeros(3), "base"
    for i, (screw, link) in enumerate(zip(robot.screws, links, strict=True), 1):
        low, high = robot.limits[screw.column] or (-1.0, 1.0)
        speed = 10.0 if arm.joint_speeds is None else arm.joint_speeds[screw.column]
        kind = "prismatic" if screw.slides else "revolute"
        own = f"link{i}"
        lines += [
            f'<joint name="{robot.joints[screw.column]}" type="{kind}">'
            f'<origin xyz="{numbers(screw.point - place)}"/>'
            f'<parent link="{parent}"/><child link="{own}"/>'
            f'<axis xyz="{numbers(screw.axis)}"/>'
            f'<limit lower="{low!r}" upper="{high!r}" effort="1000" '
            f'velocity="{float(speed)!r}"/>'
            "</joint>",
            f'<link name="{own}">{_inertial(link)}</link>',
        ]
        place, parent = screw.point, own
    rpy = Rotation.from_quat(robot.home_orientation).as_euler("xyz")
    lines += [
        '<joint name="flange_joint" type="fixed">'
        f'<origin xyz="{numbers(robot.home_position - place)}" rpy="{numbers(rpy)}"/>'
        f'<parent link="{parent}"/><child link="flange"/></joint>',
        '<link name="flange"/>',
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def _inertial(link: InertialParameters) -> str:
    values = zip(ENTRIES, tensor_to_vector(link.inertia_at_com).tolist(), strict=True)
    inertia = " ".join(f'{name}="{value!r}"' for name, value in values)
    return (
        f'<inertial><origin xyz="{numbers(link.center_of_mass)}"/>'
        f'<mass value="{float(link.mass)!r}"/><inertia {inertia}/></inertial>'
    )


def _rod(mass: float, along: Array) -> InertialParameters:
    """A cylinder from the origin to the point `along` (3,) [m]."""
    length = max(float(np.linalg.norm(along)), LEAST_LENGTH)
    unit = along / length if np.linalg.norm(along) > 1e-6 else np.array((0.0, 0.0, 1.0))
    across = mass * (3.0 * RADIUS**2 + length**2) / 12.0
    spin = 0.5 * mass * RADIUS**2
    J = across * np.eye(3) + (spin - across) * np.outer(unit, unit)
    return InertialParameters.from_com(mass, 0.5 * along, J)


def _changed(link: InertialParameters, rng: np.random.Generator) -> InertialParameters:
    mass = link.mass * np.exp(WRONG_MASS * rng.standard_normal())
    com = link.center_of_mass + WRONG_COM * rng.standard_normal(3)
    J = link.inertia_at_com * np.exp(WRONG_INERTIA * rng.standard_normal())
    return InertialParameters.from_com(float(mass), com, J)


TORQUE_ARMS = {
    "ur5e": MassiveArm(UR5E, (3.7, 8.4, 2.3, 1.2, 1.2, 0.2), (0.1, 0.05)),
    "panda": MassiveArm(PANDA, (3.1, 2.4, 3.2, 2.5, 3.4, 1.5, 0.7), (0.1, 0.05)),
    "xarm7": MassiveArm(XARM7, (2.4, 1.9, 1.7, 1.8, 1.5, 1.1, 0.3), (0.1, 0.05)),
}
"""Arms with masses, by name: about the makers' values."""
