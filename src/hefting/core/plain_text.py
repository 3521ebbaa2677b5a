"""Plain ASCII text for controllers, and terminals and pipes of other encodings."""

import unicodedata

PLAIN = str.maketrans(
    {"°": " deg", "±": "+/-", "·": "*", "×": "x", "→": "->", "–": "-", "−": "-"}
    | {"µ": "u", "…": "...", "⁻": "^-"}
    | dict(zip("┏┳┓┡╇┩├┼┤└┴┘━─┃│", "++++++++++++--||", strict=True))
)
"""Signs that have no letter or digit below them."""


def ascii_of(text: str) -> str:
    """`text` in ASCII: letters without accents, raised digits as digits, no others."""
    decomposed = unicodedata.normalize("NFKD", text.translate(PLAIN))
    return decomposed.encode("ascii", "ignore").decode()


def spell_out(error: UnicodeError) -> tuple[str, int]:
    """For `codecs.register_error`: characters that an encoding lacks in ASCII, or as a
    question mark."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(ascii_of(sign) or "?" for sign in signs), error.end


def file_word(path: str) -> str:
    """The path of a file as an argument that does not look like an option."""
    return f"./{path}" if path.startswith("-") else path
