"""Names of sources: each opens its transport; what is none is refused in one line."""

import importlib
import socket
import sys

import pytest

from hefting.core.errors import InputError, MissingDependencyError
from hefting.online.samples import Source
from hefting.sources import SCHEMES, address_of, source_of

NAMES = {
    "tcp": "tcp://localhost:9000",
    "ws": "ws://localhost",
    "wss": "wss://localhost:8765/robot",
    "zenoh": "zenoh://localhost/7",
    "dds": "dds://0",
    "rtde": "rtde://192.168.0.2",
}


def test_every_scheme_is_a_source():
    assert set(NAMES) == set(SCHEMES)
    for name in (*NAMES.values(), "-", "log.csv"):
        source = source_of(name)
        assert isinstance(source, Source)
        source.close()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("http://robot", ("'http://' is no source", "ws://")),
        ("zenho://robot", ("use tcp://, ws://, wss://, zenoh://",)),
        ("tcp://", ("which host?",)),
        ("tcp://robot", ("which port?", "as in tcp://localhost:9000")),
        ("tcp://robot:99999", ("port is not one",)),
        ("tcp://robot:x", ("port is not one",)),
        ("ws://[::1", ("which host?",)),
        ("dds://", ("domain is a number",)),
        ("dds://233", ("0 to 232",)),
        ("dds://-1", ("domain is a number",)),
        ("zenoh://robot/x", ("domain is a number",)),
    ],
)
def test_bad_names_are_refused(name, words):
    with pytest.raises(InputError) as told:
        source_of(name)
    for word in words:
        assert word in str(told.value)
    assert "\n" not in str(told.value)


def test_hosts_and_ports_are_as_given():
    assert address_of("ws://[::1]:80/a/b/", 8765, "") == ("::1", 80, "a/b")
    assert address_of("zenoh://Robot.local", 7447, "") == ("robot.local", 7447, "")


def try_briefly(monkeypatch):
    """Zenoh tries again for 3 s; here for 0.1 s."""
    config = importlib.import_module("zenoh").Config

    class Hasty:
        def __init__(self):
            self.own = config()

        def insert_json5(self, key, value):
            own = "100" if key == "connect/timeout_ms" else value
            self.own.insert_json5(key, own)

    monkeypatch.setattr("zenoh.Config", Hasty)
    opened = importlib.import_module("zenoh").open
    monkeypatch.setattr("zenoh.open", lambda made: opened(made.own))


@pytest.mark.parametrize("scheme", ["tcp", "ws", "zenoh", "rtde"])
def test_a_host_that_refuses_is_told(scheme, monkeypatch):
    module = {"ws": "websockets", "zenoh": "zenoh"}.get(scheme)
    if module:
        pytest.importorskip(module, reason=f"{scheme}:// needs {module}")
    if scheme == "zenoh":
        try_briefly(monkeypatch)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    source = source_of(f"{scheme}://127.0.0.1:{port}")
    with pytest.raises(InputError, match="cannot be reached"):
        source.open()
    source.close()


@pytest.mark.parametrize(
    ("name", "module", "distribution"),
    [
        ("ws://127.0.0.1:1", "websockets.sync.client", "websockets"),
        ("zenoh://127.0.0.1:1", "zenoh", "eclipse-zenoh"),
        ("dds://0", "cyclonedds.builtin", "cyclonedds"),
    ],
)
def test_a_missing_library_is_told(name, module, distribution, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingDependencyError) as told:
        source_of(name).open()
    assert f"{distribution} is not installed" in str(told.value)
    assert "pip install 'hefting[live]'" in str(told.value)


def test_no_transport_is_imported_before_it_is_opened():
    """Names of sources are checked where no transport's library is there."""
    assert all(importlib.import_module(module).SOURCE for module in SCHEMES.values())
    heavy = {"websockets", "zenoh", "cyclonedds", "rosbags", "foxglove"}
    code = "from hefting.sources import source_of, SCHEMES; import sys\n"
    code += f"[source_of(name) for name in {list(NAMES.values())}]\n"
    code += f"assert not {heavy} & set(sys.modules)"
    import subprocess

    subprocess.run([sys.executable, "-c", code], check=True)
