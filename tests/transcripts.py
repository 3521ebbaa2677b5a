"""What a person types and sees, at 80 columns: the list of commands, the files they
read, and how a transcript is taken.

``python tests/transcripts.py`` writes every transcript anew, into ``cli/transcripts``:
look at each before it is committed.
"""

import contextlib
import io
import os
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import numpy as np

from hefting.cli import main
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids, truth
from jobs_here import Here

FOLDER = Path(__file__).parent / "cli" / "transcripts"

BIAS = np.array((12.0, -7.0, 14.0, 0.3, -0.2, 0.1))
POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
SHAPE = (
    "--shape hammer.stl --unit mm --object-pose 0,-0.08,0.06,-0.7071068,0,0,0.7071068"
)

ANSWERS = f"""
identify log.csv
identify log.csv {SHAPE}
identify log.csv {SHAPE} --truth truth.json
identify log.csv {SHAPE} --verbose
identify log.csv {SHAPE} --hull
identify log.csv --box 0.1,0.4,0.15 --object-pose 0,0.1,0.06,0,0,0,1
identify log.csv --shape box:-0.05,0.05,-0.1,0.3,0,0.15
identify log.csv --method OLS
identify log.csv --method OLS,LMI
identify log.csv {SHAPE} --method all
identify log.csv {SHAPE} --until mass=2%,com=2mm,inertia=40%
identify log.csv --mass 0.6704kg±0.2g
identify flipped.csv
identify biased.csv --verbose
identify poses.csv
identify late.csv {SHAPE}
identify touched.csv {SHAPE}
identify log.csv --output mug.json --output mug.urdf
identify log.csv --sensor-turned z:90
identify log.csv --bias none --gravity 0,0,9.8
identify - < log.csv
identify log.csv biased.csv
identify log.csv biased.csv --verbose
identify log.csv late.csv heavy.csv
compare estimate.json again.json
compare estimate.json heavy.json
batch log.csv biased.csv words.csv --output results
batch log.csv biased.csv words.csv --output results --resume
identify foreign.csv --map foreign.toml
identify foreign.csv
inspect log.csv
inspect log.csv --verbose
inspect biased.csv
inspect poses.csv
inspect foreign.csv --map foreign.toml
predict estimate.json log.csv
predict estimate.json log.csv --verbose
predict estimate.json poses.csv
methods
export estimate.json --to ur
export estimate.json --to ur --sensor-pose-in-flange 0,0,0.03,0,0,0,1
export - --to csv < estimate.json
calibrate log.csv --output tool.json
convert log.csv short.csv --start 1 --duration 2
map foreign.csv
map log.csv
map joints.csv
reproduce --list
"""
"""Commands that answer."""

HELP = """
--help
identify --help
inspect --help
predict --help
plan --help
methods --help
compare --help
batch --help
export --help
calibrate --help
convert --help
map --help
demo --help
simulate --help
reproduce --help
completion --help
check --help
show --help
view --help
live --help
"""

