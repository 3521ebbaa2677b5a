"""Several methods on one recording: the table, the machine's version of it, and what is
recommended."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.estimators import (
    METHODS,
    OLS,
    PMD,
    VARIANTS,
    describe_methods,
    method_named,
)
from hefting.estimators.base import INVARIANCES
from hefting.identification import compare as comparison
from hefting.identification import identify
from hefting.identification.compare import (
    compare,
    explanation,
    misfit,
    recommend,
    uncertainty,
)
from hefting.logs import write_log
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids

pytestmark = pytest.mark.usefixtures("same_recordings")

NOISE = Noise(0.1, 0.005)


@pytest.fixture(scope="module")
def recording():
    """Five seconds of a hammer moved slowly (part of them near-static), poses alone,
    its wrench noisy."""
    motion = UR5.motion(sinusoids(5.0, 100.0, 0.7))
    return simulate(
        motion, hammer().parameters, noise=NOISE, pose_noise=(1e-4, 3.5e-4), seed=3
    )


@pytest.fixture(scope="module")
def shape():
    """The hammer's points, labelled: handle and head."""
    points = Shape.from_mesh(hammer().mesh())
    along = (
        points.positions
        @ np.linalg.svd(points.positions - points.positions.mean(axis=0))[2][0]
    )
    return replace(points, labels=(along > np.median(along)).astype(int))


@pytest.fixture(scope="module")
def everything(recording, shape):
    return compare(recording, shape, bias="none")


