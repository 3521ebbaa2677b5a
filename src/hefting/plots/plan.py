"""Picture of a planned motion: the joints within their limits, the fastest corner of the
object, and the expected uncertainty. Needs matplotlib."""

from collections.abc import Callable
from itertools import cycle, product
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.planning.result import Plan, corner_speeds
from hefting.plots.style import (
    BLUE,
    GREEN,
    INK,
    LINE,
    MEASURED,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    chosen,
    draw_legend,
    headed,
    lines_of,
    write_title,
)
from hefting.scene import Headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

JOINTS: tuple[dict[str, Any], ...] = tuple(
    {"color": colour, "linestyle": line}
    for line, colour in product(
        ("-", (0, (1, 1)), (0, (3, 1, 1, 1))),
        (BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE),
    )
)
"""Lines of the joints, repeated for more of them; what is not of one joint is `INK`."""
QUANTITIES = {
    "mass": ("mass", "%", 1e2, "o"),
    "center_of_mass": ("COM", "mm", 1e3, "s"),
    "inertia": ("inertia", "%", 1e2, "^"),
}
"""Label, unit, factor from SI, and marker of each quantity of an `Accuracy`."""
HEIGHTS = {"joints": 1.7, "shares": 1.1, "corner": 0.9, "widths": 1.3}
"""Heights of the rows [in]."""
LIMIT = {"linewidth": 0.6, "linestyle": (0, (4, 2))}
"""Style of limits."""
LINE_OF_NAMES, BESIDE_NAME, LONGEST_NAME = 62, 6, 24
"""Characters of a line of the legend, of the mark beside a name, and at most of a name."""


def plot_plan(plan: Plan, say: Callable[[str], str] = str) -> "Figure":
    """Joint positions with limits in view; the largest joint speed and acceleration as
    shares of their limits; speed of the fastest corner; and expected half-widths of the
    95 % intervals, with those asked for.

    `say` turns names of arguments in backquotes into the reader's. Raises
    `MissingDependencyError` without matplotlib, and `InputError` as `corner_speeds`.
    """
    lines = lines_of(_headline(plan), say=say)
    names = -(-len(plan.joints) // _columns(plan.joints))
    height = 0.9 + sum(HEIGHTS.values()) + LINE * names
    with headed(height, lines) as (figure, below):
        rows = below.subplots(
            4, 1, sharex=True, gridspec_kw={"height_ratios": list(HEIGHTS.values())}
        )
        _draw_joints(rows[0], plan)
        _draw_shares(rows[1], plan)
        _draw_corner(rows[2], plan)
        _draw_widths(rows[3], plan)
        rows[-1].set_xlabel("Time [s]")
        rows[-1].set_xlim(0.0, plan.duration)
        _draw_joint_legend(below, plan.joints)
        below.align_ylabels()
    return figure


def _headline(plan: Plan) -> Headline:
    after = plan.forecast.accuracy[-1]
    numbers = [
        f"{label} ± {_number_text(factor * value)} {unit}"
        for name, (label, unit, factor, _) in QUANTITIES.items()
        if (value := getattr(after, name)) is not None
    ]
    lines = [f"expected: {', '.join(numbers)}"]
    if plan.asked is not None:
        asked = str(plan.asked).replace(",", ", ")
        lines.append(f"asked {asked}: expected to be reached")
    what = f"planned motion of {plan.duration:.3g} s for '{plan.tip}'"
    return Headline(what, "", True, tuple(lines))


def _number_text(value: float) -> str:
    return f"{value:.2g}" if np.isfinite(value) else "open"


def _draw_joints(axes: "Axes", plan: Plan) -> None:
    motion = plan.motion
    shown = chosen(len(motion.time))
    time, position = motion.time[shown], motion.position[shown].T
    for name, q, look in zip(plan.joints, position, cycle(JOINTS), strict=False):
        axes.plot(time, q, linewidth=0.9, label=name, **look)
    low, high = axes.get_ylim()
    for ends, look in zip(plan.limits.position, cycle(JOINTS), strict=False):
        for end in ends:
            if low <= end <= high:
                axes.axhline(end, color=look["color"], **LIMIT)
    axes.set_ylim(low, high)
    axes.set_ylabel("joints [rad]")
    write_title(axes, "dashed: limits in view")


def _draw_shares(axes: "Axes", plan: Plan) -> None:
    motion, limits = plan.motion, plan.limits
    shown = chosen(len(motion.time))
    time = motion.time[shown]
    thin: dict[str, Any] = {"linewidth": 0.9}
    for name, values, most, look in (
        ("speed", motion.velocity, limits.speed, thin),
        ("acceleration", motion.acceleration, limits.acceleration, MEASURED),
    ):
        share = 1e2 * np.max(np.abs(values) / most, axis=1)
        axes.plot(time, share[shown], color=INK, label=name, **look)
    axes.axhline(1e2, color=INK, **LIMIT)
    axes.set_ylim(0.0, 1.12e2)
    axes.set_ylabel("of limits [%]")
    write_title(axes, "largest share of any limit")
    _legend_above(axes)


def _draw_corner(axes: "Axes", plan: Plan) -> None:
    speed, time = corner_speeds(plan), plan.motion.time
    shown = chosen(len(time))
    most = plan.limits.corner_speed
    axes.plot(time[shown], 1e3 * speed[shown], color=INK, linewidth=0.9)
    axes.axhline(1e3 * most, color=INK, **LIMIT)
    axes.set_ylim(0.0, 1.15e3 * max(most, float(speed.max())))
    axes.set_ylabel("[mm/s]")
    box = "assumed" if plan.box_is_assumed else "object's"
    corner = f"fastest corner of the {box} box" if len(plan.corners) > 1 else "tip"
    write_title(axes, f"speed of the {corner}")


def _draw_widths(axes: "Axes", plan: Plan) -> None:
    from matplotlib.ticker import LogLocator

    forecast = plan.forecast
    for name, (label, unit, factor, marker) in QUANTITIES.items():
        known = [getattr(each, name) for each in forecast.accuracy]
        values = factor * np.array(known, dtype=float)  # None, where open, is NaN
        values[~np.isfinite(values)] = np.nan
        look: dict[str, Any] = {"color": INK, "marker": marker, "markersize": 2.5}
        look["clip_on"] = False  # the last point is on the frame
        label = f"{label} [{unit}]"
        axes.plot(forecast.time, values, linewidth=0.9, label=label, **look)
        asked = None if plan.asked is None else getattr(plan.asked, name)
        if asked is not None and np.isfinite(asked):
            axes.axhline(factor * asked, markevery=[0], **look, **LIMIT)
    axes.set_yscale("log")
    axes.set_ylabel("± 95 %")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")
    if plan.asked is not None:
        write_title(axes, "dashed: asked")
    _legend_above(axes)


def _columns(names: tuple[str, ...]) -> int:
    longest = max(min(len(name), LONGEST_NAME) for name in names)
    return min(max(LINE_OF_NAMES // (longest + BESIDE_NAME), 1), len(names))


def _draw_joint_legend(figure: "SubFigure", names: tuple[str, ...]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], linewidth=0.9, label=name[:LONGEST_NAME], **look)
        for name, look in zip(names, cycle(JOINTS), strict=False)
    ]
    draw_legend(figure, handles, _columns(names), handlelength=1.6)


def _legend_above(axes: "Axes") -> None:
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(-0.02, 0.96),
        ncols=len(axes.get_lines()),
        borderaxespad=0.0,
        handlelength=1.2,
        columnspacing=1.0,
    )
