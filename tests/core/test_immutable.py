"""What `immutable` makes of a class: a dataclass that is itself alone."""

from dataclasses import fields, replace

import numpy as np

from hefting.core.spatial import immutable


@immutable
class Rows:
    """Of arrays."""

    values: np.ndarray
    name: str = ""


def test_it_compares_by_identity():
    one, other = (Rows(np.zeros(2)) for _ in range(2))
    assert one == one
    assert one != other
    assert len({one, other}) == 2


def test_it_is_a_dataclass():
    one = Rows(np.zeros(2))
    assert [field.name for field in fields(one)] == ["values", "name"]
    assert replace(one, name="a").name == "a"
