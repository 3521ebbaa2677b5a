"""Request: options of one identification by the names that ``hefting identify`` gives
them, and their check before any recording is read."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.identification import Identification, identify
from hefting.request.settings import (
    gravity_of,
    hyperparameters_of,
    reading_of,
    recording_of,
    sensor_pose_of,
    shape_of,
)
from hefting.shapes import Shape

Value = str | int | float | bool | None

ALSO = {"pose": "object_pose", "sign": "wrench"}
"""Other names of options."""
DEFAULTS: dict[str, Value] = {
    "bias": "auto",
    "motion": "auto",
    "start": 0.0,
    "wrench": "auto",
    "hull": False,
}
"""Defaults of options, where these are not None."""
TEXTS = (
    *("shape", "unit", "object_pose", "box", "pose_std", "shape_std"),
    *("method", "until", "mass", "sensor_accuracy", "tool"),
    *("wrench", "bias", "motion", "gravity"),
    *("map", "poses", "urdf"),
    *("sensor_frame", "sensor_pose_in_log", "sensor_turned"),
)
FLOATS = ("start", "duration", "latitude", "altitude", "points_per_cm3")
FILES = (
    *("shape", "tool", "map", "poses", "urdf"),
    *("bias", "object_pose", "sensor_pose_in_log"),
)
"""Options that name files; the last line also takes words or numbers."""
YES, NO = ("true", "yes", "1"), ("false", "no", "0")


@cache
def option_kinds() -> dict[str, type]:
    """Every option and the type of its values: str, float, int or bool."""
    from hefting.estimators import options
    from hefting.logs.registry import all_options

    kinds: dict[str, type] = dict.fromkeys((*TEXTS, *all_options()), str)
    kinds |= dict.fromkeys((*FLOATS, *options()), float)
    return kinds | {"points": int, "hull": bool}


def canonical_name(name: str) -> str:
    """The name of an option with underscores and small letters, and not one of `ALSO`;
    unknown names remain."""
    plain = name.strip().lstrip("-").replace("-", "_").lower()
    return ALSO.get(plain, plain)


def given_options(options: Mapping[str, Any]) -> dict[str, Value]:
    """The given options by canonical name, each with a value of its type.

    Numbers and booleans may be texts; a list becomes text, its items separated by
    commas. Empty values and NaN are left out. Raises `InputError` for an unknown option and for
    a value of another type.
    """
    given: dict[str, Value] = {}
    kinds = option_kinds()
    for written, value in options.items():
        name = canonical_name(written)
        if name not in kinds:
            what = f"there is no option '{written}'{nearest(name, kinds)}"
            raise InputError(what, fix="hefting identify --help lists them")
        value = value.tolist() if isinstance(value, np.generic | np.ndarray) else value
        is_nan = isinstance(value, float) and value != value
        if not (value is None or value == "" or is_nan):
            typed = _typed(name, value, kinds[name])
            if typed == typed:  # no "nan"
                given[name] = typed
    return given


def _typed(name: str, value: Any, kind: type) -> Value:
    """A value as the type of its option."""
    if not isinstance(value, str | int | float | list | tuple | Path):
        what = f"is a {type(value).__name__}, not a text or a number"
        raise InputError(what, name, "give it as it is typed: the name of a file, say")
    if kind is bool:
        word = str(value).strip().lower()
        if word in (*YES, *NO):
            return word in YES
    elif kind is str:
        if isinstance(value, list | tuple):
            return ",".join(str(item) for item in value)
        return str(value).strip()
    else:
        try:
            return kind(value)
        except (TypeError, ValueError, OverflowError):
            pass
    words = {bool: "true nor false", float: "a number", int: "a whole number"}
    no = "neither" if kind is bool else "not"
    raise InputError(f"'{value}' is {no} {words[kind]}", name)


def in_folder(options: Mapping[str, Value], folder: Path) -> dict[str, Value]:
    """The options, with names of files taken as relative to a folder."""
    placed = {name: str(folder / path) for name, path in files_of(options).items()}
    return {**options, **placed}


def files_of(options: Mapping[str, Value]) -> dict[str, str]:
    """Names of files in options, by option."""
    named = {name: options.get(name) for name in FILES}
    return {
        name: value
        for name, value in named.items()
        if isinstance(value, str) and _names_file(name, value)
    }


def _names_file(name: str, value: str) -> bool:
    """Whether a value of an option in `FILES` names a file."""
    if name == "shape":
        return not value.lower().startswith("box:")
    if name in ("bias", "object_pose", "sensor_pose_in_log"):
        return "," not in value and value not in ("auto", "none", "estimate")
    return True


def request_of(options: Mapping[str, Any]) -> SimpleNamespace:
    """The options by `given_options`, with the defaults or None for the others."""
    others = dict.fromkeys(option_kinds()) | DEFAULTS
    return SimpleNamespace(**(others | given_options(options)))


def identify_requested(
    request: SimpleNamespace, log: str, shape: Shape | None
) -> Identification:
    """Identify the object in the log at a path by a request (`request_of`), with the
    shape that `hefting.request.settings.shape_of` makes of it.

    Raises `InputError` and `NotIdentifiableError` as `hefting.identify`.
    """
    return identify(
        recording_of(request, log),
        shape,
        method=request.method,
        **reading_of(request),
        **hyperparameters_of(request),
    )


def check_request(request: SimpleNamespace) -> None:
    """`InputError` for options that are wrong for every recording: unknown words,
    impossible numbers, and missing or unreadable files.

    Options that only lack another one, as a hull without a shape, pass.
    """
    from hefting.estimators import method_named
    from hefting.ingest.ingest import check_convention
    from hefting.ingest.sign_and_bias import bias_of
    from hefting.motion.measure import check_source

    a = request
    gravity_of(a)
    hyperparameters_of(a)
    bias_of(a.bias)
    if a.method is not None:
        method_named(a.method)
    check_convention(a.wrench)
    check_source(a.motion)
    if not a.start >= 0.0:
        raise InputError(f"{a.start:g} s is before a recording", "--start")
    if a.duration is not None and not a.duration > 0.0:
        raise InputError(f"{a.duration:g} s is no time", "--duration")
    _check_files(a)
    shape_of(SimpleNamespace(**{**vars(a), "hull": a.hull and a.shape is not None}))


def _check_files(a: Any) -> None:
    """`InputError` for a faulty tool, column map, pose of the sensor or URDF."""
    from hefting.ingest.tool import load_tool
    from hefting.logs.column_map import load_map
    from hefting.logs.two_files import load_maps

    if a.tool is not None:
        load_tool(a.tool)
    if a.map is not None:
        (load_map if a.poses is None else load_maps)(a.map)
    sensor_pose_of(a)
    if a.urdf is not None and a.sensor_frame is not None:
        from hefting.robots import Robot

        Robot.from_urdf(a.urdf, a.sensor_frame)
