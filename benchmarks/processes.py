"""`python -m benchmarks.processes [--before PATH] [--json FILE] [--quick]`: whole
processes, start to end.

Processor time of a process, user and system, on one thread: of the command, beside that
of the code before (`benchmarks.parties.COMMIT`, from the history) and of the naive
script. The parties take turns; a ratio is the median of those of the rounds. The Panda
recordings are those in the folder that HEFTING_DATA names.
"""

import argparse
import os
import statistics
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.long_recording import written
from benchmarks.parties import HERE, NOW, MissingError, Party, Took, before, naive
from benchmarks.process_inputs import (
    HEAVY,
    LIGHT,
    MASSES,
    Shaped,
    box_recordings,
)
from benchmarks.report import Row, Section, saved, show
from benchmarks.timing import Timing

PANDA_GRAVITY = "0,0,-9.81"
PANDA_BOX = "box:-0.15,0.15,-0.15,0.15,-0.05,0.3"
DEMO_POSE = "0,-0.08,0.06,-0.7071068,0,0,0.7071068"
ROUNDS, ROWS, SAMPLES = 5, 1_000_000, 1000
QUICK_ROWS, QUICK_SAMPLES = 20_000, 100
MOST_MEMORY = 450.0
"""Of a million rows [MiB]."""


