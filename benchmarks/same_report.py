"""Two files of `benchmarks.same_answers` side by side."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

LIMIT = 0.1
"""Standard deviations of A beyond which a difference is listed."""
SHARE = 1e-3
"""Of the size of mass, first moment or inertia: stands for a deviation where no method
states one."""
GROUPS = (slice(1), slice(1, 4), slice(4, 10))
UPPER = np.triu_indices(3)
CLOCK = 1e-6
"""Differences of clock offsets that count as such [s]."""


@dataclass(frozen=True, eq=False)
class Difference:
    """B's answer to one identification beside A's."""

    name: str
    method: str
    groups: tuple[str, ...]
    parameters: np.ndarray
    """(10,) |difference| in standard deviations of A"""
    center_of_mass: np.ndarray
    """(3,) the same"""
    inertia_at_com: np.ndarray
    """(6,) the same"""
    stds: np.ndarray
    """(n,) B's standard deviations over A's, of those that are finite"""
    widths: np.ndarray
    """(n,) B's widths of intervals over A's"""
    bias: float
    """largest difference over the residual's rms"""
    clock: float
    """difference of clock offsets [s]"""
    changed: tuple[str, ...]
    """what else is not the same: sign, bias model, ..."""

    @property
    def largest(self) -> float:
        """Of the ten parameters, COM and inertia about it."""
        every = (self.parameters, self.center_of_mass, self.inertia_at_com)
        return float(max(part.max() for part in every))

    @property
    def far(self) -> bool:
        """Whether it is to be listed."""
        return self.largest > LIMIT or any(
            what in ("error", "sign", "bias model") for what in self.changed
        )


def compared(a: Path, b: Path, messages: bool = False) -> int:
    """Print the comparison; 1 where answers are beyond `LIMIT`, in sign, or missing,
    else 0."""
    before, after = _read(a), _read(b)
    missing = sorted(map(" ".join, before.keys() ^ after.keys()))
    found = [
        difference(_told(before, *key), after[key]) for key in before if key in after
    ]
    console = Console(width=160)
    console.print(_table(found, a, b))
    far = [each for each in found if each.far]
    console.print(
        f"{len(far)} of {len(found)} beyond {LIMIT} standard deviations, or another sign, bias model or error"
    )
    for each in sorted(far, key=lambda each: -each.largest):
        console.print(f"  {_line(each)}", highlight=False)
        for which, said in (("A", before), ("B", after)):
            error = said[each.name, each.method].get("error")
            if error:
                console.print(f"    {which}: {error}", highlight=False)
    if messages:
        for each in found:
            _show_messages(
                before[each.name, each.method], after[each.name, each.method], console
            )
    if missing:
        console.print(
            f"only in one of them: {len(missing)}: {', '.join(missing[:3])}, ...",
            highlight=False,
        )
    seconds = [
        sum(said[each.name, each.method]["seconds"] for each in found)
        for said in (before, after)
    ]
    console.print(
        f"processor time of these identifications: {seconds[0]:.1f} s, {seconds[1]:.1f} s"
    )
    return 1 if far or missing else 0


def _told(
    answers: dict[tuple[str, str], dict[str, Any]], name: str, method: str
) -> dict[str, Any]:
    """An answer; of a method without covariance, with that of least squares."""
    answer, least_squares = answers[name, method], answers.get((name, "OLS"), {})
    if (
        "error" in answer
        or answer["covariance"] is not None
        or "error" in least_squares
        or not least_squares
    ):
        return answer
    return answer | {
        "deviations": {key: least_squares[key] for key in ("covariance", "std")}
    }


def difference(a: dict[str, Any], b: dict[str, Any]) -> Difference:
    """B's answer beside A's."""
    ends = (a["name"], a["method"], tuple(a["groups"]))
    nothing = np.zeros(1)
    if "error" in a or "error" in b:
        same = a.get("error") == b.get("error")
        changed = (
            ()
            if same
            else ("error",)
            if ("error" in a) != ("error" in b)
            else ("messages",)
        )
        return Difference(
            *ends, nothing, nothing, nothing, np.ones(1), np.ones(1), 0.0, 0.0, changed
        )
    x, y = np.array(a["vector"]), np.array(b["vector"])
    deviations = {
        name: _std(a, name) for name in ("vector", "center_of_mass", "inertia_at_com")
    }
    parameters = np.abs(x - y) / deviations["vector"]
    parts = {}
    for name in ("center_of_mass", "inertia_at_com"):
        gap = np.abs(np.array(a[name]) - b[name])
        parts[name] = (_upper(gap) if name == "inertia_at_com" else gap) / deviations[
            name
        ]
    told, tells = a["provenance"], b["provenance"]
    changed = [
        what
        for what, key in (
            ("sign", "wrench"),
            ("bias model", "bias"),
            ("rejected", "outliers"),
        )
        if told[key] != tells[key]
    ]
    changed += [what for what in ("messages", "samples") if a[what] != b[what]]
    clock = abs((told["clock_offset"] or 0.0) - (tells["clock_offset"] or 0.0))
    return Difference(
        *ends,
        parameters,
        parts["center_of_mass"],
        parts["inertia_at_com"],
        np.sqrt(_ratios(_variances(a), _variances(b))),
        _ratios(_widths(a), _widths(b)),
        _bias_difference(a, b),
        clock,
        tuple(changed),
    )


