"""A scale's reading in every method: against closed forms and a fit of all samples with
the gain as an unknown of its own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from estimators.test_point_intervals import METHODS, ends
from hammers import exact, noisy, shape
from hefting.core.errors import InputError
from hefting.core.measurements import Measurements, Noise
from hefting.core.messages import codes, verdict_of
from hefting.core.quantity import MassReading
from hefting.core.regressor import full_regressor
from hefting.core.sensor_accuracy import Z95, SensorAccuracy
from hefting.estimators import GEO, LMI, OLS, PMD, Bayes
from hefting.estimators.bayes.likelihood import (
    LARGEST_DEVIATION,
    Likelihood,
    with_reading,
)
from hefting.simulation import hammer

WHITE = Noise(0.1, 0.005)
MASS = hammer().parameters.mass
ALL = METHODS | {"Bayes": Bayes(shape()), "Bayes, no shape": Bayes()}


class GainAlone(SensorAccuracy):
    """A sensor that is wrong by a gain that all channels share, and by nothing else."""

    slow_std = 0.0  # pyright: ignore[reportAssignmentType]
    channel_stds = np.zeros((6, 6))  # pyright: ignore[reportAssignmentType]


def with_gain(z: Measurements, gain: float) -> Measurements:
    return replace(z, force=(1.0 + gain) * z.force, torque=(1.0 + gain) * z.torque)


def white(seed: int, samples: int = 1000) -> Measurements:
    """Exact motion, white noise of the wrench."""
    return replace(exact(samples).with_noise(WHITE, seed), noise=None)


def rows(z: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Whitened equations of every sample."""
    scale = 1.0 / np.repeat((WHITE.force, WHITE.torque), 3)
    A = (full_regressor(z) * scale[:, None]).reshape(-1, 10)
    return A, (z.wrench * scale).ravel()


