"""HTML: elements whose text is escaped."""

from collections.abc import Iterable, Sequence
from html import escape as _escape


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def escape(text: object) -> Markup:
    """Any text as HTML that shows it as it is."""
    return text if isinstance(text, Markup) else Markup(_escape(str(text)))


def element(tag: str, *content: object, **attributes: object) -> Markup:
    """An element with its content; in names of attributes ``_`` stands for ``-``, a
    trailing one is left out, as in ``class_``."""
    named = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{_escape(str(value))}"'
        for name, value in attributes.items()
        if value is not None
    )
    return Markup(f"<{tag}{named}>{''.join(map(escape, content))}</{tag}>")


def join(parts: Iterable[object], between: str = "") -> Markup:
    """Several, one after the other."""
    return Markup(between.join(escape(part) for part in parts))


def items(lines: Iterable[object], **attributes: object) -> Markup:
    """A list with an item a line; nothing without any."""
    rows = [element("li", line) for line in lines]
    return element("ul", *rows, **attributes) if rows else Markup()


def table(head: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """A table in a box that scrolls where it is too wide; the first cell of each row
    names it."""
    top = element("tr", *(element("th", name, scope="col") for name in head))
    body = [
        element(
            "tr",
            element("th", row[0], scope="row"),
            *(element("td", cell) for cell in row[1:]),
        )
        for row in rows
    ]
    whole = element("table", element("thead", top), element("tbody", *body))
    return element("div", whole, class_="wide")


def terms(pairs: Iterable[tuple[object, object]]) -> Markup:
    """A list of terms, and what each is."""
    rows = [
        element("div", element("dt", name), element("dd", what)) for name, what in pairs
    ]
    return element("dl", *rows)
