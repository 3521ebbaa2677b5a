"""Estimate: its file, its derivatives and its standard deviations."""

import json
import os
from dataclasses import fields, replace

import numpy as np
import pytest

from hefting import __version__
from hefting.core.errors import InputError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.estimate_json import SCHEMA
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.messages import note, warning
from hefting.core.spatial import (
    tensor_to_vector,
)
from hefting.core.undetermined import Undetermined
from hefting.estimators import OLS, PMD
from hefting.shapes import Shape
from random_problems import random_body, random_motion, with_wrench

KEYS = {
    *(
        "schema",
        "version",
        "method",
        "frame",
        "mass",
        "center_of_mass",
        "inertia_at_com",
        "inertia_at_origin",
    ),
    *(
        "vector",
        "covariance",
        "std",
        "physically_consistent",
        "certificate",
        "bias",
        "samples",
        "duration",
    ),
    *(
        "messages",
        "warnings",
        "residual",
        "point_masses",
        "provenance",
        "consistency",
        "intervals",
        "accuracy",
        "sufficient",
        "undetermined",
        "verdict",
        "reasons",
    ),
}
"""What the command line documents, and the last eleven, of which `load` needs some."""


@pytest.fixture
def z():
    rng = np.random.default_rng(1)
    return with_wrench(
        random_motion(rng, 40), random_body(rng), rng.normal(size=6), rng, 0.1, 0.005
    )


@pytest.fixture
def estimate(z) -> Estimate:
    found = OLS(bias="estimate").fit(z)
    return replace(
        found,
        point_masses=np.array((0.1, 0.0, 1 / 3)),
        residual=np.array((0.1, 0.005)),
        warnings=("one", "two"),
        provenance={"log": "log.csv", "gravity": [0.0, 0.0, -9.8], "bias": None},
    )


def same(first, second) -> bool:
    if isinstance(first, InertialParameters):
        first, second = first.vector, second.vector
    if isinstance(first, Undetermined):
        return first.to_dict() == second.to_dict()
    if isinstance(first, np.ndarray):
        return first.shape == second.shape and np.array_equal(first, second)
    if isinstance(first, dict) and isinstance(second, dict):
        return set(first) == set(second) and all(
            same(first[name], second[name]) for name in first
        )
    return first == second


def assert_same_estimate(first: Estimate, second: Estimate):
    for field in fields(Estimate):
        assert same(getattr(first, field.name), getattr(second, field.name)), field.name


# the file


def test_the_name_of_the_file_format_stays():
    """Files written by earlier versions carry it."""
    assert SCHEMA == "hefting.estimate/1"


def test_saved_and_loaded_is_the_same_to_the_last_bit(estimate, tmp_path):
    for written in (
        estimate,
        Estimate("PMD", random_body(np.random.default_rng(2)), 0),
    ):
        written.save(tmp_path / "e.json")
        assert_same_estimate(Estimate.load(tmp_path / "e.json"), written)


def test_messages_keep_their_codes_in_the_file(estimate, tmp_path):
    doubt = warning(
        "sensor-axes", "give `sensor_pose_in_flange`", "sensor_pose_in_flange"
    )
    done = note("pose-source", "pose from tf")
    told = replace(
        estimate,
        warnings=(doubt, "without a code"),
        provenance={"notes": (done, "mere text")},
    )
    told.save(tmp_path / "e.json")
    data = json.loads((tmp_path / "e.json").read_text())
    assert data["warnings"] == ["give `sensor_pose_in_flange`", "without a code"]
    assert [message["code"] for message in data["messages"]] == [
        "sensor-axes",
        "unknown",
        "pose-source",
    ]
    assert data["messages"][0] == doubt.to_dict()
    found = Estimate.load(tmp_path / "e.json")
    assert [w.to_dict() for w in found.warnings] == data["messages"][:2]
    assert found.provenance["notes"][0].to_dict() == done.to_dict()
    assert found.provenance["notes"][1] == "mere text"
    del data["messages"]  # as earlier versions wrote it
    (tmp_path / "e.json").write_text(json.dumps(data))
    assert [w.code for w in Estimate.load(tmp_path / "e.json").warnings] == [
        "unknown"
    ] * 2


def test_no_text_of_a_file_controls_a_terminal(estimate, tmp_path):
    """Method, warnings and notes are printed."""
    data = estimate.to_dict()
    data["method"] = "OLS\x1b[2J"
    data["warnings"] = ["\x1b[31m"]
    data["provenance"]["notes"] = ["\x9b31m"]
    path = tmp_path / "estimate.json"
    path.write_text(json.dumps(data))
    found = Estimate.load(path)
    assert found.method == "OLS?[2J"
    assert found.warnings == ("?[31m",)
    assert found.provenance["notes"] == ["?31m"]


