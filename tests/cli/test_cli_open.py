"""An inertia that is not known, on the command line."""

import json

import numpy as np
import pytest

from commands import refused
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import rotation_matrices
from hefting.logs import write_log


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Twelve static poses of 0.7 kg, 0.25 m from the sensor; noise of 50 mN, 3 mN m."""
    folder = tmp_path_factory.mktemp("open")
    rng = np.random.default_rng(3)
    q = rng.normal(size=(12, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    force = 0.7 * 9.80665 * rotation_matrices(q)[:, 2, :]
    wrench = np.hstack((force, np.cross((0.0, 0.01, 0.25), force)))
    wrench += rng.normal(size=wrench.shape) * ([0.05] * 3 + [0.003] * 3)
    streams = {
        "orientation": Stream(np.arange(12.0), q),
        "wrench": Stream(np.arange(12.0), wrench),
    }
    write_log(Recording(streams, static=True), folder / "log.csv")
    return folder


def test_the_table_says_open(run, folder):
    status, out, _ = run("identify", folder / "log.csv")
    assert status == 0
    rows = {
        line.split("│")[1].strip(): line.split("│")[2].strip()
        for line in out.splitlines()
        if line.startswith("│")
    }
    assert {v for name, v in rows.items() if name.startswith("J")} == {"open"}
    assert rows["mass"][:3] in ("0.7", "0.6")
    _, out, _ = run("identify", folder / "log.csv", "--method", "OLS")
    inertia = [line for line in out.splitlines() if line.startswith("│ J")]
    assert [line.count("open") for line in inertia] == [3] * 6  # and both its ends
    status, out, _ = run("identify", folder / "log.csv", "--method", "LMI,OLS")
    assert status == 0
    assert out.count(" open ") == 2


def test_json_marks_it_beside_the_tensor(run, folder):
    status, out, _ = run("identify", folder / "log.csv", "--json")
    data = json.loads(out)
    assert status == 0
    assert np.array(data["undetermined"]["inertia_at_com"]).all()
    assert data["undetermined"]["filled_from"].startswith("an object of any shape")
    assert np.array(data["inertia_at_com"]).shape == (3, 3)


def test_simulators_files_are_left_out_and_the_status_says_so(run, folder):
    urdf, file = folder / "a.urdf", folder / "a.json"
    words = ("identify", folder / "log.csv", "--output", urdf, "--output", file)
    status, out, err = run(*words)
    assert status == 2
    assert not urdf.exists()
    assert f"{urdf} was not written: the recording leaves the inertia open" in err
    assert "--fill-inertia point" in err
    assert f"wrote {file}" in out
    assert refused(run("export", file, "--to", "urdf"), "leaves the inertia open")
    status, out, err = run("export", file, "--to", "ur")
    assert status == 0
    assert "inertia: open" in out
    assert out.splitlines()[-1].count("[") == 1  # the COM alone


def test_filled_in(run, folder):
    urdf, file = folder / "b.urdf", folder / "b.json"
    log = folder / "log.csv"
    point = ("--fill-inertia", "point")
    status, out, _ = run("identify", log, *point, "--output", urdf, "--output", file)
    assert status == 0
    assert "filled in as of a point" in out
    text = " ".join(urdf.read_text().split())
    assert "filled in as that of a point" in text
    box = ("--fill-inertia", "shape", "--shape", "box:-0.1,0.1,-0.1,0.1,0.2,0.3")
    status, out, err = run("export", file, "--to", "mjcf", *box)
    assert status == 0
    assert "given shape with the mass evenly spread" in " ".join(out.split())
    assert "filled in from the shape" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--fill-inertia", "box"), "neither shape nor point"),
        (("--fill-inertia", "shape"), "give --shape"),
    ],
)
def test_what_cannot_be_filled_in(run, folder, words, said):
    log, file = folder / "log.csv", folder / "c.json"
    run("identify", log, "--output", file)
    assert refused(run("identify", log, *words), said)
    assert refused(run("export", file, "--to", "urdf", *words), said)
    boxed = ("--fill-inertia", "shape", "--box", "0.1,0.1,0.1")
    assert run("export", file, "--to", "urdf", *boxed)[0] == 0
    for_nothing = run("export", file, "--to", "urdf", "--shape", "box:0,1,0,1,0,1")
    assert refused(for_nothing, "is for --fill-inertia shape")
