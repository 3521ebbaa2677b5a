"""What of tf is kept from one batch of messages to the next: a pose needs what other
links of its chain said before."""

from collections.abc import Iterable, Mapping

import numpy as np

from hefting.logs.ros.messages import Gathered, Key
from hefting.logs.ros.series import FAR_BACK, Series
from hefting.logs.ros.source import Topic

MAX_LINKS = 2000
"""Most links that are kept: a humanoid with its sensors has some hundred."""

KEPT = 10
"""Samples of a link that are kept of before what has been given."""


class Transforms:
    """Links as they were said, each for as long as it is needed."""

    def __init__(self, kept: Mapping[Topic, Mapping[Key, Series]] | None = None):
        self._kept = {topic: dict(links) for topic, links in (kept or {}).items()}

    def following(self, gathered: Iterable[Gathered]) -> "Transforms":
        """These, and what the tf messages of a batch gave."""
        found = Transforms(self._kept)
        for each in gathered:
            kept = found._kept.setdefault(each.topic, {})
            for key, series in each.series.items():
                if key in kept or len(kept) < MAX_LINKS:
                    kept[key] = _following(kept.get(key), series)
        return found

    def all(self) -> list[Gathered]:
        """Everything that is kept, as the stream finder of bags takes it."""
        return [Gathered(topic, "tf", dict(kept)) for topic, kept in self._kept.items()]

    def forget(self, before: float) -> None:
        """Drop what is no longer needed once poses up to `before` [ns] are given."""
        for topic, kept in self._kept.items():
            for key, series in kept.items():
                if topic.name.endswith("static"):
                    kept[key] = series[series.order()[-1:]]
                    continue
                series = series[np.argsort(series.time, kind="stable")]
                first = int(np.searchsorted(series.time, before, side="right"))
                kept[key] = series[max(min(first, len(series) - 1) - KEPT, 0) :]


def _following(kept: Series | None, series: Series) -> Series:
    """Both; only the newer one where the clock was set back between them."""
    if kept is None or series.time.min() < kept.time.max() - FAR_BACK:
        return series
    return Series.joined([kept, series])
