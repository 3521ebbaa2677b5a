"""hefting completion: print what a shell needs to complete commands and options."""

import argparse

EXAMPLES = (
    'eval "$(hefting completion bash)"',
    "hefting completion bash >> ~/.bash_completion",
    'hefting completion zsh > "${fpath[1]}/_hefting"',
    "hefting completion fish > ~/.config/fish/completions/hefting.fish",
)
SHELLS = ("bash", "zsh", "fish")
FILES = (
    "FILE",
    "LOG",
    "MESH",
    ".json",
    "OUTPUT",
    "POSE",
    "FOLDER",
    "TRAJECTORY",
    "RECORDINGS",
)
"""Parts of the names of arguments that take a file."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting completion``."""
    parser.add_argument(
        "shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish"
    )


def run(arguments: argparse.Namespace) -> None:
    """Print the script."""
    import shtab

    from hefting.cli import build_whole_parser, commands_of

    parser = build_whole_parser()
    for command in commands_of(parser).values():
        for action in command._actions:
            if any(part in str(action.metavar) for part in FILES):
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(parser, arguments.shell))
