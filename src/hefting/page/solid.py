"""Solid: a scene in three dimensions, in plotly's terms."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from hefting.core.spatial import Array
from hefting.page.figure import AXES, Figure, Trace, numbers
from hefting.page.html import Section, items, join, note
from hefting.scene import Body, Ellipsoid, PointSet, Scene, Surface

COLOURS = {"estimate": "@estimate", "truth": "@truth"}
HEIGHT = 560
FINEST = 1e-5
"""[m] Resolution of coordinates."""
VIEW = np.array(((0.707, 0.707, 0.0), (-0.287, 0.287, 0.914), (0.646, -0.646, 0.406)))
"""Unit vectors to the right, upwards and to the eye, as rows."""
SEEN = np.array((0.4, 0.33))
"""Half the visible width and height over the distance: those of a view of 45 degrees
without space for numbers and titles of the axes."""
ROOM = 0.03
"""Margin between content and ends of an axis, over its length."""
REACH_OF_AXES = 0.25
"""Length of the sensor's axes over the size of the scene."""


def solid(scene: Scene) -> Section:
    """Section with the object: shape, point masses, COM, ellipsoids, and the sensor."""
    lines = [
        f"No ellipsoid of equal inertia ({body.name}): {body.missing}."
        for body in scene.bodies
        if body.missing
    ]
    lines += [
        f"COM ({body.name}) open along {body.open_axes}, so it is not drawn."
        for body in scene.bodies
        if np.isnan(body.center).any()
    ]
    if scene.surface is None and scene.points is None:
        lines.append("No shape was given, so none is drawn.")
    if scene.points is not None and scene.points.masses is not None:
        lines.append(
            "Point masses are one of many sets with the same mass, COM and inertia, not "
            "a result."
        )
    says = (
        "Turn it with the mouse or a finger; zoom with the wheel or two fingers. The "
        "ellipsoid of equal inertia is a body of uniform density with the mass, COM and "
        "inertia found, not the outline of the object."
    )
    content = join(note(says), items(lines, class_="note"))
    return Section("object", "The object", content, (figure_of(scene),))


def figure_of(scene: Scene) -> Figure:
    """The scene as traces, in millimetres."""
    step = 1e3 * _step(float(np.ptp(scene.corners, axis=0).max()))
    traces = list(_traces(scene))
    ends = np.array([_ends(traces, name) for name in AXES])
    size = np.ptp(ends, axis=1)
    ratio = size / np.linalg.norm(size)
    axes = {
        f"{name}axis": _axis(name, step) | {"range": numbers(own)}
        for name, own in zip(AXES, ends, strict=True)
    }
    layout: dict[str, Any] = {
        "scene": {
            **axes,
            "aspectmode": "manual",
            "aspectratio": dict(zip(AXES, numbers(ratio), strict=True)),
            "camera": {"eye": _eye(ratio), "center": {"x": 0, "y": 0, "z": -0.07}},
            "domain": {"y": [0.0, 0.88]},
        },
        "legend": {"orientation": "h", "x": 0.0, "y": 0.0, "yanchor": "top"},
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
    }
    return Figure("object", traces, layout, HEIGHT, "The object in three dimensions")


def _ends(traces: list[Trace], name: str) -> tuple[float, float]:
    """Ends [mm] of an axis that holds all traces, with a margin."""
    drawn = [value for trace in traces for value in trace[name] if value is not None]
    low, high = min(drawn), max(drawn)
    room = ROOM * (high - low) or 1.0
    return low - room, high + room


def _eye(size: Array) -> dict[str, float]:
    """Position of the eye that sees all of a box of sides `size` (3,) at the origin."""
    corners = 0.5 * size * np.stack(np.meshgrid(*3 * [(-1, 1)]), axis=-1).reshape(-1, 3)
    right_up, near = corners @ VIEW[:2].T, corners @ VIEW[2]
    distance = (near + (np.abs(right_up) / SEEN).max(axis=1)).max()
    return dict(zip(AXES, numbers(distance * VIEW[2]), strict=True))


def _axis(name: str, step: float) -> dict[str, Any]:
    return {
        "title": {"text": f"{name} [mm]", "font": {"size": 12}},
        "dtick": step,
        "tick0": 0,
        "tickfont": {"size": 11},
        "gridcolor": "@grid",
        "zerolinecolor": "@muted",
        "showbackground": False,
    }


def _step(size: float) -> float:
    """Step of the axes [m]: 1, 2 or 5 times a power of ten, about a seventh of `size`."""
    power = 10.0 ** np.floor(np.log10(size / 7.0)) if size > 0.0 else 0.1
    return float(
        min((1.0, 2.0, 5.0, 10.0), key=lambda n: abs(n * power - size / 7.0)) * power
    )


