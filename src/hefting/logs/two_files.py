"""Wrench and poses in two tables, which separate programs of sensor and robot wrote."""

from dataclasses import replace
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.files import check_readable, check_size, load_toml
from hefting.core.messages import Message
from hefting.core.recording import Recording, column_names
from hefting.core.spatial import immutable
from hefting.logs.column_map import ColumnMap, column_map_of
from hefting.logs.map_guess import TIME_EXAMPLE
from hefting.logs.mapped import Mapped, has_columns, mapped
from hefting.logs.registry import find_format, join_words, table_formats
from hefting.logs.table import SINCE_1970, Table, with_times
from hefting.logs.table_file import map_of_part, taken_by_names
from hefting.logs.units import SECOND

POSES = ("position", "orientation", "joint_positions")
"""Streams that the file of poses holds."""


@immutable
class _Part:
    """Content of one of the files, with the recorded times in seconds."""

    path: str
    found: Mapped
    warnings: tuple[Message, ...]
    """of the table, and of columns that are taken by their names"""

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""
        times = [stream.time for stream in self.found.streams.values()]
        return min(float(t[0]) for t in times), max(float(t[-1]) for t in times)


def read_with_poses(
    path: str | Path,
    poses: str | Path,
    column_map: str | Path | None = None,
    *,
    wrench_needed: bool = True,
) -> Recording:
    """Recording with the wrench at `path`, and the `poses` or joint angles in another
    table.

    Parameters
    ----------
    path : path
        Table with time and wrench, or with time and joint torques tau1..taun;
        it may hold an IMU, but no poses.
    poses : path
        Table with time and poses or joint angles, read by its names.
    column_map : path, optional
        TOML file with the columns of one of them: of the first if it names a wrench,
        else of the poses; of the other if only that has all the named columns. A table
        ``[poses]`` at its end has those of the second file.
    wrench_needed : bool
        Whether the first is refused without a wrench.

    Both have times of one clock, up to an offset of about a second, which is found when
    an object is identified. Raises `InputError` where one of them lacks these streams, or
    the two do not overlap in time.
    """
    maps: dict[str | Path, ColumnMap] = {}
    if column_map is not None:
        chosen, second = load_maps(column_map)
        one = _file_of(chosen, path, poses) if second is None else path
        maps = {one: chosen} if second is None else {poses: second, path: chosen}
    first, second = (_part(each, maps.get(each)) for each in (path, poses))
    if wrench_needed and "wrench" not in first.found.streams:
        fix = "give the file with the wrench first, that with the poses as `poses`"
        raise InputError("there is no wrench", path, fix)
    there = [name for name in POSES if name in first.found.streams]
    if there:
        fix = "leave `poses` out, or name the wrench alone in a column map (`column_map`=FILE)"
        raise InputError(f"holds {join_words(there, 'and')} itself", path, fix)
    if not {"orientation", "joint_positions"} & set(second.found.streams):
        raise InputError(
            "there are neither poses nor joint angles",
            poses,
            "name their columns in a column map of this file (`column_map`=FILE; "
            "hefting map writes one of what is known)",
        )
    _check_clocks(first, second)
    placed = first.found.sensor_pose
    own = first.found.streams
    taken = {k: stream for k, stream in second.found.streams.items() if k not in own}
    both = replace(
        first.found,
        streams={**own, **taken},
        warnings=(
            *(*first.warnings, *second.warnings),
            *(*first.found.warnings, *second.found.warnings),
        ),
        notes=(*first.found.notes, *second.found.notes),
        joint_names=second.found.joint_names,
        sensor_pose=(second if placed is None else first).found.sensor_pose,
    )
    return both.recording(str(path), wrench_needed)


def load_maps(path: str | Path) -> tuple[ColumnMap, ColumnMap | None]:
    """The column map of one of two tables in a TOML file, and that of the poses in its
    table ``[poses]``, if there is one; `InputError` as for `load_map`."""
    content = load_toml(path)
    second = content.pop("poses", None)
    chosen = column_map_of(content, path, is_part=True)
    if second is None:
        return chosen, None
    if not isinstance(second, dict):
        raise InputError("is no table", f"{path}, key poses", "write [poses]")
    return chosen, column_map_of(second, f"{path}, table poses", is_part=True)


def _file_of(chosen: ColumnMap, path: str | Path, poses: str | Path) -> str | Path:
    """The file that a column map is for."""
    one, other = poses, path
    if {"wrench", "force"} & set(chosen.quantities):
        one, other = path, poses
    return other if not _fits(chosen, one) and _fits(chosen, other) else one


def _fits(chosen: ColumnMap, path: str | Path) -> bool:
    """Whether a file has the layout and all columns of a map."""
    try:
        return has_columns(_table(path, chosen), chosen)
    except InputError:
        return False


def _part(path: str | Path, chosen: ColumnMap | None) -> _Part:
    """Content of a table, by a map or by its names."""
    table = _table(path, chosen)
    warnings = getattr(table, "warnings", ())
    torques = column_names("joint_torques", len(table.names) - 1)
    if chosen is None and set(table.names) == {"time", *torques}:
        only = {"time": {"column": "time"}, "joint_torques": [*torques]}
        chosen = column_map_of(only, path, is_part=True)
    elif chosen is None:
        chosen, guessed = map_of_part(table)
        warnings += taken_by_names(guessed, f" of {Path(path).name}")
    found = mapped(table, chosen)
    if found.unit is None or not found.streams:
        fix = f"name its column time, in seconds, or in a column map {TIME_EXAMPLE}"
        raise InputError("there is no time", path, fix)
    streams = with_times(found.streams, found.unit.to_si)
    return _Part(str(path), replace(found, streams=streams, unit=SECOND), warnings)


def _table(path: str | Path, chosen: ColumnMap | None) -> Table:
    check_readable(path)
    check_size(path)
    form = find_format(path)
    if form is None or form.open_table is None:
        known = join_words([each.name for each in table_formats()], "and")
        raise InputError(
            f"only {known} are read in two files", path, "give such a file"
        )
    return form.open_table(path, None if chosen is None else chosen.layout)


def _check_clocks(first: _Part, second: _Part) -> None:
    """`InputError` unless the two overlap in time."""
    (begin, end), (start, last) = first.span, second.span
    if begin <= last and start <= end:
        return
    fix = "give both on one clock, as seconds since 1970"
    if (begin > SINCE_1970) != (start > SINCE_1970):
        one = first if begin > SINCE_1970 else second
        raise InputError(
            f"only the times of {Path(one.path).name} count from 1970", second.path, fix
        )
    what = (
        f"its times, {start:.6g} to {last:.6g} s, do not overlap those of "
        f"{Path(first.path).name}, {begin:.6g} to {end:.6g} s"
    )
    raise InputError(what, second.path, fix)
