"""Pictures: what they show, that they are written whole, and that they are the same
every time."""

import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip(
    "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
)

from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text

from hasty_pictures import draw_hastily
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.messages import error
from hefting.core.regressor import predict_wrench
from hefting.plots.body import plot_identification, plot_object, plot_shape
from hefting.plots.style import (
    DRAWN,
    draw_legend,
    drawing,
    lines_of,
    save_figure,
    style,
    subfigures_of,
)
from hefting.plots.views import VIEWS
from hefting.plots.wrench import plot_wrench
from hefting.scene import Headline, uniform_ellipsoid
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, sinusoids, wield
from hefting.simulation.demo import POSE

UNPHYSICAL = InertialParameters.from_com(
    0.5, (0.0, 0.1, 0.0), np.diag((1e-3, 1e-3, 5e-3))
)


@pytest.fixture(autouse=True)
def layout(request, monkeypatch):
    """Most of the time of drawing goes into the layout: only where it is looked at."""
    looked_at = (
        test_nothing_overlaps_or_leaves_the_picture,
        test_legends_of_several_rows_are_read_from_left_to_right,
    )
    if request.function not in looked_at:
        draw_hastily(monkeypatch)


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), points=60)


@pytest.fixture(scope="module")
def measurements():
    motion = UR5.motion(sinusoids(2.0, 50.0, 1.0))
    return wield(motion, hammer().parameters).with_noise(
        NOISE_LEVELS["moderate"], seed=1
    )


BODY = hammer().parameters


def collections(axes, label):
    """Those of a view whose label begins so."""
    return [c for c in axes.collections if str(c.get_label()).startswith(label)]


def texts(figure):
    return [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]


def words(figure):
    """All that is written in a picture."""
    return "\n".join(text.get_text() for text in texts(figure))


def estimate_of(parameters: InertialParameters, **more) -> Estimate:
    return Estimate("PMD", parameters, samples=100, **({"duration": 2.0} | more))


def test_wrench_shows_measured_predicted_and_the_difference(measurements):
    body, bias = hammer().parameters, np.array((1.0, -2.0, 0.5, 0.1, 0.2, -0.3))
    figure = plot_wrench(measurements, estimate_of(body, bias=bias))
    rows = figure.axes
    assert [axes.get_ylabel() for axes in rows] == [
        "Force [N]",
        "[N]",
        "Torque [N m]",
        "[N m]",
    ]
    assert rows[-1].get_xlabel() == "Time [s]"
    predicted = predict_wrench(measurements, body.vector) + bias
    for part, whole, rest in ((0, rows[0], rows[1]), (3, rows[2], rows[3])):
        lines = [line.get_ydata() for line in whole.lines]
        for i in range(3):
            np.testing.assert_array_equal(
                lines[2 * i], measurements.wrench[:, part + i]
            )
            np.testing.assert_array_equal(lines[2 * i + 1], predicted[:, part + i])
            residual = rest.lines[i].get_ydata()
            np.testing.assert_array_equal(
                residual, measurements.wrench[:, part + i] - predicted[:, part + i]
            )
    assert figure.get_figwidth() == 3.5


def test_a_long_recording_is_thinned(measurements):
    long = measurements[np.tile(np.arange(100), 40)]
    line = plot_wrench(long, estimate_of(hammer().parameters)).axes[0].lines[0]
    assert len(line.get_xdata()) == DRAWN


def test_time_may_be_that_of_the_log(measurements):
    figure = plot_identification(measurements, estimate_of(BODY), start=-0.65)
    first = figure.axes[-1].lines[0].get_xdata()[0]
    assert first == pytest.approx(measurements.time[0] + 0.65)


