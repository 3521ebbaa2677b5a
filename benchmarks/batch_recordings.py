"""Recordings for a batch: one object along many motions, and some that are broken in
ten ways."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

DURATION, RATE = 10.0, 100.0
BIAS = np.repeat((3.0, 0.15), 3)
"""[N, N m] Largest bias of the wrench."""
LATEST = 0.05
"""[s] Largest clock offset."""
SPEED = 1.0
"""[rad/s] Of the joints, typically."""


def broken_empty(path: Path, lines: list[str]) -> None:
    """An empty file."""
    path.write_text("")


def broken_header_only(path: Path, lines: list[str]) -> None:
    """No row."""
    path.write_text(lines[0])


def broken_garbage(path: Path, lines: list[str]) -> None:
    """No text."""
    path.write_bytes(np.random.default_rng(len(lines)).bytes(5000))


def broken_column(path: Path, lines: list[str]) -> None:
    """No torque about z."""
    at = lines[0].strip().split(",").index("tz")
    rows = [line.strip().split(",") for line in lines]
    path.write_text("".join(",".join(r[:at] + r[at + 1 :]) + "\n" for r in rows))


def broken_cell(path: Path, lines: list[str]) -> None:
    """Text in place of a number."""
    _with_cell(path, lines, "fx", "broken")


def broken_size(path: Path, lines: list[str]) -> None:
    """A force that no sensor shows."""
    _with_cell(path, lines, "fy", "1e40")


def broken_time(path: Path, lines: list[str]) -> None:
    """Time that goes back."""
    rows = lines[1:]
    path.write_text(lines[0] + "".join(rows[500:] + rows[:500]))


def broken_quaternions(path: Path, lines: list[str]) -> None:
    """Orientations that are none."""
    names = lines[0].strip().split(",")
    places = [names.index(name) for name in ("qx", "qy", "qz", "qw")]
    rows = [line.strip().split(",") for line in lines[1:]]
    for row in rows:
        for place in places:
            row[place] = "0"
    path.write_text(lines[0] + "".join(",".join(row) + "\n" for row in rows))


def broken_zero_wrench(path: Path, lines: list[str]) -> None:
    """A wrench of zero throughout."""
    names = lines[0].strip().split(",")
    places = [names.index(name) for name in ("fx", "fy", "fz", "tx", "ty", "tz")]
    rows = [line.strip().split(",") for line in lines[1:]]
    for row in rows:
        for place in places:
            row[place] = "0"
    path.write_text(lines[0] + "".join(",".join(row) + "\n" for row in rows))


def broken_missing(path: Path, lines: list[str]) -> None:
    """No file."""
    path.unlink(missing_ok=True)


BREAKS: tuple[Callable[[Path, list[str]], None], ...] = (
    *(broken_empty, broken_header_only, broken_garbage, broken_column, broken_cell),
    *(broken_size, broken_time, broken_quaternions, broken_zero_wrench),
    broken_missing,
)
"""Ways in which a recording is broken."""


def _with_cell(path: Path, lines: list[str], column: str, text: str) -> None:
    """The file with another text in place of a number in the middle of a column."""
    at = lines[0].strip().split(",").index(column)
    rows = [line.rstrip("\n").split(",") for line in lines]
    next(row for row in rows[len(rows) // 2 :] if row[at])[at] = text
    path.write_text("".join(",".join(row) + "\n" for row in rows))


def write_recording(task: tuple[str, int, int | None]) -> str:
    """Write the recording of a number to a path, broken in a way or whole; returns the
    path."""
    from hefting.core.spatial import STANDARD_GRAVITY
    from hefting.logs import write_log
    from hefting.simulation import UR5, hammer, random_smooth
    from hefting.simulation.demo import POSE
    from hefting.simulation.faults import WRENCH_NOISE, Faults, record
    from hefting.simulation.wield import wield_analytically

    name, number, way = task
    path = Path(name)
    rng = np.random.default_rng([29, number])
    joints = random_smooth(DURATION, RATE, SPEED, number)
    body = hammer().parameters.moved(POSE)
    wielding = wield_analytically(UR5, joints, body, STANDARD_GRAVITY)
    wrong = Faults(
        wrench_noise=WRENCH_NOISE["moderate"],
        bias=tuple(BIAS * rng.uniform(-1.0, 1.0, 6)),  # type: ignore[arg-type]
        wrench_delay=float(rng.uniform(0.0, LATEST)),
    )
    write_log(record(wielding, wrong, seed=number), path)
    if way is not None:
        BREAKS[way](path, path.read_text().splitlines(keepends=True))
    return name


def write_shape(folder: Path) -> dict[str, str]:
    """Write the mesh of what is held; the options that say where it is."""
    from hefting.core.files import write_atomically
    from hefting.core.spatial import quaternion_of
    from hefting.simulation import hammer
    from hefting.simulation.demo import POSE

    path = folder / "hammer.ply"
    write_atomically(path, hammer().mesh().export(file_type="ply"))
    pose = np.asarray(POSE)
    numbers = (*pose[:3, 3], *quaternion_of(pose[:3, :3]))
    return {"shape": str(path), "object_pose": ",".join(f"{n:.12g}" for n in numbers)}


def way_of(number: int, share: float) -> int | None:
    """In which way a recording of a number is broken; None for most."""
    if share <= 0.0 or number % round(1.0 / share):
        return None
    return (number // round(1.0 / share)) % len(BREAKS)
