"""The page that plays a planned motion."""

import time
from dataclasses import replace

import numpy as np
import pytest

from browser import COARSE, DESKTOP, browsing, needs_browser
from folding_arm import folding_arm
from hefting.core.errors import InputError
from hefting.viewer.drawing import EDGES
from hefting.viewer.player import plan_player
from plans import random_plan

BOX = np.array(
    [[x, y, z] for x in (-0.05, 0.1) for y in (-0.05, 0.05) for z in (0, 0.2)]
)
SCENE = {"x": 500, "y": 150, "width": 700, "height": 550}
"""[pixels] Beside the text, above the bar that moves."""


def plan_of(tmp_path):
    plan = random_plan(4, duration=2.0, source=folding_arm(tmp_path), size=0.5)
    return replace(plan, corners=np.vstack((np.zeros(3), BOX)))


def test_edges_are_those_of_a_box():
    """Twelve, four along each axis, as long as the box."""
    steps = np.array([BOX[j] - BOX[i] for i, j in EDGES])
    assert len(set(EDGES)) == 12
    lengths = np.ptp(BOX, axis=0)
    for axis, length in enumerate(lengths):
        along = steps[steps[:, axis] != 0.0]
        assert len(along) == 4
        wanted = np.zeros(3)
        wanted[axis] = length
        np.testing.assert_allclose(along, np.tile(wanted, (4, 1)), atol=1e-15)


@needs_browser
def test_it_plays_from_disk_without_a_network(tmp_path, browser):
    plan = replace(plan_of(tmp_path), tip="tool")
    file = tmp_path / "plan.html"
    file.write_text(plan_player(plan))
    assert file.stat().st_size < 5_000_000
    with browsing(browser, DESKTOP, offline=True) as visit:
        page = visit.page
        page.goto(file.as_uri() + COARSE)
        page.get_by_text("250 mm/s").wait_for(timeout=30_000)
        assert page.title() == "arm.urdf: planned motion - Hefting"
        # nothing yet, the arm at rest, and it plays: until it moves again
        seen, ends = set(), time.monotonic() + 60.0
        while len(seen) < 4:
            assert time.monotonic() < ends
            seen.add(page.screenshot(clip=SCENE))
            page.wait_for_timeout(50)
    assert visit.problems == []
    assert visit.foreign == []


def test_a_robot_that_is_gone_is_named(tmp_path):
    plan = replace(plan_of(tmp_path), source=str(tmp_path / "gone.urdf"))
    with pytest.raises(InputError, match=r"gone\.urdf"):
        plan_player(plan)
