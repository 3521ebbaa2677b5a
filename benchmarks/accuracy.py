"""`python -m benchmarks.accuracy [--tools] [--objects] [--seeds N] [--quick]`: Bayes,
PMD and the Cramér-Rao bound.

Twelve workshop tools with white noise (`benchmarks.accuracy_tools`), the recordings in
the folder that the environment variable HEFTING_DATA names; the paper's eight objects
with filtered and smoothed motion (`benchmarks.accuracy_objects`, needs MuJoCo). Both
unless one is asked for. A quarter of a minute for the tools, a minute for each seed of
the objects.
"""

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    from benchmarks.accuracy_objects import Run
    from benchmarks.accuracy_tools import Cell
    from hefting.core.spatial import Array

TOOL_SEEDS, OBJECT_SEEDS = 10, 3
QUICK_MOTION, QUICK_SPEED = 3.6, 1.5
"""Of a quick run: duration [s], which makes one window, and speed [rad/s]."""
THREE = "mass, COM, inertia"
BOUND = (
    "Bound: Cramér-Rao, of ten free parameters. It holds for unbiased estimators without knowledge of the shape: with\n"
    "a prior an estimator may be below it."
)


def main() -> None:
    """Compare Bayes with PMD and with the Cramér-Rao bound, and print tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.accuracy", description=main.__doc__
    )
    parser.add_argument(
        "--tools",
        action="store_true",
        help="twelve workshop tools (needs HEFTING_DATA)",
    )
    parser.add_argument(
        "--objects",
        action="store_true",
        help="the paper's eight objects (needs MuJoCo)",
    )
    seeds = f"realisations of the noise: {TOOL_SEEDS} of the tools, {OBJECT_SEEDS} of the objects by default"
    parser.add_argument("--seeds", type=int, metavar="N", help=seeds)
    parser.add_argument(
        "--quick",
        action="store_true",
        help="fewer and shorter: a check that it all runs",
    )
    arguments = parser.parse_args()
    if arguments.seeds is not None and arguments.seeds < 1:
        parser.error("there must be one seed at least")
    both = not (arguments.tools or arguments.objects)
    if arguments.tools or both:
        data = Path(os.environ.get("HEFTING_DATA") or "no-recordings")
        if (data / "workshop-tools").is_dir():
            show_tools(data, arguments.seeds or (1 if arguments.quick else TOOL_SEEDS))
        else:
            tell(
                "the tools are left out: HEFTING_DATA must name the folder that holds workshop-tools"
            )
            if not (arguments.objects or both):
                sys.exit(2)
    if arguments.objects or both:
        show_objects(
            arguments.seeds or (1 if arguments.quick else OBJECT_SEEDS), arguments.quick
        )


def show_tools(data: Path, seeds: int) -> None:
    """Ratios and errors of all tools, then of those of more than one density."""
    from benchmarks.accuracy_tools import HETEROGENEOUS, SAMPLES, cells, tools

    found: list[Cell] = []
    subjects = tools(data)
    for cell in cells(subjects, seeds):
        tell(f"tools: {cell.count} samples, {cell.level} noise")
        found.append(cell)
    print(
        f"\n{len(subjects)} workshop tools, {seeds} realisations of the noise each, which Bayes is told; the motion is "
        "stop-and-go\nat 100 Hz. WLS: ten parameters by weighted least squares with the true motion. PMD: as the "
        "paper has it."
    )
    _show_ratios("All tools", found)
    _show_errors("All tools", found, ("Bayes", "PMD", "WLS"))
    several = [cell.of(HETEROGENEOUS) for cell in found]
    long = [cell for cell in several if cell.count == max(SAMPLES)]
    what = "Tools of more than one density"
    print(f"\n{what}: {', '.join(HETEROGENEOUS)}. HPS is told their parts.")
    _show_ratios(what, several)
    for count in SAMPLES:
        ratio = over_pmd([cell for cell in several if cell.count == count])
        print(f"{count:,} samples, all noise together: {three(ratio)} of PMD's median")
    _show_errors(what, long, ("Bayes", "PMD", "HPS"))
    print(f"\n{BOUND}")


def over_pmd(found: "Sequence[Cell]") -> "Array":
    """(3,) Bayes' median errors in all of these cells together over PMD's."""
    import numpy as np

    bayes, pmd = (
        np.median(
            np.concatenate([c.errors[name].reshape(-1, 3) for c in found]), axis=0
        )
        for name in ("Bayes", "PMD")
    )
    return bayes / pmd


def _show_ratios(what: str, found: "Sequence[Cell]") -> None:
    import numpy as np

    rows, means = [], []
    for cell in found:
        each = {name: errors.reshape(-1, 3) for name, errors in cell.errors.items()}
        median, mean = (
            {name: of(e, axis=0) for name, e in each.items()}
            for of in (np.median, np.mean)
        )
        means.append(mean["Bayes"] / mean["PMD"])
        of_tools = cell.errors["Bayes"].mean(axis=1) / cell.errors["PMD"].mean(axis=1)
        above = [
            f"{name} ({worst(r)})"
            for name, r in zip(cell.tools, of_tools, strict=True)
            if (r > 1.0).any()
        ]
        over_wls = median["Bayes"][0] / median["WLS"][0]
        row = (
            three(median["Bayes"] / median["PMD"]),
            f"{over_wls:.2f}",
            three(means[-1]),
        )
        rows.append((cell.level, f"{cell.count:,}", *row, ", ".join(above) or "none"))
    columns = (
        "noise",
        "samples",
        "median over PMD's",
        "mass over WLS's",
        "mean over PMD's",
        "tools with a mean above PMD's",
    )
    table(
        f"{what}: Bayes' errors ({THREE}) over PMD's, and its median error of the mass over that of WLS",
        columns,
        rows,
    )
    high = int((np.array(means) > 1.0).sum())
    print(
        f"Of these {3 * len(means)} ratios of means {high or 'none'} {'is' if high == 1 else 'are'} above 1."
    )


def worst(ratios: Iterable[float]) -> str:
    """Which of mass, COM and inertia are above 1, and how much."""
    return ", ".join(
        f"{n} {r:.2f}"
        for n, r in zip(THREE.split(", "), ratios, strict=True)
        if r > 1.0
    )


def _show_errors(what: str, found: "Sequence[Cell]", methods: tuple[str, ...]) -> None:
    import numpy as np

    for name, of in (("median", np.median), ("mean", np.mean)):
        rows = []
        for cell in found:
            errors = [three(of(cell.errors[method], axis=(0, 1))) for method in methods]
            for motion, drawn in cell.bounds.items():
                bound = (
                    np.median(drawn, axis=(0, 1))
                    if name == "median"
                    else cell.bound_means[motion].mean(axis=0)
                )
                errors.append(three(bound))
            rows.append((cell.level, f"{cell.count:,}", *errors))
        columns = (
            "noise",
            "samples",
            *methods,
            "bound, motion known",
            "bound, motion noisy",
        )
        table(
            f"{what}: {name} errors [%] ({THREE}), and those at the bound",
            columns,
            rows,
        )


def show_objects(seeds: int, quick: bool) -> None:
    """Errors, ratios and coverage by setting and speed."""
    from benchmarks.accuracy_objects import NOISE, SETTINGS, SPEEDS, runs
    from hefting.reproduction.experiment import DURATION, OBJECTS

    speeds, duration = ((QUICK_SPEED,), QUICK_MOTION) if quick else (SPEEDS, DURATION)
    found: dict[tuple[str, float], list[Run]] = {
        (name, speed): [] for name in SETTINGS for speed in speeds
    }
    for seed in range(1, seeds + 1):
        for speed in speeds:
            tell(f"objects: seed {seed} of {seeds}, {speed} rad/s")
            for name, each in runs(speed, seed, duration).items():
                found[name, speed] += each
    print(
        f"\nThe paper's {len(OBJECTS)} objects, 150 observations, {NOISE} noise of the wrench, which Bayes finds, "
        f"{len(found['warm', speeds[0]])} runs a row.\nPMD: as the paper has it."
    )
    print("\n".join(f"- {name}: {meaning}" for name, meaning in SETTINGS.items()))
    _show_means(found)
    _show_coverage(found)
    print(
        f"\n{BOUND}\nMotion noisy: with the filter's or smoother's errors as claimed, which a cold filter has wrong."
    )


def _show_means(found: "dict[tuple[str, float], list[Run]]") -> None:
    import numpy as np

    names = ("errors", "pmd", "known", "claimed")
    rows = [
        (
            setting,
            str(speed),
            *(
                three(np.mean([getattr(run, name) for run in each], axis=0))
                for name in names
            ),
        )
        for (setting, speed), each in found.items()
    ]
    columns = (
        "motion",
        "rad/s",
        "Bayes",
        "PMD",
        "bound, motion known",
        "bound, motion noisy",
    )
    table(
        f"Eight objects: mean errors [%] ({THREE}), and those at the bound",
        columns,
        rows,
    )


def _show_coverage(found: "dict[tuple[str, float], list[Run]]") -> None:
    import numpy as np

    from benchmarks.cramer_rao import GROUPS

    rows = []
    for (setting, speed), each in found.items():
        ratio = np.mean([run.errors for run in each], axis=0) / np.mean(
            [run.pmd for run in each], axis=0
        )
        held = 100.0 * np.array([run.held for run in each])
        rows.append(
            (
                setting,
                str(speed),
                three(ratio),
                f"{held.mean():.1f}",
                three(held[:, g].mean() for g in GROUPS),
            )
        )
    columns = ("motion", "rad/s", "mean over PMD's", "95 % hold", THREE)
    title = (
        f"Eight objects: Bayes' mean errors over PMD's ({THREE}), "
        "and how many of its 95 % intervals hold the truth [%]"
    )
    table(title, columns, rows)


def three(values: Iterable[float]) -> str:
    """Three numbers in three columns."""
    from hefting.reproduction.experiment import shown

    return " ".join(f"{shown(float(value)):>8}" for value in values)


def table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print rows of text under a title and headings."""
    widths = [max(map(len, column)) for column in zip(columns, *rows, strict=True)]
    print(f"\n{title}")
    for row in (columns, *rows):
        print(
            "  ".join(
                cell.ljust(width) for cell, width in zip(row, widths, strict=True)
            ).rstrip()
        )


def tell(line: str) -> None:
    """A line on standard error."""
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
