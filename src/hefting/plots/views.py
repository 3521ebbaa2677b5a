"""Three views of a scene, each along an axis of the sensor. Needs matplotlib."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array
from hefting.plots.style import (
    BLUE,
    COMPONENTS,
    INK,
    LINE,
    PURPLE,
    SKY,
    TALLEST,
    VERMILION,
    WIDTH,
)
from hefting.scene import Body, Ellipsoid, PointSet, Scene, Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

VIEWS = ((0, 1), (2, 1), (0, 2))
"""Axes to the right and upwards of each view."""
LOOKS: dict[str, dict[str, Any]] = {
    "estimate": {"color": VERMILION, "linestyle": "-", "marker": "+"},
    "truth": {"color": INK, "linestyle": (0, (3, 2)), "marker": "o"},
    "uniform shape": {"color": INK, "linestyle": (0, (1, 1.5)), "marker": "D"},
}
"""How each body is drawn, by its name."""
OTHER: dict[str, Any] = {"color": BLUE, "linestyle": (0, (5, 1)), "marker": "x"}
"""How bodies of other names are drawn; the mark over that of an estimate is a star."""
MARK = 0.06
"""Size of the mark of a COM [in]."""
DOWN = 0.8
"""Length of gravity's directions over that of the sensor's axes."""
NARROWEST = 0.35
"""Least side of a view over the longest."""
SIDES, ROOM = 0.75, 0.95
"""Width and height [in] of axes and their labels."""
SHADES = 0.78, 0.93
"""Grey of a surface seen from the side, and from the front."""
MOST_VECTORS = 3_000
"""Most triangles, or points, that are drawn as vectors in vector formats."""


def size_of(scene: Scene) -> tuple[Array, Array, float]:
    """Lower and upper corner (3,) [mm] of the scene, with a margin; inches per millimetre
    at which three views fit the width of a column and `TALLEST`."""
    corners = 1e3 * scene.corners
    low, high = corners.min(axis=0), corners.max(axis=0)
    length = _axis_length(scene)
    high = np.maximum(high, 1.2 * length)
    if scene.gravity is not None:
        low = np.minimum(low, -DOWN * length)
    longest = float((high - low).max())
    margin = 0.07 * longest + np.maximum(0.5 * (NARROWEST * longest - high + low), 0.0)
    low, high = low - margin, high + margin
    x, y, z = high - low
    return low, high, min((WIDTH - SIDES) / (x + z), (TALLEST - ROOM) / (y + z))


def _axis_length(scene: Scene) -> float:
    """Length of the drawn sensor axes [mm]."""
    return 150.0 * float(np.ptp(scene.corners, axis=0).max()) or 10.0


def height_of(scene: Scene) -> float:
    """Height of three views and their legend [in]."""
    low, high, scale = size_of(scene)
    _, y, z = high - low
    return max(ROOM + scale * (y + z), 1.9) + LINE * _legend_lines(scene)


def draw_scene(figure: "SubFigure", scene: Scene) -> None:
    """Three views of a scene and their legend, on an empty figure of the width of a column
    and the height by `height_of`."""
    from matplotlib.lines import Line2D

    low, high, scale = size_of(scene)
    x, y, z = high - low
    layout = figure.add_gridspec(2, 2, width_ratios=(x, z), height_ratios=(y, z))
    front = figure.add_subplot(layout[0, 0])
    side = figure.add_subplot(layout[0, 1], sharey=front)
    below = figure.add_subplot(layout[1, 0], sharex=front)
    for axes, (i, j) in zip((front, side, below), VIEWS, strict=True):
        _draw_view(axes, scene, i, j, MARK / scale)
        axes.set_aspect("equal")
        axes.set_xlim(low[i], high[i])
        axes.set_ylim(low[j], high[j])
    front.set_ylabel("y [mm]")
    front.tick_params(labelbottom=False)
    side.set_xlabel("z [mm]")
    side.tick_params(labelleft=False)
    below.set(xlabel="x [mm]", ylabel="z [mm]")
    handles, labels = front.get_legend_handles_labels()
    for body in scene.bodies:
        if body.missing:
            handles.append(Line2D([], [], linestyle="none"))
            labels.append(f"no ellipsoid ({body.name}): {body.missing}")
    figure.legend(handles, labels, loc="outside lower left", borderaxespad=0.3)


def _legend_lines(scene: Scene) -> int:
    parts: list[Any] = [scene, scene.surface, scene.points, scene.gravity]
    for body in scene.bodies:
        parts += [body.region, body.ellipsoid or body.missing or None]
        open_count = int(np.isnan(body.center).sum())
        parts += [True] if open_count < 2 else []  # its mark is in some view
        parts += [True] if open_count else []
        parts += [True] if _has_band(body) else []
    return sum(part is not None for part in parts)


def _draw_view(axes: "Axes", scene: Scene, i: int, j: int, mark: float) -> None:
    """The scene projected on axes `i` and `j`; `mark` is a COM's size [mm]."""
    if scene.surface is not None:
        _draw_surface(axes, scene.surface, i, j)
    if scene.points is not None:
        _draw_points(axes, scene.points, i, j)
    length = _axis_length(scene)
    if scene.gravity is not None:
        _draw_gravity(axes, scene.gravity[:, [i, j]], DOWN * length)
    _draw_triad(axes, i, j, length)
    for body in scene.bodies:
        _draw_body(axes, body, i, j, mark)