def main() -> None:
    """Time whole processes beside those of the code before and of the naive script, and
    print a table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.processes", description=main.__doc__
    )
    parser.add_argument(
        "--before",
        metavar="PATH",
        type=Path,
        help="checkout of the code before; default from git",
    )
    parser.add_argument(
        "--json", metavar="FILE", type=Path, help="write the figures to a file as well"
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="one round, and less of it: a check that it all runs",
    )
    parser.add_argument(
        "--only", metavar="TEXT", default="", help="sections whose title has it"
    )
    arguments = parser.parse_args()

    with TemporaryDirectory() as folder:
        every = Processes(Path(folder), arguments.before, arguments.quick).sections()
        sections = [
            make() for title, make in every if arguments.only.lower() in title.lower()
        ]
    show(sections)
    if arguments.json is not None:
        saved(sections, arguments.quick, arguments.json)


Work = Callable[[], float | Took]
"""A process, or a figure that one prints."""
Measurement = tuple[str, Callable[[], Section]]
"""Title, and what measures; it may be called again."""


@dataclass(frozen=True)
class Ratio:
    """Two works, one over the other."""

    what: str
    name: str
    """under which it is kept, the other party after a slash; empty: it is not kept"""
    ours: str
    theirs: str
    at_most: float | None = None

    @property
    def unit(self) -> str:
        """Of which it is a share."""
        return "of " + (self.name.rpartition("/")[2].partition("'")[0] or HEAVY)


@dataclass(frozen=True)
class Processes:
    """Every section; nothing is run, nor looked for, before it is measured."""

    folder: Path
    """for what the processes read"""
    given: Path | None = None
    """checkout of the code before; by default from the history"""
    quick: bool = False

    @cached_property
    def parties(self) -> dict[str, Party]:
        """Those that are there, ready to run; who is missing is told on standard
        error."""
        found = {"now": NOW}
        for name, find in (
            ("before", lambda: before(self.folder / "before", self.given)),
            ("naive", naive),
        ):
            try:
                found[name] = find()
            except MissingError as missing:
                print(missing, file=sys.stderr, flush=True)
        for party in found.values():
            party.warm_up()
        return found

    @property
    def rounds(self) -> int:
        """Of most sections."""
        return 1 if self.quick else ROUNDS

    def sections(self) -> Iterator[Measurement]:
        """Titles, and what measures each."""
        data = (
            Path(os.environ.get("HEFTING_DATA") or "no-recordings") / "panda-optoforce"
        )
        if data.is_dir():
            for run in ("run1",) if self.quick else ("run1", "run3"):
                title = f"Panda {run}, no shape"
                yield title, partial(self._panda, title, data / f"{run}.csv", run)
            if not self.quick:
                title = "identify, Panda run1, box"
                panda = Shaped(str(data / "run1.csv"), PANDA_BOX, gravity=PANDA_GRAVITY)
                yield title, partial(self._shaped, title, panda, 0.2, 0.06)
        else:
            print(
                "HEFTING_DATA names no folder that holds panda-optoforce: those are left out",
                file=sys.stderr,
            )
        title = "identify, demo, its mesh"
        yield title, partial(self._demo, title)
        title = f"identify, {LIGHT} and {HEAVY} moved alike"
        yield title, partial(self._light, title)
        title = "PMD, one sample streamed"
        yield title, partial(self._streamed, title)
        title = f"identify, {QUICK_ROWS if self.quick else ROWS:,} rows of CSV"
        yield title, partial(self._long, title)

    def _works(
        self, what: str, *arguments: str, prints: bool = False
    ) -> dict[str, Work]:
        """The same by this code and by that before; if it `prints`, its figure is what
        counts."""
        run = _printed if prints else Party.run
        names = [name for name in ("now", "before") if name in self.parties]
        return {
            f"{what}, {name}": partial(run, self.parties[name], *arguments)
            for name in names
        }

    def _panda(self, title: str, log: Path, run: str) -> Section:
        works: dict[str, Work] = {}
        ratios = []
        for command, at_most in (("identify", 0.2), ("inspect", 0.13)):
            works |= self._works(
                command, "-m", "hefting", command, str(log), "--gravity", PANDA_GRAVITY
            )
            ours, name = f"{command}, now", f"{command}, Panda {run}"
            ratios.append(
                Ratio(
                    f"{command} over before",
                    f"{name}/before",
                    ours,
                    f"{command}, before",
                    at_most,
                )
            )
            ratios.append(
                Ratio(
                    f"{command} over naive", f"{name}/naive", ours, "naive script", 1.0
                )
            )
        if "naive" in self.parties:
            arguments = (str(HERE / "naive.py"), str(log), "--gravity", PANDA_GRAVITY)
            works["naive script"] = partial(self.parties["naive"].run, *arguments)
        return _measured(title, works, ratios, self.rounds)[0]

    def _demo(self, title: str) -> Section:
        demo = self.folder / "demo"
        if not demo.exists():
            # the command's files, without its pictures
            code = "import sys; from hefting.simulation.demo import run; run(sys.argv[1], False)"
            NOW.run("-c", code, str(demo))
        shaped = Shaped(
            str(demo / "log.csv"), str(demo / "hammer.stl"), "mm", DEMO_POSE
        )
        return self._shaped(title, shaped, 0.35, 0.06)

    def _shaped(
        self, title: str, shaped: Shaped, at_most: float, second_at_most: float
    ) -> Section:
        works = self._works("identify", *shaped.command) | self._works(
            "a second", *shaped.twice, prints=True
        )
        process, second, name = "identify, before", "a second, now", f"second {title}"
        ratios = [
            Ratio(
                "identify over before",
                f"{title}/before",
                "identify, now",
                process,
                at_most,
            ),
            Ratio(
                "a second over before's process",
                f"{name}/before",
                second,
                process,
                second_at_most,
            ),
            Ratio(
                "a second over before's second",
                f"{name}/before's second",
                second,
                "a second, before",
            ),
        ]
        return _measured(title, works, ratios, self.rounds)[0]

    def _light(self, title: str) -> Section:
        works: dict[str, Work] = {}
        box = box_recordings(self.folder)
        for mass in MASSES:
            works |= self._works(
                mass, *Shaped(str(self.folder / f"{mass}.csv"), box).command
            )
        ratios = [
            Ratio(
                f"{LIGHT} over {HEAVY}, now",
                f"identify, {LIGHT}/{HEAVY}",
                f"{LIGHT}, now",
                f"{HEAVY}, now",
                1.0,
            ),
            Ratio(
                f"{LIGHT} over {HEAVY}, before",
                "",
                f"{LIGHT}, before",
                f"{HEAVY}, before",
            ),
            *(
                Ratio(
                    f"{m} over before",
                    f"identify, {m}/before",
                    f"{m}, now",
                    f"{m}, before",
                )
                for m in MASSES
            ),
        ]
        return _measured(title, works, ratios, self.rounds)[0]

    def _streamed(self, title: str) -> Section:
        samples = QUICK_SAMPLES if self.quick else SAMPLES
        what = "Measurements, update and estimate"
        works = self._works(what, str(HERE / "streamed.py"), str(samples), prints=True)
        ratios = [
            Ratio(
                "over before",
                "one streamed sample/before",
                f"{what}, now",
                f"{what}, before",
                0.6,
            )
        ]
        return _measured(title, works, ratios, self.rounds)[0]

    def _long(self, title: str) -> Section:
        log = written(QUICK_ROWS if self.quick else ROWS, self.folder)
        ours, theirs = "identify, now", "identify, before"
        works = self._works("identify", "-m", "hefting", "identify", str(log))
        ratios = [Ratio("over before", f"{title}/before", ours, theirs, 0.3)]
        section, took = _measured(title, works, ratios, min(self.rounds, 2))
        peaks = {
            name: max(one.peak for one in each if isinstance(one, Took)) / 2**20
            for name, each in took.items()
        }
        more = [
            Row(
                f"peak memory, {name}",
                figure=peak,
                unit="MiB",
                at_most=MOST_MEMORY if name == ours else None,
            )
            for name, peak in peaks.items()
        ]
        if theirs in peaks:
            over = peaks[ours] / peaks[theirs]
            more.append(
                Row(
                    "  over before",
                    figure=over,
                    unit="of before",
                    name=f"memory of {title}/before",
                )
            )
        return Section(title, (*section.rows, *more))


def _printed(party: Party, *arguments: str) -> float:
    """A figure that a process prints [s]."""
    return float(party.run(*arguments).said.split()[-1])


def _measured(
    title: str, works: dict[str, Work], ratios: list[Ratio], rounds: int
) -> tuple[Section, dict[str, list[float | Took]]]:
    """The section, and what every work took in each round."""
    took: dict[str, list[float | Took]] = {name: [] for name in works}
    for turn in range(rounds):
        names = list(works) if turn % 2 == 0 else list(works)[::-1]
        for name in names:
            took[name].append(works[name]())
    cpu = {name: [_cpu(each) for each in found] for name, found in took.items()}
    rows = []
    for name, found in took.items():
        wall = [each.wall if isinstance(each, Took) else each for each in found]
        rows.append(Row(name, Timing(np.array(wall), np.array(cpu[name]), ())))
    for ratio in ratios:
        if ratio.ours in cpu and ratio.theirs in cpu:
            each = [
                ours / theirs
                for ours, theirs in zip(cpu[ratio.ours], cpu[ratio.theirs], strict=True)
            ]
            figure = statistics.median(each)
            rows.append(
                Row(
                    ratio.what,
                    None,
                    figure,
                    ratio.unit,
                    at_most=ratio.at_most,
                    name=ratio.name,
                )
            )
    return Section(title, tuple(rows)), took


def _cpu(took: float | Took) -> float:
    return took.cpu if isinstance(took, Took) else took


if __name__ == "__main__":
    main()
