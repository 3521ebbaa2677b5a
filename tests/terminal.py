"""A real terminal of 80 columns: what a command writes to it, on standard output and on
standard error apart, with every state of the line of progress.

``python tests/terminal.py`` writes the transcript of the README's commands anew: look at
it before it is committed.
"""

import fcntl
import json
import os
import pty
import re
import selectors
import shlex
import struct
import subprocess
import sys
import termios
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import hefting

COLUMNS, ROWS = 80, 40
README = Path(__file__).parents[1] / "README.md"
TRANSCRIPT = Path(__file__).parent / "cli" / "transcripts" / "terminal.txt"
STYLE = re.compile(r"\x1b\[[0-9;]*m")
"""What sets colours."""
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
"""What sets colours, erases, moves the cursor, hides or shows it."""
START = "from hefting.cli import main, progress; progress.PATIENCE = {}; main()"
"""Runs a command; nothing is shown of what takes less time [s]."""
END = "\0"
"""Stands in both terminals after each of several commands, after its exit status."""
IN_TURN = """
import gc, json, os, sys
import matplotlib.backends.backend_agg, matplotlib.figure, rich.table, trimesh
import hefting.export, hefting.identification, hefting.plots.style
from hefting.cli import main, progress
progress.PATIENCE = {}
hefting.plots.style.DPI = 60
matplotlib.figure.Figure.draw_without_rendering = lambda figure: None
gc.freeze()
for words in json.loads(sys.argv[1]):
    process = os.fork()
    if not process:
        sys.argv[1:] = words
        status = 0
        try:
            main()
        except SystemExit as stop:
            status = stop.code or 0
        for file in (sys.stdout, sys.stderr):
            file.flush()
        os._exit(status)
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    for file in (1, 2):
        os.write(file, f"{{status}}\\0".encode())
"""
"""Runs commands one after the other, each in a process of its own, which need not load
anew what several of them need, nor tidy it up at its end; pictures are of few pixels
and not laid out."""


@dataclass(frozen=True)
class Session:
    """What a command wrote to its terminals."""

    status: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """Lines of the answer, as they stand on the screen."""
        return CONTROL.sub("", self.out).replace("\r\n", "\n").splitlines()

    @property
    def states(self) -> list[str]:
        """What stood in the line of progress, one state after the other, without
        repetitions."""
        shown: list[str] = []
        for part in re.split(r"[\r\n]+|\x1b\[[0-9]*[AK]", STYLE.sub("", self.err)):
            state = CONTROL.sub("", part).rstrip()
            if state and (not shown or shown[-1] != state):
                shown.append(state)
        return shown


def run(
    command: str,
    folder: Path,
    patience: float = 1.0,
    err_is_terminal: bool = True,
    environment: Mapping[str, str] | None = None,
) -> Session:
    """Run a command, as typed after ``hefting``, in a folder. `patience` is from when on
    progress is shown [s]; standard error is another terminal, or a pipe."""
    words = [START.format(patience), *shlex.split(command)]
    return _run(words, folder, err_is_terminal, environment or {})


def run_in_turn(
    commands: list[str], folder: Path, patience: float = 1.0
) -> dict[str, Session]:
    """Run several commands, both of whose files are terminals."""
    words = json.dumps([shlex.split(command) for command in commands])
    whole = _run([IN_TURN.format(patience), words], folder, True, {})
    outs, errs = (text.split(END)[:-1] for text in (whole.out, whole.err))
    sessions = {}
    for command, out, err in zip(commands, outs, errs, strict=True):
        status = re.search(r"-?\d+\Z", out)
        assert status
        assert err.endswith(status[0])
        texts = (text.removesuffix(status[0]) for text in (out, err))
        sessions[command] = Session(int(status[0]), *texts)
    return sessions


def _run(
    words: list[str],
    folder: Path,
    err_is_terminal: bool,
    environment: Mapping[str, str],
) -> Session:
    outer, inner = zip(*(_terminal() for _ in range(2)), strict=True)
    source = str(Path(hefting.__file__).parents[1])
    own = {"TERM": "xterm-256color", "PYTHONPATH": source, **environment}
    left_out = ("COLUMNS", "LINES", "NO_COLOR")
    known = {k: v for k, v in os.environ.items() if k not in left_out}
    process = subprocess.Popen(
        [sys.executable, "-c", *words],
        cwd=folder,
        env=known | own,
        stdin=subprocess.DEVNULL,
        stdout=inner[0],
        stderr=inner[1] if err_is_terminal else subprocess.PIPE,
    )
    for each in inner:
        os.close(each)
    pipe = [] if process.stderr is None else [process.stderr.fileno()]
    out, err = _read([outer[0], *(pipe or outer[1:])])
    for each in outer:
        os.close(each)
    if process.stderr is not None:
        process.stderr.close()
    return Session(process.wait(), out, err)


def _terminal() -> tuple[int, int]:
    """The two ends of a terminal of `ROWS` and `COLUMNS`."""
    outer, inner = pty.openpty()
    fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
    return outer, inner


def _read(files: list[int]) -> list[str]:
    """What comes from each file, until all are closed at their other ends."""
    data = dict.fromkeys(files, b"")
    with selectors.DefaultSelector() as selector:
        for file in files:
            selector.register(file, selectors.EVENT_READ)
        while selector.get_map():
            for key, _ in selector.select():
                try:
                    part = os.read(key.fd, 1 << 16)
                except OSError:  # a terminal whose other end is closed
                    part = b""
                if not part:
                    selector.unregister(key.fd)
                data[key.fd] += part
    return [data[file].decode() for file in files]


def readme_commands() -> list[str]:
    """The README's commands on the files of the demo, as typed after ``hefting``."""
    blocks = re.findall(r"```sh\n(.*?)```", README.read_text(), flags=re.DOTALL)
    lines = [line for block in blocks[:2] for line in block.splitlines()]
    return [line.removeprefix("hefting ") for line in lines if "hefting" in line]


def transcript(folder: Path) -> dict[str, Session]:
    """Each of the README's commands, in a folder where the demo has been made."""
    from demo_files import write_demo

    write_demo(folder / "demo")
    return run_in_turn(readme_commands(), folder)


def text_of(sessions: Mapping[str, Session]) -> str:
    """A transcript as text."""
    return "\n".join(
        "\n".join([f"$ hefting {command}", *session.lines, ""])
        for command, session in sessions.items()
    )


if __name__ == "__main__":
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as made:
        TRANSCRIPT.write_text(text_of(transcript(Path(made))))