def test_a_verdict_in_the_file_that_is_worse_counts(estimate, tmp_path):
    """A program beside this one may know more; the same and a better one say nothing."""
    path = tmp_path / "e.json"
    data = replace(estimate, warnings=(warning("no-shape", "no shape"),)).to_dict()
    for verdict, reasons, expected in (
        ("do not use", ["the arm was touched"], ("the arm was touched",)),
        ("usable with care", ["no shape"], ("no shape",)),
        ("do not use", [], ("its file says so",)),
        ("good", ["nothing"], ()),
        (None, None, ()),
    ):
        path.write_text(json.dumps(data | {"verdict": verdict, "reasons": reasons}))
        found = Estimate.load(path)
        assert found.verdict.level == (verdict or "good")
        assert found.verdict.reasons == expected
        assert len(found.warnings) == len({*expected, "no shape"})
        found.save(path)
        assert_same_estimate(Estimate.load(path), found)
    path.write_text(
        json.dumps(replace(estimate, warnings=("x",)).to_dict() | {"verdict": "good"})
    )
    assert Estimate.load(path).verdict.level == "usable with care"


def test_what_is_said_twice_may_be_rounded_or_missing(estimate, tmp_path):
    data = estimate.to_dict()
    rounded = {"mass": float(f"{data['mass']:.4g}")}
    without = {"mass", "center_of_mass", "frame", "verdict", "reasons"}
    for each in (data | rounded, {k: v for k, v in data.items() if k not in without}):
        (tmp_path / "e.json").write_text(json.dumps(each))
        assert_same_estimate(Estimate.load(tmp_path / "e.json"), estimate)


@pytest.mark.parametrize(
    "messages",
    [
        "text",
        [1],
        [{}],
        [{"code": "a", "text": "b", "severity": "loud"}],
        [{"code": 1, "text": "b", "severity": "note"}],
    ],
)
def test_messages_that_are_none(estimate, tmp_path, messages):
    (tmp_path / "e.json").write_text(
        json.dumps(estimate.to_dict() | {"messages": messages})
    )
    with pytest.raises(InputError, match="not a whole estimate"):
        Estimate.load(tmp_path / "e.json")


def test_undetermined_variance_survives_the_file(tmp_path):
    """At rest the inertia has infinite variance."""
    rng = np.random.default_rng(3)
    still = with_wrench(
        random_motion(rng, 9, speed=0.0), random_body(rng), 0.0, rng, 0.1, 0.005
    )
    found = OLS().fit(still)
    assert np.isinf(found.covariance.diagonal()[4:]).all()
    found.save(tmp_path / "e.json")
    json.loads(
        (tmp_path / "e.json").read_text(),
        parse_constant=lambda name: pytest.fail(f"{name} is not JSON"),
    )
    assert_same_estimate(Estimate.load(tmp_path / "e.json"), found)


def test_keys_are_those_documented(estimate):
    data = estimate.to_dict()
    assert set(data) == KEYS
    assert (data["schema"], data["version"], data["frame"]) == (
        SCHEMA,
        __version__,
        "sensor",
    )
    assert set(data["std"]) == {"mass", "center_of_mass", "inertia_at_com"}
    assert set(data["certificate"]) == {
        "objective",
        "bound",
        "gap",
        "iterations",
        "converged",
    }
    assert data["physically_consistent"] is estimate.physically_consistent
    assert set(data["consistency"]) == {"margins", "violated"}
    assert data["samples"] == 40
    assert data["mass"] == estimate.parameters.mass
    for name, shape in (
        ("covariance", (10, 10)),
        ("inertia_at_com", (3, 3)),
        ("inertia_at_origin", (3, 3)),
    ):
        assert np.shape(data[name]) == shape
    np.testing.assert_array_equal(
        data["inertia_at_com"], estimate.parameters.inertia_at_com
    )
    np.testing.assert_array_equal(
        data["inertia_at_origin"], estimate.parameters.inertia_at_origin
    )
    assert np.shape(data["std"]["inertia_at_com"]) == (3, 3)
    assert np.shape(data["std"]["mass"]) == ()
    json.dumps(data, allow_nan=False)


def test_what_is_not_known_is_null():
    data = Estimate("PMD", random_body(np.random.default_rng(4)), 5).to_dict()
    assert set(data) == KEYS
    for name in (
        "covariance",
        "certificate",
        "bias",
        "duration",
        "residual",
        "point_masses",
    ):
        assert data[name] is None
    assert data["std"] == {"mass": None, "center_of_mass": None, "inertia_at_com": None}
    assert data["warnings"] == []


