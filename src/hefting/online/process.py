"""Process: understands a history in another process, so that neither sampling nor
estimates wait for it; or in this one, for streams that are played."""

import os
import pickle
import queue
import struct
import subprocess
import sys
import threading
from contextlib import suppress
from typing import IO, Any

from hefting.core.errors import HeftingError
from hefting.core.threads import ONE_THREAD
from hefting.online.understanding import Settings, Task, Understander, Understanding

LENGTH = struct.Struct(">Q")
"""Number of bytes of a message, before each message."""
COMMAND = "from hefting.online.process import serve; serve()"
NICENESS = 3
"""Niceness of the process: sampling has priority on a shared core."""


class Remote:
    """Understands in a process of its own, which ends with this one.

    It is no fork and no `multiprocessing` process: a user's script, which may drive a
    robot, is not run again.
    """

    def __init__(self, settings: Settings):
        self._settings = pickle.dumps(settings)
        self._answers: queue.SimpleQueue[Understanding | None] = queue.SimpleQueue()
        self._waiting = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._begin()

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self._waiting > 0

    def ask(self, task: Task) -> None:
        """Have a history understood."""
        if self._process is None or self._process.poll() is not None:
            self._begin()  # its condensed parts are lost
        assert self._process is not None
        assert self._process.stdin is not None
        self._waiting = 1
        with suppress(OSError):  # the reader reports its death
            _send(self._process.stdin, pickle.dumps(task))

    def answer(self) -> Understanding | None:
        """A new answer, once; None if there is none. `HeftingError` if it failed."""
        try:
            found: Any = self._answers.get_nowait()
        except queue.Empty:
            return None
        self._waiting = 0
        if isinstance(found, Exception):
            raise found
        return found

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    with suppress(OSError):
                        stream.close()

    def _begin(self) -> None:
        self.close()
        path = os.pathsep.join(each for each in sys.path if each)
        environment = os.environ | {"PYTHONPATH": path} | ONE_THREAD
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-c", COMMAND],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=environment,
                start_new_session=True,  # a terminal's Ctrl-C does not reach it
            )
        except OSError as error:
            what = f"no process can be begun ({error.strerror})"
            raise HeftingError(what) from error
        assert self._process.stdin is not None
        with suppress(OSError):
            _send(self._process.stdin, self._settings)
        self._answers = queue.SimpleQueue()  # the old one may still get its None
        read = threading.Thread(
            target=_read,
            args=(self._process, self._answers),
            name="hefting-live",
            daemon=True,
        )
        read.start()


def _read(
    process: "subprocess.Popen[bytes]",
    answers: "queue.SimpleQueue[Understanding | None]",
) -> None:
    """Pass on a process's messages until it ends; then None."""
    assert process.stdout is not None
    with suppress(OSError, ValueError):
        while (message := _receive(process.stdout)) is not None:
            answers.put(pickle.loads(message))
    answers.put(None)


def serve() -> None:
    """Understand the tasks on standard input until it ends."""
    tasks_in, answers_out = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints go to standard error, apart from the answers
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)
    settings = _receive(tasks_in)
    if settings is None:
        return
    understand = Understander(pickle.loads(settings))
    while (message := _receive(tasks_in)) is not None:
        try:
            found: Any = understand(pickle.loads(message))
        except Exception as error:
            found = HeftingError(f"{type(error).__name__}: {error}")
        with suppress(BrokenPipeError):
            _send(answers_out, pickle.dumps(found))


def _send(stream: IO[bytes], message: bytes) -> None:
    stream.write(LENGTH.pack(len(message)) + message)
    stream.flush()


def _receive(stream: IO[bytes]) -> bytes | None:
    """The next message; None at the end."""
    head = stream.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    message = stream.read(LENGTH.unpack(head)[0])
    return message if len(message) == LENGTH.unpack(head)[0] else None


class Inline:
    """Understands each task at once, for streams played as fast as possible."""

    busy = False

    def __init__(self, settings: Settings):
        self._understand = Understander(settings)
        self._found: Understanding | None = None

    def ask(self, task: Task) -> None:
        """Understand the history now."""
        self._found = self._understand(task)

    def answer(self) -> Understanding | None:
        """A new answer, once."""
        found, self._found = self._found, None
        return found
