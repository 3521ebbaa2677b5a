"""Commands that are printed to be copied."""

import shlex

import pytest

from hefting.core.shell import file_word, typed


@pytest.mark.parametrize("name", ["a.csv", "a b;ü.csv", "it's.csv", "$HOME`x`", ""])
def test_a_shell_reads_back_the_words(name):
    words = ["hefting", "identify", name, "--shape", "MESH"]
    assert shlex.split(typed(words)) == words


def test_plain_words_stay_as_they_are():
    assert typed(["hefting", "identify", "log.csv"]) == "hefting identify log.csv"


def test_a_file_is_not_taken_for_an_option():
    assert [file_word(name) for name in ("-a.csv", "b.csv")] == ["./-a.csv", "b.csv"]
