"""A file that Foxglove's writer of MCAP writes to."""

from typing import BinaryIO


class McapOutput:
    """A file for Foxglove's writer, which logs errors and goes on: the first is kept,
    and nothing is written after it."""

    def __init__(self, stream: BinaryIO):
        self._stream = stream
        self.error: OSError | None = None

    def write(self, data: bytes | bytearray) -> int:
        """Write, unless that failed before."""
        if self.error is None:
            try:
                return self._stream.write(data)
            except OSError as error:
                self.error = error
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place in the file."""
        return self._stream.seek(offset, whence)

    def flush(self) -> None:
        """Nothing: the file is flushed when it is closed."""
