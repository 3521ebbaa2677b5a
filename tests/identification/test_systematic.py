"""Errors that all samples share, of a subtracted tool and of gravity's direction:
Bayes' intervals hold them."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import Gravity
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, MotionNoise, Noise
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import full_regressor
from hefting.core.spatial import Array
from hefting.estimators import Bayes
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.identification import identify
from hefting.ingest import sign_and_bias as module
from hefting.ingest.ingest import ingest
from hefting.ingest.tool import UNDETERMINED_TOOL_INERTIA
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate, wield
from hefting.simulation.arm import SensorMotion

pytestmark = pytest.mark.usefixtures("same_recordings")

SENSOR = Noise(0.1, 0.005)
GRAVITY = np.array((0.0, 0.0, -9.80665))
SEEDS = 30
TILTED = Gravity((0.0, 0.0, -9.80665), direction="estimate")
"""Gravity of known size, whose direction is to be found."""
FEWEST = 24
"""Of 30 intervals of 95 % that hold the truth: fewer are a matter of 0.06 % for each
quantity, eight in all."""
SCATTER = (0.62, 1.41)
"""Root mean square of 30 errors in standard deviations: sqrt(chi²(30) / 30) is outside
in 0.1 % on either side."""


@cache
def shape() -> Shape:
    return Shape.from_mesh(hammer().mesh(), points=56)


@cache
def motion(seed: int) -> SensorMotion:
    """Two seconds at 50 Hz."""
    return UR5.motion(random_smooth(2.0, 50.0, 1.5, seed=seed))


def recorded(
    body: InertialParameters, seed: int, gravity: Array = GRAVITY
) -> Recording:
    """Velocities and accelerations are in the log, exact."""
    return simulate(motion(seed), body, gravity, noise=SENSOR, seed=seed, exact=True)


def identified(recording: Recording, **settings: Any) -> Estimate:
    """The hammer, by an exact sensor in a gravity of known size: of systematic errors
    there are only those that a test is about."""
    known = {"gravity": GRAVITY, "sensor_accuracy": "0%"}
    return identify(recording, shape(), **(known | settings)).estimate


def variance(estimate: Estimate) -> Array:
    assert estimate.covariance is not None
    return estimate.covariance.diagonal()


def assert_held(estimates: Iterable[Estimate]) -> None:
    """The intervals of mass and COM hold the hammer as often as they say, and are not
    too wide for their errors."""
    body, errors, held = hammer().parameters, [], []
    truth = np.array((body.mass, *body.center_of_mass))
    for estimate in estimates:
        assert estimate.intervals is not None
        low, high = np.column_stack(
            (estimate.intervals["mass"], estimate.intervals["center_of_mass"])
        )
        held.append((low <= truth) & (truth <= high))
        errors.append(((low + high) / 2.0 - truth) / ((high - low) / 3.92))
    count, scatter = np.sum(held, axis=0), np.sqrt(np.mean(np.square(errors), axis=0))
    print("held", count, "of", len(held), "rms error in deviations", scatter.round(2))
    assert (count >= FEWEST).all(), count
    assert ((scatter > SCATTER[0]) & (scatter < SCATTER[1])).all(), scatter


# the arithmetic


def random_covariance(rng: np.random.Generator, rank: int = 10) -> Array:
    """(10, 10) with units and sizes as different as those of masses and inertias
    are."""
    root = 10.0 ** rng.uniform(-3, 1, 10)[:, None] * rng.normal(size=(10, rank))
    return root @ root.T


@pytest.mark.parametrize("seed", range(5))
def test_blurring_adds_to_the_covariance(seed):
    """(Lambda^-1 + C)^-1 about the same place; as without where C is zero, whatever its
    rank."""
    rng = np.random.default_rng(seed)
    P, at, S = random_covariance(rng), rng.normal(size=10), np.eye(6)
    precision = np.linalg.inv(P)
    before = Likelihood(0.5 * (precision + precision.T), precision @ at, S)
    unit = np.sqrt(P.diagonal())
    for rank in (0, 1, 2, 10):
        C = random_covariance(rng, rank) * rng.uniform(0.1, 10.0)
        after = before.blurred(C)
        np.testing.assert_array_equal(after.precision, after.precision.T)
        found = np.linalg.inv(after.precision)
        scale = np.sqrt((P + C).diagonal())
        # rounding times the condition of P, up to 1e11 or so
        np.testing.assert_allclose(
            (found - P - C) / np.outer(scale, scale), 0.0, atol=1e-3
        )
        np.testing.assert_allclose(
            (np.linalg.solve(after.precision, after.shift) - at) / scale, 0.0, atol=1e-3
        )
        np.testing.assert_array_equal(after.covariance, S)
        if rank == 0:
            np.testing.assert_allclose(
                after.precision * np.outer(unit, unit), precision * np.outer(unit, unit)
            )


@pytest.mark.parametrize("rank", [0, 1, 4, 9])
def test_blurring_what_is_open_leaves_it_open(rank):
    """With Lambda = U D U' of fewer columns than rows: U (D^-1 + U'C U)^-1 U'
    (Woodbury), nothing of nothing."""
    rng = np.random.default_rng(rank)
    U = np.linalg.qr(rng.normal(size=(10, 10)))[0][:, :rank]
    D = np.diag(10.0 ** rng.uniform(-1, 3, rank))
    C, at = random_covariance(rng), rng.normal(size=10)
    after = Likelihood(U @ D @ U.T, U @ D @ U.T @ at, np.eye(6)).blurred(C)
    expected = U @ np.linalg.inv(np.linalg.inv(D) + U.T @ C @ U) @ U.T
    size = np.abs(expected).max() if rank else 1.0
    np.testing.assert_allclose(after.precision / size, expected / size, atol=1e-9)
    np.testing.assert_allclose(after.shift / size, expected @ at / size, atol=1e-8)


@cache
def samples() -> Measurements:
    motion = UR5.motion(random_smooth(4.0, 100.0, 1.5, seed=1))
    return wield(motion, hammer().parameters).with_noise(NOISE_LEVELS["low"], 1)


def test_a_posterior_holds_a_systematic_error():
    """Where the samples know the rest well, its covariance is theirs and that of the
    error."""
    C = np.diag(np.repeat((5.6e-7, 5.6e-9, 0.0), (1, 3, 6)))
    C[0, 1] = C[1, 0] = 4.5e-8
    estimator = Bayes(shape(), noise=NOISE_LEVELS["low"])
    state = estimator.update(estimator.start(), samples())
    alone = estimator.posterior(state).mixture
    beside = replace(estimator, systematic=C).posterior(state).mixture
    scale = np.sqrt((alone.covariance + C).diagonal())[:4]
    # the prior knows a tenth of it at most
    sums = (beside.covariance - alone.covariance - C)[:4, :4] / np.outer(scale, scale)
    np.testing.assert_allclose(sums, 0.0, atol=0.1)
    assert scale[0] > 3.0 * np.sqrt(alone.covariance[0, 0])
    off = (beside.mean - alone.mean)[:4] / scale
    assert np.abs(off).max() < 0.5  # the shape has more to say
    none = replace(estimator, systematic=np.zeros((10, 10))).posterior(state).mixture
    np.testing.assert_allclose(
        none.covariance / np.outer(scale[0], scale[0]), alone.covariance / scale[0] ** 2
    )
    with pytest.raises(InputError, match="systematic error's covariance is"):
        Bayes(shape(), systematic=np.eye(6))
    with pytest.raises(InputError, match="systematic error's covariance is"):
        Bayes(shape(), systematic=np.diag(np.full(10, np.inf)))


@pytest.mark.parametrize(("told", "rel"), [(False, 0.05), (True, 0.15)])
def test_it_is_neither_colour_nor_disagreement(told, rel):
    """All stretches share it: it makes no difference to what residuals say of
    themselves. Where errors of the accelerations are told these are judged at the
    posterior, which the shape's prior then moves a little."""
    C = np.diag(np.repeat((1e-2, 1e-4, 1e-6), (1, 3, 6)))
    z = samples()
    if not told:
        z = replace(z, motion_noise=MotionNoise(0.0, 0.0))
    found = [Bayes(shape(), systematic=each).fit(z).provenance for each in (None, C)]
    assert ("motion_noise" in found[0]) is told
    for name in ("autocorrelation", "disagreement"):
        assert found[1][name] == pytest.approx(found[0][name], rel=rel), name