@pytest.mark.parametrize("std", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("kind", [OLS, LMI])
def test_of_an_exact_sensor_it_is_one_row_of_least_squares(kind, std):
    """Noise that is given, and no other error: the row weighs as it is. LMI, whose body
    exists here, is the same."""
    z, reading = white(1), MassReading(MASS + 2.0 * std, std)
    A, b = rows(z)
    A = np.vstack((A, np.eye(1, 10) / std))
    b = np.append(b, reading.mass / std)
    size = np.linalg.norm(A, axis=0)
    expected = np.linalg.lstsq(A / size, b, rcond=None)[0] / size
    found = kind(noise=WHITE, mass=reading).fit(z)
    scale = np.sqrt(np.linalg.inv((A / size).T @ (A / size)).diagonal()) / size
    # a millionth of its deviation: the floor of a given noise and rounding; LMI's
    # solver stops within a thousandth
    tolerance = 1e-5 if kind is OLS else 5e-3
    off = np.abs(found.parameters.vector - expected)
    assert (off < tolerance * scale).all()
    if kind is OLS:
        low, high = ends(found)
        np.testing.assert_allclose(
            (high - low)[:10][0], 2.0 * Z95 * scale[0], rtol=0.02
        )


@pytest.mark.parametrize("tool", [0.0, 1.5])
def test_the_gain_is_learned_as_by_a_fit_that_has_it_as_an_unknown(tool):
    """b = (1 + gain) A phi, the gain of the sensor's accuracy, and the mass weighed: a
    fit of eleven unknowns. A tool of `tool` times the object's parameters was
    subtracted, whose wrench was too large as well: the object's is by so much more."""
    share, std = 0.02, 0.002 * MASS
    carried = tool * hammer().parameters.vector
    z = with_gain(white(2), 0.013)
    held = 0.013 * full_regressor(z) @ carried
    z = replace(z, force=z.force + held[:, :3], torque=z.torque + held[:, 3:])
    reading, gain_std = MassReading(MASS + std, std), share / Z95
    A, b = rows(z)

    def residuals(x: np.ndarray) -> np.ndarray:
        off = A @ ((1.0 + x[10]) * x[:10] + x[10] * carried) - b
        ends = ((x[0] - reading.mass) / std, x[10] / gain_std)
        return np.concatenate((off, ends))

    start = np.append(hammer().parameters.vector, 0.0)
    fit = least_squares(residuals, start, x_scale="jac", xtol=1e-12, ftol=1e-12)
    accuracy = GainAlone(share)
    estimator = OLS(
        noise=WHITE, mass=reading, sensor_accuracy=accuracy, carried=carried
    )
    found = estimator.fit(z)
    # the gain is found to first order: its square is left out
    gain = (1.0 + tool) * fit.x[10]
    assert found.provenance["sensor_gain"] == pytest.approx(
        gain, rel=2.0 * (1.0 + tool) * share
    )
    assert found.parameters.mass == pytest.approx(fit.x[0], abs=share * std)
    np.testing.assert_allclose(found.parameters.vector, fit.x[:10], atol=1e-4 * MASS)
    bayes = Bayes(noise=WHITE, mass=reading, sensor_accuracy=accuracy, carried=carried)
    assert bayes.fit(z).provenance["sensor_gain"] == pytest.approx(gain, rel=0.1)
    # as sure as that fit, by its curvature
    J = fit.jac
    scale = np.linalg.norm(J, axis=0)
    variance = np.linalg.inv((J / scale).T @ (J / scale)).diagonal() / scale**2
    low, high = ends(found)
    np.testing.assert_allclose(
        (high - low)[:1], 2.0 * Z95 * variance[:1] ** 0.5, rtol=0.03
    )
    np.testing.assert_allclose(
        (high - low)[[4, 7, 9]], 2.0 * Z95 * variance[[4, 7, 9]] ** 0.5, rtol=0.05
    )


def test_the_likelihood_is_conditioned_on_the_reading():
    rng = np.random.default_rng(3)
    X, mean = rng.normal(size=(10, 10)), rng.normal(size=10)
    C, reading = X @ X.T, MassReading(1.3, 0.02)
    Lambda = np.linalg.inv(C)
    found = with_reading(Likelihood(Lambda, Lambda @ mean, np.eye(6)), reading)
    gain = C[:, 0] / (C[0, 0] + reading.std**2)
    np.testing.assert_allclose(
        np.linalg.solve(found.precision, found.shift),
        mean + gain * (reading.mass - mean[0]),
        rtol=1e-7,
    )
    np.testing.assert_allclose(
        np.linalg.inv(found.precision), C - np.outer(gain, C[0]), atol=1e-8 * C.max()
    )


def test_the_mass_of_a_likelihood():
    """Its marginal; infinite where a direction that the samples do not see holds it."""
    rng = np.random.default_rng(4)
    X, phi = rng.normal(size=(12, 10)) * 10.0 ** np.arange(-5, 5), rng.normal(size=10)
    Lambda = X.T @ X
    mass, variance = Likelihood(Lambda, Lambda @ phi, np.eye(6)).mass
    assert mass == pytest.approx(phi[0], rel=1e-6)
    assert variance == pytest.approx(np.linalg.inv(Lambda)[0, 0], rel=1e-6)
    X[:, 0] = 1e-5 * (X[:, 1] + X[:, 5])
    open_ = Likelihood(X.T @ X, X.T @ X @ phi, np.eye(6))
    assert open_.mass[1] == np.inf
    X[:, 0] = 0.0
    assert Likelihood(X.T @ X, X.T @ X @ phi, np.eye(6)).mass[1] == np.inf


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_every_method_takes_it(name, bias):
    """A sensor whose gain is wrong by its accuracy: the mass is that of a good scale,
    and its interval the scale's; the others are no wider than without."""
    estimator = replace(ALL[name], bias=bias)
    z, std = with_gain(replace(noisy(1), noise=None), 0.004), 2e-4 * MASS
    alone = estimator.fit(z)
    found = replace(estimator, mass=(MASS, std)).fit(z)
    low, high = found.intervals["mass"]
    assert low <= MASS <= high
    # where the method leans on other equations than the intervals do, its estimate is
    # up to half a deviation from the reading
    assert found.parameters.mass == pytest.approx(MASS, abs=std)
    assert high - low == pytest.approx(2.0 * Z95 * std, rel=0.1)
    assert high - low < 0.1 * np.ptp(alone.intervals["mass"])
    # the mean is elsewhere, and mixtures widen a little with it
    widths = [np.diff(ends(each), axis=0)[0] for each in (found, alone)]
    assert np.median(widths[0] / widths[1]) < 1.05
    assert codes(found.warnings) == codes(alone.warnings)
    own = np.concatenate([found.parameters.vector])
    assert (ends(found)[0, :10] <= ends(found)[1, :10]).all()
    assert np.isfinite(own).all()
    if found.point_masses is not None and name != "Bayes, no shape":
        assert found.point_masses.min() >= 0.0
        assert found.point_masses.sum() == pytest.approx(
            found.parameters.mass, rel=1e-6
        )
    assert found.provenance["sensor_gain"] is not None
    assert estimator.fit(z).provenance.get("sensor_gain") is None


@pytest.mark.parametrize("name", ALL)
def test_a_reading_that_tells_nothing_changes_nothing(name):
    z = replace(noisy(2), noise=None)
    alone = ALL[name].fit(z)
    found = replace(ALL[name], mass=(MASS, 0.99 * MASS)).fit(z)
    # the wrench knows the mass to some 0.4 %: a weight of 2e-5 beside it; the scale of
    # Bayes' and the intervals' prior is the reading in place of a rough mass
    np.testing.assert_allclose(
        found.parameters.vector[:4], alone.parameters.vector[:4], rtol=2e-3, atol=1e-5
    )
    assert np.ptp(found.intervals["mass"]) == pytest.approx(
        np.ptp(alone.intervals["mass"]), rel=0.05
    )


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("factor", [0.5, 2.0, 1000.0])
def test_a_scale_that_contradicts_the_wrench_is_named_and_left_out(name, factor):
    """A gripper that was not weighed, a payload that the controller subtracts, grams
    for kilograms."""
    z = replace(noisy(3), noise=None)
    alone = ALL[name].fit(z)
    found = replace(ALL[name], mass=(factor * MASS, 1e-3 * MASS)).fit(z)
    message = next(w for w in found.warnings if "mass-contradicts-wrench" in codes([w]))
    assert ("gripper" in message) == (factor < 1.0)
    assert not verdict_of(found.warnings).usable
    np.testing.assert_array_equal(found.parameters.vector, alone.parameters.vector)
    np.testing.assert_array_equal(ends(found), ends(alone))


def test_what_counts_as_a_contradiction_holds_the_gain():
    """An error within the sensor's accuracy contradicts an exact sensor only."""
    z, reading = with_gain(white(4), 0.01), (MASS, 1e-4 * MASS)
    for accuracy, contradicted in (("2%", False), ("0.1%", True), ("0%", True)):
        for method in (OLS(), Bayes(shape())):
            told = replace(method, sensor_accuracy=accuracy, mass=reading)
            said = "mass-contradicts-wrench" in codes(told.fit(z).warnings)
            assert said is contradicted, (accuracy, method)


def test_readings_that_are_right_are_rarely_contradicted():
    """Of 60 with errors of up to three of the scale's deviations none is."""
    z, rng = white(5), np.random.default_rng(5)
    for std in (1e-4, 1e-3, 1e-2):
        for off in rng.uniform(-3.0, 3.0, 20):
            reading = MASS * (1.0 + std * off), MASS * std
            found = OLS(noise=WHITE, mass=reading).fit(z)
            assert not codes(found.warnings) & {"mass-contradicts-wrench"}
    assert LARGEST_DEVIATION > 3.0


def test_static_poses_with_a_bias_become_identifiable():
    """Two poses leave mass and bias undivided; the scale divides them."""
    z = white(6, 2)
    alone = OLS(noise=WHITE, bias="estimate").fit(z)
    found = OLS(noise=WHITE, bias="estimate", mass=(MASS, 1e-3)).fit(z)
    assert not np.ptp(alone.intervals["mass"]) < 0.01
    assert found.parameters.mass == pytest.approx(MASS, abs=2e-3)
    assert np.ptp(found.intervals["mass"]) == pytest.approx(2.0 * Z95 * 1e-3, rel=0.2)


def test_streamed_and_merged_it_is_the_same():
    z = replace(noisy(7, 400), noise=None)
    for method in (Bayes(shape(), mass="0.67kg±1g"), PMD(shape(), mass="0.67kg±1g")):
        state = method.start()
        for first in range(0, 400, 50):
            state = method.update(state, z[first : first + 50])
        np.testing.assert_allclose(
            method.estimate(state).parameters.vector,
            method.fit(z).parameters.vector,
            rtol=1e-6,
            atol=1e-9,
        )


def test_what_cannot_take_it_says_so():
    with pytest.raises(InputError, match="without intervals"):
        GEO(shape(), mass="0.5kg±1g", intervals=False)
    with pytest.raises(InputError, match="not a scale's reading"):
        Bayes(mass="heavy")
    assert Bayes(mass=(0.5, 0.001)).mass == MassReading(0.5, 0.001)
    assert Bayes(mass="0.5kg±1g").provenance["mass"] == "0.5kg±1g"
