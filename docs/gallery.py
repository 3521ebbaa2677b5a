"""`python docs/gallery.py gallery.html`: runs the blocks of gallery.md and writes the page,
each block with what a notebook shows of its last line."""

import ast
import os
import re
import sys
import tempfile
from html import escape
from pathlib import Path
from typing import Any

from hefting.core.files import write_atomically
from hefting.simulation import demo

SOURCE = Path(__file__).with_suffix(".md")
HEAD = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Hefting: gallery</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
:root { color-scheme: light dark; }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; }
pre { overflow-x: auto; padding: 0.7rem 1rem; border-radius: 4px; background: rgba(128,128,128,0.13); font-size: 13px; }
img { max-width: 100%; height: auto; }
h2 { margin-top: 2.5rem; }
</style></head><body>
"""


def main() -> None:
    """Write the page to the path given."""
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/gallery.py gallery.html")
    path = Path(sys.argv[1]).absolute()
    with tempfile.TemporaryDirectory() as folder:
        demo.run(Path(folder) / "demo", pictures=False)
        os.chdir(folder)
        page = page_of(SOURCE.read_text(encoding="utf-8"))
        os.chdir(path.parent)
    write_atomically(path, page)
    print(f"wrote {path}")


def page_of(text: str) -> str:
    """The page of a text with blocks of Python, which are run in the working folder."""
    names: dict[str, Any] = {}
    parts = re.split(r"```python\n(.*?)```\n", text, flags=re.DOTALL)
    body = []
    for i, part in enumerate(parts):
        if i % 2 == 0:
            body.append(prose(part))
        else:
            body += [f"<pre>{escape(part.strip())}</pre>", shown(part, names)]
    return HEAD + "\n".join(body) + "\n</body></html>\n"


def shown(code: str, names: dict[str, Any]) -> str:
    """What a notebook shows of a block's last line, after the block was run."""
    tree = ast.parse(code)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, str(SOURCE), "exec"), names)
    if last is None:
        return ""
    value = eval(compile(ast.Expression(last.value), str(SOURCE), "eval"), names)
    return value._repr_html_() or f"<pre>{escape(repr(value))}</pre>"


def prose(text: str) -> str:
    """Headings and paragraphs of the few kinds of Markdown that the page has."""
    found = []
    for paragraph in filter(None, map(str.strip, text.split("\n\n"))):
        words = re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(paragraph))
        if heading := re.match(r"(#+) (.*)", words):
            level = len(heading[1])
            found.append(f"<h{level}>{heading[2]}</h{level}>")
        else:
            found.append(f"<p>{words}</p>")
    return "\n".join(found)


if __name__ == "__main__":
    main()