@pytest.mark.parametrize("gain", [1.0, 1.004, 1.01])
def test_nor_is_the_gain_that_a_scale_shows(gain):
    """A gain within the sensor's accuracy, and what a scale showed of the object: it is
    all the reading's, and says nothing of the residuals."""
    z, mass = samples(), hammer().parameters.mass
    z = replace(z, force=gain * z.force, torque=gain * z.torque)
    alone, weighed = (
        Bayes(shape(), mass=each, sensor_accuracy="1%").fit(z)
        for each in (None, (mass, 0.001))
    )
    assert not weighed.warnings
    for name in ("autocorrelation", "disagreement"):
        before = alone.provenance[name]
        assert weighed.provenance[name] == pytest.approx(before, rel=0.15), name
    low, high = weighed.intervals["mass"]
    assert low < mass < high
    assert high - low < 0.4 * np.ptp(alone.intervals["mass"])


# a tool


GRIPPER = InertialParameters.from_com(
    0.9, (0.0, 0.005, 0.05), np.diag((2e-3, 2.5e-3, 1.5e-3))
)
BOTH = InertialParameters(GRIPPER.vector + hammer().parameters.vector)
TOOL_STD = np.repeat((0.005, 2e-4, 1e-4), (1, 3, 6))


def tool_drawn(seed: int, open_inertia: bool = False) -> Estimate:
    """As if found from a recording of the bare gripper: its parameters off by as much
    as its covariance says."""
    rng = np.random.default_rng([5, seed])
    root = TOOL_STD[:, None] * np.linalg.cholesky(0.7 * np.eye(10) + 0.3)
    covariance = root @ root.T
    vector = GRIPPER.vector + root @ rng.normal(size=10)
    if open_inertia:
        covariance[4:], covariance[:, 4:] = 0.0, 0.0
        covariance[range(4, 10), range(4, 10)] = np.inf
        vector[4:] = 0.0
    return Estimate("OLS", InertialParameters(vector), 1000, covariance=covariance)


