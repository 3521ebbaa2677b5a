"""The parser of the command line, with help of 80 columns, and errors of one line that
propose a correction."""

import argparse
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from shutil import get_terminal_size
from textwrap import fill, wrap
from typing import IO, Any, NoReturn

from hefting.core.errors import InputError, printable

WIDTH = 80
"""Largest number of columns of help."""

WORDINGS = (
    (r"argument (\S+): invalid int value: (.*)", r"\1: \2 is not a whole number"),
    (r"argument (\S+): invalid float value: (.*)", r"\1: \2 is not a number"),
    (r"argument (\S+): expected one argument", r"\1: its value is missing"),
    (r"argument (\S+): ignored explicit argument .*", r"\1 takes no value"),
    (
        r"argument (\S+): invalid choice: (.*) \(choose from (.*)\)",
        r"\1: use one of \3, not \2",
    ),
    (r"the following arguments are required: (.*)", r"\1: missing"),
)
"""Patterns of messages of `argparse`, and their replacement."""


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Help of at most `WIDTH` columns, the commands in one list."""

    def __init__(self, prog: str, **settings: Any):
        columns = min(get_terminal_size().columns, WIDTH)
        super().__init__(prog, max_help_position=26, width=columns - 1, **settings)

    def _split_lines(self, text: str, width: int) -> list[str]:
        """Wrap without breaks at hyphens, as of file names."""
        return wrap(" ".join(text.split()), width, break_on_hyphens=False)

    def _iter_indented_subactions(
        self, action: argparse.Action
    ) -> Iterator[argparse.Action]:
        """The commands, indented as options are."""
        yield from getattr(action, "_get_subactions", tuple)()

    def _format_action_invocation(self, action: argparse.Action) -> str:
        """An option's value once, behind its names, as of Python 3.13."""
        text = super()._format_action_invocation(action)
        return re.sub(r"^(-\w) .*, --", r"\1, --", text)

    def _format_action(self, action: argparse.Action) -> str:
        commands = list(self._iter_indented_subactions(action))
        if commands:
            return "".join(map(self._format_action, commands))
        return super()._format_action(action)


class Parser(argparse.ArgumentParser):
    """Reports bad usage as an `InputError`, in one line."""

    def __init__(self, **settings: Any):
        super().__init__(formatter_class=HelpFormatter, allow_abbrev=False, **settings)
        self._positionals.title = "input"
        self._optionals.title = "common options"

    def parse_known_args(self, args=None, namespace=None):  # pyright: ignore
        """As `argparse`, but the command itself reports surplus arguments."""
        found, rest = super().parse_known_args(args, namespace)
        if rest:
            what = "unknown option" if rest[0][0] == "-" else "too many arguments:"
            self.error(f"{what} {' '.join(rest)[:80]}")
        return found, rest

    def format_help(self) -> str:
        """The help, its usage in one line: what must be given, and ``[options]``."""
        if self.usage is None:
            needed = [a for a in self._actions if a.required or not a.option_strings]
            words = [_usage_of(action) for action in needed]
            self.usage = " ".join([self.prog, *words, "[options]"])
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        """Raise `message` as an `InputError`."""
        message = re.sub(r"-\w/--", "--", message)  # an option by its long name alone
        for pattern, wording in WORDINGS:
            if match := re.fullmatch(pattern, message):
                message = match.expand(wording)
        raise InputError(message, fix=f"see {self.prog} --help")

    def check_options(self, words: Sequence[str], where: str = "") -> None:
        """`InputError` for an empty value, and one that names all unknown options in
        `words`, each with a similar known one, and `where` they are."""
        known = [name for name in self._option_string_actions if name.startswith("--")]
        unknown = []
        for last, word in zip(("", *words), words, strict=False):
            if word == "--":
                break
            if not word and not last.startswith("-"):
                self.error("an argument is empty")
            name, equals, value = (word or f"{last}=").partition("=")
            if name.startswith("--") and equals and not value:
                self.error(f"{name}: its value is missing")
            if name.startswith("--") and name not in known:
                unknown.append(f"{name}{did_you_mean(name, known)}")
        if unknown:
            plural = "s" if len(unknown) > 1 else ""
            self.error(f"unknown option{plural} {', '.join(unknown)}{where}")

    def _print_message(self, message: str, file: IO[str] | None = None) -> None:
        """Print help or version; unlike `argparse`, raise the errors of that."""
        file = file or sys.stdout
        if file is not None:
            file.write(message)


def say(message: str) -> None:
    """Print a message on standard error: in one line, or wrapped in a terminal."""
    text = "hefting: " + printable(" ".join(message.split()))
    if sys.stderr.isatty():
        text = wrapped(text, max(get_terminal_size().columns, 20) - 1)
    print(text, file=sys.stderr)


def wrote(*paths: object) -> None:
    """Print the names of written files, several of them on a line each."""
    names = [printable(str(path)) for path in paths]
    print(f"wrote {names[0]}" if len(names) == 1 else "\n  ".join(("wrote:", *names)))


def output_width() -> int:
    """Columns of standard output; `WIDTH` where that is no terminal."""
    return get_terminal_size().columns if sys.stdout.isatty() else WIDTH


def wrapped(text: str, width: int) -> str:
    """A line wrapped to a width, with the lines after the first indented by two more
    spaces. Quoted names, as in a command to be copied, are not broken."""
    if len(text) <= width:
        return text
    start = text[: len(text) - len(text.lstrip())]
    kept = re.sub(r"(?<!\S)'[^']*'", lambda name: name[0].replace(" ", "\0"), text)
    lines = fill(
        kept.strip(),
        width,
        initial_indent=start,
        subsequent_indent=start + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return lines.replace("\0", " ")


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """``" (did you mean --shape?)"`` for the choice that resembles `word`, dashes aside;
    else empty."""
    from difflib import get_close_matches

    by_letters = {choice.lstrip("-"): choice for choice in choices}
    letters = word.lower().replace("_", "-").strip("-")
    found = get_close_matches(letters, by_letters, n=1, cutoff=0.6)
    return f" (did you mean {by_letters[found[0]]}?)" if found else ""


def _usage_of(action: argparse.Action) -> str:
    """Usage of an argument: its name, after its option if it has one."""
    name = action.metavar or action.dest
    text = name if isinstance(name, str) else " ".join(name)
    if action.option_strings:
        return f"{action.option_strings[-1]} {text}"
    several = {"*": f"[{text} ...]", "+": f"{text} [{text} ...]", "?": f"[{text}]"}
    return several.get(str(action.nargs), text)
