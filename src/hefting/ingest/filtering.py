"""Linear filters of evenly sampled signals, by their response to frequencies: SciPy's
take longer to import than all mistakes to be looked for."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hefting.core.spatial import Array

Complex = NDArray[np.complexfloating]

DECAYS = 8.0
"""Length of what is appended, in times in which the response decays by a factor of e:
what is left after it is a part in 3000."""


Response = Callable[[Complex], Complex]
"""Transfer function of s = 2 pi i f [rad/s]."""


@dataclass(frozen=True, eq=False)
class Signal:
    """An evenly sampled signal, to go through many filters. Before it began it rested
    at its first value."""

    values: Array
    """(K, n)"""
    rate: float
    """of the samples [Hz]"""
    _spectra: dict[int, tuple[Complex, Complex]] = field(default_factory=dict)
    """By the length of the transform: s, and the spectrum of the change since the first
    value."""

    def change_through(self, response: Response, lasting: float) -> Array:
        """(K, n) its change since the first value through a filter, whose response
        decays by a factor of e in the time `lasting` [s]."""
        K = len(self.values)
        extra = int(min(DECAYS * lasting * self.rate, 20 * K)) + 2
        size = 1 << (K + extra - 1).bit_length()
        if size not in self._spectra:
            s = 2j * np.pi * np.fft.rfftfreq(size, 1.0 / self.rate)
            change = self.values - self.values[0]
            self._spectra[size] = s, np.fft.rfft(change, size, axis=0)
        s, spectrum = self._spectra[size]
        return np.fft.irfft(spectrum * response(s)[:, None], size, axis=0)[:K]
