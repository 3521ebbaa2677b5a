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
PROJECTIONS = 3
"""Products of a larger array with random vectors that are kept beside its norm."""
DIGITS = 9
"""Significant digits that are kept."""
PARAMETERS = {"mass": slice(0, 1), "first": slice(1, 4), "inertia": slice(4, 10)}
"""Parts of the ten parameters: each has a size of its own."""
FACTORS = {"factor", "factors", "open_factor", "directions", "spread"}
"""Names of factors of matrices, which are unique but for signs and rotations."""
WORD = re.compile(r"[\w-]{1,30}")
"""Text that names something, and is no sentence."""

Values = dict[str, list[float]]
"""Numbers by name."""


def summary(result: Any, *, omit: tuple[str, ...] = ()) -> Values:
    """Numbers of a result.

    Parameters
    ----------
    result
        Numbers, arrays, and dataclasses, mappings, lists and tuples of them. Names and
        messages' codes stand in the names of the numbers; what is none of these is left out.
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
        yield f"{name}={value.severity}:{value.code}", [1.0]
    elif isinstance(value, str):
        if WORD.fullmatch(value):
            yield f"{name}={value}", [1.0]
    elif isinstance(value, bool | int | float | np.number | np.bool_):
        yield name, [float(value)]
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "biuf":
            array = _without_signs(name.rpartition(".")[2], value.astype(float))
            yield from _of_array(name, array)
    elif isinstance(value, Shape):
        yield name, [1.0]
    elif is_dataclass(value):
        for field in fields(value):
            if field.name not in omit and not field.name.startswith("_"):
                yield from _parts(
                    _joined(name, field.name), getattr(value, field.name), omit
                )
    elif isinstance(value, Mapping):
        for key, each in value.items():
            if key not in omit:
                yield from _parts(_joined(name, str(key)), each, omit)
    elif isinstance(value, list | tuple):
        yield f"{name}#", [float(len(value))]
        for number, each in enumerate(value):
            yield from _parts(_joined(name, str(number)), each, omit)


def _joined(first: str, second: str) -> str:
    return f"{first}.{second}" if first else second


def _without_signs(name: str, array: Array) -> Array:
    """What is the same whichever factor of it a library finds: R'R of upper triangular
    factors, F F' of others."""
    if name not in FACTORS or array.ndim < 2:
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
        yield f"{name} std", std.tolist()
        known = np.isfinite(std) & (std > 0.0)
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
    return bool(np.allclose(array, array.T, rtol=1e-6, atol=0.0))


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
