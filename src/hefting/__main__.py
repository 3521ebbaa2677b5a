"""``python -m hefting``: the same as ``hefting``."""

from hefting.cli import main

main()
