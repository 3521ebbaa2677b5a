"""Pages that are made at build: one a public name, one a module that pages mention, one
a command, and the project's files at the top."""

import contextlib
import inspect
import os
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import hefting
from hefting.cli import COMMANDS, build_parser, commands_of
from hefting.estimators import METHODS
from site_parts import links

MADE = ("api", "commands", "project")
"""Folders that hold nothing but these pages."""
KINDS = {
    "functions": "Functions",
    "classes": "Classes",
    "methods": "Methods",
    "errors": "Errors",
    "values": "Values",
    "modules": "Modules that these pages mention",
}
"""Folder of each kind of name, and its heading."""
NAMES_OF = "What `import hefting` gives, and the modules that other pages name."
HEAD = "| | |\n|---|---|\n"
ALONE = "---\norphan: true\n---\n"
"""Begins a page that is found through a list and not in the navigation, which would
hold more names than anyone reads."""
FILES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
MENTIONED = re.compile(r"`(hefting(?:\.\w+)+)`|from (hefting(?:\.\w+)+) import")


def write(folder: Path) -> None:
    """Write all of them below `folder`, and remove those that are no more. A page that
    stays as it is keeps its time, so that a second build reads little."""
    made = dict(all_pages(folder))
    for name, text in made.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for part in MADE:
        for path in (folder / part).rglob("*.md"):
            if path.relative_to(folder).as_posix() not in made:
                path.unlink()


def all_pages(folder: Path) -> Iterator[tuple[str, str]]:
    """Path below `folder` and text of each page."""
    modules = mentioned_modules(folder)
    yield "api/index.md", list_of_names(modules)
    for name in hefting.__all__:
        value = getattr(hefting, name)
        yield f"api/{kind_of(name, value)}/{name}.md", page_of_name(name, value)
    for module in modules:
        yield f"api/modules/{module.__name__}.md", page_of_module(module)
    yield "commands/index.md", list_of_commands()
    for name in COMMANDS:
        yield f"commands/{name}.md", page_of_command(name)
    for name in FILES:
        text = (folder.parent / name).read_text(encoding="utf-8")
        page = f"project/{name.lower()}"
        yield page, links.outside(text, "", "project")


def list_of_names(modules: list[ModuleType]) -> str:
    """Every public name and module with what it is, by kind."""
    rows: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for name in sorted(hefting.__all__, key=str.lower):
        value = getattr(hefting, name)
        kind = kind_of(name, value)
        rows[kind].append(row(f"{kind}/{name}", name, first_sentence(value)))
    for module in modules:
        name = module.__name__
        rows["modules"].append(row(f"modules/{name}", name, first_sentence(module)))
    parts = [f"## {KINDS[kind]}\n\n{HEAD}{''.join(rows[kind])}" for kind in KINDS]
    return "# Python\n\n" + NAMES_OF + "\n\n" + "\n".join(parts)


def list_of_commands() -> str:
    """Every command with what it does."""
    rows = "".join(row(name, f"hefting {name}", COMMANDS[name]) for name in COMMANDS)
    return f"# Commands\n\nWhat `hefting COMMAND --help` prints.\n\n{HEAD}{rows}"


def row(page: str, name: str, text: str) -> str:
    """A row of a list: a link, and what it leads to."""
    return f"| [`{name}`]({page}.md) | {text.replace('|', chr(92) + '|')} |\n"


def first_sentence(value: Any) -> str:
    """What a docstring says first, without the name that it may begin with."""
    if not (callable(value) or isinstance(value, ModuleType)):
        return ""
    text = " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split())
    if isinstance(value, ModuleType):
        text = text.partition(": ")[2] or text
    return re.split(r"(?<=[^. ]{3}\.) ", text)[0]


def kind_of(name: str, value: Any) -> str:
    """Folder of a public name: names that differ in case alone are apart."""
    if name in METHODS:
        return "methods"
    if isinstance(value, type):
        return "errors" if issubclass(value, Exception) else "classes"
    return "functions" if callable(value) else "values"


def page_of_name(name: str, value: Any) -> str:
    """A page of one public name."""
    if not callable(value):
        return page(f"hefting.{name}", f".. autodata:: hefting.{name}")
    if not isinstance(value, type):
        return page(f"hefting.{name}", f".. autofunction:: hefting.{name}")
    inherited = (
        ":show-inheritance:" if name in METHODS else ":inherited-members: Exception"
    )
    options = f"\n   :members:\n   {inherited}"
    return page(f"hefting.{name}", f".. autoclass:: hefting.{name}{options}")


def page_of_module(module: ModuleType) -> str:
    """A page of what a module makes public, but for what has a page of its own."""
    public = {id(getattr(hefting, name)) for name in hefting.__all__}
    names = getattr(module, "__all__", None) or [
        name
        for name, value in vars(module).items()
        if getattr(value, "__module__", None) == module.__name__
    ]
    own = {name: getattr(module, name) for name in names if not name.startswith("_")}
    lines = [f".. automodule:: {module.__name__}", ""]
    for name, value in own.items():
        if id(value) in public or isinstance(value, ModuleType):
            continue
        if isinstance(value, type):
            lines += [f".. autoclass:: {module.__name__}.{name}", "   :members:", ""]
        elif inspect.isroutine(value):
            lines += [f".. autofunction:: {module.__name__}.{name}", ""]
    return page(module.__name__, "\n".join(lines))


def mentioned_modules(folder: Path) -> list[ModuleType]:
    """Modules that pages name, or whose names they use."""
    texts = [path.read_text(encoding="utf-8") for path in sources(folder)]
    texts.append((folder.parent / "README.md").read_text(encoding="utf-8"))
    names = {a or b for text in texts for a, b in MENTIONED.findall(text)}
    found = {module_of(name) for name in names} - {"hefting"}
    return [import_module(name) for name in sorted(found)]


def sources(folder: Path) -> list[Path]:
    """Pages that are written by hand."""
    return [
        path
        for path in sorted(folder.rglob("*.md"))
        if path.relative_to(folder).parts[0] not in (*MADE, "_build", "drawn")
    ]


def module_of(dotted: str) -> str:
    """The longest part of a dotted name that is a module."""
    parts = dotted.split(".")
    for cut in range(len(parts), 0, -1):
        with contextlib.suppress(ImportError):
            return import_module(".".join(parts[:cut])).__name__
    raise ImportError(dotted)


def page_of_command(name: str) -> str:
    """What ``hefting NAME --help`` prints, on 80 columns."""
    columns = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "80"
    try:
        text = commands_of(build_parser([name]))[name].format_help()
    finally:
        del os.environ["COLUMNS"]
        if columns is not None:
            os.environ["COLUMNS"] = columns
    back = "[Commands](index.md)"
    return f"{ALONE}{back}\n\n# hefting {name}\n\n```text\n{text.rstrip()}\n```\n"


def page(title: str, text: str) -> str:
    """A page of reStructuredText, as docstrings are, under a title."""
    back = "[Python](../index.md)"
    return f"{ALONE}{back}\n\n# {title}\n\n```{{eval-rst}}\n{text.rstrip()}\n```\n"
