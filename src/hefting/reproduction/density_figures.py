"""Figures of the experiment on the density of points."""

import numpy as np

from hefting.plots.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, drawing
from hefting.reproduction.experiment import Job, Result
from hefting.reproduction.setting import legend_above, marked


def accuracy_figure(densities: list[float], found: dict[str, dict[str, np.ndarray]]):
    """Mean over the objects, with its standard error."""
    panels = {
        "mass": "mass error [%]",
        "center_of_mass": "COM error [%]",
        "inertia_at_origin": "inertia error [%]",
    }
    lines = (
        ("moderate", 0, VERMILION, "o", "moderate noise, 1.5 s"),
        ("moderate, lambda kept", 0, ORANGE, "D", "the same, lambda kept"),
        ("moderate", 1, BLUE, "^", "moderate noise, 35 s"),
        ("noise-free", 1, GREEN, "s", "noise-free, 35 s"),
    )
    with drawing(4.2) as figure:
        for axes, (name, label) in zip(
            figure.subplots(3, 1, sharex=True), panels.items(), strict=True
        ):
            for k, (series, time_index, colour, marker, what) in enumerate(lines):
                values = found[series][name][:, time_index]
                error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
                shown = marked(colour, marker) | {"elinewidth": 0.6}
                place = np.array(densities) * 1.03 ** (k - 1.5)
                axes.errorbar(
                    place,
                    np.maximum(values.mean(axis=0), 1e-12),
                    error,
                    label=what,
                    **shown,
                )
            axes.set(xscale="log", yscale="log", ylabel=label)
        axes.set_xlabel("points/cm³")
        axes.set_xticks(densities, [f"{d:g}" for d in densities])
        axes.set_xticks([], minor=True)
        figure.align_ylabels()
        legend_above(figure, axes, 2)
    return figure


def times_figure(timed: list[tuple[Job, Result]], counts: tuple[int, ...]):
    """One line a density."""
    colours = (SKY, BLUE, VERMILION, ORANGE, GREEN, PURPLE)
    with drawing(2.6) as figure:
        left, right = figure.subplots(1, 2, sharey=True)
        for k, (_, result) in enumerate(timed):
            line = marked(colours[k], "os^Dv*"[k])
            left.plot(
                counts,
                1e3 * np.array(result["solve"]),
                label=f"{result['points']} points",
                **line,
            )
            right.plot(counts, 1e3 * np.array(result["whole"]), **line)
        left.set(
            ylim=(0.0, None),
            ylabel="time [ms]",
            xlabel="observations",
            title="estimate from the moments",
        )
        right.set(xlabel="observations", title="all folded, then estimated")
        for axes in (left, right):
            axes.set_xlim(0, 1.03 * counts[-1])
            axes.set_xticks([0, 1000, 2000, 3000])
        legend_above(figure, left, 3)
    return figure
