"""Recordings of a batch: manifests of every form, folders, patterns, lists."""

import os

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import parquet

from hefting.batches import manifest
from hefting.batches.manifest import read_manifest
from hefting.batches.one import start_row
from hefting.batches.recordings import recordings_of
from hefting.core.errors import InputError

TEXT = "recording,shape,object_pose,mass,hull,start\n"
CSV = TEXT + 'a.csv,mug.stl,"0,0,0.1,0,0,0,1",0.5kg,true,2\nb.csv,,,,,\n'
TOML = """
shape = "mug.stl"
start = 1
[[recordings]]
recording = "a.csv"
object_pose = [0, 0, 0.1, 0, 0, 0, 1]
[[recordings]]
recording = "sub/b.csv"
start = 3.5
"""


def written(folder, name, text):
    path = folder / name
    path.write_text(text)
    return path


def test_a_csv_manifest_says_what_each_row_says(tmp_path):
    found = recordings_of(written(tmp_path, "m.csv", CSV))
    first, second = found
    assert first.recording == str(tmp_path / "a.csv")
    assert first.options == {
        "shape": str(tmp_path / "mug.stl"),
        "object_pose": "0,0,0.1,0,0,0,1",
        "mass": "0.5kg",
        "hull": True,
        "start": 2.0,
    }
    assert second.recording == str(tmp_path / "b.csv")
    assert second.options == {}


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_separators_are_found(tmp_path, separator):
    text = f"recording{separator}method\na.csv{separator}OLS\n"
    (entry,) = recordings_of(written(tmp_path, "m.csv", text))
    assert entry.options == {"method": "OLS"}


def test_letters_of_windows_are_read(tmp_path):
    (tmp_path / "m.csv").write_bytes(
        "recording;mass\r\ngröße.csv;1g\r\n".encode("cp1252")
    )
    (entry,) = recordings_of(tmp_path / "m.csv")
    assert entry.recording == str(tmp_path / "größe.csv")


def test_columns_are_known_in_letters_of_any_case(tmp_path):
    text = "Recording,Object,Mass\na.csv,mug,0.5kg\n"
    (entry,) = recordings_of(written(tmp_path, "m.csv", text))
    assert (entry.object, entry.options) == ("mug", {"mass": "0.5kg"})


def test_a_parquet_manifest_keeps_its_types(tmp_path):
    columns = {
        "recording": ["a.csv", "b.csv"],
        "pose": [[0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0], None],
        "start": [1.5, None],
        "hull": [False, None],
        "points": [40, None],
    }
    parquet.write_table(pa.table(columns), tmp_path / "m.parquet")
    first, second = recordings_of(tmp_path / "m.parquet")
    assert first.options == {
        "object_pose": "0.0,0.0,0.1,0.0,0.0,0.0,1.0",
        "start": 1.5,
        "hull": False,
        "points": 40,
    }
    assert second.options == {}


def test_a_toml_manifest_has_options_for_all(tmp_path):
    first, second = recordings_of(written(tmp_path, "m.toml", TOML))
    shape = str(tmp_path / "mug.stl")
    pose = "0,0,0.1,0,0,0,1"
    assert first.options == {"shape": shape, "start": 1.0, "object_pose": pose}
    assert second.options == {"shape": shape, "start": 3.5}
    assert second.recording == str(tmp_path / "sub/b.csv")


def test_a_row_goes_before_the_call_and_the_call_before_the_file(tmp_path):
    path = written(tmp_path, "m.toml", TOML)
    first, second = recordings_of(path, {"start": 2.0})
    assert first.options["start"] == 2.0
    assert second.options["start"] == 3.5


def test_a_wrong_value_is_the_problem_of_its_row_alone(tmp_path):
    text = "recording,start\na.csv,soon\nb.csv,1\n"
    first, second = recordings_of(written(tmp_path, "m.csv", text))
    assert first.problem == "start: 'soon' is not a number"
    assert second.problem is None
    assert second.options == {"start": 1.0}


def test_spaces_beside_commas_are_not_of_a_cell(tmp_path):
    text = (
        "recording, shape, start, mass, name\na.csv , a cup.stl, 1 ,  , \nb.csv,,,, \n"
    )
    found, other = recordings_of(written(tmp_path, "m.csv", text))
    assert found.recording == str(tmp_path / "a.csv")
    assert found.name is other.name is None
    assert found.options == {"shape": str(tmp_path / "a cup.stl"), "start": 1.0}


def test_rows_without_recordings_are_told_apart(tmp_path):
    text = "recording,start\n,1\na.csv,1\n,2\n"
    found = recordings_of(written(tmp_path, "m.csv", text))
    assert len(set(found.identities())) == 3
    assert found[2].problem == "row 3 names no recording"


