"""Batches: every recording has its row, whole or broken, once, whatever happens."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from recorded import recorded

import hefting
from hefting.batches import batch, group, results
from hefting.batches.batch import headline
from hefting.batches.columns import columns, flat, hash_of, table_of
from hefting.batches.one import row_of
from hefting.batches.recordings import Entry
from hefting.batches.results import TABLE, Results
from hefting.batches.summary import Reasons
from hefting.core import files
from hefting.core.errors import HeftingError, InputError
from hefting.request.request import check_request, request_of
from jobs_here import do_jobs_here


def assert_close(found, expected):
    """Equal but for the rounding of another number of threads."""
    size = np.abs(np.atleast_1d(expected)).max()
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8 * size)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A batch of whole and broken recordings, done in this process."""
    folder = tmp_path_factory.mktemp("batch")
    data = recorded(folder)
    with pytest.MonkeyPatch.context() as monkeypatch:
        do_jobs_here(monkeypatch)
        return data, batch(data.logs, folder / "results", **data.shared)


def test_every_whole_recording_is_identified_and_every_broken_one_named(done):
    data, found = done
    table = found.table().to_pandas().set_index("recording")
    assert len(table) == len(data.logs) == 4 + len(data.broken)
    for log in data.whole[:4]:
        assert table.loc[str(log), "verdict"] == "good"
    reasons = table.loc[[str(log) for log in data.broken]]
    assert (reasons["error"] == "InputError").all()
    assert reasons["error_text"].str.len().min() > 10
    assert not reasons["error_text"].str.contains("\n").any()
    assert reasons["error_text"].nunique() == len(data.broken)


def test_a_row_holds_what_identify_gives(done):
    data, found = done
    log = data.whole[2]
    row = next(r for r in found.table().to_pylist() if r["recording"] == str(log))
    alone = hefting.identify(
        log, data.shared["shape"], object_pose=data.shared["object_pose"]
    )
    told = alone.estimate.to_dict()
    for key in ("mass", "center_of_mass", "inertia_at_com", "covariance", "vector"):
        assert_close(row[key], flat(told[key]))
    for key, ends in told["intervals"].items():
        assert_close(row["intervals"][key], flat(ends))
    assert row["warnings"] == told["warnings"]
    assert (
        row["consistency"]["margins"]["mass"] == told["consistency"]["margins"]["mass"]
    )
    left_out = {"consistency", "intervals", "provenance", "messages"}
    assert set(told) - left_out <= set(row)
    assert set(row["seconds"]) == {"reading", "motion", "conditioning", "solving"}
    assert min(row["seconds"].values()) > 0.0


def test_pandas_polars_and_duckdb_read_it(done):
    import duckdb
    import pandas as pd
    import polars as pl

    _, found = done
    whole = found.table().num_rows
    assert len(pd.read_parquet(found.folder)) == whole
    assert len(pl.read_parquet(f"{found.folder}/*.parquet")) == whole
    query = f"select count(*), avg(mass) from '{found.folder}/*.parquet' where error is null"
    count, mean = duckdb.sql(query).fetchall()[0]
    table = found.table("mass", "error").to_pandas()
    assert count == table["error"].isna().sum()
    assert mean == pytest.approx(table["mass"].mean(), rel=1e-12)


def test_a_batch_again_goes_on_only_where_that_is_said(done):
    data, found = done
    with pytest.raises(InputError, match="has results already; give `resume`"):
        batch(data.whole, found.folder, **data.shared)


