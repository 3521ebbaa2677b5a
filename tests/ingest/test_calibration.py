"""Sign and bias of the wrench, found from simulated measurements whose sign and bias
are known; tare and bias files."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.estimators.sample_state import SampleState
from hefting.estimators.timescales import autocorrelation_time
from hefting.identification import identify
from hefting.ingest.conditioned import WrenchSign
from hefting.ingest.free_fit import fit_freely, lever, residuals
from hefting.ingest.free_fit import wrench_sign as sign_of_fits
from hefting.ingest.sign_and_bias import load_bias, tare
from hefting.simulation import UR5, hammer, random_smooth, simulate
from random_problems import random_body, random_motion, with_wrench

BIAS = np.array((6.0, -12.0, 20.0, 0.5, -0.4, 0.3))


def flipped(z):
    return replace(z, force=-z.force, torque=-z.torque)


def wrench_sign(z, free_bias):
    return sign_of_fits(
        fit_freely(z, True) if free_bias else None, fit_freely(z, False)
    )


def noisy(seed, K=60, bias=0.0, speed=0.5, mass=1.0):
    rng = np.random.default_rng(seed)
    return with_wrench(
        random_motion(rng, K, speed), random_body(rng, mass), bias, rng, 0.1, 0.005
    )


@pytest.mark.parametrize("free_bias", [False, True])
@pytest.mark.parametrize("speed", [0.0, 0.5, 5.0])
def test_sign_is_found_whatever_the_bias(free_bias, speed):
    """The bias is twice the weight; both signs, at rest and moving."""
    for seed in range(10):
        z = noisy(seed, bias=BIAS if free_bias else 0.0, speed=speed)
        for measurements, on_object in ((z, True), (flipped(z), False)):
            sign = wrench_sign(measurements, free_bias)
            assert sign.on_object is on_object
            assert sign.certain
            assert (sign.t > 0.0) is on_object


def test_flipping_the_wrench_flips_all_that_follows():
    z = noisy(1, bias=BIAS)
    one, other = fit_freely(z, True), fit_freely(flipped(z), True)
    np.testing.assert_allclose(other.vector, -one.vector, rtol=1e-9)  # rounding
    np.testing.assert_allclose(other.bias, -one.bias, rtol=1e-9)
    np.testing.assert_allclose(other.covariance, one.covariance, rtol=1e-9)
    assert other.mass_t == pytest.approx(-one.mass_t)


def test_one_orientation_leaves_the_sign_uncertain_beside_a_bias():
    rng = np.random.default_rng(2)
    one = random_motion(rng, 1, speed=0.0)[np.zeros(50, dtype=int)]
    z = with_wrench(one, random_body(rng), 0.0, rng, 0.1, 0.005)
    for measurements, on_object in ((z, True), (flipped(z), False)):
        sign = wrench_sign(measurements, True)
        assert not sign.certain
        assert sign.t == 0.0
        assert sign.on_object is on_object  # the likelier way
        assert wrench_sign(measurements, False).certain
    assert not fit_freely(z, True).bias_is_significant


@pytest.mark.parametrize(
    ("t", "certain"), [(10.1, True), (-10.1, True), (9.9, False), (-9.9, False)]
)
def test_a_sign_is_certain_from_ten_deviations_on(t, certain):
    assert WrenchSign(t > 0.0, t).certain is certain


def test_nothing_in_hand_leaves_the_sign_uncertain():
    """Noise alone: t is a standard normal, so it reaches ten never."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        z = random_motion(rng, 60)
        z = replace(
            z,
            force=0.1 * rng.normal(size=(60, 3)),
            torque=0.005 * rng.normal(size=(60, 3)),
        )
        assert not wrench_sign(z, False).certain


def test_a_bias_is_kept_when_it_is_one():
    """Without a bias none of six components exceeds three deviations, but for 0.27 %
    each: 1.6 % of 200 trials, 3.2.

    More than 12 would be five standard deviations off. A bias of ten deviations is
    always kept.
    """
    kept = sum(fit_freely(noisy(seed), True).bias_is_significant for seed in range(200))
    assert kept <= 12
    for seed in range(50):
        std = np.sqrt(fit_freely(noisy(seed), True).covariance.diagonal()[10:])
        bias = np.zeros(6)
        bias[seed % 6] = 10.0 * std[seed % 6]
        fit = fit_freely(noisy(seed, bias=bias), True)
        assert fit.bias_is_significant
        assert np.argmax(np.abs(fit.bias_t)) == seed % 6
    assert not fit_freely(noisy(1), False).bias_is_significant


def test_fit_finds_noise_and_parameters():
    """Root-mean-square residuals of 3,000 samples, degrees of freedom counted: known to
    0.75 %."""
    rng = np.random.default_rng(4)
    body = random_body(rng)
    z = with_wrench(random_motion(rng, 3000), body, BIAS, rng, 0.1, 0.005)
    fit = fit_freely(z, True)
    assert fit.noise.force == pytest.approx(0.1, rel=0.04)
    assert fit.noise.torque == pytest.approx(0.005, rel=0.04)
    assert fit.autocorrelation == pytest.approx(1.0, abs=0.1)
    error = np.concatenate((fit.vector - body.vector, fit.bias - BIAS))
    distance = error @ np.linalg.solve(fit.covariance, error)
    assert distance < 45.0  # chi² of 16 exceeds it once in 7,000
    np.testing.assert_allclose(
        residuals(z, body.vector, BIAS).std(axis=0),
        np.repeat((0.1, 0.005), 3),
        rtol=0.06,
    )
    np.testing.assert_allclose(
        residuals(z, body.vector, None).mean(axis=0), BIAS, atol=0.01
    )


