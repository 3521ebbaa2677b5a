"""`python -m benchmarks.same_answers --write FILE | --compare A B`: whether two
versions of the code say the same.

`--write` identifies a fixed list of recordings with the code on the path, others'
recordings in HEFTING_DATA and simulated ones, and writes what was found, one JSON
object a line. `--compare` puts two such files side by side. Differences are in standard
deviations of A. Two processes, some minutes.
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

PANDA_BOX = "box:-0.15,0.15,-0.15,0.15,-0.05,0.3"
GRIPPER_BOX = "box:-0.06,0.06,-0.06,0.06,0,0.15"
MODERATE = (0.1, 0.005)
"""Noise added to the wrenches of the workshop tools [N], [N m]."""
PROCESSES = 2


def main() -> None:
    """Write the answers of this code, or compare those of two; the latter ends with 1
    where they differ."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.same_answers", description=main.__doc__
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--write", metavar="FILE", type=Path, help="identify every recording"
    )
    what.add_argument(
        "--compare", metavar=("A", "B"), nargs=2, type=Path, help="B beside A"
    )
    where = "simulated recordings; made where they are not there; default beside FILE"
    parser.add_argument("--recordings", metavar="FOLDER", type=Path, help=where)
    parser.add_argument(
        "--simulated",
        metavar="N",
        type=int,
        help="of the simulated ones the first N only",
    )
    parser.add_argument(
        "--messages", action="store_true", help="list messages that differ as well"
    )
    arguments = parser.parse_args()
    if arguments.compare:
        from benchmarks.same_report import compared

        sys.exit(compared(*arguments.compare, messages=arguments.messages))
    folder = arguments.recordings or arguments.write.parent / "recordings"
    write(arguments.write, folder, arguments.simulated)


@dataclass(frozen=True)
class Job:
    """One identification."""

    name: str
    method: str
    """``Bayes box``, ``Bayes mesh``, ``OLS`` or ``LMI``"""
    groups: tuple[str, ...]
    """under which it is reported"""
    recording: Callable[[], Any]
    gravity: Any
    shape: dict[str, Any] | None = None
    """arguments of `hefting.load_shape`"""


def write(file: Path, folder: Path, simulated: int | None = None) -> None:
    """Identify every recording with the code on the path, and write one JSON object a
    line."""
    import hefting
    from benchmarks.same_recordings import RECORDINGS, made

    made(folder, simulated or RECORDINGS)  # before the processes part
    count = len(jobs(folder, simulated))
    print(
        f"{count} identifications with {Path(hefting.__file__).parent}",
        file=sys.stderr,
        flush=True,
    )
    began = time.perf_counter()
    numbers = range(count)
    with get_context("fork").Pool(PROCESSES) as pool, file.open("w") as out:
        work = [(number, folder, simulated) for number in numbers]
        for answer in pool.imap(_answer, work, chunksize=1):
            out.write(json.dumps(answer) + "\n")
            out.flush()
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)


def jobs(folder: Path, simulated: int | None = None) -> list[Job]:
    """The fixed list."""
    data = os.environ.get("HEFTING_DATA")
    if not data:
        print("HEFTING_DATA is not set: simulated recordings only", file=sys.stderr)
    others = [*_of_others(Path(data)), *_tools(Path(data))] if data else []
    return [*others, *_simulated(folder, simulated)]


def _of_others(data: Path) -> Iterator[Job]:
    from hefting import read_log

    found = [
        ("panda-optoforce", name, (0.0, 0.0, -9.81), PANDA_BOX)
        for name in ("run1", "run3")
    ]
    kuka = (0.0, 0.0, -9.82085)
    found += [
        ("kuka-ati", name, kuka, GRIPPER_BOX)
        for name in ("static_poses", "baseline", "vibrations")
    ]
    found += [
        ("axia80", name, (0.0, 0.0, -9.81), GRIPPER_BOX)
        for name in ("dwells", "poses7")
    ]
    for group, name, gravity, box in found:
        file = data / group / f"{name}.csv"
        if not file.exists():
            continue
        for method in ("Bayes box", "LMI", "OLS"):
            shape = {"spec": box} if method == "Bayes box" else None
            yield Job(
                f"{group}/{name}",
                method,
                (f"{group}, {method}",),
                lambda f=file: read_log(f),
                gravity,
                shape,
            )


