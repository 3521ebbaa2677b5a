"""`python -m benchmarks.mistakes [--seeds N] [--only NAME]`: what is said of mistakes
that people make.

Each mistake in each strength, in N simulated recordings, with and without a shape:
whether it is named, what the verdict is, and whether an answer that is called good is
wrong beyond twice its interval. Some fifteen minutes for ten seeds on two cores.
"""

import argparse
import os
from collections import defaultdict
from collections.abc import Iterable, Sequence

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

from benchmarks.mistake_runs import Said  # noqa: E402


def main() -> None:
    """Print the table, and the totals."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mistakes")
    parser.add_argument("--seeds", type=int, default=10, help="recordings of each")
    parser.add_argument("--only", default="", help="mistakes whose name starts so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()

    said = run(arguments.seeds, arguments.only, arguments.jobs)
    print("\n".join(table(said)))
    print("\n".join(totals(said)))


def run(seeds: int, only: str = "", jobs: int = 1) -> list[Said]:
    """What is said of every mistake, with and without a shape."""
    from concurrent.futures import ProcessPoolExecutor

    from benchmarks.mistaken import mistakes

    work = [
        (i, seed)
        for i, mistake in enumerate(mistakes())
        if mistake.name.startswith(only)
        for seed in range(seeds)
    ]
    if jobs == 1:
        return [each for task in work for each in both(task)]
    with ProcessPoolExecutor(jobs) as pool:
        return [each for found in pool.map(both, work, chunksize=4) for each in found]


def both(task: tuple[int, int]) -> list[Said]:
    """Of one mistake, by its index, and seed."""
    from benchmarks.mistake_runs import said_of
    from benchmarks.mistaken import mistakes

    index, seed = task
    mistake = mistakes()[index]
    kinds = (True,) if mistake.needs_shape else (False, True)
    return [said_of(mistake, seed, with_shape) for with_shape in kinds]


def table(said: Sequence[Said]) -> Iterable[str]:
    """One row a mistake and strength."""
    rows: dict[tuple[str, str], list[Said]] = defaultdict(list)
    for each in said:
        rows[each.mistake, each.strength].append(each)
    yield "| mistake | strength | named, of tellable | good | care | do not use (refused) | wrong | good but wrong |"
    yield "|---|---|---|---|---|---|---|---|"
    for (name, strength), some in rows.items():
        levels = [each.verdict for each in some]
        told = [s.named for s in some if s.tellable]
        named = f"{sum(told)} of {len(told)}"
        refused = sum(s.refused for s in some)
        yield (
            f"| {name} | {strength} | {named} | {levels.count('good')} | "
            f"{levels.count('usable with care')} | {levels.count('do not use')} "
            f"({refused}) | {sum(s.is_wrong for s in some)} | "
            f"{sum(s.beyond and s.verdict == 'good' for s in some)} |"
        )


def totals(said: Sequence[Said]) -> Iterable[str]:
    """What the table comes to."""
    tellable = [s for s in said if s.tellable]
    matter = [s for s in tellable if s.matters]
    wrong = [s for s in tellable if s.is_wrong or s.refused]
    yield f"{len(said)} identifications"
    bad = [s for s in said if s.beyond and s.verdict == "good"]
    untold = sum(not s.tellable for s in bad)
    yield (
        f"good, but beyond twice its interval: {len(bad)}, {untold} of which no data "
        "can tell"
    )
    yield f"named, of those that data can tell: {_share(s.named for s in tellable)}"
    yield f"named, of those that change the answer: {_share(s.named for s in matter)}"
    stopped = _share(s.verdict == "do not use" for s in wrong)
    yield f"not to be used, of those that are wrong or refused: {stopped}"
    answered = [s for s in wrong if not s.refused]
    stopped = _share(s.verdict == "do not use" for s in answered)
    yield f"not to be used, of answers that are wrong: {stopped}"


def _share(flags: Iterable[bool]) -> str:
    values = list(flags)
    return f"{_percent(sum(values), len(values))} of {len(values)}"


def _percent(count: int, of: int) -> str:
    return f"{100.0 * count / max(of, 1):.1f} %"


if __name__ == "__main__":
    main()
