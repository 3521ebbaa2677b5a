"""Tasks and their failures, and a local worker process, which answers tasks in the order
in which it gets them.

It ends with the process that started it, even if that is killed: its thread that waits
for tasks reads the end of the stream then.
"""

import hashlib
import os
import pickle
import signal
import threading
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple, Protocol

import hefting
from hefting.core.threads import ONE_THREAD

SPAWN = get_context("spawn")

LAST_BREATH = 5.0
"""[s] Longest wait for a process to end after it has closed its end of the stream."""


@dataclass(frozen=True)
class Lost:
    """In place of the result of a task at which every worker died."""

    reason: str
    """One line."""


@dataclass(frozen=True)
class Died:
    """The worker of a task died, perhaps because of that task."""

    reason: str
    """One line."""


class Task(NamedTuple):
    """An argument of a function, numbered."""

    number: int
    argument: Any


class Workers(Protocol):
    """Processes that run tasks: local ones, or those of a cluster."""

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task and its result or `Died`, as they finish."""
        ...

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task without others, which might be at fault; `Died` when its
        worker died in all attempts."""
        ...

    def close(self) -> None:
        """End local processes, or disconnect from the cluster."""
        ...


class Worker:
    """A worker process, in the process that started it."""

    def __init__(self) -> None:
        """Start it; `OSError` when the system has no room for one more."""
        self.connection, theirs = SPAWN.Pipe()
        self.process = SPAWN.Process(target=_serve, args=(theirs,), daemon=True)
        try:
            with _one_thread_each(), _interrupts_blocked():
                self.process.start()
        finally:
            theirs.close()
        self.ready = False
        """whether it waits for tasks, or runs one"""
        self.held: deque[Task] = deque()
        """tasks that it has not answered; it runs the first"""

    def give(self, function: Callable[[Any], Any], task: Task) -> None:
        """Have it run a task after those that it holds."""
        message = pickle.dumps((function, task.argument))
        self.held.append(task)
        with suppress(OSError):  # `answer` raises that it is dead
            self.connection.send_bytes(message)

    def answer(self) -> tuple[Task, Any] | None:
        """Wait for its first task and result; None for the message that it is ready.

        Raises `EOFError` when the process is dead, and what the function raised.
        """
        try:
            message = self.connection.recv_bytes()
        except OSError as error:  # it died during an answer
            raise EOFError from error
        if not self.ready:
            self.ready = True
            return None
        task = self.held.popleft()
        succeeded, result = pickle.loads(message)
        if not succeeded:
            raise result
        return task, result

    def end(self) -> None:
        """Kill it."""
        self.connection.close()
        self.process.kill()
        self.process.join()
        self.process.close()

    def cause_of_death(self) -> str:
        """How it ended by itself, as a predicate of a sentence."""
        self.process.join(LAST_BREATH)
        status = self.process.exitcode or 0
        if status < 0:
            return f"was killed by {signal.Signals(-status).name}"
        return f"ended with status {status}"


def _serve(connection: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    messages: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_receive, args=(connection, messages), daemon=True).start()
    connection.send_bytes(b"")
    while True:
        connection.send_bytes(_answer(messages.get()))


def _receive(connection: Connection, messages: SimpleQueue[bytes]) -> None:
    """Queue messages as they come, so that the sender never waits for a task to finish;
    end this process with the sender."""
    try:
        while True:
            messages.put(connection.recv_bytes())
    finally:
        os._exit(0)


def _answer(message: bytes) -> bytes:
    try:
        function, task = pickle.loads(message)
        return pickle.dumps((True, function(task)))
    except Exception as error:
        error.add_note(f"In a worker process:\n{traceback.format_exc().rstrip()}")
        return _pickled_error(error)


def _pickled_error(error: Exception) -> bytes:
    """The error, or its text where it cannot be pickled and read again."""
    try:
        message = pickle.dumps((False, error))
        pickle.loads(message)
    except Exception:
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
    return message


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let processes that start within the block compute on one thread each, which is as
    fast and gives the same result to the last bit."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C for processes that start within the block, as it reaches them too;
    this process receives it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # which would unblock them
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@cache
def source_version() -> str:
    """A hash of this library's source [64 hexadecimal digits]."""
    root = Path(hefting.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()