def test_no_line_is_drawn_over_a_gap(measurements):
    """Of half a second, as between recordings: as in a page."""
    apart = replace(measurements, time=measurements.time + 0.5 * (np.arange(100) >= 40))
    figure = plot_wrench(apart, estimate_of(BODY))
    for axes in figure.axes:
        for line in axes.lines:
            y = np.asarray(line.get_ydata(), dtype=float)
            if len(y) > 2:  # but the line at zero
                assert np.flatnonzero(np.isnan(y)).tolist() == [40]
        (grey,) = axes.patches
        ends = apart.time[[39, 40]] - apart.time[0]
        np.testing.assert_allclose(
            (grey.get_x(), grey.get_width()), (ends[0], np.ptp(ends))
        )
    assert "left out, or not recorded" in words(figure)
    assert "left out" not in words(plot_wrench(measurements, estimate_of(BODY)))


def test_one_sample_can_be_drawn(measurements):
    plot_wrench(measurements[:1], estimate_of(hammer().parameters))


def test_object_shows_coms_and_masses_where_they_are(shape):
    masses = np.random.default_rng(2).uniform(0.0, 0.02, shape.n)
    found = InertialParameters(shape.matrix @ masses)
    truth = hammer().parameters
    estimate = estimate_of(found, point_masses=masses)
    views = plot_object(estimate, shape, truth, masses=True).axes
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in views]
    assert labels == [("", "y [mm]"), ("z [mm]", ""), ("x [mm]", "z [mm]")]
    for axes, (i, j) in zip(views, VIEWS, strict=True):
        assert axes.get_aspect() == 1.0
        dots = collections(axes, "point masses")[0]
        assert "one of many sets" in dots.get_label()
        np.testing.assert_allclose(dots.get_offsets(), 1e3 * shape.positions[:, [i, j]])
        # their area is in proportion to their mass
        np.testing.assert_allclose(
            dots.get_sizes() / dots.get_sizes().max(), masses / masses.max()
        )
        for name, body in (("truth", truth), ("estimate", found)):
            (center,) = collections(axes, f"COM, {name}")[0].get_offsets()
            np.testing.assert_allclose(center, 1e3 * body.center_of_mass[[i, j]])
        low, high = np.array((axes.get_xlim(), axes.get_ylim())).T
        assert (low < 1e3 * shape.hull[:, [i, j]].min(axis=0)).all()
        assert (high > 1e3 * shape.hull[:, [i, j]].max(axis=0)).all()
        assert (low < 0.0).all()  # the sensor is in view
        assert (high > 0.0).all()
    for axes in plot_object(estimate, shape).axes:
        assert not collections(axes, "point masses")  # they are no finding


@pytest.mark.parametrize("pose", [np.eye(4), POSE], ids=("as modelled", "turned"))
def test_the_silhouette_is_that_of_the_mesh(pose):
    """Oracle: the area of the projected triangles on either side, by trimesh; of a
    convex body half of it is seen."""
    import trimesh

    mesh = trimesh.creation.box(extents=(0.1, 0.2, 0.4)).apply_transform(pose)
    figure = plot_shape(Shape.from_mesh(mesh))
    for axes, (i, j) in zip(figure.axes, VIEWS, strict=True):
        (surface,) = collections(axes, "shape")
        polygons = np.array([path.vertices[:3] for path in surface.get_paths()])
        (ax, ay), (bx, by) = (
            (polygons[:, 1] - polygons[:, 0]).T,
            (polygons[:, 2] - polygons[:, 0]).T,
        )
        area = 0.5 * np.abs(ax * by - ay * bx).sum()
        normal = mesh.face_normals[:, 3 - i - j]
        seen = 0.5 * (mesh.area_faces * np.abs(normal)).sum()
        assert area == pytest.approx(1e6 * seen, rel=1e-9)


def test_nearer_triangles_are_in_front():
    """Each view looks against the axis that is right-handed with its own two."""
    import trimesh

    plates = [
        trimesh.creation.box(extents=(0.1, 0.1, 0.1)).apply_translation(3 * [k])
        for k in (0.0, 0.5)
    ]
    figure = plot_shape(Shape.from_mesh(trimesh.util.concatenate(plates)))
    for axes, far in zip(figure.axes, (0.0, 0.5, 0.5), strict=True):
        (surface,) = collections(axes, "shape")
        first = surface.get_paths()[0].vertices.mean()
        assert abs(first - 1e3 * far) < 100.0


