"""Seconds that each stage of an identification takes, from what it reports of its
progress."""

from collections.abc import Generator
from contextlib import contextmanager
from time import perf_counter

from hefting.batches.columns import STAGES
from hefting.core.progress import listening
from hefting.logs.registry import READING

STAGE_OF = {
    READING: "reading",
    "smoothing the motion": "motion",
    "identifying": "solving",
}
"""Stage of what is reported; all else is conditioning."""


class Stopwatch:
    """Time by stage; what comes before the first report is reading."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._stage, self._since = "reading", perf_counter()

    def __call__(self, reported: str, share: float | None = None) -> None:
        """A stage is begun, or goes on."""
        now = perf_counter()
        self._seconds[self._stage] += now - self._since
        self._stage, self._since = STAGE_OF.get(reported, "conditioning"), now

    @property
    def seconds(self) -> dict[str, float]:
        """[s] by stage, up to now."""
        going_on = perf_counter() - self._since
        return self._seconds | {self._stage: self._seconds[self._stage] + going_on}


@contextmanager
def stopwatch() -> Generator[Stopwatch, None, None]:
    """A stopwatch of what is reported meanwhile."""
    watch = Stopwatch()
    with listening(watch):
        yield watch
