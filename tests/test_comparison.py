"""Several methods on one recording: the table, the machine's version of it, and what is recommended."""

import json
import sys
from dataclasses import fields, replace

import numpy as np
import pytest

from hefting.cli import main
from hefting.comparison import compare
from hefting.errors import InputError
from hefting.estimators import METHODS, VARIANTS, describe_methods, method_named
from hefting.estimators.base import INVARIANCES
from hefting.identification import identify
from hefting.logs import write_log
from hefting.measurements import Noise
from hefting.recommendation import misfit
from hefting.shapes import PointMasses
from hefting.simulation import UR5, hammer, simulate, sinusoids

NOISE = Noise(0.1, 0.005)


@pytest.fixture(scope="module")
def recording():
    """Five seconds of a hammer moved slowly (part of them near-static), poses alone, its wrench noisy."""
    motion = UR5.motion(sinusoids(5.0, 100.0, 0.7))
    return simulate(motion, hammer().parameters, noise=NOISE, pose_noise=(1e-4, 3.5e-4), seed=3)


@pytest.fixture(scope="module")
def shape():
    """The hammer's points, labelled: handle and head."""
    points = PointMasses.from_mesh(hammer().mesh())
    along = points.positions @ np.linalg.svd(points.positions - points.positions.mean(axis=0))[2][0]
    return replace(points, labels=(along > np.median(along)).astype(int))


@pytest.fixture(scope="module")
def everything(recording, shape):
    return compare(recording, shape, bias="none")


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the command in this process: exit status, standard output, standard error."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["hefting", *map(str, words)])
        status = 0
        try:
            main()
        except SystemExit as stop:
            status = stop.code
        return status, *capsys.readouterr()

    return run