def test_a_box_around_the_object_is_an_outline():
    box = Shape.from_box(-0.1, 0.1, -0.2, 0.2, 0.0, 0.4)
    for axes in plot_object(estimate_of(hammer().parameters), box).axes:
        assert not collections(axes, "shape")
        (line,) = (x for x in axes.lines if "box around" in str(x.get_label()))
        i, j = VIEWS[list(axes.figure.axes).index(axes)]
        low, high = np.array(((-0.1, -0.2, 0.0), (0.1, 0.2, 0.4))) * 1e3
        corners = np.asarray(line.get_xydata())
        np.testing.assert_allclose(corners.min(axis=0), low[[i, j]])
        np.testing.assert_allclose(corners.max(axis=0), high[[i, j]])


def test_a_com_that_is_open_is_a_line_or_nothing():
    body = hammer().parameters
    half = np.array((1e-3, 1e-3, np.inf))
    intervals = {
        "mass": np.array((0.6, 0.7)),
        "center_of_mass": np.array(
            (body.center_of_mass - half, body.center_of_mass + half)
        ),
        "inertia_at_com": np.array((body.inertia_at_com, body.inertia_at_com)),
    }
    figure = plot_object(estimate_of(body, intervals=intervals))
    front, side, below = figure.axes
    (mark,) = collections(front, "COM, estimate")[0].get_offsets()
    np.testing.assert_allclose(mark, 1e3 * body.center_of_mass[:2])
    for axes in (side, below):
        (mark,) = collections(axes, "COM, estimate")[0].get_offsets()
        assert np.ma.getmaskarray(mark).any() or np.isnan(np.asarray(mark)).any()
    assert any(np.allclose(x.get_ydata(), mark_y(body, 1)) for x in side.lines)
    assert any(np.allclose(x.get_xdata(), mark_y(body, 0)) for x in below.lines)
    assert "open along z" in words(figure)


def test_a_com_that_is_open_along_two_axes_has_its_interval_and_no_mark():
    """It is in no view; the pictures had ended at the center of the interval."""
    half = np.array((7e-3, np.inf, np.inf))
    center = np.array((1.7e-3, 0.1, 0.0))
    body = InertialParameters.from_com(0.7, center, 1e-3 * np.eye(3))
    intervals = {
        "mass": np.array((0.6, 0.7)),
        "center_of_mass": np.array((center - half, center + half)),
        "inertia_at_com": np.array((-np.inf, np.inf))[:, None, None] * np.ones((3, 3)),
    }
    figure = plot_object(estimate_of(body, intervals=intervals))
    front, side, below = figure.axes
    for axes in (front, below):
        (band,) = (p for p in axes.patches if hasattr(p, "get_width"))
        drawn = (band.get_x(), band.get_x() + band.get_width())
        np.testing.assert_allclose(drawn, 1e3 * intervals["center_of_mass"][:, 0])
        low, high = axes.get_xlim()
        assert low < drawn[0]
        assert high > drawn[1]
    assert not [p for p in side.patches if hasattr(p, "get_width")]
    (legend,) = figure.findobj(Legend)
    labels = [text.get_text() for text in legend.get_texts()]
    assert "COM, estimate: open along y and z" in labels
    assert "95 % interval of the COM" in labels
    assert "COM, estimate" not in labels


def mark_y(body, axis):
    return 1e3 * body.center_of_mass[axis]


@pytest.mark.parametrize(
    "parameters", [hammer().parameters, UNPHYSICAL], ids=("physical", "unphysical")
)
@pytest.mark.parametrize("given", ["nothing", "shape", "cloud"])
def test_object_needs_little(shape, parameters, given):
    """Without masses, shape, truth, or an ellipsoid, the rest is drawn."""
    shapes = {"shape": shape, "cloud": Shape.from_cloud(shape.positions)}
    figure = plot_object(estimate_of(parameters), shapes.get(given))
    physical = parameters is not UNPHYSICAL
    said = words(figure)
    assert ("uniform ellipsoid of equal inertia" in said) == physical
    assert ("no body has this inertia" in said) != physical


