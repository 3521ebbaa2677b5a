"""Picture of the object found, in three views: masses, centre of mass, inertia
ellipsoid. Needs matplotlib."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.plots.style import (
    BAR,
    BLUE,
    COMPONENTS,
    INK,
    SHADOW,
    TALLEST,
    VERMILION,
    WIDTH,
    figure_of,
    settled,
    style,
)
from hefting.shapes import Shape

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_object(
    estimate: Estimate,
    shape: Shape | None = None,
    mesh: Any = None,
    truth: InertialParameters | None = None,
) -> "Figure":
    """The object in three views, in sensor axes: masses found, centre of mass and
    inertia ellipsoid.

    Parameters
    ----------
    shape : its points are coloured by the masses [g] of ``estimate.point_masses``,
        heavier ones in front.
    mesh : silhouette; an object with ``vertices`` (V, 3) [m] in the sensor frame and
        ``faces`` (F, 3).
    truth : drawn beside the estimate.

    The ellipsoid is the homogeneous one with the same mass and inertia
    (`equivalent_ellipsoid`); an unphysical estimate has none. Raises
    `MissingDependencyError` without matplotlib.
    """
    bodies: list[tuple] = [(estimate.parameters, "estimate", VERMILION, "-", "x")]
    if truth is not None:
        bodies.insert(0, (truth, "truth", INK, (0, (3, 2)), "o"))
    corners = [np.zeros((1, 3))]
    corners += [_ellipsoid_box(body) for body, *_ in bodies]
    corners += [] if shape is None else [shape.positions]
    corners += [] if mesh is None else [np.asarray(mesh.vertices)]
    inside = np.vstack(corners)
    low, high = 1e3 * inside.min(axis=0), 1e3 * inside.max(axis=0)
    margin = 0.05 * float((high - low).max()) or 10.0
    low, high = low - margin, high + margin
    with style():
        x, y, z = high - low
        # inches per millimetre
        scale = min((WIDTH - 0.75) / (x + z), (TALLEST - 0.95) / (y + z))
        figure = figure_of(max(0.95 + scale * (y + z), 1.9))
        layout = figure.add_gridspec(
            3, 2, width_ratios=(x, z), height_ratios=(BAR / scale, y, z)
        )
        front = figure.add_subplot(layout[1, 0])
        side = figure.add_subplot(layout[1, 1], sharey=front)
        below = figure.add_subplot(layout[2, 0], sharex=front)
        views = ((front, 0, 1), (side, 2, 1), (below, 0, 2))
        dots = None
        diameter = 72.0 * scale * 1e3 * _pitch(shape) if shape is not None else 0.0
        for axes, i, j in views:
            if mesh is not None:
                _silhouette(
                    axes,
                    1e3 * np.asarray(mesh.vertices)[:, [i, j]],
                    np.asarray(mesh.faces),
                )
            if shape is not None:
                dots = _masses(
                    axes,
                    1e3 * shape.positions[:, [i, j]],
                    estimate.point_masses,
                    diameter,
                )
            _triad(axes, i, j, 0.12 * float((high - low).max()))
            for body, name, colour, line, marker in bodies:
                _body(axes, body, i, j, name, colour, line, marker)
            axes.set_aspect("equal")
            axes.set_xlim(low[i], high[i])
            axes.set_ylim(low[j], high[j])
        front.set_ylabel("y [mm]")
        front.tick_params(labelbottom=False)
        side.set_xlabel("z [mm]")
        side.tick_params(labelleft=False)
        below.set(xlabel="x [mm]", ylabel="z [mm]")
        corner = figure.add_subplot(layout[2, 1])
        corner.set_axis_off()
        corner.legend(
            *front.get_legend_handles_labels(), loc="upper left", borderaxespad=0.0
        )
        if dots is not None:
            bar = figure.colorbar(
                dots, cax=figure.add_subplot(layout[0, :]), orientation="horizontal"
            )
            bar.ax.xaxis.set_ticks_position("top")
            bar.ax.xaxis.set_label_position("top")
            bar.set_label("Mass of a point [g]")
            bar.outline.set_linewidth(0.4)  # pyright: ignore[reportCallIssue]
        return settled(figure)


def equivalent_ellipsoid(body: InertialParameters) -> tuple[Array, Array] | None:
    """The homogeneous ellipsoid of the same inertia: semi-axes (3,) [m], and their
    directions as columns.

    From J1 = m/5 (s2² + s3²) and so on: s1² = 5/(2m) (J2 + J3 - J1). None when the body
    is unphysical.
    """
    if not body.consistency().is_consistent:
        return None
    moments, axes = body.principal()
    square = 2.5 / body.mass * (moments.sum() - 2.0 * moments)
    return np.sqrt(np.maximum(square, 0.0)), axes


def _silhouette(axes: "Axes", corners: Array, faces: ArrayLike) -> None:
    """The triangles' shadow: one path of all of them, turned the same way round."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    triangles = corners[np.asarray(faces)]
    (ax, ay), (bx, by) = (
        (triangles[:, 1] - triangles[:, 0]).T,
        (triangles[:, 2] - triangles[:, 0]).T,
    )
    area = ax * by - ay * bx
    triangles[area < 0.0] = triangles[area < 0.0][:, ::-1]
    seen = triangles[np.abs(area) > 1e-9 * np.abs(area).max()]
    path = Outline.make_compound_path_from_polys(seen)
    many = len(triangles) > 5000
    axes.add_patch(
        PathPatch(
            path,
            facecolor=SHADOW,
            edgecolor=SHADOW,
            linewidth=0.4,
            zorder=0,
            rasterized=many,
        )
    )