@pytest.fixture(scope="module")
def log(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("comparison") / "log.csv"
    write_log(recording, path)
    return path


def test_all_means_all_methods_and_variants(everything):
    assert list(everything.results) == [*METHODS, *VARIANTS]
    assert everything.skipped == {}
    assert set(everything.seconds) == set(everything.results)
    for name, estimate in everything.results.items():
        assert estimate.method == name
        kind, _ = method_named(name)
        if kind.consistent:
            assert estimate.parameters.consistency().is_consistent, name
        assert estimate.residual is not None
        assert estimate.hull_margin is not None


@pytest.mark.parametrize("name", [*METHODS, *VARIANTS])
def test_each_result_is_that_of_the_method_alone(everything, recording, shape, name):
    kind, settings = method_named(name)
    alone = identify(recording, shape, method=name.lower(), bias="none").estimate
    np.testing.assert_array_equal(alone.parameters.vector, everything.results[name].parameters.vector)
    assert alone.method == name
    assert alone.warnings == everything.results[name].warnings
    assert {f.name for f in fields(kind)} >= set(settings)


def test_variants_differ_from_their_methods(everything):
    for name, (base, settings) in VARIANTS.items():
        if "model" not in settings:
            continue  # a condition that holds anyway changes nothing
        one, other = everything.results[name], everything.results[base]
        assert np.abs(one.parameters.vector - other.parameters.vector).max() > 1e-6, name


def test_without_a_shape_what_needs_one_is_left_out_with_a_reason(recording):
    found = compare(recording)
    assert set(found.skipped) == {"PMD", "GEO", "HPS"}
    assert list(found.results) == ["LMI", "OLS", "RTLS", "OLS-blended", "OLS-reduced"]
    for name, why in found.skipped.items():
        assert METHODS[name].needs in why
        assert "--shape" in why
    for name in found.skipped:  # asked for by name, it is an error
        with pytest.raises(InputError, match=METHODS[name].needs):
            compare(recording, None, ["LMI", name])


def test_a_list_keeps_its_order_and_repeats_nothing(recording, shape):
    found = compare(recording, shape, ["rtls", "GEO", "rtls"])
    assert list(found.results) == ["RTLS", "GEO"]
    with pytest.raises(InputError, match="unknown method 'GEE'"):
        compare(recording, shape, ["GEE"])


def test_hyperparameters_go_to_those_that_have_them(recording, shape):
    found = compare(recording, shape, ["PMD", "GEO", "LMI"], hyperparameters={"gamma": 1e9, "c1": 5e3})
    assert found.results["GEO"].provenance["gamma"] == 1e9
    assert found.results["PMD"].provenance["c1"] == 5e3
    homogeneous = shape.homogeneous.center_of_mass
    np.testing.assert_allclose(found.results["GEO"].parameters.center_of_mass, homogeneous, atol=1e-3)
    with pytest.raises(InputError, match="none of LMI has a 'gamma'"):
        compare(recording, shape, ["LMI"], hyperparameters={"gamma": 1.0})


# what is recommended


def test_misfit_of_least_squares_is_none_and_of_the_truth_that_of_ten_parameters(everything):
    """chi² of ten: mean 10, standard deviation 4.5; the noise is estimated and the motion noisy, so up to 40."""
    prepared = everything.prepared
    assert misfit(everything.results["OLS"], prepared) == pytest.approx(0.0, abs=1e-6)
    truth = replace(everything.results["OLS"], parameters=hammer().parameters)
    assert 0.5 < misfit(truth, prepared) < 40.0
    wrong = replace(truth, parameters=hammer().parameters + hammer().parameters)
    assert misfit(wrong, prepared) > 1e4


def test_the_recommended_is_consistent_and_fits(everything):
    best = everything.results[everything.recommended]
    assert everything.recommended in METHODS
    assert best.physically_consistent
    assert everything.reason


def test_a_wrong_shape_is_not_recommended(recording):
    """A box beside the object cannot hold its centre of mass: what rests on it does not explain the torque."""
    wrong = PointMasses.from_box(0.3, 0.35, 0.3, 0.35, 0.3, 0.35)
    found = compare(recording, wrong, ["PMD", "LMI", "OLS"], bias="none")
    assert found.recommended != "PMD"


# the command


def test_the_table_and_the_recommendation(run, log):
    status, out, err = run("identify", log, "--method", "all")
    assert (status, err) == (0, "")
    for name in ("LMI", "OLS", "RTLS", "OLS-blended", "OLS-reduced"):
        assert any(line.split()[:1] == [name] for line in out.splitlines()), name
    assert "recommended: LMI" in out
    assert "PMD needs a shape" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 100


def test_the_machines_version(run, log, tmp_path):
    box = "box:-0.3,0.3,-0.2,0.2,-0.2,0.2"
    saved = tmp_path / "best.json"
    words = ("--method", "GEO,pmd,OLS", "--shape", box, "--json", "--output", saved)
    status, out, err = run("identify", log, *words)
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert set(found) == {"results", "recommended", "reason", "skipped"}
    assert [result["method"] for result in found["results"]] == ["GEO", "PMD", "OLS"]
    assert json.loads(saved.read_text())["method"] == found["recommended"]
    for result in found["results"]:
        assert set(result["consistency"]["margins"]) == {"mass", "inertia", "triangle", "pseudo_inertia", "hull"}
        assert result["physically_consistent"] == (result["consistency"]["violated"] is None)
        assert result["seconds"] > 0.0


def test_one_method_by_name_is_as_before(run, log):
    _, out, _ = run("identify", log, "--method", "ols", "--json")
    assert json.loads(out)["method"] == "OLS"
    _, out, _ = run("identify", log, "--json")
    alone = json.loads(out)
    assert alone["method"] == "LMI"
    assert any("no shape given" in line for line in alone["warnings"])


@pytest.mark.parametrize(
    "words", [("--method", "PMD"), ("--method", "PMD,OLS"), ("--method", "HPS", "--shape", "box:0,1,0,1,0,1")]
)
def test_a_missing_shape_is_one_line(run, log, words):
    status, out, err = run("identify", log, *words)
    assert (status, out) == (2, "")
    assert "needs" in err
    assert err.count("\n") == 1


def test_methods_are_described(run):
    status, out, _ = run("methods", "--json")
    assert status == 0
    found = json.loads(out)
    assert found == describe_methods()
    assert list(found) == list(METHODS)
    for description in found.values():
        assert description["summary"]
        assert description["source"]
        assert set(description["invariances"]) <= set(INVARIANCES)
    status, out, _ = run("methods")
    assert status == 0
    for name, kind in METHODS.items():
        assert name in out
        assert kind.needs.split()[-1] in out