def test_columns_that_are_no_options_are_named(tmp_path):
    text = "recording,operator,object,strat\na.csv,Ann,mug,1\n"
    found = recordings_of(written(tmp_path, "m.csv", text))
    assert found.unused == ["operator", "strat"]
    assert found[0].object == "mug"


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("m.toml", "shape = 'a.stl'", "has no list `recordings`"),
        ("m.toml", "recordings = [{shape = 'a'}]", "[[recordings]] 1 has no path"),
        ("m.toml", "strat = 1\n[[recordings]]\nrecording='a'", "did you mean 'start'?"),
        ("m.csv", "recording\na.csv\na.csv\n", "is given twice"),
        ("m.csv", "recording\na.csv\n./a.csv\n", "is given twice"),
        ("m.csv", "recording,name\na.csv,b\nb.csv,b\n", "b: is given twice"),
        ("m.csv", "recording,object\n", "m.csv: there are no recordings"),
        ("m.csv", "recordings,object\na.csv,mug\n", "needs a column 'recording'"),
        ("m.csv", "Path\na.csv\n", "needs a column 'recording'"),
    ],
)
def test_manifests_that_cannot_be_used(tmp_path, name, text, what):
    with pytest.raises(InputError) as refused:
        recordings_of(written(tmp_path, name, text))
    assert what in str(refused.value)


def test_a_pose_in_a_dictionary_may_be_an_array():
    pose = np.array((0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0))
    (found,) = recordings_of([{"recording": "a.csv", "object_pose": pose}])
    assert found.options["object_pose"] == "0.0,0.1,0.0,0.0,0.0,0.0,1.0"
    assert found.problem is None


@pytest.mark.parametrize(
    "name", ["nan", "NaN", np.nan, np.float32("nan"), pd.NA, pd.NaT]
)
def test_an_empty_cell_of_a_data_frame_gives_no_option(name):
    """Whatever the column's type; as NaN in the other forms."""
    row = {"recording": "a.csv", "start": name, "duration": 2.0}
    (entry,) = recordings_of([row])
    assert (entry.options, entry.problem) == ({"duration": 2.0}, None)
    if not isinstance(name, str):
        row = {"recording": name, "object_pose": name, "name": "a"}
        (entry,) = recordings_of([row])
        assert (entry.options, entry.problem) == ({}, "row 1 names no recording")


def test_options_are_told_in_json():
    rows = [{"recording": "a.csv", "duration": "inf", "start": 1.0}]
    (entry,) = recordings_of(rows)
    assert start_row(entry)["options"] == '{"duration": null, "start": 1.0}'


@pytest.mark.parametrize("sources", ["", [""], ["a.csv", ""]])
def test_an_empty_name_is_not_the_current_folder(tmp_path, monkeypatch, sources):
    monkeypatch.chdir(tmp_path)
    written(tmp_path, "a.csv", "")
    with pytest.raises(InputError, match="a name is empty; name a manifest, logs"):
        recordings_of(sources)
    (entry,) = recordings_of(".")
    assert entry.recording == "a.csv"


def test_an_empty_list_names_no_recordings():
    with pytest.raises(InputError, match="there are no recordings; name logs"):
        recordings_of([])


@pytest.mark.parametrize(
    ("columns", "what"),
    [
        ({"recording": [[1.0]]}, "holds list<"),
        ({"recording": [1.5]}, "holds double, not text"),
        ({"recording": ["a"], "name": [2]}, "column 'name' holds int64"),
        ({"recordin": ["a"]}, "needs a column 'recording' .did you mean 'recordin'"),
        ({"recording": pa.array([b"\xff"]).view(pa.string())}, "cannot be read"),
    ],
)
def test_parquet_that_is_no_manifest(tmp_path, columns, what):
    path = tmp_path / "m.parquet"
    parquet.write_table(pa.table(columns), path)
    with pytest.raises(InputError, match=what):
        read_manifest(path)


def test_a_column_stands_once(tmp_path):
    path = written(tmp_path, "m.csv", "recording,recording\na.csv,b.csv\n")
    with pytest.raises(InputError, match="has two columns 'recording'"):
        recordings_of(path)


def test_a_name_tells_recordings_of_one_path_apart(tmp_path):
    text = "recording,name,method\na.csv,one,OLS\na.csv,two,Bayes\n"
    found = recordings_of(written(tmp_path, "m.csv", text))
    assert [entry.identity for entry in found] == ["one", "two"]


def test_a_folder_holds_the_logs_below_it(tmp_path):
    (tmp_path / "day1").mkdir()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "bag").mkdir()
    names = ("b.csv", "day1/a.parquet", "day1/c.mcap", "notes.txt", "mug.stl")
    for name in (*names, ".hidden/a.csv", ".a.csv", "bag/metadata.yaml", "bag/b.db3"):
        (tmp_path / name).write_text("x")
    recordings = recordings_of(tmp_path)
    found = [entry.recording for entry in recordings]
    expected = ("b.csv", "bag", "day1/a.parquet", "day1/c.mcap")
    assert found == [str(tmp_path / name) for name in expected]
    assert recordings.texts == 1
    (tmp_path / "texts").mkdir()
    (tmp_path / "texts" / "log.txt").write_text("x")
    with pytest.raises(
        InputError, match=r"files that end in .txt.* were left out \(1\)"
    ):
        recordings_of(tmp_path / "texts")


