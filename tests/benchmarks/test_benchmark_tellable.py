"""What a recording can tell of a mistake."""

import numpy as np
from benchmarks.given import Given, Mistake, correct
from benchmarks.mistaken import mistakes as catalogue
from benchmarks.tellable import is_tellable

from hefting.simulation.faults import WRENCH_NOISE


def mistake(name: str, strength: str) -> Mistake:
    (found,) = (
        each for each in catalogue() if (each.name, each.strength) == (name, strength)
    )
    return found


def with_noise(given: Given, seed: int) -> Given:
    """With other noise of the same size."""
    noise = (
        np.random.default_rng(seed).normal(size=(2000, 6)) * WRENCH_NOISE["moderate"]
    )
    exact = given.wrench_of(given.truth.vector)
    return given.wrench(lambda time, _: exact + noise[: len(time)])


def test_large_mistakes_can_be_told_and_none_cannot():
    """Half of the mass missing is another mass; another mesh is no other body."""
    right = correct(0)
    assert is_tellable(mistake("turned about x", "10°"), right, 0)
    assert is_tellable(mistake("another mesh", ""), right, 0)
    lighter = Mistake(
        "lighter",
        "",
        lambda given, _: given.wrench(lambda _, wrench: 0.5 * wrench),
        frozenset({"-"}),
    )
    assert not is_tellable(lighter, right, 0)
    same = Mistake(
        "same mesh", "", lambda given, _: given, frozenset({"-"}), needs_shape=True
    )
    assert not is_tellable(same, right, 0)


def test_it_is_the_noise_of_the_recording_that_hides_a_mistake():
    """A torque about a point 20 mm off, chi-squared of 45 without noise: of other noise
    it is normal about the root of that, above the bound of 40 in six of ten; the
    binomial deviation of fifty is 7 %."""
    tcp = mistake("torque about the TCP", "20 mm")
    right = correct(5)
    told = [is_tellable(tcp, with_noise(right, k), 5) for k in range(50)]
    assert 0.45 < np.mean(told) < 0.80
