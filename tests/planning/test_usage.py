"""The grid on which a motion is held against its limits."""

import numpy as np
import pytest
from problems import problem

from hefting.planning.check import Usage
from hefting.planning.limits import CLEARANCE
from hefting.planning.optimise import random_motion


class Asked:
    """A space that keeps the positions of which it is asked."""

    def nearest(self, q):
        self.q = q
        return 0.1, "nothing"


@pytest.mark.parametrize("speed", [0.25, 1.0])
def test_between_looks_at_clearances_no_corner_passes_an_edge(speed):
    own = problem(duration=2.0)
    x = speed / 0.25 * random_motion(own, np.random.default_rng(0))
    trajectory = own.basis.trajectory(own.start, x)
    space, joints = Asked(), tuple(map(str, range(len(own.start))))
    usage = Usage.of(trajectory, own.chain, own.constraints, joints, space)
    assert usage.shares["corner_speed"] > 0.8 * speed / 0.25
    zero = np.zeros_like(space.q)
    tip = own.chain.forward(space.q, zero, zero).motion
    corners = np.einsum("ijk,cj->kci", tip.rotation, own.constraints.corners)
    corners = corners + tip.position.T[:, None]
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=2)
    # half an interval is to be a quarter of the clearance; rounding of the grid
    assert steps.max() < 0.51 * CLEARANCE
