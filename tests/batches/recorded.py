"""A few recordings of one object, whole and broken, made once."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

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
def _files() -> dict[str, bytes]:
    with TemporaryDirectory() as name:
        folder = Path(name)
        for k in range(WHOLE):
            write_recording((str(folder / f"whole-{k}.csv"), k + 1, None))
        lines = (folder / "whole-0.csv").read_text().splitlines(keepends=True)
        for k, broken in enumerate(BREAKS):
            broken(folder / f"broken-{k}.csv", lines)
        return {path.name: path.read_bytes() for path in folder.iterdir()}


def recorded(folder: Path) -> Recorded:
    """The recordings, in a folder that a test may change."""
    (data := folder / "data").mkdir()
    for name, content in _files().items():
        (data / name).write_bytes(content)
    return Recorded(data, write_shape(folder))
