"""Agreement of estimates: how many deviations they are apart, and when they contradict
one another."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.undetermined import Undetermined
from hefting.identification.agreement import FALSE_ALARM, Agreement, compare, limit_of
from random_problems import random_body

BODY = random_body(np.random.default_rng([16, 9]), 1.2, 0.08)
UNIT = 1.2 * np.repeat((1.0, 0.1, 0.01), (1, 3, 6))


def covariance(rng, size: float) -> np.ndarray:
    """(10, 10) of errors of a share `size` of the body."""
    L = rng.normal(size=(10, 10)) / 10.0**0.5 + np.eye(10)
    return (size * UNIT)[:, None] * (L @ L.T) * (size * UNIT)


def drawn(rng, C: np.ndarray) -> Estimate:
    """The body with an error of that covariance."""
    vector = rng.multivariate_normal(BODY.vector, C, method="cholesky")
    return Estimate("OLS", InertialParameters(vector), 100, covariance=C)


def test_deviations_are_those_of_independent_draws():
    """Of 1,000 pairs of one body, whose larger moments differ by 1 %: squares average
    one, within four deviations of such a mean, and 95 % are within 1.96."""
    rng = np.random.default_rng([16, 10])
    apart = []
    for _ in range(1000):
        sizes = 10.0 ** rng.uniform(-4.0, -3.0, 2)
        two = {
            name: drawn(rng, covariance(rng, s))
            for name, s in zip("ab", sizes, strict=True)
        }
        (found,) = Agreement.of(two).apart.values()
        apart.append(found)
    np.testing.assert_allclose(np.mean(np.square(apart), axis=0), 1.0, atol=0.18)
    # 95 % within 1.96: four deviations of a share of 1,000 are 2.8 %
    np.testing.assert_allclose(np.mean(np.abs(apart) < 1.96, axis=0), 0.95, atol=0.028)


def test_the_limit_is_that_of_all_comparisons_together():
    for pairs in (1, 3, 45):
        each = 2.0 * stats.norm.sf(limit_of(pairs))
        assert 7 * pairs * each == pytest.approx(FALSE_ALARM, rel=1e-6)


def test_intervals_count_by_the_side_that_faces_the_other():
    """A lopsided interval from 1.2 - 0.0196 to 1.2 + 1.96."""
    rng = np.random.default_rng([16, 11])
    C = covariance(rng, 1e-4)
    first = drawn(rng, C)
    ends = {
        "mass": np.array((BODY.mass - 0.0196, BODY.mass + 1.96)),
        "center_of_mass": BODY.center_of_mass
        + np.array(((-1.0,), (1.0,))) * np.ones(3),
        "inertia_at_origin": np.stack((-np.ones((3, 3)), np.ones((3, 3)))),
        "inertia_at_com": np.stack((-np.ones((3, 3)), np.ones((3, 3)))),
    }
    first = replace(first, parameters=BODY, intervals=ends)
    for change, std in ((-0.5, 0.01), (0.5, 1.0)):
        other = replace(
            first, parameters=InertialParameters(BODY.vector * (1.0, *np.ones(9)))
        )
        moved = BODY.vector.copy()
        moved[0] += change
        exact = {k: np.stack((e.mean(axis=0),) * 2) for k, e in ends.items()}
        exact["mass"] = np.array((moved[0], moved[0]))
        other = replace(first, parameters=InertialParameters(moved), intervals=exact)
        found = Agreement.of({"a": first, "b": other})
        assert found.apart["a", "b"][0] == pytest.approx(abs(change) / std, rel=1e-4)


def test_what_is_open_contradicts_nothing():
    rng = np.random.default_rng([16, 12])
    C = covariance(rng, 1e-3)
    open_ = C.copy()
    open_[4:], open_[:, 4:] = 0.0, 0.0
    open_[range(4, 10), range(4, 10)] = np.inf
    a, b = drawn(rng, C), replace(drawn(rng, C), covariance=open_)
    far = BODY.vector.copy()
    far[4:] *= 5.0
    b = replace(b, parameters=InertialParameters(far))
    found = Agreement.of({"a": a, "b": b})
    assert (found.apart["a", "b"][4:] == 0.0).all()
    assert found.tested
    assert found.agree
    # a prior knows of what the recording leaves open, which is none the less open
    names = ["mcz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz"]
    undetermined = Undetermined.of_parameters(names, "the prior")
    prior = replace(b, covariance=C, undetermined=undetermined)
    found = Agreement.of({"a": a, "b": prior})
    assert (found.apart["a", "b"][3:] == 0.0).all()
    assert np.isinf(found.intervals["b"][:, 3:]).all()
    assert np.isfinite(found.intervals["b"][:, :3]).all()
    unknown = Agreement.of({"a": a, "b": replace(b, covariance=None)})
    assert not unknown.tested
    assert unknown.agree
    assert unknown.to_dict()["estimates"][1]["intervals"][0] == [None] * 7


def test_of_several_the_pair_that_differs_most_is_told():
    rng = np.random.default_rng([16, 13])
    C = covariance(rng, 1e-3)
    heavy = replace(drawn(rng, C), parameters=InertialParameters(1.5 * BODY.vector))
    found = Agreement.of({"a": drawn(rng, C), "b": heavy, "c": drawn(rng, C)})
    assert "b" in (found.largest.first, found.largest.second)
    assert not found.agree
    assert len(found.apart) == 3
    with pytest.raises(InputError, match="two estimates or more"):
        Agreement.of({"a": heavy})


def test_compare_takes_estimates_and_paths_by_name(tmp_path):
    rng = np.random.default_rng([16, 14])
    C = covariance(rng, 1e-3)
    one, other = drawn(rng, C), drawn(rng, C)
    heavy = replace(one, parameters=InertialParameters(1.5 * BODY.vector))
    path = tmp_path / "other.json"
    other.save(path)
    assert list(compare(one, path, later=heavy).values) == ["1", str(path), "later"]
    assert list(compare(one, saved=path).values) == ["1", "saved"]
    expected = Agreement.of({"1": one, "2": other})
    np.testing.assert_array_equal(
        compare(one, other).apart["1", "2"], expected.apart["1", "2"]
    )
    differ = f"by {expected.largest.deviations:.1f} standard deviations (limit 3.8)"
    assert repr(compare(one, other)).endswith(differ)
    assert "they agree; 1 and 2" in repr(compare(one, other))
    assert "contradict" in repr(compare(one, heavy))
    open_ = replace(other, covariance=None)
    assert repr(compare(open_, open_)).endswith("nothing to compare by")


def test_what_cannot_be_compared_is_named():
    one = drawn(np.random.default_rng(0), covariance(np.random.default_rng(0), 1e-3))
    with pytest.raises(InputError, match="float is no estimate"):
        compare(one, 1.2)
    with pytest.raises(InputError, match="1: is given twice"):
        compare(one, **{"1": one})
    with pytest.raises(InputError, match="two estimates or more"):
        compare(one)
