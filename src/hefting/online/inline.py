"""Inline: a history is understood at once, where it is asked for."""

from hefting.online.understanding import Settings, Task, Understander, Understanding


class Inline:
    """Understands each task when it is given: for streams that are played as fast as
    it goes."""

    busy = False

    def __init__(self, settings: Settings):
        self._understand = Understander(settings)
        self._found: Understanding | None = None

    def ask(self, task: Task) -> None:
        """Understand the history now."""
        self._found = self._understand(task)

    def answer(self) -> Understanding | None:
        """What was found, once."""
        found, self._found = self._found, None
        return found