def test_the_drawn_outline_is_the_ellipsoids_shadow():
    body = hammer().parameters
    ellipsoid = uniform_ellipsoid(body)
    assert ellipsoid is not None
    figure = plot_object(estimate_of(body))
    for axes, (i, j) in zip(figure.axes, VIEWS, strict=True):
        outline = next(
            line for line in axes.lines if "inertia" in str(line.get_label())
        ).get_xydata()
        np.testing.assert_allclose(outline, 1e3 * ellipsoid.shadow(i, j))


def test_verdict_and_numbers_stand_over_every_picture(measurements, shape):
    body = hammer().parameters
    good = estimate_of(body)
    bad = estimate_of(body, warnings=(error("toy-mistake", "give `toy` another"),))
    for estimate in (good, bad):
        for figure in (
            plot_object(estimate, shape, say=str.upper),
            plot_wrench(measurements, estimate, say=str.upper),
            plot_identification(measurements, estimate, shape, say=str.upper),
        ):
            said = words(figure)
            assert f"{body.mass:.4g} kg" in said
            assert (said.count("do not use") > 1) == (estimate is bad)
            assert ("GIVE `TOY` ANOTHER" in said) == (estimate is bad)


def test_a_long_reason_is_cut():
    long = error("toy-mistake", 60 * "word ")
    figure = plot_object(estimate_of(hammer().parameters, warnings=(long,)))
    title = next(text for text in texts(figure) if "verdict" in text.get_text())
    assert title.get_text().count("\n") == 6  # verdict, three lines, three of numbers
    assert "…" in title.get_text()


def test_static_poses_are_told_by_their_row(measurements):
    figure = plot_wrench(measurements[:7], estimate_of(BODY, duration=None))
    assert figure.axes[-1].get_xlabel() == "Pose"
    np.testing.assert_array_equal(figure.axes[0].lines[1].get_xdata(), np.arange(1, 8))
    assert figure.axes[0].lines[1].get_linestyle() == "None"


@pytest.mark.parametrize("count", [1, 2, 7])
def test_poses_have_whole_numbers(measurements, count):
    figure = plot_wrench(measurements[:count], estimate_of(BODY, duration=None))
    low, high = figure.axes[-1].get_xlim()
    ticks = [tick for tick in figure.axes[-1].get_xticks() if low <= tick <= high]
    assert ticks
    assert all(float(tick).is_integer() for tick in ticks)


def test_legends_of_several_rows_are_read_from_left_to_right():
    """By the places of the words: matplotlib fills columns."""
    names = list("abcdefg")
    with drawing(2.0) as figure:
        part = subfigures_of(figure, 1)[0]
        part.subplots(1, 1)
        draw_legend(part, [Line2D([], [], label=name) for name in names], 4)
        (legend,) = part.legends
        with style():
            figure.draw_without_rendering()
        boxes = {t.get_text(): t.get_window_extent() for t in legend.get_texts()}
    placed = sorted(boxes, key=lambda name: (-round(boxes[name].y0, 1), boxes[name].x0))
    assert placed == names


def test_bias_and_turned_sign_are_told(measurements):
    bias = np.array((1.0, -2.0, 0.5, 0.1, 0.2, -0.3))
    made = {"wrench": "on-sensor"}
    said = words(
        plot_wrench(measurements, estimate_of(BODY, bias=bias, provenance=made))
    )
    assert "(1, −2, 0.5) N" in said
    assert "(0.1, 0.2, −0.3) N m" in said
    assert "sign turned" in said
    assert "predicted + bias" in said


