"""The command line: parse, call one library function, print or save."""

import sys


def main() -> None:
    """Entry point of ``hefting``. Exit status: 0 done, 2 bad usage or input, 1 anything else."""
    import typer

    from hefting.cli.app import app
    from hefting.errors import HeftingError, InputError

    usage_error = typer.BadParameter.__mro__[1]
    try:
        sys.exit(app(standalone_mode=False) or 0)
    except HeftingError as error:
        _fail(str(error), 2 if isinstance(error, InputError) else 1)
    except usage_error as error:
        _fail(f"{error.format_message()}; see hefting --help", 2)  # type: ignore[attr-defined]
    except (KeyboardInterrupt, typer.Abort):
        _fail("stopped", 1)
    except BrokenPipeError:  # the reader of a pipe went away
        sys.stderr.close()
        sys.exit(1)


def _fail(message: str, status: int) -> None:
    print("hefting: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(status)
