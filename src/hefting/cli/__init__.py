"""The command line: parse, call one library function, print or save.

Plain `argparse`, and imports of the library inside the commands, keep ``hefting --help`` quick.
"""

import re
import sys

from hefting.errors import HeftingError, InputError


def main() -> None:
    """Entry point of ``hefting``. Exit status: 0 done, 2 bad usage or input, 1 anything else."""
    from hefting.cli.parser import build_parser

    try:
        arguments = build_parser().parse_args(_joined(sys.argv[1:]))
        arguments.run(arguments)
    except HeftingError as error:
        _fail(str(error), 2 if isinstance(error, InputError) else 1)
    except KeyboardInterrupt:
        _fail("stopped", 1)
    except BrokenPipeError:  # the reader of a pipe went away
        sys.stderr.close()
        sys.exit(1)


def _joined(words: list[str]) -> list[str]:
    """``--option -1,2`` as ``--option=-1,2``: a value that starts with a minus sign is not an option."""
    joined: list[str] = []
    for word in words:
        if joined and re.match(r"-\.?\d", word) and re.fullmatch(r"--[a-z][a-z0-9-]*", joined[-1]):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _fail(message: str, status: int) -> None:
    print("hefting: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(status)
