"""hefting methods: list the methods, what each needs and what it guarantees."""

import argparse

from hefting.cli.options import add_json, add_verbose

EXAMPLES = (
    "hefting methods",
    "hefting methods --verbose",
    "hefting identify log.csv --shape mug.stl --method all",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting methods``."""
    add_json(parser)
    add_verbose(parser, "sources, variants, and what a method does not depend on")


def run(arguments: argparse.Namespace) -> None:
    """Print every method."""
    if arguments.json:
        import json

        from hefting.estimators import describe_methods

        print(json.dumps(describe_methods()))
        return
    from hefting.cli.report.methods import methods_report
    from hefting.cli.report.printing import print_report

    print_report(methods_report(arguments.verbose))
