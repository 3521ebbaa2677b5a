"""Docstrings as reStructuredText: formulas in them are written as plain text, with bars
for norms, and stand as indented blocks."""

import re
from pathlib import Path
from typing import Any

from jinja2 import FileSystemLoader
from jinja2.sandbox import SandboxedEnvironment
from numpydoc import docscrape_sphinx

CODE = re.compile(r"(`+[^`]+`+)")
"""Code within a line, which stays as it is."""

TEMPLATES = SandboxedEnvironment(
    loader=FileSystemLoader(Path(docscrape_sphinx.__file__).with_name("templates"))
)


def compile_templates_once() -> None:
    """Let numpydoc keep its template, which it compiles anew for each docstring: a tenth
    of a build."""
    docscrape_sphinx.SandboxedEnvironment = lambda loader: TEMPLATES


def prepare(
    app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]
) -> None:
    """Escape bars, and mark indented blocks before the first section as literal
    (``autodoc-process-docstring``)."""
    sections = [k for k, line in enumerate(lines) if set(line.strip()) == {"-"}]
    first = sections[0] - 1 if sections else len(lines)
    found: list[str] = []
    literal = False
    for k, line in enumerate(lines):
        indented = line.startswith("    ") and k < first
        if indented and not literal and _begins(lines, k):
            found += ["::", ""]
            literal = True
        elif line.strip() and not indented:
            literal = False
        found.append(line if literal else escaped(line))
    lines[:] = found


def _begins(lines: list[str], k: int) -> bool:
    """Whether an indented line begins a block that is not yet marked as literal."""
    before = [line for line in lines[:k] if line.strip()]
    marked = before and before[-1].rstrip().endswith("::")
    return k > 0 and not lines[k - 1].strip() and not marked


def escaped(line: str) -> str:
    """A line with bars that are no markup."""
    parts = CODE.split(line)
    return "".join(
        part if i % 2 else part.replace("|", "\\|") for i, part in enumerate(parts)
    )