def test_what_is_the_same_stays_and_what_is_not_is_done_again(tmp_path, monkeypatch):
    do_jobs_here(monkeypatch)
    data = recorded(tmp_path)
    logs = [*data.whole[:3], data.broken[0]]
    first = batch(logs, tmp_path / "r", jobs=1, **data.shared)
    stamp = (tmp_path / "r" / TABLE).stat().st_mtime_ns
    again = batch(logs, tmp_path / "r", jobs=1, resume=True, **data.shared)
    assert again.progress.kept == len(logs)
    assert (tmp_path / "r" / TABLE).stat().st_mtime_ns == stamp
    assert again.table().equals(first.table())
    data.whole[0].write_bytes(data.whole[4].read_bytes())  # another content
    data.broken[0].write_bytes(data.whole[5].read_bytes())  # mended
    third = batch(logs, tmp_path / "r", jobs=1, resume=True, **data.shared)
    assert (third.progress.kept, third.progress.anew) == (2, 2)
    assert third.progress.failed == 0
    assert third.table().num_rows == len(logs)
    options = {**data.shared, "start": 2.0}
    other = batch(logs, tmp_path / "r", jobs=1, resume=True, **options)
    assert (other.progress.kept, other.progress.anew) == (0, 4)
    assert "4 replaced, of other options" in headline(other)
    assert "replaced" not in headline(again)
    assert other.table().num_rows == len(logs)


@pytest.mark.parametrize("option", [None, "shape", "poses"])
def test_what_may_have_no_end_is_a_row_that_says_so(tmp_path, option):
    """A device that ends at once: without the check there would be an answer."""
    (tmp_path / "log.csv").write_text("x")
    (tmp_path / "device.csv").symlink_to("/dev/null")
    device = str(tmp_path / "device.csv")
    said = {option: device} if option else {}
    row = row_of(
        (Entry(str(tmp_path / "log.csv") if option else device, None, None, said), None)
    )
    assert row["error_text"].startswith(f"{device}: is a pipe or a device")
    assert group._hash(Entry(device)) is None


def test_what_is_said_of_a_shape_that_a_row_has_not_fails_that_row(tmp_path):
    data = recorded(tmp_path)
    log = str(data.whole[0])
    rows = [
        {"recording": log, "name": "with", **data.shared},
        {"recording": log, "name": "pose", "object_pose": "0,0,0.1"},
        {"recording": log, "name": "unit", "unit": "mm"},
        {"recording": log, "name": "std", "pose_std": "1mm,1deg"},
        {"recording": log, "name": "plain"},
    ]
    found = batch(rows, tmp_path / "results", jobs=1, shape_std="5%")
    errors = found.table("name", "error_text").to_pydict()
    texts = dict(zip(errors["name"], errors["error_text"], strict=True))
    assert texts["with"] is texts["plain"] is None
    for name, option in (
        ("pose", "object-pose"),
        ("unit", "unit"),
        ("std", "pose-std"),
    ):
        fix = "give --shape FILE or --box X,Y,Z, or leave it out"
        assert texts[name] == f"--{option}: there is no shape; {fix}"


def test_a_column_map_of_one_of_two_files_is_no_mistake(tmp_path):
    """It names no poses, which are in the other file."""
    chosen = tmp_path / "map.toml"
    chosen.write_text("header = false\ntime = 1\nwrench = [2, 3, 4, 5, 6, 7]\n")
    check_request(request_of({"map": str(chosen), "poses": "robot.csv"}))
    with pytest.raises(InputError, match="neither an orientation nor joint angles"):
        check_request(request_of({"map": str(chosen)}))


def test_a_shared_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_BYTES", 2)
    (tmp_path / "a.csv").write_text("abc")
    with pytest.raises(InputError, match="more than 2 GiB"):
        hash_of(str(tmp_path / "a.csv"), {"shape": str(tmp_path / "a.csv")})


def test_a_content_moved_elsewhere_is_the_same(tmp_path):
    data = recorded(tmp_path)
    options = dict(data.shared)
    (kept,) = (
        row_of((Entry(str(log), options=options), None)) for log in data.whole[:1]
    )
    elsewhere = tmp_path / "mesh.ply"
    Path(options["shape"]).rename(elsewhere)
    moved = data.whole[0].rename(tmp_path / "moved.csv")
    entry = Entry(str(moved), options={**options, "shape": str(elsewhere)})
    assert row_of((entry, None))["hash"] == kept["hash"]