def test_results_of_a_batch_in_the_folder_are_no_recordings(tmp_path):
    table = pa.table({"recording": ["a.csv"]})
    for name, told in (("log", {}), ("results", {"hefting": "hefting.batch/1"})):
        kept = table.replace_schema_metadata(told)
        parquet.write_table(kept, tmp_path / f"{name}.parquet")
    found = [entry.recording for entry in recordings_of(tmp_path)]
    assert found == [str(tmp_path / "log.parquet")]


def test_a_parquet_pipe_in_the_folder_is_not_opened(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe.parquet")
    monkeypatch.setattr(parquet, "read_schema", lambda path: pytest.fail("opened"))
    found = [entry.recording for entry in recordings_of(tmp_path)]
    assert found == [str(tmp_path / "pipe.parquet")]


def test_patterns_lists_and_dictionaries(tmp_path):
    for name in ("a.csv", "b.csv", "c.txt"):
        (tmp_path / name).write_text("x,y\n")
    paths = [str(tmp_path / "a.csv"), str(tmp_path / "b.csv")]
    assert [e.recording for e in recordings_of(str(tmp_path / "*.csv"))] == paths
    assert [e.recording for e in recordings_of(paths)] == paths
    rows = [{"recording": paths[0], "start": 1}, {"recording": paths[1]}]
    first, second = recordings_of(rows)
    assert (first.options, second.options) == ({"start": 1.0}, {})
    with pytest.raises(InputError, match="there are no recordings"):
        recordings_of(str(tmp_path / "*.mcap"))
    with pytest.raises(InputError, match="does not exist"):
        recordings_of(tmp_path / "manifset.csv")


def test_options_of_the_call_are_as_they_are_typed():
    import numpy as np

    from hefting.shapes import Shape

    pose = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0])
    rows = [{"recording": "a.csv"}]
    given = {"pose": pose, "start": np.float64(2.0), "box": "1,1,1"}
    (entry,) = recordings_of(rows, given)
    text = "0.0,0.0,0.1,0.0,0.0,0.0,1.0"
    assert entry.options == {"object_pose": text, "start": 2.0, "box": "1,1,1"}
    with pytest.raises(InputError, match="shape: is a Shape, not a text"):
        recordings_of(rows, {"shape": Shape.from_box(0, 1, 0, 1, 0, 1)})


def test_what_is_said_of_shapes_in_general_is_of_recordings_that_have_one(tmp_path):
    rows = [{"recording": "a.csv", "box": "1,1,1"}, {"recording": "b.csv", "unit": "m"}]
    general = {"pose_std": "1mm,1deg", "start": 1.0}
    found = recordings_of(rows, general)
    found.check()
    first, second = found
    assert first.options == {"box": "1,1,1", **general}
    assert second.options == {"unit": "m", "start": 1.0}
    for given in (general, general | {"hull": True}):
        with pytest.raises(InputError, match="--pose-std: there is no shape"):
            recordings_of([{"recording": "a.csv"}], given).check()


def test_files_that_only_workers_have_are_not_looked_for(tmp_path):
    log = written(tmp_path, "a.csv", "")
    entries = recordings_of(log, {"shape": "mug.stl", "object_pose": "0,0,0"})
    entries.check(with_files=False)
    with pytest.raises(InputError, match=r"mug\.stl: no such file"):
        entries.check()
    with pytest.raises(InputError, match="unknown method"):
        recordings_of(log, {"method": "FOO"}).check(with_files=False)


def test_objects_by_a_column_or_by_folder(tmp_path):
    text = "recording,thing\nx/a.csv,mug\ny/b.csv,cup\nx/c.csv,mug\nx/d.csv,\n"
    path = written(tmp_path, "m.csv", text)
    assert recordings_of(path, group_by="thing").in_groups() == [[0, 2], [1], [3]]
    assert recordings_of(path, group_by="folder").in_groups() == [[0, 2, 3], [1]]
    with pytest.raises(InputError, match="did you mean 'thing'"):
        recordings_of(path, group_by="thin")


def test_a_path_is_a_value_as_its_text_is(tmp_path):
    tool = tmp_path / "gripper.json"
    (tmp_path / "a.csv").touch()
    (entry,) = recordings_of([tmp_path / "a.csv"], {"tool": tool})
    assert entry.options == {"tool": str(tool)}


def test_a_small_manifest_of_very_much_is_refused(tmp_path, monkeypatch):
    """2 MB of Parquet held 20 GB of paths; 12 MB of TOML with an option of its own for
    each recording would have had 90 billion cells."""
    monkeypatch.setattr(manifest, "LARGEST_TABLE", 1_000_000)
    path = tmp_path / "m.parquet"
    table = pa.table({"recording": pa.array(["x" * 1000] * 10_000)})
    parquet.write_table(table, path)
    assert path.stat().st_size < 6000
    with pytest.raises(InputError, match="too many cells"):
        read_manifest(path)
    monkeypatch.setattr(manifest, "LARGEST_TOML", 9000)
    rows = (f"[[recordings]]\nrecording='a'\nk{i}=1\n" for i in range(200))
    with pytest.raises(InputError, match="too many cells"):
        read_manifest(written(tmp_path, "m.toml", "".join(rows)))
