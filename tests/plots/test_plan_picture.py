"""The picture of a plan shows the plan's own numbers."""

from dataclasses import replace

import numpy as np
import pytest

from folding_arm import folding_arm
from hasty_pictures import draw_hastily
from hefting.core.accuracy import Accuracy
from hefting.core.messages import note
from hefting.core.spatial import rotation_matrices
from hefting.planning.held import BOX_ASSUMED
from hefting.planning.result import corner_speeds
from hefting.plots import picture_of, plot_plan
from hefting.plots.plan import JOINTS
from hefting.robots import Robot
from plans import random_plan

ASKED = Accuracy.parse("mass=1%,com=2mm,inertia=20%")


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    source = folding_arm(tmp_path_factory.mktemp("plan"))
    return random_plan(4, source=source, size=0.4, asked=ASKED)


@pytest.fixture(scope="module")
def rows(plan):
    return plot_plan(plan).axes


def test_corner_speeds_are_those_of_the_corners_positions(plan):
    """Central differences of positions by the robot's poses."""
    h, motion = 1e-5, plan.motion
    robot = Robot.from_urdf(plan.source, plan.tip)

    def corners(time):
        position, orientation = robot.poses(plan.at(time).position)
        turned = np.einsum("kij,cj->kci", rotation_matrices(orientation), plan.corners)
        return position[:, None] + turned

    inside = slice(1, -1)
    time = motion.time[inside]
    speed = (corners(time + h) - corners(time - h)) / (2 * h)
    wanted = np.linalg.norm(speed, axis=2).max(axis=1)
    # h² times a third derivative of some 1e3 m/s³
    np.testing.assert_allclose(corner_speeds(plan)[inside], wanted, atol=1e-6)


def test_the_box_is_the_object_s_or_is_assumed(plan, rows):
    title = rows[2].get_title(loc="right")
    assert title == "speed of the fastest corner of the object's box"
    assumed = replace(plan, notes=(note(BOX_ASSUMED, "no shape given"),))
    title = plot_plan(assumed).axes[2].get_title(loc="right")
    assert title == "speed of the fastest corner of the assumed box"


def test_each_row_shows_what_it_says(plan, rows):
    joints, shares, corner, widths = rows
    drawn = [line for line in joints.get_lines() if len(line.get_xdata()) > 2]
    for line, q, name in zip(drawn, plan.motion.position.T, plan.joints, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), q)
        assert line.get_label() == name
    speed = np.max(np.abs(plan.motion.velocity) / plan.limits.speed, axis=1)
    np.testing.assert_allclose(shares.get_lines()[0].get_ydata(), 100 * speed)
    fastest = 1e3 * corner_speeds(plan)
    np.testing.assert_array_equal(corner.get_lines()[0].get_ydata(), fastest)
    limit = corner.get_lines()[1].get_ydata()
    np.testing.assert_array_equal(limit, 1e3 * plan.limits.corner_speed)
    assert corner.get_ylim()[1] > fastest.max()
    mass = next(x for x in widths.get_lines() if x.get_label() == "mass [%]")
    wanted = [100 * each.mass for each in plan.forecast.accuracy]
    np.testing.assert_allclose(mass.get_ydata(), wanted)
    np.testing.assert_array_equal(mass.get_xdata(), plan.forecast.time)


def test_half_widths_are_whole_at_the_end_and_beside_numbers(plan):
    """Also where they are within a power of ten, whose ends alone had numbers."""
    axes = plot_plan(replace(plan, asked=None)).axes[3]
    axes.set_ylim(2.0, 50.0)
    assert all(not line.get_clip_on() for line in axes.get_lines())
    low, high = axes.get_ylim()
    assert sum(low <= tick <= high for tick in axes.get_yticks()) >= 3


def test_what_is_open_is_not_drawn(plan, rows):
    inertia = next(x for x in rows[3].get_lines() if x.get_label() == "inertia [%]")
    assert plan.forecast.accuracy[0].inertia == np.inf
    assert np.isnan(inertia.get_ydata()[0])
    assert np.isfinite(inertia.get_ydata()[1:]).all()


def test_what_is_asked_is_dashed(plan, rows):
    heights = {float(x.get_ydata()[0]) for x in rows[3].get_lines() if len(x.get_xdata()) == 2}  # fmt: skip
    assert heights == {1.0, 2.0, 20.0}
    bare = plot_plan(replace(plan, asked=None)).axes[3]
    assert len(bare.get_lines()) == 3


def test_limits_are_drawn_where_they_are_in_view(plan, rows):
    near = replace(
        plan, limits=replace(plan.limits, position=np.array([[-9.0, 0.1]] * 4))
    )
    lines = plot_plan(near).axes[0].get_lines()
    ends = [x for x in lines if len(x.get_xdata()) == 2]
    assert [float(x.get_ydata()[0]) for x in ends] == [0.1] * 4
    low, high = rows[0].get_ylim()
    ends = plan.limits.position.ravel()
    in_view = ((ends >= low) & (ends <= high)).sum()
    assert len(rows[0].get_lines()) == 4 + in_view


@pytest.mark.parametrize("length", [3, 60])
def test_names_of_any_length_stay_in_the_picture(plan, length):
    names = tuple(f"{'x' * length}{i}" for i in range(4))
    figure = plot_plan(replace(plan, joints=names))
    (legend,) = figure.subfigs[0].legends if figure.subfigs else figure.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.width


def test_joints_are_named_above_them_in_order_and_have_lines_of_their_own(plan):
    names = tuple(f"joint{i}" for i in range(1, 5))
    figure = plot_plan(replace(plan, joints=names))
    (legend,) = figure.subfigs[0].legends
    assert legend.get_window_extent().y0 > figure.axes[0].get_window_extent().y1
    looks = [(str(x["color"]), x["linestyle"]) for x in JOINTS]
    assert len(set(looks)) == len(JOINTS) == 18
    drawn = [x for axes in figure.axes[1:] for x in axes.get_lines()]
    assert not {x.get_color() for x in drawn} & {colour for colour, _ in looks}


def test_what_is_expected_is_told_from_what_is_asked_by_its_mark(rows):
    curves = [x for x in rows[3].get_lines() if len(x.get_xdata()) > 2]
    marks = {x.get_label(): x.get_marker() for x in curves}
    assert len(set(marks.values())) == 3
    lines = [x for x in rows[3].get_lines() if len(x.get_xdata()) == 2]
    asked = {float(x.get_ydata()[0]): x.get_marker() for x in lines}
    assert asked == {
        1.0: marks["mass [%]"],
        2.0: marks["COM [mm]"],
        20.0: marks["inertia [%]"],
    }


def test_the_same_plan_is_drawn_with_the_same_bytes(plan, monkeypatch):
    draw_hastily(monkeypatch)
    figures = [plot_plan(plan) for _ in range(2)]
    for suffix in (".png", ".svg", ".pdf"):
        first, second = (picture_of(figure, suffix) for figure in figures)
        assert first == second, suffix
