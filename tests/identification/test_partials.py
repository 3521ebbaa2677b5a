"""Parts: recordings that were condensed where they lie give the estimate of all their
samples together."""

import pickle
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from disturbances import NOISE, body
from hefting import InputError, calibrate, identify
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_regressor
from hefting.estimators import METHODS, OLS
from hefting.identification.contradictions import FEW
from hefting.identification.identify import Identification, identify_understood
from hefting.identification.partials import (
    condense,
    identify_parts,
    part_of,
    what_others_tell,
)
from hefting.identification.run import understand
from hefting.ingest.ingest import ingest
from hefting.ingest.joint import JointIngested
from hefting.shapes import Shape
from hefting.simulation import UR5, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_recordings")

SAME = 1e-9
"""Relative difference: sums in another order, of factors of condition up to 1e5."""
WAYS = [
    (name, shaped)
    for name, kind in METHODS.items()
    for shaped in (True, False)
    if kind.needs == "nothing" or (shaped and kind.needs != "labelled parts")
]
"""Methods that need no labelled parts, with a shape and, where they do, without."""


@cache
def recording(seed: int, duration: float = 4.0, noise: float | None = None):
    """At 100 Hz, with a bias, a clock offset, a sign and a noise level of its own."""
    rng = np.random.default_rng([18, seed])
    motion = UR5.motion(random_smooth(duration, 100.0, 1.2, seed=seed))
    factor = rng.uniform(0.5, 3.0) if noise is None else noise
    levels = replace(NOISE, force=factor * NOISE.force, torque=factor * NOISE.torque)
    log = simulate(
        motion, body(1.347), noise=levels, pose_noise=(1e-4, 3.5e-4), seed=seed
    )
    wrench = log["wrench"]
    bias = rng.uniform(-1.0, 1.0, 6) * np.repeat((20.0, 1.0), 3)
    wrench = replace(
        wrench,
        values=(-1.0) ** seed * (wrench.values + bias),
        time=wrench.time + 0.005 * (seed % 3),
    )
    streams = {**log.streams, "wrench": wrench}
    return replace(log, streams=streams, source=f"run{seed}.csv")


@cache
def shape() -> Shape:
    points = np.random.default_rng(3).uniform(-0.08, 0.08, (80, 3))
    return Shape(body(1.0).center_of_mass + points)


@cache
def understood(count: int) -> JointIngested:
    """Recordings with all their samples."""
    found = understand([recording(i) for i in range(count)])
    assert isinstance(found, JointIngested)
    return found


@cache
def alone_of(seed: int):
    """A recording as another machine would read it."""
    return ingest(recording(seed))


@cache
def read_alone(count: int):
    """Each, as another machine would read it, and read again as the others tell."""
    alone = [alone_of(i) for i in range(count)]
    again = what_others_tell([part_of(found) for found in alone])
    return [
        ingest(recording(i), **how) if how else found
        for i, (found, how) in enumerate(zip(alone, again, strict=True))
    ]


def assert_same(one: Identification, other: Identification) -> None:
    """All that is told of the object and its recordings."""
    a, b = one.estimate, other.estimate
    pairs = [
        (a.parameters.vector, b.parameters.vector),
        (a.parameters.inertia_at_com, b.parameters.inertia_at_com),
        (a.covariance, b.covariance),
        (a.bias, b.bias),
        (a.residual, b.residual),
        *((a.intervals[name], b.intervals[name]) for name in a.intervals or {}),
    ]
    for first, second in pairs:
        assert (first is None) == (second is None)
        if first is not None:
            first, second = np.asarray(first), np.asarray(second)
            size = np.abs(first[np.isfinite(first)]).max(initial=0.0)
            np.testing.assert_allclose(second, first, rtol=SAME, atol=SAME * size)
    assert (a.samples, a.duration, a.verdict) == (b.samples, b.duration, b.verdict)
    assert [str(m) for m in a.warnings] == [str(m) for m in b.warnings]
    keys = ("recordings", "notes", "log", "wrench", "motion", "outliers", "method")
    for key in keys:
        told = [found.provenance.get(key) for found in (a, b)]
        assert str(told[0]) == str(told[1]), key


@pytest.mark.parametrize(
    ("count", "method", "shaped"),
    [(2, "Bayes", True), (2, "OLS", False), *((5, *way) for way in WAYS)],
)
def test_parts_tell_what_the_recordings_tell(count, method, shaped):
    known = shape() if shaped else None
    whole = identify_understood(understood(count), known, method, {})
    parts = [part_of(found, known, method) for found in read_alone(count)]
    parts = pickle.loads(pickle.dumps(parts))
    assert not any(len(part.measurements) for part in parts)
    assert_same(whole, identify_parts(parts, known, method=method))


def test_parts_of_more_recordings_than_are_compared_one_by_one():
    count = FEW + 1
    whole = identify_understood(understood(count), None, "OLS", {})
    parts = [part_of(found, None, "OLS") for found in read_alone(count)]
    assert_same(whole, identify_parts(parts, None, method="OLS"))


