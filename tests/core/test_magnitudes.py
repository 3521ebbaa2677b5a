"""Magnitudes: numbers that nothing has are refused where they enter, by name; the
largest that are let in do no harm further on."""

import json
from contextlib import suppress

import numpy as np
import pytest

from hefting.core.accuracy import errors_between
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.magnitudes import (
    LARGEST,
    LARGEST_CELL,
    LARGEST_DISTANCE,
    LARGEST_GRAVITY,
    LARGEST_PARAMETER,
    LARGEST_TIME,
)
from hefting.core.recording import COLUMNS, Recording, Stream
from hefting.core.spatial import check_gravity, check_pose, pose_matrix
from hefting.identification import identify
from hefting.identification.truth import load_truth
from hefting.ingest.sign_and_bias import load_bias
from hefting.inspection import inspect
from hefting.logs import read_log
from hefting.simulation import UR5, hammer, simulate, sinusoids


@pytest.fixture(scope="module")
def recording():
    motion = UR5.motion(sinusoids(4.0, 20.0, 1.0))
    return simulate(motion, hammer().parameters)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("name", LARGEST)
def test_every_stream_has_a_largest_value(name, sign):
    """At it a recording is made, beyond it the error names row and column."""
    width = len(COLUMNS[name])
    values = np.zeros((3, width))
    time = np.arange(3.0)
    values[1, width - 1] = sign * LARGEST[name]
    Recording({name: Stream(time, values)})
    values[1, width - 1] *= 1.0 + 1e-15
    with pytest.raises(InputError, match=r"row 2, column .*: the value .* is beyond"):
        Recording({name: Stream(time, values)})


def test_times_have_a_largest_value():
    one = np.zeros((1, 3))
    Recording({"position": Stream(np.array([LARGEST_TIME]), one)})
    with pytest.raises(InputError, match="row 1, column time"):
        Recording({"position": Stream(np.array([1e300]), one)})


@pytest.mark.parametrize("cell", ["1e31", "-1e300", "1e308"])
@pytest.mark.parametrize("column", ["px", "fx", "gyro_x"])
def test_cells_are_refused_by_row_and_column(tmp_path, cell, column):
    groups = ["time", *COLUMNS["position"], *COLUMNS["orientation"], *COLUMNS["wrench"]]
    names = [*groups, *COLUMNS["gyroscope"]]
    rows = [[str(k), *"0000001", *"123456", *"000"] for k in range(5)]
    rows[3][names.index(column)] = cell
    path = tmp_path / "log.csv"
    path.write_text("\n".join(",".join(row) for row in [names, *rows]))
    with pytest.raises(InputError, match=rf"row 5, column {column}"):
        read_log(path)
    assert float(cell.lstrip("-")) > LARGEST_CELL


@pytest.mark.parametrize("name", ["position", "wrench"])
def test_the_largest_values_do_no_harm(recording, name):
    """Of one sample or of all, whatever inspection and identification find then."""
    for part in (slice(3, 4), slice(None)):
        values = np.array(recording[name].values)
        values[part] = LARGEST[name] * np.sign(values[part] + 1e-300)
        stream = Stream(recording[name].time, values)
        changed = Recording(dict(recording.streams) | {name: stream})
        for action in (inspect, identify):
            with suppress(InputError):  # any other is a failure
                action(changed)


@pytest.mark.parametrize("size", [1e300, 1.01 * LARGEST_GRAVITY, 1e-10, 5e-324])
def test_gravity_is_that_of_some_body(recording, size):
    with pytest.raises(InputError, match="cannot be"):
        check_gravity((0.0, 0.0, -size))
    with pytest.raises(InputError, match="cannot be"):
        inspect(recording, (0.0, size, 0.0))


def test_gravity_of_moon_and_sun_is_taken():
    for size in (1e-6, 1.62, 274.0):
        assert check_gravity((0.0, 0.0, size))[2] == size


def test_poses_are_at_hand():
    far = np.eye(4)
    far[0, 3] = 1.1 * LARGEST_DISTANCE
    with pytest.raises(InputError, match="pose matrix"):
        check_pose(far)
    with pytest.raises(InputError, match="distance"):
        pose_matrix((1e300, 0, 0, 0, 0, 0, 1))
    with pytest.raises(InputError, match="norm"):
        pose_matrix((0, 0, 0, 1e300, 0, 0, 1))
    with pytest.raises(InputError):
        check_pose(1e300 * np.eye(4))


def test_numbers_of_json_files(recording, tmp_path):
    path = tmp_path / "x.json"
    whole = identify(recording).estimate.to_dict()
    for change in (
        {"vector": [1e300] * 10},
        {"bias": [1e300] * 6},
        {"covariance": (1e200 * np.eye(10)).tolist()},
        {"residual": [10 * LARGEST_PARAMETER, 1.0]},
    ):
        path.write_text(json.dumps(whole | change))
        with pytest.raises(InputError, match=next(iter(change))):
            Estimate.load(path)
    path.write_text(json.dumps([1e300] * 6))
    with pytest.raises(InputError, match="a bias"):
        load_bias(path)
    known = {"mass": 1.0, "center_of_mass_sensor": [0.0, 1e300, 0.0]}
    known["inertia_at_sensor"] = np.eye(3).tolist()
    path.write_text(json.dumps(known))
    with pytest.raises(InputError, match="center_of_mass_sensor"):
        load_truth(path)


@pytest.mark.parametrize("notes", [0.0, None, "text", {"a": 1}, [1], [["a"]]])
def test_notes_of_an_estimate_are_texts(recording, tmp_path, notes):
    whole = identify(recording).estimate.to_dict()
    whole["provenance"]["notes"] = notes
    (tmp_path / "x.json").write_text(json.dumps(whole))
    with pytest.raises(InputError, match="notes are not a list of texts"):
        Estimate.load(tmp_path / "x.json")


def test_errors_are_shares_of_something(recording):
    """A truth of no size or mass gave divisions by zero."""
    body = hammer().parameters
    with pytest.raises(InputError, match="sides"):
        errors_between(body, body, (1e-165, 0.1, 0.1))
    light = type(body)(1e-165 * body.vector)
    with pytest.raises(InputError, match="mass"):
        errors_between(body, light, (0.1, 0.1, 0.1))
