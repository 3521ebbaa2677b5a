"""Reference values: the numbers of each case as they were when they were last renewed,
and what differs from them.

`python tests/reference/renew.py` writes them.
"""

import json
import math
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from reference.summaries import SINGLE, Values, summary

FOLDER = Path(__file__).parent / "values"
"""A file for each group of cases."""
TOLERANCE = 1e-6
"""Of the largest number of one name. Other libraries and processors, which add in
another order, change numbers by 1e-9 or so where an iteration has settled; a change of
the source that changes no number by so much is none."""
SMALLEST = 1e-6
"""Size below which numbers count as if they were of this size: what is left of them is
rounding, of forces of some newtons."""
RENEW = "where a change of results is meant: python tests/reference/renew.py"

Cases = Mapping[str, Callable[[], Any]]
"""By name: a function that returns the results of a case."""


def numbers_of(case: Callable[[], Any]) -> Values:
    """The numbers of a case, but for how often a solver repeated itself: rounding may
    ask for once more."""
    return summary(case(), omit=("iterations",))


@cache
def values_of(group: str) -> dict[str, Values]:
    """The values of a group of cases, by the case's name."""
    return json.loads((FOLDER / f"{group}.json").read_bytes())


def write_values(group: str, cases: Cases) -> None:
    """Run a group of cases, and write their values: a line for each name, so that a
    change shows what it changes. Numbers that differ by no more than the tolerance stay
    as they were."""
    blocks, path = [], FOLDER / f"{group}.json"
    kept = values_of(group) if path.exists() else {}
    for name, case in sorted(cases.items()):
        found, before = numbers_of(case), kept.get(name, {})
        for key in found.keys() & before.keys():
            if _distance(key, found[key], before[key], SMALLEST) <= TOLERANCE:
                found[key] = before[key]
        lines = [
            f"  {json.dumps(key)}: {json.dumps(numbers)}"
            for key, numbers in found.items()
        ]
        blocks.append(f" {json.dumps(name)}: {{\n" + ",\n".join(lines) + "\n }")
    path.write_text("{\n" + ",\n".join(blocks) + "\n}\n")


def differences(
    found: Values, expected: Values, smallest: float = SMALLEST
) -> list[str]:
    """What of the values differs by more than the tolerance, a line for each name."""
    lines = [f"{name}: is gone" for name in expected.keys() - found.keys()]
    lines += [f"{name}: is new" for name in found.keys() - expected.keys()]
    for name in expected.keys() & found.keys():
        off = _distance(name, found[name], expected[name], smallest)
        if off > TOLERANCE:
            lines.append(f"{name}: {found[name]}, not {expected[name]} ({off:.1g})")
    return sorted(lines)


def _distance(
    name: str, found: list[float], expected: list[float], smallest: float
) -> float:
    """The largest difference over the size of what is expected: over that of its
    largest number or, of single numbers, of each."""
    if len(found) != len(expected):
        return math.inf
    sizes = [
        abs(v) if abs(v) > smallest and v < math.inf else smallest for v in expected
    ]
    if not name.endswith(SINGLE):
        sizes = [max(sizes, default=smallest)] * len(sizes)
    parts = zip(found, expected, sizes, strict=True)
    return max((_apart(*part) for part in parts), default=0.0)


def _apart(found: float, expected: float, size: float) -> float:
    if found == expected or (math.isnan(found) and math.isnan(expected)):
        return 0.0
    off = abs(found - expected)
    return off / size if math.isfinite(off) else math.inf


def check(group: str, cases: Cases, name: str, smallest: float = SMALLEST) -> None:
    """Fail where the results of a case are not its reference values."""
    found = differences(numbers_of(cases[name]), values_of(group)[name], smallest)
    assert not found, "\n".join([f"{group}, {name}:", *found, RENEW])
