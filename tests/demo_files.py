"""The files of ``hefting demo``, without its pictures, made once for all tests that read
them."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from hefting.simulation import demo

PLACE = b"{the folder}"


def write_demo(folder: Path) -> None:
    """As `demo.run` writes them into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in _files().items():
        (folder / name).write_bytes(data.replace(PLACE, str(folder).encode()))


@cache
def _files() -> dict[str, bytes]:
    with TemporaryDirectory() as name:
        demo.run(name, pictures=False)
        return {
            path.name: path.read_bytes().replace(name.encode(), PLACE)
            for path in Path(name).iterdir()
        }