def test_the_two_ways_as_they_are_called():
    logs = [recording(i) for i in range(3)]
    settings = {"method": "OLS-blended", "sensor_accuracy": "1%"}
    whole = identify(logs, **settings, gravity=(0.0, 0.0, -9.81))
    how = {"method": "OLS-blended", "hyperparameters": {"sensor_accuracy": "1%"}}
    parts = [condense(log, **how, gravity=(0.0, 0.0, -9.81)) for log in logs]
    assert what_others_tell(parts) == [{}, {}, {}]
    assert_same(whole, identify_parts(parts, **how))


def test_a_labelled_shape_and_an_estimator_of_ones_own():
    labels = np.digitize(shape().positions[:, 2], (0.06, 0.1))
    known = Shape(shape().positions, labels=labels)
    logs = [recording(i) for i in range(2)]
    parts = [condense(log, known, method="HPS") for log in logs]
    whole = identify(logs, known, method="HPS")
    assert_same(whole, identify_parts(parts, known, method="HPS"))
    own = OLS("estimate", intervals=False)
    parts = [condense(log, method=own) for log in logs]
    assert_same(identify(logs, method=own), identify_parts(parts, method=own))


def test_a_tool_is_subtracted_from_each_part():
    tool = calibrate(recording(30))
    logs = [recording(1), recording(2)]
    light = [replace_mass(log) for log in logs]
    parts = [condense(log, tool=tool) for log in light]
    assert_same(identify(light, tool=tool), identify_parts(parts))


def replace_mass(log):
    """Twice the wrench: an object as heavy as the tool."""
    wrench = log["wrench"]
    doubled = replace(wrench, values=2.0 * wrench.values)
    return replace(log, streams={**log.streams, "wrench": doubled})


def test_one_part_is_its_recording():
    parts = [condense(recording(1))]
    assert_same(identify(recording(1)), identify_parts(parts))


def test_least_squares_is_that_of_all_rows_with_a_bias_of_each_recording():
    """Against dense least squares over the rows of all recordings, their weights
    included, with six columns for the bias of each."""
    count = 5
    parts = [part_of(found, method="OLS") for found in read_alone(count)]
    found = identify_parts(parts, method="OLS").estimate
    together = understood(count)
    level = together.fit.noise
    std = np.repeat((level.force, level.torque), 3)
    blocks, right = [], []
    for i, part in enumerate(together.parts):
        z: Measurements = part.measurements
        scale = np.sqrt(z.weights)[:, None] / std
        rows = full_regressor(replace(z, weights=None)) * scale[:, :, None]
        biases = np.zeros((len(z), 6, 6 * count))
        biases[:, :, 6 * i : 6 * i + 6] = scale[:, :, None] * np.eye(6)
        blocks.append(np.concatenate((rows, biases), axis=2).reshape(6 * len(z), -1))
        right.append((z.wrench * scale).ravel())
    A, b = np.concatenate(blocks), np.concatenate(right)
    lengths = np.linalg.norm(A, axis=0)
    x = np.linalg.lstsq(A / lengths, b, rcond=None)[0] / lengths
    np.testing.assert_allclose(found.parameters.vector, x[:10], rtol=SAME, atol=1e-11)
    np.testing.assert_allclose(found.bias.ravel(), x[10:], rtol=SAME, atol=SAME)


def test_a_part_is_small_however_long_its_recording():
    """Its time scales grow by one with twice the length: a factor of 4 kB."""
    short, long = (
        len(pickle.dumps(condense(recording(1, duration=seconds), shape())))
        for seconds in (10.0, 40.0)
    )
    assert short < 200_000
    assert long - short < 3 * 5_000


def test_what_one_tells_of_the_others():
    """A bias that one shows is one that all may have."""
    plain = recording(2)
    wrench = plain["wrench"]
    values = wrench.values - np.array(identify(plain).estimate.bias)
    unbiased = {**plain.streams, "wrench": replace(wrench, values=values)}
    logs = [recording(4), replace(plain, streams=unbiased)]
    parts = [condense(log) for log in logs]
    again = what_others_tell(parts)
    assert again == [{}, {"bias": "estimate"}]
    parts[1] = condense(logs[1], **again[1])
    assert_same(identify(logs), identify_parts(parts))


# what is refused


@dataclass(frozen=True, eq=False)
class Halved(OLS):
    """Takes samples in a way of its own."""

    def update(self, state, measurements):
        return super().update(state, measurements[::2])


def test_what_parts_cannot_do_is_refused():
    with pytest.raises(InputError, match=r"until.*needs the samples in order"):
        condense(recording(1), hyperparameters={"until": "mass=1%"})
    with pytest.raises(InputError, match="an `update` of its own"):
        condense(recording(1), method=Halved("estimate"))
    with pytest.raises(InputError, match="no recording is given"):
        identify_parts([])
    parts = [condense(recording(i), method="OLS") for i in (1, 2)]
    with pytest.raises(InputError, match="condensed for another method than PMD"):
        identify_parts(parts, shape(), method="PMD")
    with pytest.raises(InputError, match=r"until.*needs the samples in order"):
        identify_parts(parts, hyperparameters={"until": "mass=1%"})


def test_a_method_with_an_update_of_its_own_still_sees_samples():
    logs = [recording(1), recording(2)]
    half, whole = (
        identify(logs, method=kind("estimate")).estimate for kind in (Halved, OLS)
    )
    assert half.mass != whole.mass
    assert half.mass == pytest.approx(whole.mass, rel=0.01)