ERRORS = """

identfy log.csv
--json identify log.csv
identify
identify log.csv --shpae hammer.stl
identify log.csv --shpae hammer.stl --unti mm
identify log.csv --points many
identify log.csv --points
identify log.csv --json=yes
identify log.csv log.csv log.csv
identify none.csv
identify .
identify log.xlsx
identify pipe.csv
identify empty.csv
identify words.csv
identify misspelt.csv
identify partly.csv
identify nan.csv
identify early.csv
identify log.csv --map missing.toml
identify foreign.csv --map wrong.toml
identify foreign.csv --map typo.toml
identify log.csv --map pipe.toml
identify log.csv --shape none.stl
identify log.csv --shape log.pdf
identify log.csv --shape box:0,1
identify log.csv --box 0.1,0.2
identify log.csv --box 0.1,0.2,0.3 --shape hammer.stl
identify log.csv --hull
identify log.csv --shape hammer.stl --unit ft
identify log.csv --object-pose 0,0,0.1
identify log.csv --box 0.1,0.1,0.1 --object-pose 1,2,3,4
identify log.csv --method bayse
identify log.csv --method PMD
identify log.csv --gravity down
identify log.csv --bias sometimes
identify log.csv --wrench up
identify log.csv --motion fast
identify log.csv --start 100
identify log.csv --until mass=1kg
identify log.csv --box 0.1,0.1,0.1 --pose-std 5
identify log.csv --sensor-turned 45
identify log.csv --output mug.docx
identify log.csv --output log.csv
identify log.csv --output nowhere/mug.json
identify log.csv --tool truth.json
identify log.csv --truth log.csv
identify - < nothing
compare estimate.json
compare estimate.json estimate.json
batch log.csv
batch nowhere* --output nothing
batch log.csv --output . --group-by colour
compare estimate.json log.csv
export estimate.json
export estimate.json --to urdff
export log.csv --to urdf
export pipe.json --to urdf
export estimate.json --to urdf --into pipe.urdf --link tool0
plan --urdf pipe.urdf
plan --urdf none.urdf --tip tool0
plan --urdf pipe.urdf --tip tool0
plan --urdf truth.json --tip tool0
check pipe.urdf
check none.urdf
identify poses.csv --output mug.xml
predict estimate.json log.csv --gravity estimate
convert log.csv log.xlsx
map words.csv
simulate out.csv --object spoon
completion powershell
reproduce nois
live
live http://robot
live tcp://robot
live zenoh://robot/x
live dds://300
live none.csv
live poses.csv
live log.csv --speed 0
live log.csv --record log.csv
live log.csv --export-to urr
live log.csv --export-to ur --json
live dds://0 --map foreign.toml
"""
"""Commands that are refused."""

GROUPS = {"answers": ANSWERS, "help": HELP, "errors": ERRORS}


def commands(group: str) -> list[str]:
    """The commands of a group, as typed after ``hefting``."""
    return GROUPS[group].removeprefix("\n").removesuffix("\n").split("\n")


def write_files(folder: Path) -> None:
    """The files that the commands read."""
    held = hammer()
    body = held.parameters.moved(POSE)
    motion = UR5.motion(sinusoids(5.0, 100.0, 1.5))
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4), "seed": 3}
    log = simulate(motion, body, **noise)
    write_log(log, folder / "log.csv")
    surface = held.mesh()
    surface.copy().apply_scale(1e3).export(folder / "hammer.stl")
    import json

    facts = truth(body, surface.extents, POSE, mesh_unit="mm", name=held.name)
    (folder / "truth.json").write_text(json.dumps(facts))
    _write_variants(folder, log)
    _write_texts(folder, (folder / "log.csv").read_text().splitlines())
    from hefting.identification import identify

    for log, name in (("log", "estimate"), ("biased", "again"), ("heavy", "heavy")):
        found = identify(folder / f"{log}.csv", method="OLS").estimate
        found.save(folder / f"{name}.json")
    for name in ("pipe.csv", "pipe.toml", "pipe.json", "pipe.urdf"):
        os.mkfifo(folder / name)


def _write_variants(folder: Path, log: Recording) -> None:
    """The recording with another sign, a bias, a delay, a touch, and static poses."""
    wrench = log["wrench"]
    touch = wrench.values.copy()
    touch[200:260, :3] += (4.0, 1.0, 8.0)
    changed = {
        "flipped.csv": (wrench.time, -wrench.values),
        "biased.csv": (wrench.time, wrench.values + BIAS),
        "late.csv": (wrench.time + 0.03, wrench.values),
        "heavy.csv": (wrench.time, 1.5 * wrench.values),
        "touched.csv": (wrench.time, touch),
    }
    for name, (time, values) in changed.items():
        streams = {**log.streams, "wrench": Stream(time, values, wrench.rows)}
        write_log(Recording(streams), folder / name)
    few = {
        name: Stream(np.arange(20.0), log[name].values[::25])
        for name in ("orientation", "wrench")
    }
    write_log(Recording(few, static=True), folder / "poses.csv")


