"""Linear filters of evenly sampled signals, by their frequency response. Importing
SciPy's would take longer than searching for all mistakes."""

from collections.abc import Callable
from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from hefting.core.spatial import Array, immutable, interpolated

Complex = NDArray[np.complexfloating]

DECAYS = 8.0
"""Length of the padding, in time constants of the response's decay: a part in 3000
remains after it."""

SHORTEST_LAG = 0.02
"""[s] Lag of a wrench from which on its response matters."""
INSTANTS_PER_LAG, MOST_INSTANTS = 20, 100_000
"""Number of instants at which the wrench is filtered."""
FEWEST_INSTANTS_PER_LAG = 3


Response = Callable[[Complex], Complex]
"""Transfer function of s = 2 pi i f [rad/s]."""


@immutable
class Signal:
    """An evenly sampled signal to filter repeatedly; before it, its first value."""

    values: Array
    """(K, n)"""
    rate: float
    """of the samples [Hz]"""
    _spectra: dict[int, tuple[Complex, Complex]] = field(default_factory=dict)
    """By transform length: s, and the spectrum of the change from the first value."""

    def change_through(self, response: Response, lasting: float) -> Array:
        """(K, n) filtered change from the first value; the response decays by a factor
        e in the time `lasting` [s]."""
        K = len(self.values)
        extra = int(min(DECAYS * lasting * self.rate, 20 * K)) + 2
        size = 1 << (K + extra - 1).bit_length()
        if size not in self._spectra:
            s = 2j * np.pi * np.fft.rfftfreq(size, 1.0 / self.rate)
            change = self.values - self.values[0]
            self._spectra[size] = s, np.fft.rfft(change, size, axis=0)
        s, spectrum = self._spectra[size]
        late = np.fft.irfft(spectrum * response(s)[:, None], size, axis=0)
        return np.asarray(late[:K], dtype=float)


@immutable
class Ahead:
    """Signals through first-order filters, each ahead by the filter's lag in steady
    motion. Before their start they changed steadily, which passes unchanged."""

    grid: Array
    """(n,) [s] even instants"""
    steady: Array
    """(n, m) steady change of the beginning"""
    rest: Signal
    """remainder of the signals, constant beyond the end"""

    @classmethod
    def of(cls, grid: Array, values: Array, longest: float) -> "Ahead":
        """Of values (n, m) at even instants (n,), for constants up to `longest` [s]."""
        step = (grid[-1] - grid[0]) / (len(grid) - 1)
        slope = (values[1] - values[0]) / step
        steady = values[0] + (grid - grid[0])[:, None] * slope
        beyond = int(longest / step) + 2
        rest = np.asarray(values - steady, dtype=float)
        rest = np.concatenate((rest, np.repeat(rest[-1:], beyond, axis=0)))
        return cls(grid, steady, Signal(rest, 1.0 / step))

    def through(self, constant: float) -> Array:
        """(n, m) signals through a filter with a time constant [s]."""
        late = self.rest.change_through(lambda s: 1.0 / (1.0 + constant * s), constant)
        instants = self.grid[0] + np.arange(len(late)) / self.rest.rate
        return self.steady + interpolated(self.grid + constant, instants, late)


def filtered(time: Array, wrench: Array, lag: float) -> Array | None:
    """(K, 6) a wrench through a first-order filter, ahead by the filter's lag in steady
    motion; None if the recording is too long for such a short lag."""
    span = float(time[-1] - time[0])
    step = max(lag / INSTANTS_PER_LAG, span / MOST_INSTANTS)
    if step * FEWEST_INSTANTS_PER_LAG > lag:
        return None
    grid = np.linspace(time[0], time[-1], int(span / step) + 2)
    late = Ahead.of(grid, interpolated(grid, time, wrench), lag).through(lag)
    return interpolated(time, grid, late)