def test_faults_of_the_machine_are_tried_again_and_those_of_the_input_never(
    tmp_path, monkeypatch
):
    from hefting.batches import one

    data = recorded(tmp_path)
    monkeypatch.setattr(one, "PAUSES", (0.0, 0.0))
    calls = []

    def fails(error, times):
        def identify(request, log, shape):
            calls.append(log)
            if len(calls) <= times:
                raise error
            return real(request, log, shape)

        return identify

    real = one.estimate_of
    entry = Entry(str(data.whole[0]))
    for error, times, attempts, name in (
        (OSError(5, "Input/output error"), 2, 3, None),
        (OSError(5, "Input/output error"), 9, 3, "OSError"),
        (MemoryError(), 9, 3, "MemoryError"),
        (InputError("no good"), 9, 1, "InputError"),
        (ValueError("a mistake of ours"), 9, 1, "ValueError"),
    ):
        calls.clear()
        monkeypatch.setattr(one, "estimate_of", fails(error, times))
        row = row_of((entry, None))
        assert (len(calls), row["error"]) == (attempts, name)
        is_of_input = name in ("InputError", "ValueError", None)
        assert (row["hash"] is not None) == is_of_input, "or it is not tried again"
    assert "unexpected, please report it: a mistake of ours" in row["error_text"]


def test_a_recording_that_is_written_while_it_is_read_says_so(tmp_path, monkeypatch):
    from hefting.batches import one

    data = recorded(tmp_path)
    monkeypatch.setattr(one, "PAUSES", (0.0, 0.0))
    real = one.estimate_of

    def grows(request, log, shape):
        found = real(request, log, shape)
        with open(log, "a") as stream:
            stream.write("\n")
        return found

    monkeypatch.setattr(one, "estimate_of", grows)
    row = row_of((Entry(str(data.whole[0])), None))
    assert row["error"] == "ChangedError"
    assert "was written while it was read" in row["error_text"]
    assert row["hash"] is None


def test_a_recording_that_changes_before_it_is_condensed_says_so(tmp_path, monkeypatch):
    """Its hash is that of what was there; what is read may be another thing."""
    from hefting.batches import group, one

    data = recorded(tmp_path)
    monkeypatch.setattr(one, "PAUSES", (0.0, 0.0))
    real = one.hash_of

    def hash_of(log, options):
        found = real(log, options)
        with open(log, "a") as stream:
            stream.write("\n")
        return found

    monkeypatch.setattr(one, "hash_of", hash_of)
    told = group.condensed((Entry(str(data.whole[0])), []))
    assert told.error["error"] == "ChangedError"


def test_only_one_run_at_a_time_writes_to_a_folder(tmp_path, monkeypatch):
    do_jobs_here(monkeypatch)
    data = recorded(tmp_path)
    with (
        Results.opened(tmp_path / "r", False),
        pytest.raises(InputError, match=rf"process {os.getpid()} .* is writing there"),
    ):
        batch(data.whole, tmp_path / "r", jobs=1)
    assert batch(data.whole[:1], tmp_path / "r", jobs=1).progress.done == 1


def test_a_lock_on_a_file_that_was_taken_away_is_none(tmp_path, monkeypatch):
    """Another run ends, and takes its file away, between opening and locking."""
    path, opened = tmp_path / results.LOCK, []

    def locks(handle):
        opened.append(handle)
        if len(opened) == 1:
            path.unlink()
        return True

    monkeypatch.setattr(results, "lock", locks)
    with results.locked(tmp_path):
        assert len(opened) == 2
        assert path.read_text().startswith(f"process {os.getpid()} ")
    assert not path.exists()


def test_half_files_of_a_run_that_was_killed_are_gone(tmp_path):
    folder = tmp_path / "r"
    folder.mkdir()
    (folder / ".part-000001.parquet.x1").write_bytes(b"PAR1")
    with Results.opened(folder, False):
        assert [each.name for each in folder.iterdir()] == [".lock"]