def _draw_surface(axes: "Axes", surface: Surface, i: int, j: int) -> None:
    """The triangles that face the viewer, with nearer ones in front, and paler the more
    they face the viewer; of a box that only holds the object the edges."""
    if not surface.is_object:
        low, high = 1e3 * surface.vertices.min(axis=0), 1e3 * surface.vertices.max(0)
        corners = [[low[i], low[j]], [high[i], low[j]], [high[i], high[j]]]
        corners += [[low[i], high[j]], [low[i], low[j]]]
        axes.plot(
            *np.transpose(corners),
            color=INK,
            linewidth=0.6,
            linestyle=(0, (6, 3)),
            label="box around the object",
        )
        return
    from matplotlib.collections import PolyCollection

    k = 3 - i - j
    towards = 1.0 if (j - i) % 3 == 1 else -1.0
    triangles = 1e3 * surface.vertices[surface.faces]
    normal = np.cross(
        triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    )
    size = np.linalg.norm(normal, axis=1)
    facing = towards * normal[:, k] / np.where(size > 0.0, size, 1.0)
    seen = facing > 1e-6
    triangles, facing = triangles[seen], facing[seen]
    order = np.argsort(towards * triangles[:, :, k].mean(axis=1), kind="stable")
    side, front = SHADES
    grey = side + (front - side) * facing[order]
    collection = PolyCollection(
        list(triangles[order][:, :, [i, j]]),
        facecolors=np.repeat(grey[:, None], 3, axis=1),
        edgecolors="face",
        linewidths=0.2,
        zorder=0,
        label="shape",
        rasterized=len(triangles) > MOST_VECTORS,
    )
    axes.add_collection(collection, autolim=False)


def _draw_points(axes: "Axes", points: PointSet, i: int, j: int) -> None:
    places = 1e3 * points.positions[:, [i, j]].T
    if points.masses is None:
        axes.scatter(
            *places,
            s=2.0,
            color="#B8B8B8",
            linewidths=0.0,
            zorder=0,
            label="shape (points)",
            rasterized=places.shape[1] > MOST_VECTORS,
        )
        return
    largest = float(points.masses.max()) or 1.0
    axes.scatter(
        *places,
        s=40.0 * points.masses / largest,
        facecolors="none",
        edgecolors=SKY,
        linewidths=0.5,
        zorder=1,
        label=f"point masses to {1e3 * largest:.2g} g: one of many sets that fit equally well",
    )


def _draw_gravity(axes: "Axes", directions: Array, length: float) -> None:
    ends = length * directions
    gaps = np.full(len(ends), np.nan)
    zeros = np.zeros(len(ends))
    axes.plot(
        np.column_stack((zeros, ends[:, 0], gaps)).ravel(),
        np.column_stack((zeros, ends[:, 1], gaps)).ravel(),
        color=PURPLE,
        linewidth=0.5,
        alpha=0.6,
        zorder=1,
        label="gravity during the log",
    )