def _std(a: dict[str, Any], name: str) -> np.ndarray:
    """Deviations of A; where there are none, `SHARE` of what it found."""
    said = a.get("deviations", a)
    if said["covariance"] is not None:
        if name == "vector":
            return np.sqrt(_variances(said))
        std = said["std"][name]
        return _open(
            np.array(_upper(std) if name == "inertia_at_com" else std, dtype=float)
        )
    x = np.array(a["vector"])
    size = np.concatenate(
        [
            np.full(part.stop - (part.start or 0), np.linalg.norm(x[part]))
            for part in GROUPS
        ]
    )
    found = {
        "vector": size,
        "center_of_mass": size[1:4] / x[0],
        "inertia_at_com": size[4:],
    }[name]
    return SHARE * found


def _variances(a: dict[str, Any]) -> np.ndarray:
    """(10,) infinite where the data leave a parameter open."""
    if a["covariance"] is None:
        return np.full(10, np.inf)
    return _open(
        np.array([row[i] for i, row in enumerate(a["covariance"])], dtype=float)
    )


def _open(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.inf)


def _upper(tensor: Any) -> np.ndarray:
    return np.array(tensor, dtype=float)[UPPER]


def _widths(a: dict[str, Any]) -> np.ndarray:
    """Of mass, COM and inertia at both points, in one array."""
    if a["intervals"] is None:
        return np.full(16, np.inf)
    ends = [
        np.array(a["intervals"][name], dtype=float)
        for name in ("mass", "center_of_mass")
    ]
    ends += [
        np.array([_upper(end) for end in a["intervals"][f"inertia_at_{at}"]])
        for at in ("origin", "com")
    ]
    return np.concatenate([np.atleast_1d(high - low) for low, high in ends])


def _ratios(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of those that are finite in both; infinity where only one is."""
    known, knows = np.isfinite(a), np.isfinite(b)
    both = known & knows & (a > 0.0)
    return np.concatenate(
        (b[both] / a[both], np.full(int((known != knows).sum()), np.inf))
    )


def _bias_difference(a: dict[str, Any], b: dict[str, Any]) -> float:
    if a["bias"] is None or b["bias"] is None:
        return 0.0
    return float(
        (
            np.abs(np.array(a["bias"]) - b["bias"])
            / np.maximum(np.repeat(a["residual"], 3), 1e-9)
        ).max()
    )


def _table(found: list[Difference], a: Path, b: Path) -> Table:
    title = f"B = {b} beside A = {a}: |difference| in standard deviations of A, and ratios B / A"
    table = Table(show_edge=False, pad_edge=False, title=title, title_justify="left")
    table.add_column("", no_wrap=True)
    heads = (
        "n",
        "ten: max",
        "95 %",
        "COM: max",
        "95 %",
        "J_com: max",
        "95 %",
        "std",
        "intervals",
        "clock µs",
    )
    for name in (*heads, "bias"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("changed", overflow="fold", min_width=12)
    for name, each in _grouped(found):
        changed = [what for one in each for what in one.changed]
        counts = ", ".join(
            f"{what} {changed.count(what)}" for what in dict.fromkeys(changed)
        )
        parts = [
            text
            for part in ("parameters", "center_of_mass", "inertia_at_com")
            for text in _largest([getattr(one, part) for one in each])
        ]
        clock = max(one.clock for one in each)
        table.add_row(
            name,
            str(len(each)),
            *parts,
            _span([one.stds for one in each]),
            _span([one.widths for one in each]),
            f"{1e6 * clock:.1f}" if clock > CLOCK else "",
            f"{max(one.bias for one in each):.2g}",
            counts,
        )
    return table


def _grouped(found: list[Difference]) -> Iterator[tuple[str, list[Difference]]]:
    yield "all", found
    names = dict.fromkeys(group for each in found for group in each.groups)
    for name in sorted(names, key=lambda name: (name.startswith("simulated"), name)):
        yield name, [each for each in found if name in each.groups]


def _largest(parts: Iterable[np.ndarray]) -> tuple[str, str]:
    """The largest of all, and the 95th percentile of the identifications' largest."""
    each = np.array([part.max() for part in parts])
    return f"{each.max():.2g}", f"{np.percentile(each, 95.0):.2g}"


def _span(parts: Iterable[np.ndarray]) -> str:
    every = np.concatenate(list(parts))
    return f"{every.min():.3f}-{every.max():.3f}" if len(every) else ""


def _line(each: Difference) -> str:
    groups = " / ".join(
        f"{each.parameters[part].max():.2g}"
        for part in GROUPS
        if len(each.parameters[part])
    )
    changed = f"; changed: {', '.join(each.changed)}" if each.changed else ""
    com = f"COM {each.center_of_mass.max():.2g}, J_com {each.inertia_at_com.max():.2g}"
    return f"{each.name}, {each.method}: m / mc / J {groups}, {com}{changed}"


def _show_messages(a: dict[str, Any], b: dict[str, Any], console: Console) -> None:
    lines = [tuple(each.get("messages", [each.get("error")])) for each in (a, b)]
    if lines[0] != lines[1]:
        console.print(f"{a['name']}, {a['method']}", highlight=False, markup=False)
        for sign, ours, theirs in (("-", *lines), ("+", *lines[::-1])):
            for line in ours:
                if line not in theirs:
                    console.print(f"  {sign} {line}", highlight=False, markup=False)


def _read(file: Path) -> dict[tuple[str, str], dict[str, Any]]:
    answers = [json.loads(line) for line in file.read_text().splitlines()]
    return {(each["name"], each["method"]): each for each in answers}