def _masses(axes: "Axes", places: Array, masses: Array | None, diameter: float):
    """Points, the heavier the larger and the nearer; all alike when their masses are
    unknown."""
    largest = float(np.clip(0.75 * diameter, 1.0, 4.0))
    if masses is None:
        axes.scatter(
            *places.T, s=0.3 * largest**2, color=BLUE, linewidths=0.0, zorder=1
        )
        return None
    grams = 1e3 * masses
    order = np.argsort(grams)
    size = largest**2 * (0.1 + 0.9 * np.sqrt(grams / (grams.max() or 1.0)))
    return axes.scatter(
        *places[order].T,
        c=grams[order],
        s=size[order],
        cmap="viridis_r",
        vmin=0.0,
        linewidths=0.0,
        zorder=1,
        rasterized=len(grams) > 5000,
    )


def _pitch(shape: Shape) -> float:
    """Usual distance [m] between neighbouring points."""
    from scipy.spatial import KDTree

    if shape.n == 1:
        return 0.01
    distances, _ = KDTree(shape.positions).query(shape.positions[:2000], k=2)
    return float(np.median(distances[:, 1]))


def _body(
    axes: "Axes",
    body: InertialParameters,
    i: int,
    j: int,
    name: str,
    colour,
    line,
    marker,
) -> None:
    """Centre of mass and the outline of the ellipsoid, projected on axes i and j."""
    center = 1e3 * body.center_of_mass[[i, j]]
    face = {"facecolors": "none"} if marker == "o" else {}
    axes.scatter(
        *center,
        marker=marker,
        s=22.0,
        linewidths=1.0,
        zorder=4,
        label=f"COM, {name}",
        **(face | ({"edgecolors": colour} if face else {"color": colour})),
    )
    ellipsoid = equivalent_ellipsoid(body)
    if ellipsoid is None:
        return
    semi_axes, directions = ellipsoid
    # the shadow of {A u: |u| <= 1} is {B u}, B the rows of A in the plane: an ellipse
    # with the matrix B B'
    shadow = 1e3 * (directions * semi_axes)[[i, j]]
    values, vectors = np.linalg.eigh(shadow @ shadow.T)
    angle = np.linspace(0.0, 2.0 * np.pi, 120)
    outline = (vectors * np.sqrt(np.maximum(values, 0.0))) @ np.vstack(
        (np.cos(angle), np.sin(angle))
    )
    axes.plot(
        *(center[:, None] + outline),
        color=colour,
        linestyle=line,
        linewidth=0.9,
        zorder=3,
        label=f"inertia, {name}",
    )


def _ellipsoid_box(body: InertialParameters) -> Array:
    """Two corners (2, 3) [m] of the box around centre of mass and ellipsoid."""
    ellipsoid = equivalent_ellipsoid(body)
    reach = (
        np.zeros(3)
        if ellipsoid is None
        else np.linalg.norm(ellipsoid[1] * ellipsoid[0], axis=1)
    )
    return body.center_of_mass + np.array(((-1.0,), (1.0,))) * reach


def _triad(axes: "Axes", i: int, j: int, length: float) -> None:
    """Sensor origin and its two axes that lie in the view."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.0, foreground="white")]
    for axis, tip, beyond in (
        (i, (length, 0.0), (4.0, 0.0)),
        (j, (0.0, length), (0.0, 4.0)),
    ):
        name, colour = list(COMPONENTS.items())[axis]
        style = {
            "arrowstyle": "-|>,head_length=0.25,head_width=0.12",
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        }
        axes.annotate(
            "",
            tip,
            (0.0, 0.0),
            arrowprops=style | {"color": colour, "linewidth": 0.9},
            zorder=2,
        )
        axes.annotate(
            name,
            tip,
            beyond,
            textcoords="offset points",
            ha="center",
            va="center",
            color=colour,
            path_effects=halo,
        )
    axes.plot(
        0.0,
        0.0,
        "s",
        color=INK,
        markersize=2.5,
        zorder=5,
        label="sensor",
        linestyle="none",
    )
