"""Reading JSON and XML: bounded, UTF-8 wherever it runs, and whatever is wrong in one
line."""

import json
import os

import pytest

from hefting.core import files
from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_json


def test_json_is_read_as_utf_8_in_any_locale(tmp_path):
    path = tmp_path / "a.json"
    for mark in (b"", b"\xef\xbb\xbf"):
        path.write_bytes(
            mark + json.dumps({"name": "Prüfling"}, ensure_ascii=False).encode()
        )
        assert read_json(path) == {"name": "Prüfling"}


def test_json_that_cannot_be_read_is_one_line(tmp_path, monkeypatch):
    path = tmp_path / "a.json"
    monkeypatch.setattr(files, "MAX_JSON", 300_000)
    cases = {
        b"": "is not JSON",
        b"{": "is not JSON",
        b"\xff\xfe\x00": "is not JSON",
        b"[" * 200_000: "is not JSON",
    }
    for content, words in {
        **cases,
        b" " * 300_000 + b"1": "is larger than 300,000 bytes",
    }.items():
        path.write_bytes(content)
        with pytest.raises(InputError, match=words) as caught:
            read_json(path)
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)
    path.write_bytes(b" " * 299_999 + b"1")
    assert read_json(path) == 1
    with pytest.raises(InputError, match="cannot be read"):
        read_json(tmp_path / "absent.json")
    if os.path.exists("/dev/zero"):  # which has no end
        with pytest.raises(InputError, match="a pipe or a device"):
            read_json("/dev/zero")


def test_xml_is_read_to_its_depth_and_no_deeper():
    """10,000 elements in each other, with the offset of each tag."""
    started, ended = [], []

    def parse(depth):
        started.clear()
        ended.clear()
        data = b"<a>" * depth + b"</a>" * depth
        parse_xml(
            data,
            "deep",
            lambda _, __, at, *___: started.append(at),
            lambda _, at, *__: ended.append(at),
        )

    parse(10_000)
    assert started == list(range(0, 30_000, 3))
    assert ended == list(range(30_000, 70_000, 4))
    with pytest.raises(
        InputError, match="deep: has elements nested deeper than 10,000"
    ):
        parse(10_001)


def test_what_is_written_has_the_permissions_of_new_files(tmp_path):
    """And not those of a temporary one, which nobody else may read."""
    before = os.umask(0o027)
    try:
        files.write_atomically(tmp_path / "a.json", "{}")
    finally:
        os.umask(before)
    if os.name == "posix":
        assert (tmp_path / "a.json").stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_what_is_replaced_keeps_its_permissions(tmp_path):
    """A model that a group may write is so after an export into it."""
    path = tmp_path / "robot.urdf"
    path.write_text("before")
    path.chmod(0o664)
    before = os.umask(0o077)
    try:
        files.write_atomically(path, "after")
    finally:
        os.umask(before)
    assert path.read_text() == "after"
    assert path.stat().st_mode & 0o777 == 0o664
