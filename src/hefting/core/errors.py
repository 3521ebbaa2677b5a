"""Errors: one root class, one-line messages: what is wrong, where, and what to do; and
their text for terminals, pipes and controllers of other encodings."""

import unicodedata
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from numbers import Real

LONGEST_PLACE = 1000
"""Largest number of characters of the place in a message: paths are shorter, a text
typed in place of a file may not be."""


def printable(text: str) -> str:
    """`text` with a question mark for each character that controls a terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else "?" for c in text)


def encodable(text: str) -> str:
    """`text` with a question mark for each character that UTF-8 lacks, as in file names
    with other bytes."""
    written = text.encode(errors="replace").decode()
    return text if written == text else written


class HeftingError(Exception):
    """Root of every error this library raises on purpose.

    Examples
    --------
    >>> try:
    ...     hefting.identify("missing.csv")
    ... except hefting.HeftingError as error:
    ...     print(error)
    missing.csv: does not exist
    """


class InputError(HeftingError):
    """Something the user gave cannot be used.

    Parameters
    ----------
    what : what is wrong, in plain words.
    where : file, column or row it was found at.
    fix : what to do about it.

    ``str(error)`` is one line: ``where: what; fix``. Characters that control a terminal
    are question marks in it.

    Examples
    --------
    >>> try:
    ...     hefting.identify("demo/log.csv", method="OSL")
    ... except hefting.InputError as error:
    ...     print(error.what)
    unknown method 'OSL' (did you mean 'OLS'?)
    """

    def __init__(self, what: str, where: object = None, fix: str | None = None):
        self.what, self.where, self.fix = what, where, fix
        place = str(where)
        if len(place) > LONGEST_PLACE:
            place = f"{place[: LONGEST_PLACE - 4]} ..."
        message = f"{place}: {what}" if where is not None else what
        words = (f"{message}; {fix}" if fix else message).split()
        super().__init__(printable(" ".join(words)))


class MissingDependencyError(HeftingError):
    """An optional library is not installed; the message holds the command that installs
    it.

    Examples
    --------
    >>> print(hefting.MissingDependencyError("mujoco", "sim"))
    mujoco is not installed; run: pip install 'hefting[sim]'
    """

    def __init__(self, module: str, extra: str):
        self.module, self.extra = module, extra
        super().__init__(
            f"{module} is not installed; run: pip install 'hefting[{extra}]'"
        )

    def __reduce__(self) -> tuple[type, tuple[str, str]]:
        return type(self), (self.module, self.extra)


@contextmanager
def needing(module: str, extra: str) -> Generator[None]:
    """Context in which a failed import raises `MissingDependencyError` of a library."""
    try:
        yield
    except ImportError as error:
        raise MissingDependencyError(module, extra) from error


class NotIdentifiableError(InputError):
    """The recording cannot determine what was asked for.

    Examples
    --------
    >>> import numpy as np
    >>> held = np.tile([0.0, 0.0, 0.0, 1.0], (100, 1))
    >>> try:
    ...     hefting.identify(orientation=held, wrench=np.ones((100, 6)), bias="estimate")
    ... except hefting.NotIdentifiableError as error:
    ...     print(error.fix)
    turn the sensor to other orientations, or give `bias` none
    """


class NeedError(InputError):
    """A method needs to know more of the object than is given.

    Examples
    --------
    >>> try:
    ...     hefting.identify("demo/log.csv", method="PMD")
    ... except hefting.NeedError as error:
    ...     print(error.what)
    PMD needs a shape
    """


def check_number(name: str, value: object, unit: str, where: object = None) -> None:
    """`InputError` for a value that is no number; `unit` in words, if it has one."""
    if not isinstance(value, Real):
        of = f" of {unit}" if unit else ""
        raise InputError(f"{name} is {str(value)[:40]!r}, not a number{of}", where)


def nearest(name: str, choices: Iterable[str]) -> str:
    """``" (did you mean 'x'?)"`` if a choice resembles `name`, in any case, else an
    empty string."""
    import difflib

    by_letters = {choice.lower(): choice for choice in choices}
    found = difflib.get_close_matches(
        name[:100].lower(), list(by_letters), n=1, cutoff=0.5
    )
    return f" (did you mean '{by_letters[found[0]][:40]}'?)" if found else ""


PLAIN = str.maketrans(
    {"°": " deg", "±": "+/-", "·": "*", "×": "x", "→": "->", "–": "-", "−": "-"}
    | {"µ": "u", "…": "...", "⁻": "^-"}
    | dict(zip("┏┳┓┡╇┩├┼┤└┴┘━─┃│", "++++++++++++--||", strict=True))
)
"""Signs that have no letter or digit below them."""


def ascii_of(text: str) -> str:
    """`text` in ASCII: letters without accents, raised digits as digits, no others."""
    decomposed = unicodedata.normalize("NFKD", text.translate(PLAIN))
    return decomposed.encode("ascii", "ignore").decode()


def spell_out(error: UnicodeError) -> tuple[str, int]:
    """For `codecs.register_error`: characters that an encoding lacks in ASCII, or as a
    question mark."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(ascii_of(sign) or "?" for sign in signs), error.end


def file_word(path: str) -> str:
    """The path of a file as an argument that does not look like an option."""
    return f"./{path}" if path.startswith("-") else path