def _tools(data: Path) -> Iterator[Job]:
    folders = sorted(
        file.parent for file in (data / "workshop-tools").glob("*/truth.json")
    )
    for number, folder in enumerate(folders):
        pose = json.loads((folder / "truth.json").read_text())["object_pose_in_sensor"]
        shape = {"spec": str(folder / "mesh.ply"), "unit": "mm", "pose": pose}
        for method in ("Bayes mesh", "OLS"):
            yield Job(
                f"workshop-tools/{folder.name}",
                method,
                (f"workshop tools, {method}",),
                lambda f=folder, n=number: _noisy_tool(f, n),
                (0.0, 0.0, 9.81),
                shape if method == "Bayes mesh" else None,
            )


def _noisy_tool(folder: Path, number: int) -> Any:
    from dataclasses import replace

    import numpy as np

    from hefting import Stream, read_log

    recording = read_log(folder / "log.csv")
    wrench = recording["wrench"]
    noise = np.repeat(MODERATE, 3) * np.random.default_rng([78, number]).normal(
        size=wrench.values.shape
    )
    streams = {
        **recording.streams,
        "wrench": Stream(wrench.time, wrench.values + noise),
    }
    return replace(recording, streams=streams)


def _simulated(folder: Path, simulated: int | None) -> Iterator[Job]:
    from benchmarks.same_recordings import made, read

    for number, facts in enumerate(made(folder)[:simulated]):
        mesh = {
            "spec": str(folder / f"{facts['name']}.ply"),
            "unit": "m",
            "pose": facts["pose"],
        }
        known = (
            ("Bayes mesh", mesh)
            if number % 3
            else ("Bayes box", {"spec": facts["box"]})
        )
        for method, shape in (known, ("OLS", None)):
            groups = (
                f"simulated, {method}",
                f"simulated, {facts['kind']}",
                f"simulated, {facts['rate']:.0f} Hz",
            )
            name = f"simulated/{facts['name']} ({facts['kind']}, {facts['motion']}, {facts['rate']:.0f} Hz)"
            yield Job(
                name,
                method,
                groups,
                lambda f=facts: read(folder, f),
                facts["gravity"],
                shape,
            )


_JOBS: dict[Path, list[Job]] = {}


def _answer(work: tuple[int, Path, int | None]) -> dict[str, Any]:
    number, folder, simulated = work
    if folder not in _JOBS:
        _JOBS[folder] = jobs(folder, simulated)
    return answer(_JOBS[folder][number])


def answer(job: Job) -> dict[str, Any]:
    """What is found of one recording, ready for JSON; or the error that ended it."""
    from hefting import HeftingError, identify, load_shape

    said = {"name": job.name, "method": job.method, "groups": job.groups}
    shape = None if job.shape is None else load_shape(**job.shape)
    recording = job.recording()
    began = time.process_time()
    try:
        estimate = identify(
            recording, shape, method=job.method.split()[0], gravity=job.gravity
        ).estimate
    except HeftingError as error:
        return said | {"error": str(error), "seconds": time.process_time() - began}
    # a defect of the code on the path, to be told beside what the other version says
    except Exception as error:
        return said | {
            "error": f"{type(error).__name__}: {error}",
            "seconds": time.process_time() - began,
        }
    seconds = time.process_time() - began
    found = estimate.to_dict()
    kept = (
        "vector",
        "center_of_mass",
        "inertia_at_com",
        "covariance",
        "std",
        "intervals",
        "bias",
        "residual",
    )
    told = ("clock_offset", "wrench", "bias", "outliers", "gravity", "notes")
    provenance = {name: found["provenance"].get(name) for name in told}
    return (
        said
        | {name: found[name] for name in (*kept, "samples")}
        | {
            "provenance": provenance,
            "messages": [str(line) for line in estimate.warnings],
            "seconds": seconds,
        }
    )


if __name__ == "__main__":
    main()
