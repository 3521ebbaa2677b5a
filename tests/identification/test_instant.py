"""The estimate up to an instant: that of the samples before it by themselves, and at the
end that of `hefting.identify`."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import NotIdentifiableError
from hefting.core.spatial import skew
from hefting.estimators import METHODS, method_named
from hefting.identification import identify
from hefting.identification.convergence import estimate_until
from hefting.identification.estimator import estimator_for
from hefting.ingest.ingest import ingest
from viewing import recorded, shape

pytestmark = pytest.mark.usefixtures("same_recordings")

SAME = 1e-9
"""Of the largest value: the samples are folded in the same order, so what differs is
rounding."""
INSTANTS = (0.4, 1.7, 5.0)
NAMES = [name for name, kind in METHODS.items() if kind.needs != "labelled parts"]


@pytest.fixture(scope="module")
def found():
    return ingest(recorded())


@pytest.fixture(scope="module")
def held():
    return shape()


def made(name, found, held):
    kind, settings = method_named(name)
    return estimator_for(kind, found, held, dict(settings))


def close(one, other):
    one, other = np.asarray(one), np.asarray(other)
    np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))
    known = np.isfinite(one)
    scale = np.abs(one[known]).max(initial=0.0)
    np.testing.assert_allclose(one[known], other[known], rtol=0.0, atol=SAME * scale)


@pytest.mark.parametrize("instant", INSTANTS)
@pytest.mark.parametrize("name", NAMES)
def test_it_is_the_methods_estimate_from_the_samples_up_to_it(
    name, instant, found, held
):
    estimator = made(name, found, held)
    z = found.measurements
    if estimator.depends_on_count:
        z = found.weighted_by_count
    plain = estimator.fit(z[z.time <= instant])
    estimate = estimate_until(found, estimator, held, instant)
    close(estimate.parameters.vector, plain.parameters.vector)
    for key, ends in plain.intervals.items():
        close(estimate.intervals[key], ends)
    if plain.bias is not None:
        close(estimate.bias, plain.bias)
    assert estimate.samples == round(found.counts[z.time <= instant].sum())


@pytest.mark.parametrize("name", NAMES)
def test_at_the_end_it_is_that_of_identify(name, found, held):
    estimate = estimate_until(found, made(name, found, held), held, np.inf)
    whole = identify(recorded(), held, method=name).estimate
    close(estimate.parameters.vector, whole.parameters.vector)
    close(estimate.residual, whole.residual)
    assert estimate.warnings == whole.warnings
    assert estimate.samples == whole.samples


@pytest.mark.parametrize("name", NAMES)
def test_nothing_of_later_samples_is_used(name, found, held):
    """A wrench a hundred times as large after the instant changes nothing."""
    estimator, z = made(name, found, held), found.measurements
    later = z.time > 1.7
    force = np.where(later[:, None], 100.0 * z.force, z.force)
    other = replace(found, measurements=replace(z, force=force))
    one = estimate_until(found, estimator, held, 1.7)
    two = estimate_until(other, estimator, held, 1.7)
    np.testing.assert_array_equal(one.parameters.vector, two.parameters.vector)
    assert one.to_dict() == two.to_dict()


def rows(z):
    """Rows (6 K, 10) of the Newton-Euler equations in the parameters, from their
    textbook form (Atkeson et al. 1986, eq. 7)."""
    blocks = []
    for a, g, w, al in zip(
        z.linear_acceleration,
        z.gravity,
        z.angular_velocity,
        z.angular_acceleration,
        strict=True,
    ):

        def dot(v):  # J v by the six entries xx, xy, xz, yy, yz, zz
            x, y, z = v
            return np.array(
                [[x, y, z, 0, 0, 0], [0, x, 0, y, z, 0], [0, 0, x, 0, y, z]]
            )

        block = np.zeros((6, 10))
        block[:3, 0] = a - g
        block[:3, 1:4] = skew(al) + skew(w) @ skew(w)
        block[3:, 1:4] = -skew(a - g)
        block[3:, 4:] = dot(al) + skew(w) @ dot(w)
        blocks.append(block)
    return np.vstack(blocks)


def test_least_squares_up_to_an_instant_against_numpy(found):
    """OLS with the noise levels and weights that are those of the whole recording."""
    estimator = made("OLS", found, None)
    z = found.measurements[found.measurements.time <= 1.7]
    A, b = rows(z), z.wrench.ravel()
    if estimator.bias == "estimate":
        A = np.hstack((A, np.tile(np.eye(6), (len(z), 1))))
    levels = estimator.noise
    each = np.repeat((levels.force, levels.torque), 3)
    root = np.sqrt(np.ones(len(z)) if z.weights is None else z.weights)
    scale = (root[:, None] / each).ravel()
    expected = np.linalg.lstsq(A * scale[:, None], b * scale, rcond=None)[0][:10]
    vector = estimate_until(found, estimator, None, 1.7).parameters.vector
    # conditions of a few thousand, in doubles
    np.testing.assert_allclose(vector, expected, atol=1e-9 * np.abs(expected).max())


def test_what_is_open_is_what_is_open_then(found):
    """After 0.05 s of motion no inertia is known, at the end it is."""
    estimator = made("OLS", found, None)
    first = estimate_until(found, estimator, None, 0.05)
    assert first.undetermined.inertia_at_com.any()
    assert not estimate_until(found, estimator, None, 5.0).undetermined


def test_before_the_first_sample_there_is_none(found, held):
    with pytest.raises(NotIdentifiableError, match="no samples"):
        estimate_until(found, made("Bayes", found, held), held, -1.0)
