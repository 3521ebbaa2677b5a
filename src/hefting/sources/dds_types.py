"""Types of ROS messages as DDS needs them to match a publisher's, made from their
definitions; what comes is left as bytes."""

from functools import lru_cache
from typing import Any

from hefting.core.errors import InputError
from hefting.logs.ros.layout import PLACEHOLDER, standard_definitions


@lru_cache
def type_for(name: str) -> Any:
    """A class for ``pkg/msg/Name`` that `cyclonedds` takes as the type of a topic, and
    whose `deserialize` gives a `RawMessage`: decoding takes cyclonedds a millisecond for
    each. Publishers of ROS tell nothing of their type but its name, which is therefore
    the same."""
    made = _struct(name)

    def deserialize(
        cls: Any, data: bytes, has_header: bool = True, use_version_2: Any = None
    ) -> RawMessage:
        return RawMessage(data)

    made.deserialize = classmethod(deserialize)
    return made


class RawMessage:
    """The bytes of a message, with their encapsulation."""

    sample_info: Any = None

    def __init__(self, data: bytes):
        self.data = bytes(data)


@lru_cache
def struct_for(name: str) -> Any:
    """A class for ``pkg/msg/Name`` by `cyclonedds`, which it decodes."""
    return _struct(name)


def _struct(name: str) -> Any:
    from cyclonedds.idl import annotations, make_idl_struct

    definitions = standard_definitions("cdr")
    if name not in definitions:
        raise InputError(f"the schema of {name} is not understood")
    package, _, kind = name.rpartition("/")
    fields = {
        field: _type_of(node, detail)
        for field, (node, detail) in definitions[name][1]
        if field != PLACEHOLDER
    }
    typename = f"{package.replace('/', '::')}::dds_::{kind}_"
    made = make_idl_struct(kind, typename, fields)
    annotations.final(made)
    return made


def _type_of(node: int, detail: Any) -> Any:
    from cyclonedds.idl import types

    if int(node) == 1:
        if detail[0] == "string":
            return str
        plain = {"bool": bool, "byte": types.uint8, "char": types.uint8}
        return plain.get(detail[0]) or getattr(types, detail[0])
    if int(node) == 2:
        return struct_for(detail)
    (element, content), count = detail
    inner = _type_of(element, content)
    return types.array[inner, count] if int(node) == 3 else types.sequence[inner]
