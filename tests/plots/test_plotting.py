"""Pictures: what they show, that they are written whole, and that they are the same
every time."""

import sys
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip(
    "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
)

from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.regressor import predict_wrench
from hefting.plots.body import equivalent_ellipsoid, plot_object
from hefting.plots.style import DRAWN, save_figure
from hefting.plots.wrench import plot_wrench
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, sinusoids, wield

UNPHYSICAL = InertialParameters.from_com(
    0.5, (0.0, 0.1, 0.0), np.diag((1e-3, 1e-3, 5e-3))
)


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), points=60)


@pytest.fixture(scope="module")
def measurements():
    motion = UR5.motion(sinusoids(2.0, 50.0, 1.0))
    return wield(motion, hammer().parameters).with_noise(
        NOISE_LEVELS["moderate"], seed=1
    )


def estimate_of(parameters: InertialParameters, **more) -> Estimate:
    return Estimate("PMD", parameters, samples=100, **more)


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


def test_one_sample_can_be_drawn(measurements):
    plot_wrench(measurements[:1], estimate_of(hammer().parameters))


def test_object_shows_masses_to_scale(shape):
    masses = np.random.default_rng(2).uniform(0.0, 0.02, shape.n)
    found = InertialParameters(shape.matrix @ masses)
    truth = hammer().parameters
    figure = plot_object(
        estimate_of(found, point_masses=masses), shape, hammer().mesh(), truth
    )
    views = figure.axes[:3]
    labels = [(axes.get_xlabel(), axes.get_ylabel()) for axes in views]
    assert labels == [("", "y [mm]"), ("z [mm]", ""), ("x [mm]", "z [mm]")]
    for axes, (i, j) in zip(views, ((0, 1), (2, 1), (0, 2)), strict=True):
        assert axes.get_aspect() == 1.0
        dots = next(c for c in axes.collections if len(c.get_offsets()) == shape.n)
        order = np.argsort(masses)
        np.testing.assert_allclose(
            dots.get_offsets(), 1e3 * shape.positions[order][:, [i, j]]
        )
        np.testing.assert_allclose(dots.get_array(), 1e3 * masses[order])
        centers = [
            c.get_offsets()[0] for c in axes.collections if len(c.get_offsets()) == 1
        ]
        for body, center in zip((truth, found), centers, strict=True):
            np.testing.assert_allclose(center, 1e3 * body.center_of_mass[[i, j]])
        low, high = np.array((axes.get_xlim(), axes.get_ylim())).T
        assert (low < 1e3 * shape.positions[:, [i, j]].min(axis=0)).all()
        assert (high > 1e3 * shape.positions[:, [i, j]].max(axis=0)).all()
        assert (low < 0.0).all()  # the sensor is in view
        assert (high > 0.0).all()
    assert figure.axes[-1].get_xlabel() == "Mass of a point [g]"


@pytest.mark.parametrize(
    "parameters", [hammer().parameters, UNPHYSICAL], ids=("physical", "unphysical")
)
@pytest.mark.parametrize("given", ["nothing", "shape", "mesh"])
def test_object_needs_little(shape, parameters, given):
    """Without masses, shape, mesh, truth, or an ellipsoid, the rest is drawn."""
    plot_object(
        estimate_of(parameters),
        shape if given == "shape" else None,
        hammer().mesh() if given == "mesh" else None,
    )


def test_ellipsoid_has_the_bodys_inertia():
    """A homogeneous ellipsoid has J1 = m/5 (s2² + s3²) along its own axes."""
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    semi = np.array((0.05, 0.1, 0.2))
    square = semi**2
    J = (turn * (2.0 / 5.0 * (square.sum() - square))) @ turn.T
    body = InertialParameters.from_com(2.0, (0.1, 0.2, 0.3), J)
    found = equivalent_ellipsoid(body)
    assert found is not None
    lengths, axes = found
    np.testing.assert_allclose(np.sort(lengths), semi, rtol=1e-12)
    np.testing.assert_allclose(
        (axes * lengths**2) @ axes.T, (turn * square) @ turn.T, atol=1e-15
    )
    assert equivalent_ellipsoid(UNPHYSICAL) is None


def test_the_drawn_outline_is_the_ellipsoids_shadow():
    """Farthest point of the outline in any direction d of the view: sqrt(d'Qd), Q = sum
    of s_k² e_k e_k'."""
    body = hammer().parameters
    ellipsoid = equivalent_ellipsoid(body)
    assert ellipsoid is not None
    Q = (ellipsoid[1] * ellipsoid[0] ** 2) @ ellipsoid[1].T
    figure = plot_object(estimate_of(body))
    for axes, (i, j) in zip(figure.axes[:3], ((0, 1), (2, 1), (0, 2)), strict=True):
        outline = next(
            line for line in axes.lines if "inertia" in str(line.get_label())
        ).get_xydata()
        outline = np.asarray(outline) / 1e3 - body.center_of_mass[[i, j]]
        for angle in np.linspace(0.0, np.pi, 7):
            d = np.array((np.cos(angle), np.sin(angle)))
            reach = np.sqrt(d @ Q[np.ix_((i, j), (i, j))] @ d)
            # one of 120 points is within 1.5° of the farthest, in the ellipse's
            # parameter: 1 - cos 1.5°
            assert (outline @ d).max() == pytest.approx(reach, rel=4e-4)


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