def _draw_body(axes: "Axes", body: Body, i: int, j: int, mark: float) -> None:
    look = LOOKS.get(body.name, OTHER)
    _draw_center(axes, body, i, j, look)
    if body.region is not None:
        within = 2e3 * body.region.reach.max() < 1.5 * mark
        size = " (smaller than its mark)" if within else ""
        axes.fill(
            *(1e3 * body.region.shadow(i, j)).T,
            color=look["color"],
            alpha=0.25,
            linewidth=0.0,
            zorder=3,
            label=f"95 % region of the COM{size}",
        )
    if body.ellipsoid is not None:
        _draw_ellipsoid(axes, body, body.ellipsoid, i, j, look)


def _draw_center(
    axes: "Axes", body: Body, i: int, j: int, look: dict[str, Any]
) -> None:
    """The COM as a mark; as a line along the axis if it is open on one, with its 95 %
    interval; nothing if it is open on both."""
    center = 1e3 * body.center
    name = f"COM, {body.name}"
    is_open = np.isnan(center)
    line: dict[str, Any] = {
        "color": look["color"],
        "linewidth": 0.7,
        "linestyle": (0, (1, 1)),
    }
    band: dict[str, Any] = {
        "color": look["color"],
        "alpha": 0.25,
        "linewidth": 0.0,
        "zorder": 0,
    }
    if is_open.any():
        label = f"{name}: open along {body.open_axes}"
        shown: dict[str, Any] = {"linestyle": "none"} if is_open.all() else {}
        axes.plot([], [], label=label, **(line | shown))
    reach = body.reach if _has_band(body) else None
    if reach is not None:
        axes.fill([], [], label="95 % interval of the COM", **band)
    right, up = center[i], center[j]
    if is_open[i] != is_open[j]:
        known = j if is_open[i] else i
        draw, fill = axes.axvline, axes.axvspan
        if is_open[i]:
            draw, fill = axes.axhline, axes.axhspan
        draw(center[known], **line)
        if reach is not None:
            fill(
                center[known] - 1e3 * reach[known],
                center[known] + 1e3 * reach[known],
                **band,
            )
    paint = {"color": look["color"]}
    if look["marker"] in "oD":
        paint = {"facecolors": "none", "edgecolors": look["color"]}
    axes.scatter(
        right,
        up,
        marker=look["marker"],
        s=(72.0 * MARK) ** 2,
        linewidths=0.9,
        zorder=6,
        label=name if is_open.sum() < 2 else None,  # open on two it is in no view
        **paint,
    )


def _has_band(body: Body) -> bool:
    """Whether the COM is a line in some view, of known uncertainty."""
    is_open = np.isnan(body.center)
    if body.reach is None or not is_open.any():
        return False
    return bool(np.isfinite(body.reach[~is_open]).any())


def _draw_ellipsoid(
    axes: "Axes", body: Body, ellipsoid: Ellipsoid, i: int, j: int, look: dict[str, Any]
) -> None:
    share = body.inertia_doubt
    doubt = "" if share is None else f" (± {100 * share:.0f} %)"
    of = "" if body.name == "estimate" else f", {body.name}"
    axes.plot(
        *(1e3 * ellipsoid.shadow(i, j)).T,
        color=look["color"],
        linestyle=look["linestyle"],
        linewidth=0.9,
        zorder=3,
        label=f"uniform ellipsoid of equal inertia{doubt}{of}",
    )


def _draw_triad(axes: "Axes", i: int, j: int, length: float) -> None:
    """Sensor origin and its two axes in the view, with each letter beside the tip, as a COM
    is often ahead of it."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.0, foreground="white")]
    for axis, tip, beside in (
        (i, (length, 0.0), (-1.0, -5.0)),
        (j, (0.0, length), (-5.0, -1.0)),
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
            beside,
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
        label="sensor, with its axes",
        linestyle="none",
    )
