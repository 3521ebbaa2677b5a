"""`benchmarks.accuracy`: its bound against closed forms, least squares and a larger
problem; and a run of it."""

import sys
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benchmarks.accuracy import main
from benchmarks.cramer_rao import Scale, bound

from hefting.core.accuracy import errors_between
from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.spatial import vector_to_tensor
from hefting.estimators import OLS, PMD, Bayes
from hefting.simulation import UR5, hammer, sinusoids, wield
from recordings import needs_recordings

NOISE = Noise(0.1, 0.005, 0.5, 4.0)
WRENCH = np.repeat((NOISE.force**2, NOISE.torque**2), 3)
MOTION = np.repeat((NOISE.linear_acceleration**2, NOISE.angular_acceleration**2), 3)
POSE = np.array(((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
SIDES = np.array((0.05, 0.2, 0.3))


@cache
def exact(samples: int = 150) -> Measurements:
    return wield(
        UR5.motion(sinusoids(samples / 100.0, 100.0, 3.0)), hammer().parameters
    )


def balanced(g: float, alpha: float) -> Measurements:
    """Gravity along, and angular acceleration about, each axis either way: 36 samples
    at rest."""
    axes = np.vstack((np.eye(3), -np.eye(3)))
    pairs = np.array([(a, b) for a, b in product(g * axes, alpha * axes)])
    zero = np.zeros((len(pairs), 3))
    return Measurements(
        np.arange(len(pairs), dtype=float),
        pairs[:, 0],
        zero,
        zero,
        pairs[:, 1],
        zero,
        zero,
    )


def newton_euler(
    parameters: np.ndarray, accelerations: np.ndarray, z: Measurements
) -> np.ndarray:
    """Wrench (K, 6) by Newton's and Euler's equations about the sensor, without the
    regressors."""
    m, h, J = parameters[0], parameters[1:4], vector_to_tensor(parameters[4:])
    d = accelerations[:, :3] - z.gravity
    alpha = accelerations[:, 3:]
    w = z.angular_velocity
    force = m * d + np.cross(alpha, h) + np.cross(w, np.cross(w, h))
    return np.hstack((force, np.cross(h, d) + alpha @ J + np.cross(w, w @ J)))


# the bound


@pytest.mark.parametrize("noisy", [False, True], ids=["motion known", "motion noisy"])
def test_the_bound_of_a_balanced_motion_is_that_of_its_closed_form(noisy):
    """All cross terms cancel. Of a ball about the sensor the motion's noise is more
    noise in force and torque."""
    g, alpha, m, j = 9.81, 7.0, 0.8, 0.002
    z = balanced(g, alpha)
    ball = InertialParameters.from_com(m, (0.0, 0.0, 0.0), j * np.eye(3))
    force, torque = WRENCH[0], WRENCH[3]
    if noisy:
        force, torque = force + m**2 * MOTION[0], torque + j**2 * MOTION[3]
    K = len(z)
    mass = force / (K * g**2)
    moment = 1.0 / (2.0 * K / 3.0 * (g**2 / torque + alpha**2 / force))
    square = 3.0 * torque / (K * alpha**2)
    wanted = np.diag(
        [mass, *[moment] * 3, *(square * np.array((1.0, 0.5, 0.5, 1.0, 0.5, 1.0)))]
    )
    found = bound(z, ball, WRENCH, MOTION if noisy else None)
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-12 * wanted.max())


def test_weighted_least_squares_reaches_the_bound_where_the_motion_is_known():
    """It is efficient: over 2,000 recordings each standard deviation is the bound's to
    1/sqrt(4,000), 1.6 %; four of these are allowed. In no direction do variances differ
    by 25 %: chance makes 14 % (Marchenko and Pastur)."""
    runs, body = 2000, hammer().parameters
    estimator = OLS(noise=Noise(NOISE.force, NOISE.torque), intervals=False)
    wrench = Noise(NOISE.force, NOISE.torque)
    found = np.array(
        [
            estimator.fit(exact().with_noise(wrench, (1, i))).parameters.vector
            for i in range(runs)
        ]
    )
    deviations = found - body.vector
    least = bound(exact(), body, WRENCH)
    whitened = np.linalg.solve(np.linalg.cholesky(least), deviations.T)
    np.testing.assert_allclose(
        np.linalg.eigvalsh(whitened @ whitened.T / runs), 1.0, atol=0.25
    )
    np.testing.assert_allclose(
        deviations.std(axis=0), np.sqrt(least.diagonal()), rtol=0.064
    )
    scale = Scale(body, SIDES, POSE)
    errors, drawn = scale.errors(deviations), scale.drawn_errors(least, 20_000)
    # of one number a mean error is known to 0.76/sqrt(2,000), 1.7 %, and a median to
    # 2.6 %: four and three of those
    np.testing.assert_allclose(errors.mean(axis=0), scale.mean_errors(least), rtol=0.07)
    np.testing.assert_allclose(
        np.median(errors, axis=0), np.median(drawn, axis=0), rtol=0.08
    )


def test_with_noisy_motion_it_is_the_bound_of_a_problem_with_all_accelerations_unknown():
    """Fisher information of the ten parameters and 6 K accelerations together, by
    central differences of Newton-Euler equations; S_k may differ from sample to
    sample."""
    z, body = exact()[::10], hammer().parameters
    K, step = len(z), 1e-5
    motion = MOTION * np.linspace(0.3, 3.0, K)[:, None]
    accelerations = np.hstack((z.linear_acceleration, z.angular_acceleration))
    np.testing.assert_allclose(
        newton_euler(body.vector, accelerations, z), z.wrench, atol=1e-10
    )
    J = np.zeros((12 * K, 10 + 6 * K))
    for i in range(10 + 6 * K):
        change = np.zeros(10 + 6 * K)
        change[i] = step
        ends = (
            newton_euler(
                body.vector + s * change[:10],
                accelerations + s * change[10:].reshape(K, 6),
                z,
            )
            for s in (1.0, -1.0)
        )
        J[: 6 * K, i] = np.subtract(*ends).ravel() / (2.0 * step)
    J[6 * K :, 10:] = np.eye(6 * K)
    J /= np.sqrt(np.concatenate((np.tile(WRENCH, K), motion.ravel())))[:, None]
    wanted = np.linalg.inv(J.T @ J)[:10, :10]
    scale = np.sqrt(np.outer(wanted.diagonal(), wanted.diagonal()))
    found = bound(z, body, WRENCH, motion)
    # differences are good to 1e-9 or so
    np.testing.assert_allclose(found / scale, wanted / scale, atol=1e-6)
    # or nothing is tested
    assert (found.diagonal() > 1.05 * bound(z, body, WRENCH).diagonal()).all()


def test_what_the_motion_leaves_open_has_no_bound():
    still = balanced(9.81, 0.0)
    for z in (still, still[:1], exact()[:1]):
        with pytest.raises(NotIdentifiableError, match="leaves a parameter open"):
            bound(z, hammer().parameters, WRENCH)


# errors


def test_errors_are_those_of_the_metrics():
    """Of mass and inertia exactly, of the COM to first order: deviations of 1e-6 square
    to 1e-12."""
    body, scale = hammer().parameters, Scale(hammer().parameters, SIDES, POSE)
    deviations = 1e-6 * np.random.default_rng(4).normal(size=(20, 10))
    for deviation, errors in zip(deviations, scale.errors(deviations), strict=True):
        e = errors_between(
            InertialParameters(body.vector + deviation), body, SIDES, POSE
        )
        np.testing.assert_allclose(
            errors, (e.mass, e.center_of_mass, e.inertia_at_origin), rtol=1e-4
        )


def test_means_and_medians_of_errors():
    """40,000 draws: means within 1.6 %, four of the 0.4 % that one number's is known
    to; the median of the mass is that of a half-normal number, 0.6745 standard
    deviations, to 2 %, four of 0.6 %."""
    scale = Scale(hammer().parameters, SIDES, POSE)
    covariance = bound(exact(), hammer().parameters, WRENCH)
    drawn = scale.drawn_errors(covariance, 40_000, seed=1)
    np.testing.assert_allclose(
        drawn.mean(axis=0), scale.mean_errors(covariance), rtol=0.016
    )
    std = 100.0 * np.sqrt(covariance[0, 0]) / hammer().parameters.mass
    assert np.median(drawn[:, 0]) == pytest.approx(0.67449 * std, rel=0.02)
    assert scale.mean_errors(covariance)[0] == pytest.approx(
        (2.0 / np.pi) ** 0.5 * std, rel=1e-12
    )


# the command


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the benchmark: exit status, standard output, standard error."""

    def run(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["accuracy", *words])
        status = 0
        try:
            main()
        except SystemExit as stop:
            status = stop.code
        return status, *capsys.readouterr()

    return run


def rows(output: str, title: str) -> dict[tuple[str, str], list[float]]:
    """Numbers under the heading that holds `title`, by the first two columns."""
    block = next(
        block for block in output.split("\n\n") if title in block.splitlines()[0]
    )
    found = {}
    for line in block.splitlines()[2:]:
        key, speed, *numbers = line.rsplit(maxsplit=13 if "bound" in title else 8)
        found[key, speed] = [float(n) for n in numbers]
    return found


def test_the_eight_objects(run):
    """One window of each: in the COM far better than PMD, in the inertia than the
    bound, as the shape tells more; with a cold filter, whose claims are wrong, better
    than PMD."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    status, out, err = run("--objects", "--quick")
    assert status == 0, err
    assert "unbiased estimators without knowledge of the shape" in out
    assert "objects: seed 1 of 1, 1.5 rad/s" in err
    errors = rows(out, "those at the bound")
    assert list(errors) == [
        (motion, "1.5") for motion in ("warm", "smoothed", "smoothed, std", "cold")
    ]
    for (motion, _), numbers in errors.items():
        bayes, pmd, known, noisy = np.array(numbers).reshape(4, 3)
        assert (known < noisy).all()
        assert bayes[1] < 0.4 * pmd[1], motion  # 0.004 to 0.14
        # 0.1 to 0.3 of the bound, but cold
        assert bayes[2] < (pmd if motion == "cold" else 0.6 * known)[2], motion
    held = rows(out, "95 % intervals")
    assert list(held) == list(errors)
    for key, numbers in held.items():
        np.testing.assert_allclose(
            numbers[:3], np.divide(errors[key][:3], errors[key][3:6]), rtol=0.015
        )  # three digits
        # one number, three, six
        assert numbers[3] == pytest.approx(
            np.dot(numbers[4:], (1, 3, 6)) / 10.0, abs=0.1
        )
        # of 80 in eight bodies: 94 to 99
        assert numbers[3] > 80.0 or key[0] == "cold", key


def test_what_bayes_is_told_of_the_motion():
    """Of a filter its standard deviations, and pi times the rate over its bandwidth, in
    samples; of the smoother those too, or weights in their place. PMD has the paper's
    c1, and no weights."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    from benchmarks.accuracy_objects import (
        SETTINGS,
        compared,
        informed,
        least_errors,
        seen,
    )

    from hefting.reproduction.experiment import thing, wielded
    from hefting.reproduction.filtered import OBSERVATIONS, Observed
    from hefting.simulation import WRENCH_NOISE

    subject, true = thing("hammer"), wielded("hammer", 1.5, duration=3.6)
    observed = Observed.of(true, WRENCH_NOISE["moderate"], (1,))
    found = {
        setting: (window, z, motion) for setting, window, z, motion in seen(observed)
    }
    assert list(found) == list(SETTINGS)
    assert found["smoothed"][2] is found["smoothed, std"][2]
    wrong = {}
    for setting, (window, z, motion) in found.items():
        assert len(z) == OBSERVATIONS
        np.testing.assert_array_equal(z.time, true.motion.time[window])
        z = informed(setting, z, motion)
        known = z.motion_noise
        assert (z.weights is not None) == (setting == "smoothed") == (known is None)
        if known is not None:
            assert motion.linear_acceleration_std is not None
            claimed = np.square(
                (motion.linear_acceleration_std, motion.angular_acceleration_std)
            ).mean(axis=1)
            np.testing.assert_allclose(
                np.square((known.linear, known.angular)), claimed, rtol=1e-12
            )
            assert known.memory == pytest.approx(np.pi / motion.bandwidth)
        wrong[setting] = np.std(
            z.angular_acceleration - true.measurements[window].angular_acceleration
        )
        pmd = compared(
            subject,
            Bayes(subject.shape),
            z,
            least_errors(subject, true.measurements[window], motion),
        ).pmd
        wanted = subject.errors(
            PMD(subject.shape, c1=300.0).fit(replace(z, weights=None))
        )
        np.testing.assert_allclose(
            pmd, (wanted.mass, wanted.center_of_mass, wanted.inertia_at_origin)
        )
    assert wrong["smoothed"] < 0.5 * wrong["warm"] < 0.5 * wrong["cold"]  # 0.1 and 0.2


def test_which_intervals_hold():
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    from benchmarks.accuracy_objects import compared

    from hefting.reproduction.experiment import thing, wielded

    subject = thing("hammer")
    body, none = subject.held.parameters, np.zeros(3)
    z = wielded("hammer", 1.5, duration=3.6).measurements[:150]
    ends = {
        name: np.stack((getattr(body, name) - 1.0, getattr(body, name) + 1.0))
        for name in ("mass", "center_of_mass", "inertia_at_origin", "inertia_at_com")
    }
    ends["mass"] -= 2.0
    ends["center_of_mass"][0, 2] += 2.0
    ends["inertia_at_origin"][:, 1, 2] += 2.0
    ends["inertia_at_origin"][:, 2, 1] += 2.0
    estimate = Estimate("Bayes", body, 150, intervals=ends)
    found = compared(subject, SimpleNamespace(fit=lambda _: estimate), z, (none, none))  # type: ignore[arg-type]
    assert found.held.tolist() == [
        False,
        True,
        True,
        False,
        True,
        True,
        True,
        True,
        False,
        True,
    ]
    assert not found.errors.any()


def test_without_the_recordings_there_are_no_tools(run, tmp_path, monkeypatch):
    monkeypatch.setenv("HEFTING_DATA", str(tmp_path))
    status, out, err = run("--tools")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "HEFTING_DATA" in err


@needs_recordings
def test_the_twelve_tools(run):
    """With one seed Bayes' median COM and inertia are below 0.6 of PMD's in every cell
    (0.1 to 0.35 with ten)."""
    status, out, err = run("--tools", "--quick")
    assert status == 0, err
    lines = out.split("All tools: Bayes' errors")[1].splitlines()[2:8]
    assert [line.split()[:2] for line in lines] == [
        [n, k] for k in ("150", "1,000") for n in ("low", "moderate", "high")
    ]
    for line in lines:
        assert all(0.0 < float(ratio) < 0.6 for ratio in line.split()[3:5]), line
    assert "machinist-hammer, file, electronic-caliper, vise-clamp" in out
    assert "HPS" in out
