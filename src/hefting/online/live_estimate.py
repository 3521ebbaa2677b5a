"""Live estimate: what is known of the object at one time of a stream."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import Message

LiveStateName = Literal[
    "waiting",
    "too little motion",
    "identified",
    "sufficient",
    "contradicted",
    "lost source",
]


@dataclass(frozen=True, eq=False)
class LiveEstimate:
    """What is known of the object at one time of a stream.

    Examples
    --------
    >>> live = hefting.LiveIdentifier()
    >>> live.latest is None  # before any sample
    True
    >>> live.close()
    """

    time: float
    """[s] Newest stamp of the stream."""
    state: LiveStateName
    """``"waiting"`` for streams, ``"too little motion"``, ``"identified"``,
    ``"sufficient"`` where that is what `until` asks for, ``"contradicted"`` while the
    wrench is not that of the object (touched, slipped or swapped), ``"lost source"``."""
    estimate: Estimate | None = None
    """None before the motion suffices."""
    object: int = 1
    """Number of the object, which counts up where another is held."""
    previous: Estimate | None = None
    """The last estimate of the object before."""
    recent: Measurements | None = None
    """Samples since the stream was last looked at as a whole, put right as it was: the
    newest that the estimate includes."""
    messages: tuple[Message, ...] = ()
    """What is to be said of the stream; those on the estimate are among its own."""
    counts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """``samples`` that came, ``dropped`` as they came faster than they were taken, and
    ``skipped``: a number for each reason."""

    @property
    def sufficient(self) -> bool:
        """Whether the estimate is as sure as was asked for."""
        return self.state == "sufficient"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values: keys of `Estimate.to_dict`, where there is one, and
        ``state``, ``sufficient``, ``time``, ``object``, ``previous``, ``counts``."""
        own = {} if self.estimate is None else self.estimate.to_dict()
        said = [message.to_dict() for message in self.messages]
        before = self.previous
        return own | {
            "messages": [*said, *own.get("messages", [])],
            "time": self.time,
            "state": self.state,
            "sufficient": self.sufficient,
            "object": self.object,
            "previous": before
            and {
                "mass": before.mass,
                "center_of_mass": before.center_of_mass.tolist(),
            },
            "counts": {k: _plain(v) for k, v in self.counts.items()},
        }


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else value
