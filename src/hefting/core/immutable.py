"""Immutable: the decorator of classes that hold arrays and are never changed."""

from dataclasses import dataclass, field, fields
from typing import Any, TypeVar, dataclass_transform

T = TypeVar("T")


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def immutable(cls: type[T]) -> type[T]:
    """A dataclass that compares by identity, as arrays have no single answer.

    Type checkers refuse to set its fields, as of ``dataclass(frozen=True, eq=False)``.
    That makes four functions a class at its import, of some 200 classes; this makes
    one, which halves the time that their imports take. What a user is handed is a
    frozen dataclass, which refuses at run time, too.
    """
    made = dataclass(eq=False, repr=False)(cls)
    if "__repr__" not in vars(cls):
        made.__repr__ = _represent
    return made


def _represent(each: Any) -> str:
    """``Name(field=value, ...)``, as of a dataclass."""
    shown = (f"{f.name}={getattr(each, f.name)!r}" for f in fields(each) if f.repr)
    return f"{type(each).__qualname__}({', '.join(shown)})"