INTERVALS = {"mass": [1.0, 2.0], "center_of_mass": [[0.0] * 3, [1.0] * 3]}
INTERVALS |= {
    name: [np.zeros((3, 3)).tolist(), np.ones((3, 3)).tolist()]
    for name in ("inertia_at_origin", "inertia_at_com")
}
"""As a file has them."""


def broken(data):
    """Ways to spoil the dictionary of a file, each of which must be noticed."""
    cases = {
        "another schema": data | {"schema": "hefting.estimate/99"},
        "no schema": {k: v for k, v in data.items() if k != "schema"},
        "no vector": {k: v for k, v in data.items() if k != "vector"},
        "no method": {k: v for k, v in data.items() if k != "method"},
        "no samples": {k: v for k, v in data.items() if k != "samples"},
        "list": [data],
        "number": 3,
    }
    spoiled = {
        "vector": (
            [1.0] * 9,
            [[1.0] * 10],
            "abc",
            [float("nan")] * 10,
            [None] * 10,
            ["x"] * 10,
            {},
            1.0,
            None,
        ),
        "covariance": (
            [1.0] * 10,
            [[1.0] * 9] * 10,
            "x",
            [[1.0], [1.0, 2.0]],
            [[float("nan")] * 10] * 10,
            (-np.eye(10)).tolist(),
            np.triu(np.ones((10, 10))).tolist(),
        ),
        "verdict": ("bad", 1, ["good"]),
        "reasons": ("x", 1, [1]),
        "frame": ("world", 1),
        "mass": (data["mass"] * 1.01, -1.0, "x", [1.0]),
        "center_of_mass": ([0.0] * 3, [1.0], 1.0),
        "bias": ([1.0] * 5, "x", [float("nan")] * 6),
        "point_masses": (1.0, [[1.0]], "x", [float("inf")]),
        "residual": ([1.0] * 3, "x"),
        "intervals": (
            5,
            "x",
            {},
            {"mass": [1.0, 2.0]},
            INTERVALS | {"mass": [2.0, 1.0]},
            INTERVALS | {"mass": [None, 1.0]},
        ),
        "certificate": (
            5,
            "x",
            [],
            {},
            {"objective": 1.0},
            {"objective": "a", "bound": None, "gap": 0.0},
        ),
        "samples": ("x", None, [1], float("inf"), float("nan")),
        "duration": ("x", [1.0]),
        "warnings": (5,),
        "provenance": (5, [1]),
    }
    for name, values in spoiled.items():
        for value in values:
            cases[f"{name} = {str(value)[:30]}"] = data | {name: value}
    return cases


def test_files_that_are_no_estimates_give_one_line(estimate, tmp_path):
    path = tmp_path / "spoiled.json"
    unnoticed = []
    for name, data in broken(estimate.to_dict()).items():
        path.write_text(json.dumps(data))
        try:
            Estimate.load(path)
            unnoticed.append(f"{name}: loaded")
        except InputError as error:
            if "\n" in str(error) or not str(error).startswith(f"{path}: "):
                unnoticed.append(f"{name}: says {error}")
        except Exception as error:
            unnoticed.append(f"{name}: {error!r}")
    assert not unnoticed


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"garbage",
        b"{",
        b"\xff\xfe\x00",
        b"null",
        b"[" * 100_000,
        b'{"schema": "' + SCHEMA.encode(),
    ],
)
def test_files_that_are_not_json_give_one_line(content, tmp_path):
    path = tmp_path / "garbage.json"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        Estimate.load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_missing_files_and_folders(estimate, tmp_path):
    with pytest.raises(InputError, match=r"nothing\.json: cannot be read"):
        Estimate.load(tmp_path / "nothing.json")
    with pytest.raises(InputError, match="cannot be read"):
        Estimate.load(tmp_path)
    with pytest.raises(InputError, match="cannot be written"):
        estimate.save(tmp_path / "no" / "folder.json")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        estimate.save(tmp_path / "folder")
    with pytest.raises(InputError, match="saved as JSON"):
        estimate.save(tmp_path / "robot.urdf")
    assert os.listdir(tmp_path) == ["folder"]


