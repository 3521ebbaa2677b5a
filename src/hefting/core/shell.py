"""Commands as they are typed in a shell, whatever is in the names of files."""

import shlex
from collections.abc import Iterable


def typed(words: Iterable[str]) -> str:
    """A command, to be copied: words that a shell would take apart are in quotes."""
    return shlex.join(words)


def file_word(path: str) -> str:
    """The path of a file as an argument that is not taken for an option."""
    return f"./{path}" if path.startswith("-") else path
