"""`docs/mutants.md`: what share of the mutants was killed, and why the others were
not."""

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

from benchmarks.mutation.forks import ROOT
from benchmarks.mutation.mutate import find_mutants

PAGE = ROOT / "docs" / "mutants.md"
MARK = "<!-- written by python -m benchmarks.mutants --docs -->"
REASONS = Path(__file__).with_name("reasons.json")
"""Why a survivor is left, by its key: `equivalent`, `tolerable`, `later` (and by
which tests) or `open`, and the words."""


def write_page(samples: list[Path]) -> None:
    """Renew what stands below the mark of the page, from what `--json` kept; reasons of
    mutants that the sources no longer have are dropped."""
    reasons = still_there(json.loads(REASONS.read_bytes()), ROOT / "src")
    REASONS.write_text(json.dumps(reasons, ensure_ascii=False, indent=1) + "\n")
    found = {path.stem: json.loads(path.read_bytes()) for path in samples}
    lines = [PAGE.read_text().partition(MARK)[0] + MARK, "", "## Killed", ""]
    lines += _shares(found)
    lines += ["", "## Survivors", "", *_survivors(found, reasons)]
    PAGE.write_text("\n".join(lines) + "\n")


def still_there(reasons: dict[str, list[str]], sources: Path) -> dict[str, list[str]]:
    """The reasons whose mutants can still be made of the files in `sources`."""
    files = {key.partition(" ")[0] for key in reasons}
    there = [file for file in files if (sources / file).exists()]
    keys = {mutant.key for file in there for mutant in find_mutants(sources, file)}
    return {key: why for key, why in reasons.items() if key in keys}


def share(outcomes: list[dict[str, Any]]) -> str:
    """Killed among all, and the share."""
    killed = sum(outcome["killed"] for outcome in outcomes)
    return f"{killed} of {len(outcomes)}, {killed / len(outcomes):.1%}"


def _shares(found: dict[str, list[dict[str, Any]]]) -> list[str]:
    lines = ["| | " + " | ".join(found) + " |", "|---" * (len(found) + 1) + "|"]
    for kind in ("package", "operator"):
        names = {outcome[kind] for outcomes in found.values() for outcome in outcomes}
        for name in (["all"] if kind == "package" else []) + sorted(names):
            cells = []
            for outcomes in found.values():
                group = [o for o in outcomes if name in ("all", o[kind])]
                cells.append(share(group) if group else "")
            lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


def _survivors(
    found: dict[str, list[dict[str, Any]]], reasons: dict[str, list[str]]
) -> list[str]:
    groups = defaultdict(set)
    every = [outcome for outcomes in found.values() for outcome in outcomes]
    killed = {outcome["key"] for outcome in every if outcome["killed"]}
    for outcomes in found.values():
        for outcome in outcomes:
            if outcome["key"] not in killed:
                kind, why = reasons.get(outcome["key"], ("open", "not looked into"))
                file, _, rest = outcome["key"].partition(" ")
                function, _, change = rest.partition(": ")
                place = f"{file.removeprefix('hefting/')} {function}"
                groups[kind].add((place, change.replace("|", r"\|"), why))
    lines = []
    for kind, title in KINDS.items():
        if not groups[kind]:
            continue
        lines += [title, "", "| where | change | why it lives |", "|---|---|---|"]
        lines += [
            f"| `{place}` | `{change}` | {why} |"
            for place, change, why in sorted(groups[kind])
        ]
        lines.append("")
    return lines[:-1]


KINDS = {
    "equivalent": "**Equivalent**: no result differs.",
    "tolerable": "**Tolerable**: only speed, wording, or a judged constant differs.",
    "later": "**Killed since** by tests that were written for them, and not counted above.",
    "open": "**Open**: a test could tell, and none does.",
}
"""What is said of each kind of survivor, in the order of the page."""
