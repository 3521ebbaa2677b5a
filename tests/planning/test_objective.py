"""The number that plans make least."""

import numpy as np
import pytest
from problems import BODY

from hefting.core.accuracy import Accuracy
from hefting.core.inertia import InertialParameters
from hefting.planning.problem import Objective, quantities

ASKED = "mass=1%,com=2mm,inertia=20%"


def information(seed=0):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(30, 10)) * np.repeat((3.0, 30.0, 300.0), (1, 3, 6))
    return A.T @ A


@pytest.mark.parametrize("asked", [None, ASKED, "inertia=5%", "mass=1%"])
def test_its_slope_is_that_of_differences(asked):
    own = Objective.of(BODY, Accuracy.parse(asked) if asked else None, gain=0.001)
    L = information()
    _, slope = own.value(L)
    for seed in range(4):
        way = information(seed + 1)
        step = 1e-5
        high, low = own.value(L + step * way)[0], own.value(L - step * way)[0]
        # differences of numbers of some 10 lose 1e-15 / 1e-5
        assert np.sum(slope * way) == pytest.approx((high - low) / (2 * step), rel=1e-6)


def test_without_tolerances_it_is_the_volume_of_the_ellipsoid():
    own = Objective.of(BODY, None)
    L, T = information(), np.diag(np.arange(1.0, 11.0))
    value = own.value(L)[0]
    assert value == pytest.approx(-np.linalg.slogdet(L)[1] / 20.0)
    # so the units of the parameters do not matter
    shift = own.value(T @ L @ T)[0] - value
    assert shift == pytest.approx(
        own.value(T @ information(3) @ T)[0] - own.value(information(3))[0]
    )


def test_with_tolerances_it_is_about_the_worst_share():
    own = Objective.of(BODY, Accuracy.parse("mass=0.0001%,com=2mm,inertia=20%"))
    L = information()
    worst = 1.96 * np.sqrt(np.linalg.inv(L)[0, 0]) / BODY.mass / 1e-6
    assert own.value(L)[0] == pytest.approx(np.log(worst), abs=1e-6)


def test_what_no_motion_lessens_stays():
    own = Objective.of(BODY, Accuracy.parse("mass=1%"), gain=0.005)
    assert own.value(1e12 * information())[0] == pytest.approx(np.log(1.96 * 0.5))


def test_quantities_are_slopes_of_mass_com_and_inertia():
    rng, step = np.random.default_rng(5), 1e-7
    J = BODY.inertia_at_com
    for _ in range(5):
        way = rng.normal(size=10) * np.repeat((1.0, 0.1, 0.01), (1, 3, 6))
        other = InertialParameters(BODY.vector + step * way)
        changes = {
            "mass": [(other.mass - BODY.mass) / BODY.mass],
            "center_of_mass": other.center_of_mass - BODY.center_of_mass,
            "inertia": (other.inertia_at_com - J) / np.linalg.norm(J),
        }
        for name, rows in quantities(BODY).items():
            own = np.linalg.norm(rows @ way)
            assert own == pytest.approx(np.linalg.norm(changes[name]) / step, rel=1e-5)
