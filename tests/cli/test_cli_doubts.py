"""What the command line says of recordings that are wrong, or too poor for an answer."""

import json

import numpy as np
import pytest

from commands import refused
from hammer_log import edited, log_folder, shape_options
from hefting.core.recording import Recording, Stream
from hefting.logs import read_log, write_log

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return log_folder(tmp_path_factory)


def test_flipped_wrench_is_found_and_said(run, folder, tmp_path):
    log = read_log(folder / "log.csv")
    wrench = log["wrench"]
    write_log(
        Recording(
            {**log.streams, "wrench": Stream(wrench.time, -wrench.values, wrench.rows)}
        ),
        tmp_path / "f.csv",
    )
    _, plain, _ = run("identify", folder / "log.csv", *shape_options(folder), "--json")
    _, flipped, _ = run(
        "identify", tmp_path / "f.csv", *shape_options(folder), "--json"
    )
    plain, flipped = json.loads(plain), json.loads(flipped)
    assert flipped["provenance"]["wrench"] == "on-sensor"
    # one sign apart
    np.testing.assert_allclose(
        flipped["vector"], plain["vector"], rtol=1e-9, atol=1e-12
    )
    assert refused(
        run(
            "identify",
            tmp_path / "f.csv",
            *shape_options(folder),
            "--wrench",
            "on-object",
        ),
        "--wrench",
    )


def scaled_wrench(folder, tmp_path, force, torque):
    log = read_log(folder / "log.csv")
    wrench = log["wrench"]
    values = wrench.values * np.repeat((force, torque), 3)
    path = tmp_path / "scaled.csv"
    write_log(
        Recording({**log.streams, "wrench": Stream(wrench.time, values, wrench.rows)}),
        path,
    )
    return path


def test_wrench_in_the_wrong_unit(run, folder, tmp_path):
    path = scaled_wrench(folder, tmp_path, 1e4, 1e4)
    assert refused(
        run("identify", path, *shape_options(folder)), "scaled.csv", "kg", "newtons"
    )
    path = scaled_wrench(folder, tmp_path, 1.0, 1e3)
    assert refused(
        run("identify", path, *shape_options(folder)),
        "scaled.csv",
        "torque",
        "newton-metres",
    )


def test_everything_a_thousand_times_too_large(run, folder, tmp_path):
    path = scaled_wrench(folder, tmp_path, 1e3, 1e3)
    assert refused(
        run("identify", path, *shape_options(folder)),
        "scaled.csv",
        "kg",
        "cm³",
        "newtons",
    )


def test_a_held_pose_says_what_it_lacks(run, folder, tmp_path):
    """Three seconds in one pose, with noise on poses and wrench: mass without a bias,
    nothing beside one."""
    rng = np.random.default_rng(0)
    log = read_log(folder / "log.csv")
    streams = {}
    for name, std in (("position", 1e-4), ("orientation", 1e-4), ("wrench", 0.0)):
        values = np.repeat(log[name].values[:1], 300, axis=0)
        noise = np.repeat((0.1, 0.005), 3) if name == "wrench" else std
        streams[name] = Stream(
            log[name].time[:300], values + noise * rng.normal(size=values.shape)
        )
    path = tmp_path / "held.csv"
    write_log(Recording(streams), path)
    status, out, _ = run("identify", path, *shape_options(folder), "--json")
    assert status == 0
    result = json.loads(out)
    # the first row's wrench, repeated: taken in motion, so about 0.7 N from the
    # weight of 6.6 N
    assert abs(result["mass"] - 0.67) < 0.1
    assert any("cannot tell a bias" in line for line in result["warnings"])
    assert any("open" in line for line in result["warnings"])
    assert refused(
        run("identify", path, *shape_options(folder), "--bias", "estimate"),
        "too poor",
    )
    _, out, _ = run("inspect", path, "--json")
    assert "Jxx" in json.loads(out)["undetermined"]


def test_gravity_the_wrong_way_round_is_noticed(run, folder):
    words = [
        *shape_options(folder),
        "--gravity",
        "0,0,9.80665",
        "--wrench",
        "on-sensor",
        "--json",
    ]
    _, out, _ = run("identify", folder / "log.csv", *words)
    said = json.loads(out)
    assert (
        "gravity seems to point the other way: give --gravity 0,0,-9.80665"
        in (said["warnings"][0])
    )
    assert said["verdict"] != "good"


def test_one_sample_gives_the_mass_and_warns(run, folder, tmp_path):
    path = edited(folder, tmp_path, lambda lines: lines[:2])
    status, out, _ = run("identify", path, *shape_options(folder), "--json")
    assert status == 0
    result = json.loads(out)
    # the hammer's 0.670 kg: one reading of 6.6 N, off by what the arm's unmodelled
    # motion takes, some 0.7 N here
    assert abs(result["mass"] - 0.67) < 0.1
    warnings = " ".join(result["warnings"])
    for words in (
        "sign is uncertain",
        "cannot tell a bias",
        "leaves the COM and the inertia open",
    ):
        assert words in warnings, warnings


def still(folder, tmp_path, rows):
    """Static poses without time: the log's first row, `rows` times."""
    lines = (folder / "log.csv").read_text().splitlines()
    path = tmp_path / "still.csv"
    keep = [line.split(",", 1)[1] for line in (lines[0], *[lines[1]] * rows)]
    path.write_text("\n".join(keep) + "\n")
    return path


def test_motion_too_poor(run, folder, tmp_path):
    for rows in (1, 20):
        path = still(folder, tmp_path, rows)
        assert refused(
            run("identify", path, *shape_options(folder), "--bias", "estimate"),
            "still.csv",
            "too poor",
        )
        status, out, _ = run(
            "identify", path, *shape_options(folder), "--bias", "none", "--json"
        )
        assert status == 0  # the mass at least is known
        assert any("inertia" in line for line in json.loads(out)["warnings"])