def test_lever_is_the_distance_of_the_com():
    rng = np.random.default_rng(5)
    for bias in (0.0, BIAS):
        body = random_body(rng, offset=0.3)
        z = with_wrench(random_motion(rng, 100, speed=0.0), body, bias)
        assert lever(SampleState.of(z), np.any(bias)) == pytest.approx(
            np.linalg.norm(body.center_of_mass), rel=1e-9
        )


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.98])
def test_autocorrelation_time_of_a_first_order_process(rho):
    """(1 + rho)/(1 - rho). Summing down to a correlation of 5 % leaves 5 % out;
    estimates spread by a few percent."""
    rng = np.random.default_rng(6)
    noise = rng.normal(size=(50_000, 6))
    series = np.empty_like(noise)
    series[0] = noise[0]
    for k in range(1, len(noise)):
        series[k] = rho * series[k - 1] + noise[k]
    assert autocorrelation_time(series) == pytest.approx(
        (1 + rho) / (1 - rho), rel=0.15
    )


def test_autocorrelation_time_of_little():
    assert autocorrelation_time(np.zeros((100, 6))) == 1.0
    assert autocorrelation_time(np.ones((3, 6))) == 1.0


# tare and files


def recording():
    time = 0.5 + 0.01 * np.arange(100)
    wrench = np.where(time[:, None] < 0.755, np.arange(6.0), 100.0)
    return Recording({"wrench": Stream(time, wrench)}, source="log")


def test_tare_counts_from_the_first_sample():
    np.testing.assert_allclose(tare(recording(), 0.0, 0.25), np.arange(6.0))
    np.testing.assert_allclose(tare(recording(), 0.5, 0.6), 100.0)
    with pytest.raises(InputError, match="log: no wrench between 2 and 3 s"):
        tare(recording(), 2.0, 3.0)


def test_bias_files(tmp_path):
    path = tmp_path / "bias.json"
    for content in (list(BIAS), {"bias": list(BIAS), "other": 1}):
        path.write_text(json.dumps(content))
        np.testing.assert_array_equal(load_bias(path), BIAS)
    for content in (
        "x",
        "[1, 2]",
        "{}",
        '{"bias": null}',
        "[1, 2, 3, 4, 5, NaN]",
        "3",
        '["a", 1, 1, 1, 1, 1]',
    ):
        path.write_text(content)
        with pytest.raises(InputError, match=r"bias\.json"):
            load_bias(path)
    with pytest.raises(InputError, match="nothing"):
        load_bias(tmp_path / "nothing.json")
    path.write_text('{"bias": null}')  # as of an estimate without
    with pytest.raises(InputError, match="found no bias; leave it out"):
        load_bias(path)


@pytest.mark.parametrize("on_sensor", [False, True])
def test_the_bias_of_an_estimate_can_be_given_to_the_next(on_sensor, tmp_path):
    """Its file's `bias` is read back as recorded: the same log with it gives the same
    object."""
    motion = UR5.motion(random_smooth(6.0, 100.0, 1.0, seed=1))
    log = simulate(
        motion,
        hammer().parameters,
        noise=Noise(0.1, 0.005),
        bias=BIAS,
        on_sensor=on_sensor,
        exact=True,
    )
    first = identify(log, method="OLS", bias="estimate")
    first.estimate.save(tmp_path / "first.json")
    second = identify(log, method="OLS", bias=str(tmp_path / "first.json"))
    assert first.sign.on_object is second.sign.on_object is not on_sensor
    np.testing.assert_allclose(
        second.estimate.parameters.vector[:4],
        first.estimate.parameters.vector[:4],
        atol=1e-3,
        # the noise levels found differ by a little, and so the weights of force and
        # torque
    )


@pytest.mark.parametrize("told", [False, True])
@pytest.mark.parametrize("on_sensor", [False, True])
def test_an_estimates_bias_serves_a_log_of_the_other_sign(on_sensor, told, tmp_path):
    """Of the same sensor through a driver that negates what it reads; that is told, or
    found from gravity."""
    motion = UR5.motion(random_smooth(6.0, 100.0, 1.0, seed=1))
    body, noise = hammer().parameters, Noise(0.1, 0.005)
    given = {"noise": noise, "bias": BIAS, "on_sensor": on_sensor, "exact": True}
    log = simulate(motion, body, **given)
    first = identify(log, method="OLS", bias="estimate").estimate
    first.save(tmp_path / "first.json")
    wrench = replace(log["wrench"], values=-log["wrench"].values)
    other = replace(log, streams={**log.streams, "wrench": wrench})
    sign = ("on-object" if on_sensor else "on-sensor") if told else "auto"
    path = tmp_path / "first.json"
    found = identify(other, method="OLS", bias=path, wrench=sign)
    made = found.estimate.provenance
    assert made["wrench"] == ("on-object" if on_sensor else "on-sensor")
    # the noise of the bias
    subtracted = made["bias_subtracted"]
    np.testing.assert_allclose(subtracted, -BIAS, atol=0.1)
    assert found.estimate.mass == pytest.approx(first.mass, abs=1e-3)
    assert found.estimate.verdict.usable


def test_a_bias_in_standard_deviations_has_six_components_free_or_not():
    rng = np.random.default_rng(12)
    z = with_wrench(random_motion(rng, 200), random_body(rng), BIAS, rng, 0.1, 0.005)
    found = fit_freely(z, free_bias=True)
    deviations = found.bias_t * np.sqrt(found.covariance.diagonal()[10:])
    np.testing.assert_allclose(deviations, found.bias, rtol=1e-12)
    np.testing.assert_array_equal(fit_freely(z, free_bias=False).bias_t, np.zeros(6))