def test_a_file_is_never_half_written(estimate, tmp_path, monkeypatch):
    """A write that breaks off leaves the file that was there, and nothing else."""
    path = tmp_path / "e.json"
    estimate.save(path)
    before = path.read_bytes()
    real = os.fdopen

    def full_disk(handle, mode):
        stream = real(handle, mode)
        write = stream.write

        class Stream:
            def __enter__(self):
                return self

            def __exit__(self, *_):
                stream.close()

            def write(self, data):
                write(data[: len(data) // 2])
                raise OSError(28, "No space left on device")

        return Stream()

    monkeypatch.setattr(os, "fdopen", full_disk)
    with pytest.raises(InputError, match="No space left"):
        replace(estimate, method="another").save(path)
    monkeypatch.undo()
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["e.json"]
    replace(estimate, method="another").save(path)
    assert Estimate.load(path).method == "another"


# values


def test_certificate_gap():
    assert Certificate(3.0, 2.5).gap == 0.5


def test_arrays_are_read_only(estimate):
    for name in ("covariance", "bias", "point_masses", "residual"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(estimate, name)[0] = 0.0


def test_consistency_is_that_of_the_parameters():
    body = random_body(np.random.default_rng(5))
    assert Estimate("X", body, 1).physically_consistent is True
    assert (
        Estimate("X", InertialParameters(-body.vector), 1).physically_consistent
        is False
    )


# derivatives and standard deviations


def derived(vector: np.ndarray) -> np.ndarray:
    body = InertialParameters(vector)
    return np.concatenate(
        ([body.mass], body.center_of_mass, tensor_to_vector(body.inertia_at_com))
    )


@pytest.mark.parametrize(("mass", "size"), [(1e-3, 1e-3), (1.0, 0.1), (50.0, 2.0)])
def test_jacobian_is_the_derivative(mass, size):
    rng = np.random.default_rng(6)
    unit = np.repeat((mass, mass * size, mass * size**2), (1, 3, 6))
    out = np.repeat((mass, size, mass * size**2), (1, 3, 6))
    for _ in range(5):
        body = random_body(rng, mass, size, size)
        numeric = np.empty((10, 10))
        for i in range(10):
            h = np.zeros(10)
            h[i] = 1e-6 * unit[i]
            numeric[:, i] = (
                (derived(body.vector + h) - derived(body.vector - h)) / 2e-6 / out
            )
        # central differences of step 1e-6: truncation 1e-12, rounding 1e-16 / 1e-6,
        # times terms of the order of ten
        np.testing.assert_allclose(
            com_jacobian(body) * unit / out[:, None], numeric, atol=3e-8
        )


def test_std_is_the_spread_of_samples():
    """10,000 draws from a covariance so small that the map is linear: each deviation is
    known to 0.7 %."""
    rng = np.random.default_rng(7)
    body = random_body(rng)
    root = (
        rng.normal(size=(10, 10))
        * 1e-5
        * np.repeat((1.0, 0.1, 0.01), (1, 3, 6))[:, None]
    )
    std = Estimate("X", body, 1, covariance=root @ root.T).std
    draws = np.array(
        [derived(body.vector + root @ rng.normal(size=10)) for _ in range(10_000)]
    )
    spread = draws.std(axis=0)
    assert std["mass"] == pytest.approx(spread[0], rel=0.03)  # four standard errors
    np.testing.assert_allclose(std["center_of_mass"], spread[1:4], rtol=0.03)
    np.testing.assert_allclose(
        tensor_to_vector(std["inertia_at_com"]), spread[4:], rtol=0.03
    )
    assert Estimate("X", body, 1).std is None


def test_std_of_what_is_determined_beside_what_is_not():
    """At rest: mass and COM keep the deviations they have without the inertia entries,
    whose own are infinite."""
    body = random_body(np.random.default_rng(8))
    finite = np.diag(np.repeat((1e-4, 1e-6, 0.0), (1, 3, 6)))
    infinite = finite + np.diag(np.repeat((0.0, np.inf), (4, 6)))
    infinite[~np.eye(10, dtype=bool)] = 0.0
    known, open_ = (
        Estimate("X", body, 1, covariance=c).std for c in (finite, infinite)
    )
    assert known["mass"] == open_["mass"] == pytest.approx(1e-2)
    np.testing.assert_allclose(
        open_["center_of_mass"], known["center_of_mass"], rtol=1e-12
    )
    assert np.isposinf(open_["inertia_at_com"]).all()


def test_every_estimator_gives_a_file_that_reads_back(z, tmp_path):
    shape = Shape(np.random.default_rng(9).normal(scale=0.1, size=(20, 3)))
    for estimator in (OLS(), OLS("estimate"), PMD(shape), PMD(shape, bias="estimate")):
        found = estimator.fit(z)
        found.save(tmp_path / "e.json")
        assert_same_estimate(Estimate.load(tmp_path / "e.json"), found)
