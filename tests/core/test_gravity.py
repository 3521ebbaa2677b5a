"""Local gravity, and how well it is known."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.gravity import (
    CENTRIFUGAL_RATIO,
    FLATTENING,
    LATITUDE_STD,
    ON_EARTH,
    PLACE_STD,
    SEMI_MAJOR_AXIS,
    SQUARED_ECCENTRICITY,
    WORLD_STD,
    Gravity,
    normal_gravity,
)
from hefting.core.spatial import STANDARD_GRAVITY, check_gravity


def test_normal_gravity_is_that_of_wgs_84():
    """Against the values its report states: at the equator, at the poles, and their
    mean over the ellipsoid; each to its last digit."""
    assert normal_gravity(0.0) == pytest.approx(9.7803253359, abs=1e-10)
    assert normal_gravity(90.0) == pytest.approx(9.8321849378, abs=1e-9)
    latitude = np.degrees(np.linspace(-np.pi / 2, np.pi / 2, 4001))
    e2 = 0.00669437999014
    sine = np.sin(np.radians(latitude))
    area = np.cos(np.radians(latitude)) / (1.0 - e2 * sine**2) ** 2
    each = [normal_gravity(float(x)) for x in latitude]
    assert np.average(each, weights=area) == pytest.approx(9.7976432222, abs=1e-6)


@pytest.mark.parametrize("latitude", [-67.0, 0.0, 33.0])
def test_it_decreases_with_altitude_as_free_air_has_it(latitude):
    """0.3086 mGal a metre, to a percent, on either side of the equator."""
    change = normal_gravity(latitude, 1000.0) - normal_gravity(latitude, 0.0)
    assert change == pytest.approx(-3.086e-3, rel=0.01)
    assert normal_gravity(-latitude, 500.0) == normal_gravity(latitude, 500.0)


def test_a_gravity_serves_as_three_numbers():
    found = Gravity.at(48.0, 500.0)
    np.testing.assert_array_equal(check_gravity(found), found.vector)
    assert Gravity.of(found) is found
    assert Gravity.of([0.0, 0.0, -9.81]) == Gravity((0.0, 0.0, -9.81))
    assert Gravity.of("estimate") == Gravity(STANDARD_GRAVITY, WORLD_STD, "estimate")
    assert ON_EARTH.vector == STANDARD_GRAVITY


def test_more_is_known_of_a_place_than_of_the_earth():
    stds = (PLACE_STD, LATITUDE_STD, WORLD_STD)
    found = (Gravity.at(10.0, 0.0), Gravity.at(10.0), ON_EARTH)
    assert tuple(each.std for each in found) == stds
    assert 0.0 < stds[0] < stds[1] < stds[2]
    # nearly all of the Earth is within two deviations
    for latitude in (0.0, 90.0):
        off = abs(normal_gravity(latitude) - 9.80665)
        assert 1.5 * WORLD_STD < off < 2.1 * WORLD_STD


def test_three_numbers_may_be_text_as_on_the_command_line():
    assert Gravity.of("0, 0,-9.81") == Gravity.of((0.0, 0.0, -9.81))


def test_places_that_are_not_on_the_earth_are_refused():
    for place in ((91.0, 0.0), (float("nan"), 0.0), (0.0, 1e5), (0.0, float("nan"))):
        with pytest.raises(InputError, match="give"):
            Gravity.at(*place)
    for place, said in (
        (("north",), "latitude is 'north', not a number of degrees"),
        ((50.0, "low"), "altitude is 'low', not a number of metres"),
    ):
        with pytest.raises(InputError, match=said):
            Gravity.at(*place)
    with pytest.raises(InputError, match="unknown gravity"):
        Gravity.of("down")
    with pytest.raises(InputError, match="three numbers"):
        Gravity.of([0.0, 0.0])


def test_the_constants_of_the_ellipsoid_follow_from_each_other():
    """By its defining constants: rate of rotation [rad/s], gravitational constant times
    mass [m³/s²]; to their last digits."""
    rotation, attraction = 7.292115e-5, 3.986004418e14
    a, f = SEMI_MAJOR_AXIS, FLATTENING
    assert f * (2.0 - f) == pytest.approx(SQUARED_ECCENTRICITY, abs=1e-14)
    ratio = rotation**2 * a**3 * (1.0 - f) / attraction
    assert ratio == pytest.approx(CENTRIFUGAL_RATIO, rel=1e-11)