@pytest.mark.parametrize("kind", ["object", "wrench", "identification", "shape"])
@pytest.mark.parametrize("verdict", ["good", "bad"])
def test_nothing_overlaps_or_leaves_the_picture(measurements, shape, kind, verdict):
    """Boxes of texts, legends and axes as drawn, in pixels."""
    said = (error("toy-mistake", 40 * "word "),) if verdict == "bad" else ()
    bias = np.array((-9.08, 1.02, -9.98, -0.433, 0.692, 0.157))
    made = {"wrench": "on-sensor"}
    intervals = {
        "mass": BODY.mass + np.array((-0.01, 0.01)),
        "center_of_mass": BODY.center_of_mass + 1e-4 * np.array(((-1.0,), (1.0,))),
        "inertia_at_com": BODY.inertia_at_com + np.array((-1e-6, 1e-6))[:, None, None],
    }
    estimate = estimate_of(
        BODY, bias=bias, warnings=said, provenance=made, intervals=intervals
    )
    figure = {
        "object": lambda: plot_object(estimate, shape, BODY),
        "wrench": lambda: plot_wrench(measurements, estimate),
        "identification": lambda: plot_identification(measurements, estimate, shape),
        "shape": lambda: plot_shape(
            shape, {"estimate": estimate}, measurements.gravity
        ),
    }[kind]()
    with style():
        figure.draw_without_rendering()
        parts = [axes.get_tightbbox() for axes in figure.axes]
        parts += [legend.get_window_extent() for legend in figure.findobj(Legend)]
        title = next(text for text in texts(figure) if "\n" in text.get_text())
        parts.append(title.get_window_extent())
        for k, one in enumerate(parts):
            # a pixel or two of rounding and of an arrow's tip are no overlap
            assert min(one.x0, one.y0) >= -2.0, one
            assert one.x1 <= figure.bbox.x1 + 2.0, one
            if k < len(figure.axes):  # titles end here
                assert one.x1 <= figure.bbox.x1 - 0.02 * 3.5 * figure.dpi, one
            assert one.y1 <= figure.bbox.y1 + 2.0, one
            for other in parts[:k]:
                wide = min(one.x1, other.x1) - max(one.x0, other.x0)
                high = min(one.y1, other.y1) - max(one.y0, other.y0)
                assert min(wide, high) < 2.0, (one, other)


def test_a_shape_is_shown_with_what_is_known_of_it(shape, measurements):
    found = {"estimate": estimate_of(BODY), "another": estimate_of(BODY)}
    figure = plot_shape(shape, found, measurements.gravity)
    said = words(figure)
    for name in ("uniform shape", "estimate", "another", "gravity during the log"):
        assert name in said
    assert "ellipsoid" not in said  # it is the COM that tells of the pose
    uniform = 1e3 * shape.homogeneous.center_of_mass
    for axes, (i, j) in zip(figure.axes, VIEWS, strict=True):
        (center,) = collections(axes, "COM, uniform shape")[0].get_offsets()
        np.testing.assert_allclose(center, uniform[[i, j]])


def test_files_are_whole_and_repeat(tmp_path, measurements):
    figure = plot_wrench(measurements, estimate_of(hammer().parameters))
    png, svg = save_figure(figure, tmp_path / "wrench")
    assert (png.name, svg.name) == ("wrench.png", "wrench.svg")
    assert png.read_bytes().startswith(b"\x89PNG\r\n")
    assert ElementTree.parse(svg).getroot().tag.endswith("svg")
    again = plot_wrench(measurements, estimate_of(hammer().parameters))
    for first, second in zip(
        (png, svg), save_figure(again, tmp_path / "again"), strict=True
    ):
        assert first.read_bytes() == second.read_bytes()
    assert len(list(tmp_path.iterdir())) == 4
    with pytest.raises(InputError, match="cannot be written"):
        save_figure(figure, tmp_path / "nowhere" / "wrench")


def test_drawing_changes_no_setting(measurements):
    import matplotlib

    before = dict(matplotlib.rcParams)
    plot_wrench(measurements, estimate_of(hammer().parameters))
    assert dict(matplotlib.rcParams) == before


def test_without_matplotlib_the_error_says_what_to_install(measurements, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'hefting\[plot\]'"):
        plot_wrench(measurements, estimate_of(hammer().parameters))


def test_lines_break_between_numbers():
    text = "at the COM: " + ", ".join(f"J{k} 1.2345 ± 0.0012" for k in ("xx", "yy"))
    headline = Headline("verdict: good", "", True, (text,))
    assert lines_of(headline, 2.0)[1:] == [
        "at the COM: Jxx 1.2345 ± 0.0012,",
        "Jyy 1.2345 ± 0.0012",
    ]
