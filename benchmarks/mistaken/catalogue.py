"""Catalogue: a list of mistakes that grows by one for each strength."""

from collections.abc import Callable, Mapping

from benchmarks.given import Change, Mistake

UNSEEN: frozenset[str] = frozenset()
"""Codes of what no data can tell."""

Add = Callable[..., None]
"""`Catalogue.add` of a catalogue."""


def named(*codes: str) -> frozenset[str]:
    """Codes of messages that name a mistake rightly."""
    return frozenset(codes)


class Catalogue:
    """Mistakes, each strength by itself, in the order in which they are added."""

    def __init__(self) -> None:
        self.mistakes: list[Mistake] = []

    def add(
        self,
        name: str,
        codes: frozenset[str],
        strengths: Mapping[str, Change],
        needs_shape: bool = False,
        imu: bool = False,
    ) -> None:
        """Add a mistake, with the change of what is given by strength; see
        `Mistake`."""
        for strength, make in strengths.items():
            self.mistakes.append(Mistake(name, strength, make, codes, needs_shape, imu))