def test_rows_written_last_count(tmp_path):
    def rows(mass, *names):
        return [{"recording": name, "mass": mass} for name in names]

    with Results.opened(tmp_path, False) as results:
        for row in rows(1.0, "c", "a", "b"):
            results.add(row)
        results.write()
        for row in rows(2.0, "d", "b"):
            results.add(row)
        results.gather("dcb")
        for row in rows(3.0, "a"):
            results.add(row)
        results.gather("dcba")
        (table,) = results.tables(["recording", "mass"])
    found = dict(zip(*(column.to_pylist() for column in table), strict=True))
    assert found == {"a": 3.0, "b": 2.0, "c": 1.0, "d": 2.0}
    assert "".join(found) == "dcba"
    assert [each.name for each in tmp_path.iterdir()] == [TABLE]


FULL = """
import resource, signal, sys
import hefting.jobs
from hefting.batches import batch
from hefting.core.errors import InputError
from jobs_here import Here
hefting.jobs.Processes = Here
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), resource.RLIM_INFINITY))
if __name__ == "__main__":
    try:
        batch(sys.argv[1], sys.argv[2], jobs=1)
    except InputError as error:
        print(error)
"""


KILLED = """
import json, os, signal, sys
from hefting.batches import batch, results
results.ROWS, results.SECONDS = 2, float("inf")
def kill(progress):
    if progress.done == 5:
        os.killpg(0, signal.SIGKILL)
if __name__ == "__main__":
    logs, folder, shared = map(json.loads, sys.argv[1:])
    batch(logs, folder, jobs=2, progress=kill, **shared)
"""


def test_a_full_disk_loses_nothing_and_is_said(tmp_path, monkeypatch):
    """A limit of the size of files stands for the disk: writing fails half way."""
    do_jobs_here(monkeypatch)
    data = recorded(tmp_path)
    script = tmp_path / "full.py"
    script.write_text(FULL)
    for log in (*data.broken, *data.whole[2:]):
        log.unlink(missing_ok=True)
    command = [sys.executable, script, data.folder, tmp_path / "r", "8000"]
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    told = subprocess.run(
        command, capture_output=True, text=True, check=True, env=paths
    )
    assert (
        "cannot be written (File too large); what was written before is kept"
        in told.stdout
    )
    assert [each.name for each in (tmp_path / "r").iterdir()] in ([], [".lock"])
    found = batch(data.folder, tmp_path / "r", jobs=1, resume=True)
    assert found.progress.done == 2


def test_a_batch_that_is_killed_and_resumed_gives_the_same_table(
    done, tmp_path, monkeypatch
):
    """With its workers, after five recordings of which four were written."""
    data, whole = done
    logs = [str(log) for log in data.logs]
    script, folder = tmp_path / "killed.py", str(tmp_path / "killed")
    script.write_text(KILLED)
    given = [json.dumps(each) for each in (logs, folder, data.shared)]
    killed = subprocess.run([sys.executable, script, *given], start_new_session=True)
    assert killed.returncode == -signal.SIGKILL
    do_jobs_here(monkeypatch)
    found = batch(logs, folder, resume=True, **data.shared)
    assert found.progress.kept == 4
    rows, expected = (each.table().drop(["seconds"]) for each in (found, whole))
    assert rows.equals(expected)


def test_the_columns_are_those_of_the_schema():
    assert table_of([{"recording": "a"}]).schema == columns()


def test_arguments_that_cannot_be_used(tmp_path):
    data = recorded(tmp_path)
    with pytest.raises(InputError, match="did you mean 'shape'"):
        batch(data.whole, tmp_path / "r", shap="mug.stl")
    with pytest.raises(HeftingError, match="at least one process"):
        batch(data.whole, tmp_path / "r", jobs=0)
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="cannot be made"):
        batch(data.whole, tmp_path / "file")


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("runs/t", "holds a torque, at 3 s"),
        ("runs/t.csv", "holds a torque, at 3 s, as ... does"),
    ],
)
def test_a_failure_is_said_without_the_path_of_its_recording(path, said):
    """A folder's name may be part of any word."""
    failure = {"error": "InputError", "error_text": f"{path}: {said}"}
    failure["error_text"] = failure["error_text"].replace("...", Path(path).name)
    reasons = Reasons()
    reasons.add(failure, path, path)
    assert reasons.sorted()[0].text == said
