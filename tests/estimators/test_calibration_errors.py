"""Errors of gain, cross-talk and offset: against every entry of M one by one on the
samples themselves, and against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.test_bayes_streamed import WHITE, noisy, shape
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_regressor
from hefting.core.sensor_accuracy import Z95, SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators import METHODS, OLS, PMD, Bayes
from hefting.estimators.bayes.calibration_errors import CalibrationErrors
from hefting.estimators.bayes.likelihood import Equations
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.bayes.time_samples import TimeSamples
from hefting.estimators.sample_state import SampleState

ACCURACY = SensorAccuracy(0.02, 0.7, 0.03, lever=0.05)


def recorded(
    seed: int, samples: int, free_bias: bool
) -> tuple[Measurements, CalibrationErrors, Equations, TimeSamples]:
    z = replace(noisy(seed, samples, WHITE), motion_noise=None)
    state = SampleState.empty(True).fold(z)
    every = Samples.of(state, free_bias)
    S = every.noise_left(every.least_residual)
    equations = Equations.of(every, every.least_squares, S, None)
    found = CalibrationErrors.of(
        every, equations, every.least_squares, ACCURACY, free_bias
    )
    time = TimeSamples.of(state, free_bias)
    assert time is not None
    return z, found, equations, time


def responses(z: Measurements, W: Array, free_bias: bool) -> tuple[Array, Array]:
    """Whitened regressors (K, 6, 10), and (36, K, 6) what each entry of M adds to the
    whitened wrench, both without their mean where a bias is free."""
    A = full_regressor(z)
    if free_bias:
        A = A - A.mean(axis=0)
    state = SampleState.of(z)
    w = A @ Samples.of(state, free_bias).least_squares
    added = [np.outer(w[:, d], W[:, c]) for c in range(6) for d in range(6)]
    return W @ A, np.array(added)


def entries(z: Measurements, free_bias: bool) -> Array:
    """(36,) Standard deviations of the entries of M, with the offset that follows the
    load."""
    A = full_regressor(z)
    whole = Samples.of(SampleState.of(z), free_bias).least_squares
    scale = np.repeat((1.0, ACCURACY.lever), 3)
    K = len(z) - 1.0 if free_bias else len(z)
    w = A @ whole / scale
    mean = w.mean(axis=0)
    square = np.sum((w - mean) ** 2) / K if free_bias else np.mean(np.sum(w**2, axis=1))
    load = np.sqrt((square + (np.sum(mean**2) if free_bias else 0.0)) / 6.0)
    offset = np.repeat((0.7, 0.03), 3) / Z95
    # half of its variance, divided among six loads
    with_load = np.outer(offset, 1.0 / scale) / (2.0 * 6.0) ** 0.5 / load
    return np.hypot(ACCURACY.channel_stds, with_load).ravel()


@pytest.mark.parametrize("free_bias", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_the_score_s_covariance_is_a_sum_over_the_entries(seed, free_bias):
    z, found, equations, _ = recorded(seed, 90, free_bias)
    W = equations.whitening
    A, added = responses(z, W, free_bias)
    scores = np.einsum("kci,ekc->ei", A, added)
    rows = [*(entries(z, free_bias)[:, None] * scores)]
    gain = ACCURACY.gain_std
    rows.append(gain * scores[::7].sum(axis=0))
    if not free_bias:
        for c, std in enumerate(np.repeat((0.7, 0.03), 3) / Z95):
            rows.append(std * np.einsum("kci,c->i", A, W[:, c]))
    expected = np.array(rows).T @ np.array(rows)
    scale = np.sqrt(expected.diagonal())
    # rounding of the factors
    np.testing.assert_allclose(
        found.score / np.outer(scale, scale),
        expected / np.outer(scale, scale),
        atol=1e-9,
    )


@pytest.mark.parametrize("free_bias", [False, True])
def test_what_shows_in_the_residuals_is_what_least_squares_leaves(free_bias):
    """Energies at each time scale, by the Haar transform of the residuals of each entry
    of M; 128 samples are whole blocks at each."""
    z, found, equations, time = recorded(4, 128, free_bias)
    slow = replace(found, slow=np.zeros(6))
    W = equations.whitening
    A, added = responses(z, W, free_bias)
    flat = A.reshape(-1, 10)
    left = []
    for each in added:
        fitted = np.linalg.lstsq(flat, each.ravel(), rcond=None)[0]
        left.append(each - A @ fitted)
    left = entries(z, free_bias)[:, None, None] * np.array(left)
    expected = []
    while left.shape[1] > 1:
        details = (left[:, ::2] - left[:, 1::2]) / 2.0**0.5
        expected.append(np.sum(details**2) / (6.0 * details.shape[1]))
        left = (left[:, ::2] + left[:, 1::2]) / 2.0**0.5
    shown = slow.residual_variances(time)[: len(expected)]
    np.testing.assert_allclose(shown, expected, rtol=1e-6)
    assert (found.residual_variances(time)[: len(expected)] > shown).all()


def test_stretches_differ_by_what_cross_talk_does_to_each():
    z, found, equations, time = recorded(5, 160, False)
    slow = replace(found, slow=np.zeros(6))
    A, added = responses(z, equations.whitening, False)
    fitted = [
        np.linalg.lstsq(A.reshape(-1, 10), each.ravel(), rcond=None)[0]
        for each in added
    ]
    left = added - np.array([A @ each for each in fitted])
    left *= entries(z, False)[:, None, None]
    first = 0
    for count, V in zip(time.stretches.counts, slow.of_stretches(time), strict=True):
        part = slice(first, first + int(count))
        scores = np.einsum("kci,ekc->ei", A[part], left[:, part])
        expected = scores.T @ scores
        scale = np.sqrt(expected.diagonal())
        np.testing.assert_allclose(
            V / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-6
        )
        first += int(count)
    assert first == 160


def scaled(z: Measurements, factor: float) -> Measurements:
    return replace(z, force=factor * z.force, torque=factor * z.torque)


@pytest.mark.parametrize("name", [name for name in METHODS if name != "HPS"])
def test_a_gain_that_all_channels_share_is_held_though_no_residual_shows_it(name):
    """A wrench that is half a percent too large: by the default, and beside noise that
    is given by what is said of the sensor; of a sensor without errors it is not. HPS
    has its intervals from the same place, but near-static samples only."""
    kind = METHODS[name]
    needs = {"shape": shape()} if "shape" in kind.hyperparameters() else {}
    wrong = scaled(noisy(5, 1000, WHITE), 1.005)
    truth = kind(**needs).fit(noisy(5, 1000, WHITE)).parameters.mass
    given = {"noise": WHITE} if "noise" in kind.hyperparameters() else {}
    for settings in ({}, {"sensor_accuracy": "0.5%"} | given):
        low, high = kind(**needs, **settings).fit(wrong).intervals["mass"]  # type: ignore[index]
        assert low <= truth <= high, settings
    exact = kind(**needs, sensor_accuracy="0%").fit(wrong).intervals
    if name in ("OLS", "RTLS", "LMI", "Bayes"):
        assert not exact["mass"][0] <= truth <= exact["mass"][1]  # type: ignore[index]


def test_more_samples_do_not_lessen_it():
    """Four times as many of the same samples: the noise's part of the variance is a
    quarter, that of gain and cross-talk is what it was."""
    stds = []
    for repeated in (1, 4):
        z = noisy(6, 600, WHITE)
        state = SampleState.of(z)
        for _ in range(repeated - 1):
            state = state.merge(SampleState.of(z), one_bias=True)
        samples = Samples.of(state, free_bias=False)
        S = samples.noise_left(samples.least_residual)
        equations = Equations.of(samples, samples.least_squares, S, None)
        found = CalibrationErrors.of(
            samples, equations, samples.least_squares, SensorAccuracy(0.02), False
        )
        P = equations.inverse
        stds.append(np.sqrt((P @ found.score @ P).diagonal()))
    # the noise found, by which forces and torques are weighed, changes by its ten
    # parameters less
    np.testing.assert_allclose(stds[0], stds[1], rtol=1e-2)


def test_a_common_gain_is_a_share_of_all_ten_parameters():
    """What least squares makes of it is the body itself, as many times."""
    _, found, equations, _ = recorded(7, 300, False)
    phi = found.whole
    made = equations.inverse @ np.einsum("cci->i", found.by_entry)
    # rounding over what the samples know of each parameter
    scale = np.abs(phi) + np.sqrt(equations.inverse.diagonal())
    np.testing.assert_allclose(made / scale, phi / scale, atol=1e-7)


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_an_offset_matters_most_where_no_bias_is_free(bias):
    """A constant one is absorbed by the bias; one that follows the load is not."""
    z = noisy(8, 600, WHITE)
    widths = [
        np.ptp(OLS(bias=bias, sensor_accuracy=text).fit(z).intervals["mass"])  # type: ignore[index]
        for text in ("0%", "0% 0.3N", "0% 0.6N")
    ]
    assert widths[0] < widths[1] < widths[2]
    # of a body that is turned all around a constant force is no weight
    assert widths[2] / widths[1] == pytest.approx(2.0, rel=0.2)


def test_estimates_do_not_move():
    """Of methods that find a point, not by a bit; Bayes' by a fraction of what it is
    unsure of."""
    z = noisy(9, 1000, WHITE)
    for make in (OLS, lambda **s: PMD(shape(), **s)):
        found = [make(sensor_accuracy=text).fit(z) for text in ("0%", "2% 0.1N")]
        np.testing.assert_array_equal(
            found[0].parameters.vector, found[1].parameters.vector
        )
    sure, unsure = (
        Bayes(shape(), sensor_accuracy=text).fit(z) for text in ("0%", "2%")
    )
    off = abs(unsure.parameters.mass - sure.parameters.mass)
    assert off < 0.1 * np.ptp(unsure.intervals["mass"])  # type: ignore[index]


def test_what_a_tool_weighs_counts_too():
    tool = InertialParameters.from_com(3.0, (0.0, 0.0, 0.05), 0.01 * np.eye(3)).vector
    z = noisy(10, 600, WHITE)
    alone, beside = (
        np.ptp(OLS(carried=carried).fit(z).intervals["mass"])  # type: ignore[index]
        for carried in (None, tool)
    )
    mass = OLS().fit(z).parameters.mass
    # noise is a part of what is known alone
    assert 0.5 * (mass + 3.0) / mass < beside / alone < (mass + 3.0) / mass


def test_it_is_told():
    z = noisy(11, 200, WHITE)
    for method in (
        Bayes(shape(), sensor_accuracy="1% 0.2N"),
        OLS(sensor_accuracy="1% 0.2N"),
    ):
        assert method.provenance["sensor_accuracy"] == "1% 0.2N"
        assert method.fit(z).intervals is not None
    assert (
        "sensor_accuracy" not in OLS(sensor_accuracy="1%", intervals=False).provenance
    )


def test_slow_errors_of_the_sensor_widen_the_mass(monkeypatch):
    """By what their score adds to that of the noise."""
    z, slow_score = noisy(3, 600, WHITE), CalibrationErrors.slow_score
    widths = []
    for times in (0.0, 1.0, 25.0):

        def scaled(*given, times=times):
            return times * slow_score(*given)

        monkeypatch.setattr(CalibrationErrors, "slow_score", scaled)
        found = OLS(bias="estimate", sensor_accuracy="1% 0.3N").fit(z)
        widths.append(np.ptp(found.intervals["mass"]))
    assert widths[0] < widths[1] < widths[2]
