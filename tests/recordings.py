"""Recordings nobody here made: where they are, which ones the tests use, and the mark
of tests that need them."""

import os
from pathlib import Path

import pytest
from benchmarks.accuracy_tools import NAMES

DATA = Path(os.environ.get("HEFTING_DATA") or "no-recordings")
"""Folder that the environment variable HEFTING_DATA names."""
TOOL_FOLDERS = tuple(DATA / "workshop-tools" / name for name in NAMES)
"""Folders of the simulated workshop tools."""
LOGS = (
    *(DATA / f"panda-optoforce/{name}.csv" for name in ("run1", "run3")),
    *(
        DATA / f"kuka-ati/{name}.csv"
        for name in ("baseline", "static_poses", "vibrations")
    ),
    *(DATA / f"axia80/{name}.csv" for name in ("dwells", "poses7")),
    *(folder / "log.csv" for folder in TOOL_FOLDERS),
)
"""Every recording the tests read."""

needs_recordings = pytest.mark.skipif(
    not DATA.is_dir(),
    reason="recordings not there: set the environment variable HEFTING_DATA to their folder",
)
