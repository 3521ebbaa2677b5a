"""Text in ASCII, and commands that are printed to be copied."""

import codecs

import pytest

from hefting.core.errors import (
    LONGEST_PLACE,
    InputError,
    ascii_of,
    file_word,
    spell_out,
)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("kg m²", "kg m2"),
        ("10⁻³ ± 3°", "10^-3 +/- 3 deg"),
        ("┏━┳┓", "+-++"),
        ("Prüfling", "Prufling"),
        ("日", ""),
    ],
)
def test_signs_are_spelled_out(text, plain):
    assert ascii_of(text) == plain


def test_what_an_encoding_has_stays():
    codecs.register_error("spell-out-here", spell_out)
    for encoding, plain in (
        ("utf-8", "² ± ┃ 日 ?"),
        ("cp1252", "² ± | ? ?"),
        ("ascii", "2 +/- | ? ?"),
    ):
        text = "² ± ┃ 日 \udcf6".encode(encoding, "spell-out-here")
        assert text.decode(encoding) == plain


def test_what_cannot_be_read_is_not_its_business():
    codecs.register_error("spell-out-here", spell_out)
    with pytest.raises(UnicodeDecodeError):
        b"\xff".decode("utf-8", "spell-out-here")


def test_a_file_is_not_taken_for_an_option():
    assert [file_word(name) for name in ("-a.csv", "b.csv")] == ["./-a.csv", "b.csv"]


def test_a_text_in_place_of_a_path_is_cut_in_an_error():
    for length in (LONGEST_PLACE, LONGEST_PLACE + 1):
        said = str(InputError("is not a file", "x" * length))
        assert (" ...: is not a file" in said) is (length > LONGEST_PLACE)
        assert len(said) == LONGEST_PLACE + len(": is not a file")