def test_a_tool_widens_the_intervals():
    recording, tool = recorded(BOTH, 1), tool_drawn(1)
    sure = replace(tool, covariance=np.zeros((10, 10)))
    one, other = (identified(recording, tool=each) for each in (sure, tool))
    assert one.intervals is not None
    assert other.intervals is not None
    for name in ("mass", "center_of_mass"):
        assert (
            np.ptp(other.intervals[name], axis=0)
            > 2.0 * np.ptp(one.intervals[name], axis=0)
        ).all()
    # what the tool adds to mass and first moment, of which the shape may know a third
    sums = variance(one)[:4] + TOOL_STD[:4] ** 2
    assert (
        (0.6 * sums < variance(other)[:4]) & (variance(other)[:4] < 1.05 * sums)
    ).all()
    without = identified(recording, tool=replace(tool, covariance=None))
    # not known: left out, with a warning
    np.testing.assert_allclose(variance(without), variance(one))
    assert any("has no standard deviations" in line for line in without.warnings)
    assert ingest(recording, tool=sure).systematic is None


@pytest.mark.usefixtures("nothing_looked_for")
def test_intervals_hold_the_object_beside_a_tool():
    """Over 30 recordings and tools: mass and COM, of which the tool's error is by far
    the largest."""
    assert_held(
        identified(recorded(BOTH, seed), tool=tool_drawn(seed), bias="none")
        for seed in range(SEEDS)
    )


def test_a_tool_whose_inertia_is_open():
    """As from static poses: mass and COM as ever, the inertia from the shape; a finite
    covariance goes in."""
    recording, tool = recorded(BOTH, 2), tool_drawn(2, open_inertia=True)
    systematic = ingest(recording, tool=tool).systematic
    assert systematic is not None
    np.testing.assert_allclose(systematic[:4, :4], tool.covariance[:4, :4], rtol=1e-12)  # type: ignore[index]
    np.testing.assert_allclose(
        systematic[4:, 4:],
        np.eye(6) * (UNDETERMINED_TOOL_INERTIA * tool.parameters.mass) ** 2,
    )
    estimate = identified(recording, tool=tool)
    known = identified(recording, tool=tool_drawn(2))
    assert np.isfinite(variance(estimate)).all()
    assert estimate.physically_consistent
    truth = hammer().parameters
    assert estimate.parameters.mass == pytest.approx(truth.mass, abs=4.0 * TOOL_STD[0])
    assert (variance(estimate)[4:] > 4.0 * variance(known)[4:]).any()
    assert estimate.intervals is not None
    low, high = estimate.intervals["inertia_at_com"]
    assert ((low <= truth.inertia_at_com) & (truth.inertia_at_com <= high)).all()
    # what the shape alone would say of the same mass
    assert (
        np.ptp(estimate.intervals["inertia_at_com"], axis=0)[0, 0]
        > 0.2 * truth.inertia_at_com[0, 0]
    )


# gravity


