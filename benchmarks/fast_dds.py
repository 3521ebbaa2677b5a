"""A sender of ROS 2 messages through eProsima's Fast DDS, the middleware that most ROS 2
installations have: of Debian, ``apt install libfastrtps-dev libfastcdr-dev g++``."""

import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).with_suffix(".cpp")
HEADER = "/usr/include/fastdds/dds/domain/DomainParticipant.hpp"


def is_installed() -> bool:
    """Whether Fast DDS and a compiler are."""
    return Path(HEADER).exists() and shutil.which("g++") is not None


class FastDds:
    """Reliable writers of a domain: topics without their prefix, and types, both as ROS
    has them. Raises `SystemExit` where Fast DDS is not installed."""

    def __init__(self, domain: int, topics: Mapping[str, str]):
        if not is_installed():
            raise SystemExit("Fast DDS is missing: apt install libfastrtps-dev g++")
        self._library = library()
        participant = self._library.participant(domain)
        self._writers: dict[str, int] = {}
        for topic, kind in topics.items():
            package, _, name = kind.rpartition("/")
            named = f"{package.replace('/', '::')}::dds_::{name}_"
            self._writers[topic] = self._library.writer(
                participant, f"rt{topic}".encode(), named.encode()
            )

    def wait_for_readers(self) -> None:
        """Until each topic has one."""
        while not all(self._library.readers(each) for each in self._writers.values()):
            time.sleep(0.01)

    def send(self, topic: str, data: bytes) -> None:
        """A serialised message. Raises `RuntimeError` where it is not sent."""
        if not self._library.send_message(self._writers[topic], data, len(data)):
            raise RuntimeError(f"a message of {topic} was not sent")


@cache
def library() -> ctypes.CDLL:
    """``fast_dds.cpp``, compiled; kept, as that of Python is, until it changes."""
    kept = SOURCE.parent / "__pycache__" / "fast_dds.so"
    if not kept.exists() or kept.stat().st_mtime < SOURCE.stat().st_mtime:
        kept.parent.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=kept.parent) as folder:
            made = Path(folder) / "fast_dds.so"
            flags = ["-std=c++17", "-O1", "-Wall", "-Werror", "-shared", "-fPIC"]
            libraries = ["-lfastrtps", "-lfastcdr"]
            subprocess.run(["g++", *flags, SOURCE, "-o", made, *libraries], check=True)
            made.replace(kept)
    loaded = ctypes.CDLL(str(kept))
    pointer, text = ctypes.c_void_p, ctypes.c_char_p
    loaded.participant.argtypes = [ctypes.c_uint]
    loaded.participant.restype = pointer
    loaded.writer.argtypes = [pointer, text, text]
    loaded.writer.restype = pointer
    loaded.readers.argtypes = [pointer]
    loaded.send_message.argtypes = [pointer, text, ctypes.c_uint]
    loaded.send_message.restype = ctypes.c_bool
    return loaded
