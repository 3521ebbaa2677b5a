"""Mutated files of every kind: a few hundred of them in each run of the tests, and that
the fuzzing finds what it is there to find."""

import pickle
from collections import Counter

import numpy as np
import pytest
from bad_readers import bounded
from benchmarks.fuzzing.bytes_mutations import BYTES, TEXT
from benchmarks.fuzzing.outcome import run_command
from benchmarks.fuzzing.readers import READERS, make_case
from benchmarks.fuzzing.seeds import make_seeds
from benchmarks.fuzzing.workers import Fuzzer, run_case

from hefting.ingest.rivals import UNDONE, two_mistakes
from hefting.planning.result import INSTANTS
from hefting.planning.search import EFFORTS, Effort

pytestmark = pytest.mark.usefixtures("same_recordings")

COUNT = 8
"""Files of each reader."""
FEW = 3
"""Files of those that take seconds."""
COUNTS = {"mapped": 3}
"""Files of those that take tenths of a second, as all of them can be identified."""


@pytest.fixture
def _short_searches(monkeypatch):
    """A plan is searched in 20 steps, not 240, and expected to tell something at two
    instants, not six: files are read before the first. One mistake is undone, not ten,
    where two at once are looked for, as in most files that are read in spite of all."""
    monkeypatch.setitem(EFFORTS, "quick", Effort(10, 1, 2, 10, 0))
    monkeypatch.setitem(INSTANTS, "quick", 2)
    monkeypatch.setattr(two_mistakes, "UNDONE", UNDONE[:1])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("seeds")


@pytest.fixture(scope="module")
def seeds(folder):
    return make_seeds(folder)


FAILED_ONCE = (
    ("csv", 12, 1037),  # q999: an error of a thousand columns
    ("csv", 12, 4102),  # values of 1e300: singular equations of a change
    ("mapped", 12, 751),  # two samples a minute: too slow for any filter
    ("parquet", 12, 604),  # values of which a step overflows
    ("db3", 12, 606),  # one pose
    ("parquet", 13, 1756),  # times of 1e-242 s
    ("options", 14, 797),  # a shape of thousands of characters, repeated in the error
    ("estimate", 15, 883),  # a mass of 1e-210 kg
    ("estimate", 17, 2898),  # a warning that colours the terminal
    ("estimate", 17, 3625),  # made with a gravity of 1e300 m/s²
    ("estimate", 17, 2961),  # the same beside another
    ("plan-estimate", 2, 134),  # a covariance that is none
    ("plan-estimate", 2, 237),  # a noise that is a list
    ("arm", 13, 357),  # masses of which forces overflow when summed
)
"""Files, by reader, seed and number, that made a traceback or a warning."""


@pytest.mark.usefixtures("_short_searches")
@pytest.mark.parametrize(("name", "seed", "index"), FAILED_ONCE)
def test_files_that_failed_once_do_not(name, seed, index, folder, seeds, tmp_path):
    status, failure, details = run_case(
        name, seeds[name], seed, index, folder, tmp_path / "place"
    )
    assert not failure, details
    assert status in (0, 1, 2, 3)


@pytest.mark.usefixtures("_short_searches")
@pytest.mark.parametrize("name", READERS)
def test_mutated_files_are_read_or_refused_in_one_line(name, folder, seeds, tmp_path):
    place = tmp_path / "place"
    count = FEW if READERS[name].slow else COUNTS.get(name, COUNT)
    for index in range(count):
        status, failure, details = run_case(
            name, seeds[name], 2022, index, folder, place
        )
        assert not failure, f"{name} {index}: {failure}\n{details}"
        assert status in (0, 1, 2, 3)


def first_of(name, number, files):
    """Commands that read a whole file: every one; of the many shapes, and where each
    takes a second, one of them in turn."""
    every = READERS[name].first
    if files > len(every) or READERS[name].slow:
        return every[(number + 1) % len(every) :][:1]
    return every


# a whole map is read with a whole log: by "mapped"
WHOLE = [name for name in READERS if name not in ("options", "toml")]


@pytest.mark.usefixtures("_short_searches")
@pytest.mark.parametrize("name", WHOLE)
def test_whole_files_are_read(name, folder, seeds, tmp_path):
    """Else mutated ones would say nothing: they are refused before anything is read. A
    real-time record of random wrenches is inspected only."""
    for number, seed in enumerate(seeds[name]):
        place = tmp_path / str(number)
        for file, data in {**seed.beside, seed.name: seed.data}.items():
            (place / file).parent.mkdir(parents=True, exist_ok=True)
            (place / file).write_bytes(data)
        file = place / (seed.argument or seed.name)
        ended = [
            run_command([
                word.format(file=file, folder=folder, out=place / "out")
                for word in command.split()
            ])
            for command in first_of(name, number, len(seeds[name]))
        ]  # fmt: skip
        assert not any(outcome.failure for outcome in ended)
        assert any(outcome.status in (0, 3) for outcome in ended), seed.name


def test_cases_are_the_same_for_the_same_seed(folder, seeds, tmp_path):
    for name in READERS:
        cases = [
            make_case(name, seeds[name], seed, 3, folder, tmp_path)
            for seed in (1, 1, 2)
        ]
        assert cases[0] == cases[1]
        assert cases[0].data != cases[2].data


def test_mutations_change_what_they_are_given():
    """Most of the time: a line may be swapped with itself."""
    data = b"1.5,2,3\n4,5,6e3\n" * 20
    for mutation in (*BYTES, *TEXT):
        rng = np.random.default_rng(5)
        changed = [mutation(data, rng) != data for _ in range(20)]
        assert np.mean(changed) > 0.5, mutation


def test_hangs_memory_and_ends_of_processes_are_found(tmp_path):
    """Each ends the job and no other; what comes after is run by another process, as it
    is after two files. One that waits is found after 1.5 s by the clock; the others take
    none of that."""
    (tmp_path / "seeds.pickle").write_bytes(pickle.dumps({"csv": []}))
    fuzzer = Fuzzer(0, tmp_path, run=bounded, longest=0.25, most_files=2)
    found = dict(fuzzer.outcomes([("csv", index) for index in range(8)], 1))
    kinds = {index: outcome[1] for (_, index), outcome in found.items()}
    assert kinds == dict.fromkeys(range(8), "") | {
        1: "hang",
        3: "crash (7)",
        5: "memory",
        6: "hang",
    }


def test_failures_of_commands_are_told_apart(monkeypatch):
    def outcome(main):
        monkeypatch.setattr("hefting.cli.main", main)
        return run_command(["inspect", "x"]).failure

    def raising():
        raise KeyError("x")

    def noting():
        np.float64(1e300) * np.float64(1e300)

    def ending():
        raise SystemExit(7)

    def printing():
        print("text")
        raise SystemExit(2)

    found = [
        outcome(main) for main in (raising, noting, ending, printing, lambda: None)
    ]
    kinds = Counter(kind.split(" ")[0] for kind in found)
    assert kinds == Counter(("KeyError", "RuntimeWarning", "exit", "error", ""))