def tilted(seed: int) -> Array:
    """Gravity on a base that is tilted by a few degrees."""
    rng = np.random.default_rng([6, seed])
    return Rotation.from_rotvec(
        np.radians(3.0) * np.append(rng.normal(size=2), 0.0)
    ).apply(GRAVITY)


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_what_gravity_s_direction_does_to_the_parameters(bias):
    """Against a turn of the gravity in each sample itself, and least squares by another
    solver."""
    recording = recorded(hammer().parameters, 3, tilted(3))
    prepared = ingest(recording, gravity="estimate", bias=bias)
    z, found = prepared.measurements, prepared.conditioned
    orientation = recording["orientation"]
    R = Slerp(orientation.time, Rotation.from_quat(orientation.values))(z.time)
    W = np.repeat((1.0 / prepared.fit.noise.force, 1.0 / prepared.fit.noise.torque), 3)

    def fitted(turn: Rotation) -> Array:
        turned = replace(
            z, gravity=R.inv().apply(turn.apply(np.array(found.gravity))), weights=None
        )
        A, b = full_regressor(turned), turned.wrench
        if bias == "estimate":
            A, b = A - A.mean(axis=0), b - b.mean(axis=0)
        rows, right = (W[:, None] * A).reshape(-1, 10), (W * b).ravel()
        return np.array(np.linalg.lstsq(rows, right, rcond=None)[0], dtype=float)

    down = np.array(found.gravity) / np.linalg.norm(found.gravity)
    one = np.cross(down, (0.6, 0.8, 0.0)) / np.linalg.norm(
        np.cross(down, (0.6, 0.8, 0.0))
    )
    step, changes = 1e-4, []
    for axis in (one, np.cross(down, one)):
        changes.append(
            (
                fitted(Rotation.from_rotvec(step * axis))
                - fitted(Rotation.from_rotvec(-step * axis))
            )
            / step
        )
    expected = found.tilt_std**2 / 4.0 * np.array(changes).T @ np.array(changes)  # type: ignore[operator]
    # some percent: a turn to one side only, and noise levels found anew; beside the
    # mass's own spread hardly any
    scale = np.sqrt(expected.diagonal() + 0.1 * prepared.fit.covariance.diagonal()[:10])
    assert prepared.systematic is not None
    np.testing.assert_allclose(
        prepared.systematic / np.outer(scale, scale),
        expected / np.outer(scale, scale),
        atol=0.05,
    )
    assert (
        np.linalg.matrix_rank(prepared.systematic / np.outer(scale, scale), 1e-9) == 2
    )
    assert ingest(recording, gravity=found.gravity, bias=bias).systematic is None


def test_a_recording_that_had_to_be_put_right_is_no_different(monkeypatch):
    """A wrench that is late, with spikes: gravity does to mass, COM and Jxx what it
    does without. How the wrench is late is another error that samples share."""
    monkeypatch.setattr(module, "response_of", lambda *_: None)
    clean = recorded(hammer().parameters, 8, tilted(8))
    wrench, spikes = clean["wrench"], np.zeros((100, 6))
    spikes[[11, 30, 52, 77], :3] = (30.0, -30.0, 30.0)
    late = Stream(wrench.time + 0.03, wrench.values + spikes)
    spoiled = replace(clean, streams={**clean.streams, "wrench": late})
    effects = []
    for recording in (clean, spoiled):
        prepared = ingest(recording, gravity="estimate", bias="none")
        assert prepared.systematic is not None
        assert prepared.conditioned.tilt_std is not None
        effects.append(
            np.sqrt(prepared.systematic.diagonal()) / prepared.conditioned.tilt_std
        )
    assert len(prepared.measurements) < 100
    # some samples less
    np.testing.assert_allclose(effects[1][:5], effects[0][:5], rtol=0.15)


def test_a_gravity_that_was_found_widens_the_intervals():
    recording = recorded(hammer().parameters, 4, tilted(4))
    prepared = ingest(recording, gravity="estimate", bias="none")
    assert prepared.systematic is not None
    found = identified(recording, gravity=TILTED, bias="none")
    given = identified(recording, gravity=prepared.conditioned.gravity, bias="none")
    assert found.intervals is not None
    assert given.intervals is not None
    np.testing.assert_array_equal(
        found.provenance["gravity"], given.provenance["gravity"]
    )
    wider = np.ptp(found.intervals["center_of_mass"], axis=0) / np.ptp(
        given.intervals["center_of_mass"], axis=0
    )
    assert wider.max() > 2.0
    # where gravity's error moves the COM most: its spread is added, of which the shape
    # may know a third
    worst = int(np.argmax(prepared.systematic.diagonal()[1:4])) + 1
    sums = variance(given)[worst] + prepared.systematic[worst, worst]
    assert 0.6 * sums < variance(found)[worst] < 1.05 * sums


def test_both_add_up():
    recording, tool = recorded(BOTH, 5, tilted(5)), tool_drawn(5)
    beside = ingest(recording, bias="none", tool=tool).systematic
    tilt = ingest(recording, bias="none", gravity="estimate").systematic
    both = ingest(recording, bias="none", tool=tool, gravity="estimate").systematic
    assert beside is not None
    assert tilt is not None
    assert both is not None
    np.testing.assert_allclose(both, beside + tilt, rtol=1e-9)


@pytest.mark.usefixtures("nothing_looked_for")
def test_intervals_hold_the_object_on_a_tilted_base():
    """Over 30 recordings: the COM, whose error across is up to five times that with
    gravity known; and the mass."""
    truth = hammer().parameters
    assert_held(
        identified(recorded(truth, seed, tilted(seed)), gravity=TILTED, bias="none")
        for seed in range(SEEDS)
    )
