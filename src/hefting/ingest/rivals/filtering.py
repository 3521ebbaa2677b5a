"""Linear filters of evenly sampled signals, by their response to frequencies: SciPy's
take longer to import than all mistakes to be looked for."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hefting.core.spatial import Array

Complex = NDArray[np.complexfloating]

DECAYS = 8.0
"""Length of what is appended, in times in which the response decays by a factor of e:
what is left after it is a part in 3000."""


def filtered(
    values: Array, rate: float, response: Callable[[Complex], Complex], lasting: float
) -> Array:
    """Values (K, n) through a filter.

    Parameters
    ----------
    values : of a signal that was zero before.
    rate : of the samples [Hz].
    response : transfer function of s = 2 pi i f [rad/s].
    lasting : time [s] in which the filter's response decays by a factor of e.
    """
    K = len(values)
    extra = int(min(DECAYS * lasting * rate, 20 * K)) + 2
    size = 1 << (K + extra - 1).bit_length()
    s = 2j * np.pi * np.fft.rfftfreq(size, 1.0 / rate)
    spectrum = np.fft.rfft(values, size, axis=0) * response(s)[:, None]
    return np.fft.irfft(spectrum, size, axis=0)[:K]
