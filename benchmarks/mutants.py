"""`python -m benchmarks.mutants [--count N] [--seed S]`: whether the tests notice small
changes of the source.

A sample, drawn evenly from all mutants of `core`, `estimators` and `ingest`
(`benchmarks/mutation/operators.py` says which there are), is written one by one into
copies of the source. Tests that execute the changed line run on it, the quickest first,
until one fails; a mutant is killed by a test that fails, takes ten times as long, or
ends. Which tests execute which lines is measured once, and again where a file has
changed (`.mutants/`, some 15 minutes). Not run are tests that start programs or
browsers, recordings of others, and, beyond `--limit` s for one mutant, the slower
tests: the share that is killed is a lower bound.

`--json FILE` keeps what came of each mutant; given again, tests that killed a mutant
come first. `--docs` writes the table of `docs/mutants.md` from such files, with the
reasons of `benchmarks/mutation/reasons.json` why survivors are left.
"""

import argparse
import json
import random
import sys
from pathlib import Path

from benchmarks.mutation.choice import PACKAGES, TestMap, test_files
from benchmarks.mutation.forks import ROOT
from benchmarks.mutation.mutate import Mutant, find_mutants
from benchmarks.mutation.page import share, write_page
from benchmarks.mutation.run import Outcome, failing_without, run_mutants


def main() -> None:
    """Draw mutants, run the tests on each, and tell what share was killed."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.mutants",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=300, help="mutants in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--packages", default=",".join(PACKAGES))
    parser.add_argument("--only", nargs="+", help="files, such as core/spatial.py")
    parser.add_argument("--key", help="only mutants whose key contains this")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument(
        "--limit", type=float, default=60.0, help="seconds of tests for one mutant"
    )
    parser.add_argument("--json", type=Path, help="what came of each mutant")
    parser.add_argument("--docs", type=Path, nargs="+", help="files of --json")
    a = parser.parse_args()
    if a.docs:
        write_page(a.docs)
        return

    drawn = draw(candidates(a.packages.split(","), a.only, a.key), a.count, a.seed)
    tests = TestMap(ROOT / ".mutants", test_files(), a.jobs)
    known = _known(a.json)
    outcomes = []
    for outcome in run_mutants(drawn, tests, a.jobs, a.limit, known):
        outcomes.append(outcome)
        print(f"{_line(len(outcomes), len(drawn), outcome)}", flush=True)
        if a.json:
            found = [outcome.as_json() for outcome in outcomes]
            a.json.write_text(json.dumps(found, indent=1) + "\n")
    failing = failing_without({o.test for o in outcomes if o.test}, a.jobs)
    for test in sorted(failing):
        print(f"fails without any mutant: {test}")
    print(shares(outcomes))
    sys.exit(bool(failing))


def candidates(
    packages: list[str], only: list[str] | None, key: str | None
) -> list[Mutant]:
    """All mutants of the packages, or of some files of them."""
    sources = ROOT / "src"
    files = [
        str(path.relative_to(sources))
        for package in packages
        for path in sorted((sources / "hefting" / package).rglob("*.py"))
    ]
    return [
        mutant
        for file in files
        if not only or any(file.endswith(name) for name in only)
        for mutant in find_mutants(sources, file)
        if not key or key in mutant.key
    ]


def draw(mutants: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """A sample, drawn evenly and without repetition."""
    return random.Random(seed).sample(mutants, min(count, len(mutants)))


def shares(outcomes: list[Outcome]) -> str:
    """Killed and all mutants, by package and by operator."""
    found = [outcome.as_json() for outcome in outcomes]
    lines = [f"killed: {share(found)}"]
    for kind in ("package", "operator"):
        for name in sorted({outcome[kind] for outcome in found}):
            group = [outcome for outcome in found if outcome[kind] == name]
            lines.append(f"  {name}: {share(group)}")
    return "\n".join(lines)


def _known(file: Path | None) -> dict[str, str]:
    if file is None or not file.exists():
        return {}
    return {found["key"]: found["test"] for found in json.loads(file.read_bytes())}


def _line(number: int, count: int, outcome: Outcome) -> str:
    word = "killed" if outcome.killed else "SURVIVED"
    by = outcome.test if outcome.killed else outcome.how
    return (
        f"{number}/{count} {word} {outcome.mutant.operator}: {outcome.mutant.key}"
        f" | {by} ({outcome.tests} tests, {outcome.seconds:.1f} s)"
    )


if __name__ == "__main__":
    main()
