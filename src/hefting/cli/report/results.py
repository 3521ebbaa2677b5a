"""Output of hefting identify: the result of one method, or of several, and the written
files."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hefting.cli.parser import wrote

if TYPE_CHECKING:
    from hefting.core.accuracy import Errors
    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.export import Exported
    from hefting.identification.compare import Comparison


@dataclass(frozen=True)
class Results:
    """Estimates, and the files with them."""

    estimates: "dict[str, Estimate]"
    """by method"""
    best: str
    """the recommended method, or the only one"""
    comparison: "Comparison | None"
    """None for a single method"""
    truth: "InertialParameters | None"
    errors: "dict[str, Errors]"
    """by method; empty without a truth"""
    written: "list[tuple[str, Exported]]"
    pictures: tuple[str, ...] = ()


def print_json(results: Results, render: Callable[[str], str]) -> None:
    """Print the results as one JSON object; `render` replaces the library's names of
    arguments by the reader's."""
    import json

    from hefting.core.estimate_json import METHODS_SCHEMA

    estimates = _estimates_json(results)
    out = best = estimates[results.best]
    if comparison := results.comparison:
        out = {
            "schema": METHODS_SCHEMA,
            **{key: best[key] for key in ("version", "verdict", "reasons")},
            "results": [
                r | {"seconds": comparison.seconds[name]}
                for name, r in estimates.items()
            ],
            "recommended": results.best,
            "reason": comparison.reason,
            "skipped": comparison.skipped,
        }
    print(render(json.dumps(out)))


def _estimates_json(results: Results) -> dict[str, dict[str, Any]]:
    """Each estimate by method, with its errors; the best one also with warnings of the
    written files."""
    from hefting.core.estimate_json import coded, json_ready

    estimates = {k: e.to_dict() for k, e in results.estimates.items()}
    for name, found in results.errors.items():
        estimates[name]["errors"] = json_ready(found.to_dict())
    best = estimates[results.best]
    for path, exported in results.written:
        for line in exported.warnings:
            text = f"{path}: {line}"
            best["warnings"].append(text)
            best["messages"].append(coded(line).to_dict() | {"text": text})
    return estimates


def print_results(
    results: Results, render: Callable[[str], str], verbose: bool
) -> None:
    """Print the results as a table, then the written files; `render` as in `print_json`,
    `verbose` as in `estimate_report`."""
    comparison, best = results.comparison, results.best
    if comparison:
        from hefting.cli.report.methods import comparison_report
        from hefting.cli.report.printing import print_report

        print_report(
            comparison_report(comparison, results.errors, verbose, results.truth),
            render,
        )
    else:
        from hefting.cli.report.estimate import estimate_report, print_lines

        report = estimate_report(
            results.estimates[best], results.truth, results.errors.get(best), verbose
        )
        print_lines(report, render)
    for path, exported in results.written:
        wrote(f"{path} ({best + ', ' if comparison else ''}{exported.frame} axes)")
        for line in exported.warnings:
            print(f"warning: {render(line)}")
    for path in results.pictures:
        wrote(path)
