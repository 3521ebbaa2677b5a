"""One object in many recordings: as all identified together, whatever is left out."""

import numpy as np
import pytest
from recorded import recorded

import hefting
from hefting.batches import batch
from hefting.batches.columns import flat
from jobs_here import do_jobs_here

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """No processes: that they make no difference is tested beside."""
    do_jobs_here(monkeypatch)


def written(folder, rows):
    path = folder / "manifest.csv"
    lines = [",".join(map(str, row)) for row in rows]
    path.write_text("\n".join(("recording,object,mass", *lines)) + "\n")
    return path


def test_an_object_is_identified_from_all_its_recordings_together(tmp_path):
    """Each has a bias and a clock of its own; 1e-9 is asked, and other sums of the same
    samples round otherwise."""
    data = recorded(tmp_path)
    rows = [(log.name, "ab"[k % 2], "") for k, log in enumerate(data.whole[:4])]
    manifest = written(data.folder, rows)
    found = batch(manifest, tmp_path / "r", group_by="object", **data.shared)
    table = {row["object"]: row for row in found.table().to_pylist()}
    assert sorted(table) == ["a", "b"]
    for name, logs in (("a", data.whole[:4:2]), ("b", data.whole[1:4:2])):
        pose = data.shared["object_pose"]
        joint = hefting.identify(logs, data.shared["shape"], object_pose=pose).estimate
        row = table[name]
        assert row["recordings"] == [str(log) for log in logs]
        for key, value in (
            ("vector", joint.parameters.vector),
            ("covariance", joint.covariance.ravel()),
            ("bias", joint.bias.ravel()),
        ):
            size = np.abs(value).max()
            np.testing.assert_allclose(row[key], value, rtol=0.0, atol=1e-9 * size)
        assert row["verdict"] == joint.verdict.level
        ends = flat(joint.to_dict()["intervals"])
        for key in ends:
            size = np.abs(ends[key]).max()
            np.testing.assert_allclose(
                row["intervals"][key], ends[key], rtol=0.0, atol=1e-9 * size
            )


def test_broken_recordings_are_left_out_and_named(tmp_path):
    data = recorded(tmp_path)
    logs = [*data.whole[:2], *data.broken[:3]]
    rows = [(log.name, "mug", "") for log in logs]
    rows += [(log.name, "cup", "") for log in data.broken[3:5]]
    found = batch(written(data.folder, rows), tmp_path / "r", group_by="object")
    table = {row["object"]: row for row in found.table().to_pylist()}
    mug, cup = table["mug"], table["cup"]
    assert mug["error"] is None
    assert mug["recordings"] == [str(log) for log in data.whole[:2]]
    left = {each["recording"]: each["error_text"] for each in mug["left_out"]}
    assert set(left) == {str(log) for log in data.broken[:3]}
    assert all(left.values())
    assert sum(text.startswith("left out: ") for text in mug["warnings"]) == 3
    assert mug["verdict"] == "good"
    assert cup["error"] == "InputError"
    assert cup["error_text"].startswith("none of 2 recordings can be used: ")


def test_a_recording_that_is_wrong_alone_is_left_out_where_others_are_right(tmp_path):
    """Positions in millimetres, forces 10,000 times too large; where all are wrong
    nothing is left out."""
    data = recorded(tmp_path)
    scales = (
        dict.fromkeys(("px", "py", "pz"), 1e3),
        dict.fromkeys(("fx", "fy", "fz"), 1e4),
    )
    for k, scale in enumerate(scales, start=1):
        head, *rows = data.whole[k].read_text().splitlines()
        sizes = [scale.get(name, 1.0) for name in head.split(",")]
        scaled = (
            ",".join(cell and repr(size * float(cell)) for cell, size in cells)
            for cells in (zip(row.split(","), sizes, strict=True) for row in rows)
        )
        data.whole[k].write_text("\n".join((head, *scaled)) + "\n")
    rows = [(log.name, "mug", "") for log in data.whole[:3]]
    again = data.whole[1].with_name("again.csv")
    again.write_bytes(data.whole[1].read_bytes())
    rows.append((again.name, "cup", ""))
    found = batch(written(data.folder, rows), tmp_path / "r", group_by="object")
    table = {row["object"]: row for row in found.table().to_pylist()}
    alone = hefting.identify(data.whole[0]).estimate
    mug = table["mug"]
    assert mug["recordings"] == [str(data.whole[0])]
    assert mug["mass"] == pytest.approx(alone.mass, rel=1e-9)  # of the same samples
    assert mug["verdict"] == alone.verdict.level
    texts = [each["error_text"] for each in mug["left_out"]]
    assert "in millimetres" in texts[0]
    assert "the force" in texts[1]
    assert table["cup"]["left_out"] == []


