"""What a command made of a file: read, refused in one line, or a failure of some
kind."""

import contextlib
import io
import sys
import traceback
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

LONGEST_LINE = 2000
"""Characters of an error message; a longer one has taken over what the file holds."""


@dataclass(frozen=True)
class Outcome:
    """How one command ended."""

    status: int
    failure: str = ""
    """kind of the failure; empty for none"""
    details: str = ""


def run_command(words: Sequence[str]) -> Outcome:
    """Run ``hefting`` with these words in this process."""
    from hefting.cli import main

    argv, out, err = sys.argv, io.StringIO(), io.StringIO()
    status: object = 0
    sys.argv = ["hefting", *words]
    try:
        with (
            warnings.catch_warnings(record=True) as noted,
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
        ):
            warnings.simplefilter("always")
            try:
                main()
            except SystemExit as stop:
                status = stop.code or 0
    except BaseException as error:
        kind = f"{type(error).__name__} {place_of(error)}"
        return Outcome(-1, kind, _trace(error))
    finally:
        sys.argv = argv
    # an export into a file prints the file, whatever it holds
    shown = "" if words[0] == "export" and not status else out.getvalue()
    return _judge(status, shown, err.getvalue(), noted)


def _judge(
    status: object, out: str, err: str, noted: Sequence[warnings.WarningMessage]
) -> Outcome:
    """Whether a command that came to its end kept what it promises."""
    if status not in (0, 1, 2, 3):  # 3: done, but not to be used
        return Outcome(-1, f"exit status {status}", err)
    assert isinstance(status, int)
    if noted:
        first = noted[0]
        name = "/".join(first.filename.split("/")[-2:])
        kind = f"{first.category.__name__} {name}:{first.lineno}"
        return Outcome(status, kind, str(first.message))
    if not _is_printable(out):
        return Outcome(status, "output that controls a terminal", out)
    if status in (0, 3):
        return Outcome(status)
    if "not enough memory" in err:
        return Outcome(status, "memory", err)
    lines = err.splitlines()
    last = lines[-1] if lines else ""
    if not last.startswith("hefting: ") or len(lines) > 1 or out:
        return Outcome(status, "error of more than one line", f"{out}\n{err}")
    if len(last) > LONGEST_LINE or not last.isprintable():
        return Outcome(status, "error that cannot be read", last)
    return Outcome(status)


def _is_printable(text: str) -> bool:
    return text.replace("\n", "").replace("\t", "").isprintable()


def place_of(error: BaseException) -> str:
    """The function of the library in which an error arose."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "/hefting/" in frame.filename]
    if not own:
        return "elsewhere"
    file = own[-1].filename.rpartition("/hefting/")[2]
    return f"{file}:{own[-1].name}"


def _trace(error: BaseException) -> str:
    return "".join(traceback.format_exception(error))[-4000:]
