"""JSON that would take much more memory than its file is large."""

import pytest

from hefting.core import files
from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_json


@pytest.mark.parametrize("unit", [b"[],", b"[1],", b"{},", b'{"a":[]},', b"[[[]]],"])
def test_too_many_lists(tmp_path, unit):
    """Lists of nothing: 100 MB of them took 5.7 GB."""
    path = tmp_path / "x.json"
    path.write_bytes(b"[" + unit * files.MAX_LISTS + b"0]")
    with pytest.raises(InputError, match="more than 1,000,000 lists"):
        read_json(path)


@pytest.mark.parametrize("opened", [b"[", b'{"a":'])
def test_too_deep(tmp_path, opened):
    path = tmp_path / "x.json"
    path.write_bytes(opened * 200_000)
    with pytest.raises(InputError, match="is not JSON"):
        read_json(path)


def test_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_JSON", 100)
    path = tmp_path / "x.json"
    path.write_text("[" + "1," * 60 + "1]")
    with pytest.raises(InputError, match="larger than 100 bytes"):
        read_json(path)


def test_xml_that_declares_its_type_is_refused_before_anything_is_expanded():
    """Entities could be expanded to gigabytes, or name files of the machine."""
    seen = []

    def parse(text: bytes):
        parse_xml(text, "x.xml", lambda tag, *_: seen.append(tag), lambda *_: None)

    parse(b"<a><b/></a>")
    assert seen == ["a", "b"]
    for inside in (b"", b'[<!ENTITY e "x">]', b'SYSTEM "file:///etc/passwd"'):
        with pytest.raises(InputError, match="document type declaration"):
            parse(b"<!DOCTYPE a " + inside + b"><a>&e;</a>")
    assert seen == ["a", "b"]


def test_xml_of_many_elements_that_are_all_deep():
    """Whoever looks at the elements around each would take minutes."""
    deep = b"<a>" * 5000 + b"<b/>" * 50_000 + b"</a>" * 5000
    with pytest.raises(InputError, match="too many deep ones"):
        parse_xml(deep, "x.xml", lambda *_: None)