def test_recordings_too_short_to_tell_the_mass_say_so(tmp_path):
    data = recorded(tmp_path)
    rows = [(log.name, "mug", "") for log in data.whole[:2]]
    path = written(data.folder, rows)
    options = {"duration": 0.1, "bias": "estimate"}
    found = batch(path, tmp_path / "r", group_by="object", **options)
    (row,) = found.table().to_pylist()
    assert row["error"] == "NotIdentifiableError", row["error_text"]


def test_recordings_of_an_object_say_the_same_of_it(tmp_path):
    data = recorded(tmp_path)
    logs = enumerate(data.whole[:2], start=5)
    rows = [(log.name, "mug", f"0.{k}kg") for k, log in logs]
    found = batch(written(data.folder, rows), tmp_path / "r", group_by="object")
    (row,) = found.table().to_pylist()
    assert "say different mass: 0.5kg, 0.6kg" in row["error_text"]


def test_a_blank_cell_says_what_others_say_of_the_object(tmp_path):
    data = recorded(tmp_path)
    rows = [(data.whole[0].name, "mug", "0.5kg±1g"), (data.whole[1].name, "mug", "")]
    found = batch(written(data.folder, rows), tmp_path / "r", group_by="object")
    (row,) = found.table().to_pylist()
    assert row["error"] is None


def test_a_pose_in_one_row_is_of_the_shape_in_another(tmp_path):
    data = recorded(tmp_path)
    shape = dict(data.shared)
    pose = {"object_pose": shape.pop("object_pose")}
    rows = [
        {"recording": str(log), "object": "mug", **said}
        for log, said in zip(data.whole, (shape, pose), strict=False)
    ]
    found = batch(rows, tmp_path / "r", group_by="object", pose_std="1mm,1deg")
    (row,) = found.table().to_pylist()
    assert row["error"] is None


def test_an_object_stays_until_one_of_its_recordings_changes(tmp_path):
    data = recorded(tmp_path)
    rows = [(log.name, "ab"[k // 2], "") for k, log in enumerate(data.whole[:3])]
    manifest = written(data.folder, rows)

    def again():
        return batch(manifest, tmp_path / "r", resume=True, group_by="object")

    first = again()
    assert again().progress.kept == 3
    data.whole[0].write_bytes(data.whole[5].read_bytes())
    second = again()
    assert second.progress.kept == 1
    assert second.table().num_rows == first.table().num_rows == 2


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The first recording and its shape, and what is found from all of it at once."""
    data = recorded(tmp_path_factory.mktemp("whole"))
    log, pose = data.whole[0], data.shared["object_pose"]
    return data, hefting.identify(log, data.shared["shape"], object_pose=pose)


@pytest.mark.parametrize("size", [0, 10**9])
def test_a_large_recording_is_one_object_in_windows(whole, monkeypatch, size):
    """Each window has a bias; the mass lies in the interval of the whole."""
    from hefting.batches.one import row_of
    from hefting.batches.recordings import Entry
    from hefting.logs import windows

    monkeypatch.setattr(windows, "LARGEST_WHOLE", size)
    monkeypatch.setattr(windows, "FEWEST_ROWS", 250)
    monkeypatch.setattr(
        windows.windows, "__kwdefaults__", {"seconds": 5.0, "rows": 500}
    )
    data, found = whole
    row = row_of((Entry(str(data.whole[0]), options=data.shared), None))
    assert row["error"] is None, row["error_text"]
    assert (len(row["bias"]) > 6) == (size == 0)
    low, high = found.interval("mass")
    assert low < row["mass"] < high