def _write_texts(folder: Path, lines: list[str]) -> None:
    """Tables with other names, and tables with mistakes."""
    header, rows = lines[0], lines[1:]
    names = "stamp_s,x,y,z,rot_x,rot_y,rot_z,rot_w,F_X,F_Y,F_Z,M_X,M_Y,M_Z"
    texts = {
        "foreign.csv": [names, *rows],
        "foreign.toml": [
            'time = "stamp_s"',
            'position = ["x", "y", "z"]',
            'orientation = ["rot_x", "rot_y", "rot_z", "rot_w"]',
            'wrench = ["F_X", "F_Y", "F_Z", "M_X", "M_Y", "M_Z"]',
        ],
        "wrong.toml": [
            'time = "stamp"',
            'orientation = ["rot_x", "rot_y", "rot_z", "rot_ww"]',
            'wrench = ["F_X", "F_Y", "F_Z", "T_X", "T_Y", "T_Z"]',
        ],
        "typo.toml": ['tiem = "stamp_s"', 'wrnech = ["F_X"]'],
        "empty.csv": [""],
        "words.csv": ["name,colour", "mug,blue"],
        "misspelt.csv": [header.replace("time", "tiem").replace("fx", "Fx"), *rows],
        "partly.csv": [header.replace(",fy", ",f2").replace(",qw", ",qq"), *rows],
        "nan.csv": [
            *lines[:7],
            *(line.replace(line.split(",")[9], "NaN") for line in lines[7:10]),
        ],
        "early.csv": [*lines[:9], lines[3], *lines[9:]],
        "log.xlsx": ["spreadsheet"],
        "log.pdf": ["page"],
        "nothing": [],
        "joints.csv": [
            "t_ms,q1,q2,q3,q4,q5,q6,ft_0,ft_1,ft_2,ft_3,ft_4,ft_5",
            "0,10,20,30,40,50,60,1,2,-9,0.1,0.2,0.3",
            "10,11,21,31,41,51,61,1,2,-9,0.1,0.2,0.3",
        ],
    }
    for name, text in texts.items():
        (folder / name).write_text("".join(f"{line}\n" for line in text))


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


class Terminal(io.StringIO):
    """Standard error of a person."""

    def isatty(self) -> bool:
        """Yes."""
        return True


def take(command: str, folder: Path) -> str:
    """What is typed and seen: the command, its output, what it says on standard error,
    and the exit status where it is not 0."""
    typed, _, source = command.partition(" < ")
    words = ["hefting", *shlex.split(typed)]
    out, err, status = io.StringIO(), Terminal(), 0
    size = mock.patch.dict(os.environ, {"COLUMNS": "80", "NO_COLOR": "1"})
    with _inside(folder), size, contextlib.ExitStack() as stack:
        if source:
            given = stack.enter_context(open(source))
            stack.enter_context(mock.patch("sys.stdin", given))
        stack.enter_context(mock.patch("sys.argv", words))
        stack.enter_context(mock.patch("hefting.cli.progress.PATIENCE", 1e3))
        # a batch of three recordings is done by this process
        stack.enter_context(mock.patch("hefting.jobs.Processes", Here))
        no_bar = contextlib.nullcontext(lambda progress: None)
        stack.enter_context(mock.patch("hefting.cli.batch._bar", return_value=no_bar))
        stack.enter_context(contextlib.redirect_stdout(out))
        stack.enter_context(contextlib.redirect_stderr(err))
        try:
            main()
        except SystemExit as stop:
            status = stop.code
    lines = [f"$ hefting {command}".rstrip()]
    text = out.getvalue()
    text = without_times(text) if words[1:2] == ["batch"] else text
    lines += [line.rstrip() for line in text.splitlines()]
    lines += [f"! {line}" for line in err.getvalue().splitlines()]
    lines += [f"[{status}]"] if status else []
    return "\n".join(lines) + "\n"


def without_times(text: str) -> str:
    """What is printed of a batch, without how long it took."""
    text = re.sub(r"(recordings in )[^;\n]*", r"\1# s", text)
    return re.sub(r"(\w+ )\d+ %", r"\1# %", text)


def masked(transcript: str) -> str:
    """The same with every number as ``#``: they are tested elsewhere, and differ
    between machines in their last digits. Widths of tables are left out as well."""
    text = re.sub(r"[-+]?(?<![A-Za-z_])\d+(\.\d+)?(e[-+]?\d+)?", "#", transcript)
    return re.sub(r"[ ━─]+", " ", text)


def transcript_of(group: str, folder: Path) -> str:
    """All of a group, one after another."""
    return "\n".join(take(command, folder) for command in commands(group))


if __name__ == "__main__":
    from tempfile import TemporaryDirectory

    sys.path.insert(0, str(Path(__file__).parent))
    for group in GROUPS:
        with TemporaryDirectory() as made:
            write_files(Path(made))
            (FOLDER / f"{group}.txt").write_text(transcript_of(group, Path(made)))