def _traces(scene: Scene) -> Iterable[Trace]:
    if scene.surface is not None:
        yield _surface(scene.surface)
    if scene.points is not None:
        yield _points(scene.points)
    yield from _sensor(float(np.ptp(scene.corners, axis=0).max()))
    if scene.gravity is not None:
        yield _gravity(scene)
    for body in scene.bodies:
        yield from _body(body)


def _mm(points: Array) -> dict[str, list[Any]]:
    """Coordinates of points (n, 3) [m] in millimetres, by axis."""
    rounded = 1e3 * np.round(np.asarray(points) / FINEST) * FINEST
    return {name: numbers(c) for name, c in zip(AXES, rounded.T, strict=True)}


def _triangles(vertices: Array, faces: np.ndarray) -> Trace:
    corners = zip("ijk", faces.T, strict=True)
    return {"type": "mesh3d", **_mm(vertices), **{n: c.tolist() for n, c in corners}}


def _surface(surface: Surface) -> Trace:
    known = surface.is_object
    name = "shape" if known else "box around the object"
    look = {
        "name": name,
        "color": "@shape",
        "opacity": 0.3 if known else 0.12,
        "flatshading": True,
        "hoverinfo": "skip",
        "showlegend": True,
    }
    return _triangles(surface.vertices, surface.faces) | look


def _points(points: PointSet) -> Trace:
    trace: Trace = {"type": "scatter3d", "mode": "markers", **_mm(points.positions)}
    if points.masses is None:
        look = {"color": "@shape", "size": 2}
        return trace | {"name": "shape (points)", "marker": look, "hoverinfo": "skip"}
    grams = 1e3 * points.masses
    bar = {
        "title": {"text": "point mass [g]", "side": "top"},
        "orientation": "h",
        "thickness": 10,
        "len": 0.5,
        "x": 0.0,
        "xanchor": "left",
        "y": 1.0,
        "yanchor": "top",
    }
    marker = {
        "color": numbers(grams),
        "colorscale": "Viridis",
        "cmin": 0.0,
        "cmax": float(grams.max()) or 1.0,
        "size": 5,
        "colorbar": bar,
    }
    text = "%{marker.color:.3g} g<extra></extra>"
    return trace | {"name": "point masses", "marker": marker, "hovertemplate": text}


def _sensor(size: float) -> Iterable[Trace]:
    length = REACH_OF_AXES * size
    for name, unit in zip(AXES, np.eye(3), strict=True):
        yield {
            "type": "scatter3d",
            "mode": "lines+text",
            **_mm(length * np.vstack((np.zeros(3), unit))),
            "text": ["", name],
            "textfont": {"color": f"@{name}", "size": 16},
            "line": {"color": f"@{name}", "width": 6},
            "name": "sensor axes",
            "legendgroup": "sensor",
            "showlegend": name == "x",
            "hoverinfo": "skip",
        }


def _gravity(scene: Scene) -> Trace:
    assert scene.gravity is not None
    length = 0.6 * REACH_OF_AXES * float(np.ptp(scene.corners, axis=0).max())
    ends = length * scene.gravity
    gap = np.full_like(ends, np.nan)
    points = np.stack((np.zeros_like(ends), ends, gap), axis=1).reshape(-1, 3)
    return {
        "type": "scatter3d",
        "mode": "lines",
        **_mm(points),
        "line": {"color": "@gravity", "width": 2},
        "name": "gravity during the log",
        "hoverinfo": "name",
    }


def _body(body: Body) -> Iterable[Trace]:
    colour = COLOURS.get(body.name, "@gravity")
    if not np.isnan(body.center).any():
        yield {
            "type": "scatter3d",
            "mode": "markers",
            **_mm(body.center[None]),
            "marker": {"color": colour, "size": 5, "symbol": "cross"},
            "name": f"COM, {body.name}",
        }
    if body.region is not None:
        yield _ellipsoid(body.region, "95 % region of the COM", colour, 0.45)
    if body.ellipsoid is not None:
        doubt = body.inertia_doubt
        sure = "" if doubt is None else f" (± {100 * doubt:.0f} %)"
        name = f"ellipsoid of equal inertia{sure}"
        name += "" if body.name == "estimate" else f", {body.name}"
        yield _ellipsoid(body.ellipsoid, name, colour, 0.15)


def _ellipsoid(ellipsoid: Ellipsoid, name: str, colour: str, opacity: float) -> Trace:
    look = {
        "name": name,
        "color": colour,
        "opacity": opacity,
        "hoverinfo": "name",
        "showlegend": True,
    }
    return _triangles(*ellipsoid.triangles()) | look
