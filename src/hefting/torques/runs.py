"""Runs of a robot, loaded and empty, folded into one set of moments.

Offsets and frictions that a run without the payload shares with one that has it tell
the small mass from the large offset. They change slowly as the gears warm up: how much
of them may have changed between the runs is said by the standard deviations of two
nuisances that the loaded samples alone have.
"""

from __future__ import annotations

import numpy as np

from hefting.core.spatial import Array
from hefting.torques import equations
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OWN, Rows, width
from hefting.torques.samples import TorqueSamples
from hefting.torques.scales import TorqueScales

OFFSET_CHANGE = 0.02
"""[N m] Standard deviation of an offset's change between two runs, for each 10 N m of a
joint's usual torque: drift of a warm-up."""
FRICTION_CHANGE = 0.03
"""Standard deviation of the Coulomb friction's change between two runs, likewise."""
NO_CHANGE = 1e-4
"""[N m] Standard deviation of a change that is none."""


def no_samples(dynamics: JointDynamics, arm_known: bool = False) -> TorqueScales:
    """Moments before any sample."""
    arm = width(dynamics, arm_known)
    return TorqueScales.empty(dynamics.joints, len(OWN), arm)


def fold(
    scales: TorqueScales,
    dynamics: JointDynamics,
    samples: TorqueSamples,
    loaded: bool,
    arm_known: bool = False,
) -> TorqueScales:
    """With a run of samples, whole."""
    return scales.fold(Rows.of(dynamics, samples, loaded, arm_known))


def priors(dynamics: JointDynamics, drift: bool = True) -> Array:
    """(own, n) standard deviations of each joint's nuisances; infinite where nothing is
    known. Without `drift` the runs are parts of one recording."""
    found = np.full((len(OWN), dynamics.joints), np.inf)
    found[equations.OFFSET_CHANGE] = OFFSET_CHANGE if drift else NO_CHANGE
    found[equations.FRICTION_CHANGE] = FRICTION_CHANGE if drift else NO_CHANGE
    return found
