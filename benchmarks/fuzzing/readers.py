"""Which files are mutated how, and which commands read them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np

from benchmarks.fuzzing.bag_mutations import BAG, MCAP, SQLITE
from benchmarks.fuzzing.bytes_mutations import BYTES, TEXT, Mutation, choice
from benchmarks.fuzzing.seeds import Seed
from benchmarks.fuzzing.structure_mutations import (
    JSON,
    TOML,
    XML,
    glb_scene,
    json_line,
    npy_header,
    npz_member,
)
from benchmarks.fuzzing.table_mutations import TABLE, arrow_table, parquet_table

LOG = (
    "inspect {file} --json",
    "inspect {file} --gravity estimate",
    "identify {file} --method OLS",
    "identify {file} --method LMI --json",
    "identify {file}",
    "identify {file} --method RTLS --motion filter",
    "predict {folder}/estimate.json {file}",
    "convert {file} {out}.csv",
    "convert {file} {out}.mcap",
    "calibrate {file} --output {out}.json",
)
"""What is done with a log that `inspect` could read: one of these."""

SHAPE = (
    "identify {folder}/static.csv --shape {file} --unit m",
    "identify {folder}/static.csv --shape {file} --method PMD --json",
    "identify {folder}/static.csv --shape {file} --method GEO",
)
"""What is done with a shape: one of these."""


SIMULATED = "--duration 1 --rate 20"
"""A short simulation."""

PLANNED = "--tip tool --duration 1 --quick --keep z>=-1 --output {out}.csv"
"""A short plan."""


@dataclass(frozen=True)
class Reader:
    """One kind of file: how it is mutated, and which commands read it."""

    mutations: tuple[Mutation, ...]
    first: tuple[str, ...]
    """one of these commands reads every file"""
    then: tuple[str, ...] = ()
    """one of these follows where the first could, half of the time"""
    slow: bool = False
    """a file takes seconds: read only where it is asked for"""


def _into(target: str, link: str) -> Reader:
    """Files into which an estimate is put."""
    command = (
        f"export {{folder}}/estimate.json --to {target} --into {{file}} --link {link}"
    )
    return Reader(XML * 6 + TEXT, (command,))


READERS = {
    "csv": Reader(TABLE, ("inspect {file}",), LOG),
    "mapped": Reader(
        TABLE,
        ("inspect {file} --map {folder}/robot.toml",),
        ("identify {file} --map {folder}/robot.toml",),
    ),
    "parquet": Reader((parquet_table,) * 6 + BYTES, ("inspect {file}",), LOG),
    "npz": Reader((npz_member,) * 6 + BYTES, ("inspect {file}",), LOG),
    "mat": Reader(BYTES, ("inspect {file}",), LOG),
    "jsonl": Reader((json_line,) * 6 + TEXT, ("inspect {file}",), LOG),
    "arrow": Reader((arrow_table,) * 6 + BYTES, ("inspect {file}",), LOG),
    "ur": Reader(TABLE, ("inspect {file}",), LOG),
    "bag": Reader(BAG, ("inspect {file}",), LOG),
    "mcap": Reader(MCAP, ("inspect {file}",), LOG),
    "db3": Reader(SQLITE, ("inspect {file}",), LOG),
    "folder": Reader(SQLITE + TEXT, ("inspect {file}",), LOG),
    "estimate": Reader(
        JSON + TEXT,
        (
            "predict {file} {folder}/static.csv",
            "identify {folder}/static.csv --method OLS --tool {file}",
            "identify {folder}/static.csv --method OLS --bias {file}",
            "identify {folder}/static.csv --method OLS --truth {file} --shape box:-1,1,-1,1,-1,1",
            "export {file} --to urdf",
            "export {file} --to json",
            "export {file} --to csv",
            "export {file} --to usd",
            "export {file} --to ur --sensor-pose-in-flange 0,0,0.1,0,0,0,1",
            "export {file} --to kuka --sensor-pose-in-flange 0,0,0.1,0,0,0,1",
            "export {file} --to abb --sensor-pose-in-flange 0,0,0.1,0,0,0,1",
            "export {file} --to fanuc --sensor-pose-in-flange 0,0,0.1,0,0,0,1",
        ),
    ),
    "truth": Reader(
        JSON + TEXT, ("identify {folder}/static.csv --method OLS --truth {file}",)
    ),
    "bias": Reader(
        JSON + TEXT, ("identify {folder}/static.csv --method OLS --bias {file}",)
    ),
    "pose": Reader(
        JSON + TEXT,
        (
            "export {folder}/estimate.json --to ur --sensor-pose-in-flange {file}",
            "identify {folder}/static.csv --shape {folder}/box.stl --object-pose {file}",
        ),
    ),
    "toml": Reader(
        TOML * 6 + TEXT,
        ("inspect {folder}/robot.csv --map {file}",),
        ("identify {folder}/robot.csv --map {file}",),
    ),
    "urdf": Reader(
        XML * 8 + TEXT,
        ("inspect {folder}/joints.csv --urdf {file} --sensor-frame tool0",),
        (
            "identify {folder}/joints.csv --urdf {file} --sensor-frame tool0",
            "predict {folder}/estimate.json {folder}/joints.csv --urdf {file} --sensor-frame tool0",
        ),
    ),
    "inertials": Reader(
        XML * 8 + TEXT,
        (
            "check {file} --json",
            "check {file} --diff",
            "check {file} --repair {out}.urdf --diff",
        ),
    ),
    "into-urdf": _into("urdf", "tool0"),
    "into-mjcf": _into("mjcf", "object"),
    "into-sdf": _into("sdf", "object"),
    "mesh": Reader(TEXT + BYTES + (glb_scene,) * 5, SHAPE),
    "cloud": Reader(TEXT + BYTES + (npy_header,) * 5, SHAPE),
    "held": Reader(
        TEXT + BYTES + (glb_scene,) * 3,
        (f"simulate {{out}}.csv --object {{file}} --density 1000 {SIMULATED}",),
    ),
    "arm": Reader(
        XML * 8 + TEXT,
        (f"simulate {{out}}.csv --arm {{file}} --sensor-frame tool0 {SIMULATED}",),
    ),
    "plan-arm": Reader(
        XML * 8 + TEXT,
        (
            f"plan --urdf {{file}} {PLANNED}",
            f"plan --urdf {{file}} --box 0.1,0.1,0.1 {PLANNED}",
        ),
        slow=True,
    ),
    "plan-srdf": Reader(
        XML * 8 + TEXT,
        (f"plan --urdf {{folder}}/arm.urdf --srdf {{file}} {PLANNED}",),
        slow=True,
    ),
    "plan-estimate": Reader(
        JSON + TEXT,
        (f"plan --urdf {{folder}}/arm.urdf --estimate {{file}} {PLANNED}",),
        slow=True,
    ),
    "options": Reader(TEXT, ()),
}
"""Every kind of file by its name."""


@dataclass(frozen=True)
class Case:
    """One mutated file."""

    seed: Seed
    data: bytes
    commands: tuple[tuple[str, ...], ...]
    """words of the commands, in order; the later ones follow where the first ended
    well"""


def make_case(
    name: str, seeds: Sequence[Seed], seed: int, index: int, folder: Path, place: Path
) -> Case:
    """The mutated file of some number, the same for the same `seed`.

    `folder` holds what is read beside it, `place` is where it will be.
    """
    rng = np.random.default_rng([seed, crc32(name.encode()), index])
    reader, chosen = READERS[name], choice(rng, seeds)
    data = chosen.data
    for _ in range(min(int(rng.geometric(0.55)), 8)):
        data = choice(rng, reader.mutations)(data, rng)
    if name == "options":
        words = data.decode(errors="replace").replace("{folder}", str(folder))
        return Case(chosen, data, (tuple(_harmless(words.split("\n"))),))
    file = place / (chosen.argument or chosen.name)

    def words_of(command: str) -> tuple[str, ...]:
        return tuple(
            word.format(file=file, folder=folder, out=place / "out")
            for word in command.split()
        )

    commands = [words_of(choice(rng, reader.first))]
    if reader.then and rng.random() < 0.5:
        commands.append(words_of(choice(rng, reader.then)))
    return Case(chosen, data, tuple(commands))


def _harmless(words: list[str]) -> list[str]:
    """Words of a command, but for an output and what ends a word in C."""
    kept = [
        word.replace("\0", "?") for word in words if not word.startswith("--output")
    ]
    return [word[:100_000] for word in kept]
