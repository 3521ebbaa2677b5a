"""Numbers of a result, by name: every field of a dataclass that holds numbers, names or
further results. Of large arrays a few projections are kept."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from hefting.core.messages import Message
from hefting.core.spatial import Array
from hefting.shapes import Shape

LARGEST = 12
"""Numbers up to which an array is kept as it is."""
PROJECTIONS = 1
"""Products of a larger array with random vectors that are kept beside its norm."""
NOTHING = 1e-7
"""Standard deviation, over the largest one, below which there is none but by rounding."""
DIGITS = 8
"""Significant digits that are kept."""
SCALARS = (bool, int, float, np.number, np.bool_)
"""Single numbers."""
SINGLE = "*"
"""Name of the single numbers of a result, each of which has a size of its own."""
PARAMETERS = {"mass": slice(0, 1), "first": slice(1, 4), "inertia": slice(4, 10)}
"""Parts of the ten parameters: each has a size of its own."""
FACTORS = {"factor", "factors", "open_factor", "directions", "spread"}
"""Names of factors of matrices, which are unique but for signs and rotations."""
WORD = re.compile(r"[\w-]{1,30}")
"""Text that names something, and is no sentence."""
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
"""A number in a text."""

Values = dict[str, list[float]]
"""Numbers by name."""


def summary(result: Any, *, omit: tuple[str, ...] = ()) -> Values:
    """Numbers of a result.

    Parameters
    ----------
    result
        Numbers, arrays, and dataclasses, mappings, lists and tuples of them. Names and
        messages' codes stand in the names of the numbers, and of what texts say the
        numbers are kept; what is none of these is left out.
    omit
        Fields that are left out, wherever they are.
    """
    found: Values = {}
    for name, values in _parts("", result, omit):
        if name in found:
            raise ValueError(f"two results are called {name}")
        found[name] = [float(f"{value:.{DIGITS}g}") for value in values]
    return found


def _parts(
    name: str, value: Any, omit: tuple[str, ...]
) -> Iterator[tuple[str, list[float]]]:
    if isinstance(value, Message):
        yield f"{name}={value.severity}:{value.code}", numbers_in(value)
    elif isinstance(value, str):
        if WORD.fullmatch(value):
            yield f"{name}={value}", [1.0]
        elif numbers := numbers_in(value):
            yield name, numbers
    elif isinstance(value, SCALARS):
        yield name, [float(value)]
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "biuf":
            array = _without_signs(name, value.astype(float))
            yield from _of_array(name, array)
    elif isinstance(value, Shape):
        yield name, [1.0]
    elif isinstance(value, list | tuple):
        yield f"{name}#", [float(len(value))]
        each = {str(number): one for number, one in enumerate(value)}
        yield from _of_names(name, each, omit)
    elif is_dataclass(value):
        each = {field.name: getattr(value, field.name) for field in fields(value)}
        public = {key: one for key, one in each.items() if not key.startswith("_")}
        yield from _of_names(name, public, omit)
    elif isinstance(value, Mapping):
        texts = {str(key): one for key, one in value.items()}
        yield from _of_names(name, dict(sorted(texts.items())), omit)


def _of_names(
    name: str, each: Mapping[str, Any], omit: tuple[str, ...]
) -> Iterator[tuple[str, list[float]]]:
    """Single numbers together, and all else by itself."""
    kept = {key: value for key, value in each.items() if key not in omit}
    single = [float(v) for v in kept.values() if isinstance(v, SCALARS)]
    if single:
        yield _joined(name, SINGLE), single
    for key, value in kept.items():
        if not isinstance(value, SCALARS):
            yield from _parts(_joined(name, key), value, omit)


def numbers_in(text: str) -> list[float]:
    """The numbers that a text states, in order."""
    return [float(number) for number in NUMBER.findall(text)]


def _joined(first: str, second: str) -> str:
    return f"{first}.{second}" if first else second


def _without_signs(name: str, array: Array) -> Array:
    """What is the same whichever factor of it a library finds: R'R of upper triangular
    factors, F F' of others."""
    if array.ndim < 2 or not FACTORS.intersection(name.split(".")[-2:]):
        return array
    rows = array if (np.tril(array, -1) == 0.0).all() else np.swapaxes(array, -1, -2)
    return np.swapaxes(rows, -1, -2) @ rows


def _of_array(name: str, array: Array) -> Iterator[tuple[str, list[float]]]:
    """Parts of one size, each by itself."""
    if array.shape == (10,):
        for part, where in PARAMETERS.items():
            yield _joined(name, part), array[where].tolist()
    elif _is_covariance(array):
        std = np.sqrt(array.diagonal())
        short = len(std) <= LARGEST
        yield f"{name} std", std.tolist() if short else projections(std)
        known = np.isfinite(std) & (
            std > NOTHING * np.max(std, where=std < np.inf, initial=0.0)
        )
        inner = array[np.ix_(known, known)] / np.outer(std[known], std[known])
        if inner.size:
            yield f"{name} correlation", projections(inner)
    elif array.size <= LARGEST:
        yield name, array.ravel().tolist()
    else:
        yield f"{name} {'x'.join(map(str, array.shape))}", projections(array)


def _is_covariance(array: Array) -> bool:
    if array.ndim != 2 or array.shape[0] != array.shape[1] or len(array) < 4:
        return False
    if np.isnan(array).any() or not (array.diagonal() >= 0.0).all():
        return False
    known = np.isfinite(array)
    std = np.sqrt(np.where(known, array, 0.0).diagonal())
    apart = np.where(known, array, 0.0) - np.where(known.T, array.T, 0.0)
    alike = np.abs(apart) <= 1e-6 * np.outer(std, std)
    return bool(np.all(alike & (known == known.T)))


def projections(array: Array) -> list[float]:
    """Norm of the numbers that are finite, how many are not, and products with vectors
    of random signs and sizes, of norm one."""
    values = array.ravel()
    known = np.isfinite(values)
    values = np.where(known, values, 0.0)
    along = np.random.default_rng(len(values)).normal(size=(PROJECTIONS, len(values)))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    others = float((~known).sum())
    return [float(np.linalg.norm(values)), others, *(along @ values).tolist()]
