"""A few recordings of one object, whole and broken, written once."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from shutil import copytree
from tempfile import mkdtemp

from benchmarks.batch_recordings import BREAKS, write_recording, write_shape

WHOLE = 6


@dataclass(frozen=True)
class Recorded:
    """A folder of recordings: `whole` ones, then one `broken` in each way, all of which
    were the same before."""

    folder: Path
    shared: dict[str, str]
    """Options that say where the shape is."""

    @property
    def logs(self) -> list[Path]:
        """The first four of the whole ones, and all broken ones."""
        return [*self.whole[:4], *self.broken]

    @property
    def whole(self) -> list[Path]:
        return [self.folder / f"whole-{k}.csv" for k in range(WHOLE)]

    @property
    def broken(self) -> list[Path]:
        return [self.folder / f"broken-{k}.csv" for k in range(len(BREAKS))]


@cache
def _written() -> Path:
    folder = Path(mkdtemp(prefix="hefting-tests-"))
    for k in range(WHOLE):
        write_recording((str(folder / f"whole-{k}.csv"), k + 1, None))
    lines = (folder / "whole-0.csv").read_text().splitlines(keepends=True)
    for k, broken in enumerate(BREAKS):
        broken(folder / f"broken-{k}.csv", lines)
    return folder


def recorded(folder: Path) -> Recorded:
    """The recordings, in a folder that a test may change."""
    copytree(_written(), folder / "data")
    return Recorded(folder / "data", write_shape(folder))
