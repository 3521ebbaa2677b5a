"""Filters of evenly sampled signals, against SciPy's systems in continuous time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, lsim

from hefting.ingest.filtering import Signal
from hefting.ingest.rivals.not_rigid import swing
from hefting.ingest.rivals.timing import low_passed

RATE = 200.0
TIME = np.arange(0.0, 6.0, 1.0 / RATE)


def smooth(time):
    """(K, 3) Sines below 2 Hz that begin at zero, slowly."""
    frequencies, phases = np.array((0.5, 1.1, 1.9)), np.array((0.3, 1.0, 2.0))
    sines = np.sin(2.0 * np.pi * frequencies * time[:, None] + phases)
    return (1.0 - np.exp(-(time[:, None] ** 2))) * sines


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("bandwidth", [2.0, 10.0])
def test_a_low_pass_is_a_butterworth_filter(order, bandwidth):
    values = smooth(TIME)
    system = butter(order, 2.0 * np.pi * bandwidth, analog=True)
    found = low_passed(Signal(values, RATE), order, bandwidth)
    for column, expected in zip(found.T, values.T, strict=True):
        _, exact, _ = lsim(system, expected, TIME)
        # SciPy's lines between samples are straight; before the end, at which the
        # signal stops at once, its spectrum is not that of the motion
        np.testing.assert_allclose(column[:-20], exact[:-20], atol=2e-3)


@pytest.mark.parametrize(("frequency", "damping"), [(0.8, 0.3), (3.0, 0.08)])
def test_a_loose_mass_swings_as_its_equation_says(frequency, damping):
    """x'' + 2 z w x' + w² x = s, at rest where the first force holds it."""
    w = 2.0 * np.pi * frequency
    gravity = np.array((0.0, 3.0, -9.0))

    def rate(t, state):
        force = gravity + smooth(np.array([t]))[0]
        place, speed = state[:3], state[3:]
        return np.append(speed, force - 2.0 * damping * w * speed - w**2 * place)

    rest = np.append(gravity / w**2, np.zeros(3))
    exact = solve_ivp(rate, TIME[[0, -1]], rest, t_eval=TIME, rtol=1e-9, atol=1e-12)
    place, acceleration = swing(
        Signal(gravity + smooth(TIME), RATE), frequency, damping
    )
    inner = slice(0, -20)  # after the end the force counts as its first value
    expected = exact.y[:3].T
    scale = np.abs(expected - expected[0]).max()
    np.testing.assert_allclose(place[inner], expected[inner], atol=5e-3 * scale)
    exact_acceleration = np.array(
        [rate(t, state)[3:] for t, state in zip(TIME, exact.y.T, strict=True)]
    )
    scale = np.abs(exact_acceleration).max()
    np.testing.assert_allclose(
        acceleration[inner], exact_acceleration[inner], atol=2e-2 * scale
    )
