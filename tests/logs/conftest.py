"""The table of several files of tests, and what a file of it is read as."""

import pytest

from hefting.logs import read_log
from table_of_log import table


@pytest.fixture
def frame():
    return table()


@pytest.fixture
def read(frame, tmp_path):
    """The recording of the same table in a file."""
    frame.to_parquet(tmp_path / "log.parquet")
    return read_log(tmp_path / "log.parquet")
