"""Real torques of a bare arm with a body added exactly, and the arm unknown."""

import os
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benchmarks.torques_real import BareArm, identified, random_bodies

DATA = Path(os.environ.get("HEFTING_TORQUES") or "no-torques")
pytestmark = pytest.mark.skipif(
    not (DATA / "bare_arm.csv").is_file(),
    reason="torques not there: set HEFTING_TORQUES to their folder",
)


@cache
def bare_arm() -> BareArm:
    return BareArm.read(DATA)


@pytest.mark.parametrize("split", ["first", "odd"])
def test_a_body_is_found_beside_an_unknown_arm(split):
    body = random_bodies(1, seed=7)[0]
    found = identified(bare_arm(), body, bare_arm().splits()[split])
    # measured over 80 identifications: 6 to 7.5 g; 0.8 mm an axis for 1.1 kg
    assert abs(found.mass) < 0.010
    assert np.abs(found.com).max() < 0.0015 * max(1.0, 1.1 / body.mass)
    # the intervals know it
    assert np.abs(found.z).max() < 2.5


def test_the_published_arm_in_place_of_the_empty_part_is_far_off():
    """Why an empty run is asked for: else this test would not be worth its data."""
    body = random_bodies(1, seed=7)[0]
    bare = bare_arm()
    known = identified(bare, body, bare.splits()["odd"], arm_known=True)
    assert abs(known.mass) > 0.03