@pytest.fixture(scope="module")
def log(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("comparison") / "log.csv"
    write_log(recording, path)
    return path


def test_all_means_all_methods_and_variants(everything):
    assert list(everything.results) == [*METHODS, *VARIANTS]
    assert list(everything.shown) == list(METHODS)
    rows = repr(everything).splitlines()[-len(METHODS) :]
    assert [row.split()[0] for row in rows] == list(METHODS)
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
    alone = identify(recording, shape, method=name.lower(), bias="none").estimate
    np.testing.assert_array_equal(
        alone.parameters.vector, everything.results[name].parameters.vector
    )
    assert alone.method == name
    assert alone.warnings == everything.results[name].warnings


def test_variants_differ_from_their_methods(everything):
    for name, (base, settings) in VARIANTS.items():
        if "model" not in settings:
            continue  # a condition that holds anyway changes nothing
        one, other = everything.results[name], everything.results[base]
        assert np.abs(one.parameters.vector - other.parameters.vector).max() > 1e-6, (
            name
        )


def test_without_a_shape_what_needs_one_is_left_out_with_a_reason(recording):
    found = compare(recording)
    assert set(found.skipped) == {"PMD", "GEO", "HPS"}
    assert list(found.results) == [
        "Bayes",
        "LMI",
        "OLS",
        "RTLS",
        "OLS-blended",
        "OLS-reduced",
    ]
    for name, why in found.skipped.items():
        assert METHODS[name].needs in why
        assert "`shape`" in why
    for name in found.skipped:  # asked for by name, it is an error
        with pytest.raises(InputError, match=METHODS[name].needs):
            compare(recording, None, ["LMI", name])


def test_a_list_keeps_its_order_and_repeats_nothing(recording, shape):
    found = compare(recording, shape, ["rtls", "GEO", "rtls"])
    assert list(found.results) == ["RTLS", "GEO"]
    with pytest.raises(InputError, match="unknown method 'GEE'"):
        compare(recording, shape, ["GEE"])


def test_own_methods_and_complete_ones_are_compared_with_others(recording, shape):
    class Own(OLS):
        """A method that is not in the list."""

    strong = PMD(shape, regularization=10.0)
    methods = ["OLS", Own, strong, PMD]
    found = identify(recording, shape, method=methods, bias="none")
    assert list(found.results) == ["OLS", "Own", "PMD", "PMD 2"]
    own, ols = (found.results[name].parameters.vector for name in ("Own", "OLS"))
    np.testing.assert_array_equal(own, ols)
    assert found.estimators["PMD"] is strong
    assert found.estimators["PMD 2"].regularization != 10.0
    alone = identify(recording, shape, method=Own, bias="none")
    np.testing.assert_array_equal(alone.estimate.parameters.vector, ols)
    given = compare(
        recording, shape, [strong, "PMD"], hyperparameters={"regularization": 1.0}
    )
    assert [e.regularization for e in given.estimators.values()] == [10.0, 1.0]


def test_hyperparameters_go_to_those_that_have_them(recording, shape):
    found = compare(
        recording,
        shape,
        ["PMD", "GEO", "LMI"],
        hyperparameters={"gamma": 1e9, "c1": 5e3},
    )
    assert found.results["GEO"].provenance["gamma"] == 1e9
    assert found.results["PMD"].provenance["c1"] == 5e3
    homogeneous = shape.homogeneous.center_of_mass
    np.testing.assert_allclose(
        found.results["GEO"].parameters.center_of_mass, homogeneous, atol=1e-3
    )
    with pytest.raises(InputError, match="none of LMI has a 'gamma'"):
        compare(recording, shape, ["LMI"], hyperparameters={"gamma": 1.0})


# what is recommended


def test_misfit_of_least_squares_is_none_and_of_the_truth_that_of_ten_parameters(
    everything,
):
    """chi² of ten: mean 10, standard deviation 4.5; the noise is estimated and the
    motion noisy, so up to 40."""
    prepared = everything.ingested
    assert misfit(everything.results["OLS"], prepared) == pytest.approx(0.0, abs=1e-6)
    truth = replace(everything.results["OLS"], parameters=hammer().parameters)
    assert 0.5 < misfit(truth, prepared) < 40.0
    wrong = replace(truth, parameters=hammer().parameters + hammer().parameters)
    assert misfit(wrong, prepared) > 1e4


def test_which_is_recommended_and_when(everything, shape):
    """Every branch; uncertainties lie a factor of 1.4 or more from their limits,
    misfits one of ten or more."""
    prepared = everything.ingested
    one = everything.results["OLS"]
    true = hammer().parameters.vector
    body, twice, minus, worse = (
        replace(one, parameters=InertialParameters(k * true)) for k in (1, 2, -1, -2)
    )

    def best(s, given=shape, **results):
        covariance = (
            prepared.fit.covariance * (s / uncertainty(prepared, given or shape)) ** 2
        )
        return recommend(
            results,
            replace(prepared, fit=replace(prepared.fit, covariance=covariance)),
            given,
        )[0]

    assert (
        best(0.05, Bayes=body, GEO=body, LMI=body)
        == best(0.3, Bayes=body, PMD=body)
        == "Bayes"
    )
    assert (
        best(0.05, Bayes=twice, GEO=body, LMI=body, PMD=body)
        == best(0.05, GEO=body, LMI=body, PMD=body)
        == "GEO"
    )
    assert (
        best(0.05, GEO=twice, LMI=body, PMD=body)
        == best(0.14, PMD=body, LMI=body)
        == "LMI"
    )
    assert best(0.15, GEO=twice, LMI=body) == best(0.05, GEO=twice, PMD=body) == "GEO"
    assert (
        best(0.3, PMD=body, LMI=body)
        == best(0.3, GEO=minus, LMI=body, PMD=body)
        == "PMD"
    )
    assert (best(0.05, LMI=minus, OLS=body), best(0.05, None, OLS=body, LMI=body)) == (
        "OLS",
        "LMI",
    )
    assert (
        best(0.05, OLS=worse, RTLS=minus),
        best(0.05, None, GEO=twice, HPS=body),
    ) == ("RTLS", "HPS")
    outside = replace(body, hull_margin=-0.3)
    assert (
        best(0.05, GEO=body, LMI=outside) == best(0.05, GEO=outside, LMI=body) == "LMI"
    )


def test_misfit_allows_for_correlated_residuals(everything):
    p = everything.ingested
    true = replace(everything.results["OLS"], parameters=hammer().parameters)
    tripled = replace(p, fit=replace(p.fit, inflation=3 * p.fit.inflation))
    # one division: rounding
    assert misfit(true, tripled) == pytest.approx(misfit(true, p) / 3, rel=1e-12)


def test_variants_are_not_recommended(recording, shape, monkeypatch):
    asked = []
    monkeypatch.setattr(
        comparison,
        "recommend",
        lambda results, *_: asked.append(set(results)) or ("PMD", "said so"),
    )
    start = time.perf_counter()
    found = compare(recording, shape, "all", bias="none")
    elapsed = time.perf_counter() - start
    assert asked == [set(METHODS)]
    assert (found.recommended, found.reason) == ("PMD", "said so")
    assert len(set(found.seconds.values())) > 1
    assert sum(found.seconds.values()) < elapsed


def test_a_mistake_is_not_skipped(recording, shape):
    for wrong in ({"c1": -5.0}, {"gamma": -1.0}):
        with pytest.raises(InputError, match="must be positive"):
            compare(recording, shape, "all", hyperparameters=wrong)
    with pytest.raises(InputError, match="unknown method 'foo'"):
        compare(recording, shape, "all,foo")
    with pytest.raises(InputError, match="no method"):
        compare(recording, shape, [])


def test_the_wrong_sign_is_refused_by_every_method(recording, shape):
    """The least-squares mass is negative by hundreds of standard deviations."""
    for method in METHODS:
        with pytest.raises(InputError, match="no positive mass"):
            identify(recording, shape, method=method, wrench="on-sensor", bias="none")


@pytest.mark.parametrize(
    "words", [(), ("--shape", "box:-0.01,0.01,-0.1,0.1,0.06,0.08")]
)
def test_the_table_is_not_cut(run, log, words):
    """With a shape that does not hold the COM, which makes the longest rows."""
    status, out, _ = run("identify", log, "--method", "all", *words)
    assert status == 0
    assert "…" not in out


def test_a_wrong_shape_is_not_recommended(recording):
    """A box beside the object cannot hold its centre of mass: what rests on it does not
    explain the torque."""
    wrong = Shape.from_box(0.3, 0.35, 0.3, 0.35, 0.3, 0.35)
    found = compare(recording, wrong, ["Bayes", "PMD", "LMI", "OLS"], bias="none")
    assert found.recommended not in ("Bayes", "PMD")


# the command


def test_the_table_and_the_recommendation(run, log):
    status, out, err = run("identify", log, "--method", "all", "--verbose")
    assert (status, err) == (0, "")
    for name in ("LMI", "OLS", "RTLS", "OLS-blended", "OLS-reduced"):
        assert any(line.split()[:1] == [name] for line in out.splitlines()), name
    assert "recommended: Bayes" in out
    assert "OLS-reduced" not in run("identify", log, "--method", "all")[1]
    assert "PMD needs a shape" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


def test_the_machines_version(run, log, tmp_path):
    box = "box:-0.3,0.3,-0.2,0.2,-0.2,0.2"
    saved = tmp_path / "best.json"
    words = ("--method", "GEO,pmd,OLS", "--shape", box, "--json", "--output", saved)
    status, out, err = run("identify", log, *words)
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert set(found) == {
        *("schema", "version", "verdict", "reasons"),
        *("results", "recommended", "reason", "skipped"),
    }
    assert [result["method"] for result in found["results"]] == ["GEO", "PMD", "OLS"]
    best = json.loads(saved.read_text())
    assert best["method"] == found["recommended"]
    assert found["verdict"] == best["verdict"]
    assert len(found["reasons"]) == len(best["reasons"])
    (whole := tmp_path / "all.json").write_text(out)
    np.testing.assert_array_equal(
        Estimate.load(whole).parameters.vector, Estimate.load(saved).parameters.vector
    )
    for broken in ({**found, "recommended": "LMI"}, {**found, "results": {"mass": 1}}):
        whole.write_text(json.dumps(broken))
        with pytest.raises(InputError, match="not an estimate"):
            Estimate.load(whole)
    for result in found["results"]:
        assert set(result["consistency"]["margins"]) == {
            "mass",
            "inertia",
            "triangle",
            "pseudo_inertia",
            "hull",
        }
        assert result["physically_consistent"] == (
            result["consistency"]["violated"] is None
        )
        assert result["seconds"] > 0.0


def test_one_method_by_name_is_as_before(run, log):
    _, out, _ = run("identify", log, "--method", "ols", "--json")
    assert json.loads(out)["method"] == "OLS"
    _, out, _ = run("identify", log, "--json")
    alone = json.loads(out)
    assert alone["method"] == "Bayes"
    assert any("no shape given" in line for line in alone["warnings"])


@pytest.mark.parametrize(
    "words",
    [
        ("--method", "PMD"),
        ("--method", "PMD,OLS"),
        ("--method", "HPS", "--shape", "box:0,1,0,1,0,1"),
    ],
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


def test_a_larger_residual_is_told():
    """Half as much again as another's: never "to within the noise"."""
    close = Estimate("LMI", hammer().parameters, 100, residual=np.array((0.1, 0.01)))
    far = replace(close, method="Bayes", residual=np.array((0.11, 0.015)))
    said = explanation("Bayes", {"Bayes": far, "LMI": close})
    assert "1.5 times the residual of the closest fit" in said
    same = {"Bayes": close, "LMI": close}
    assert "to within the noise and says" in explanation("Bayes", same)
