"""Links: those that leave the folder lead to a page that stands for the file, and names
of the library in code lead to their pages."""

import contextlib
import posixpath
import re
from importlib import import_module
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms.post_transforms import SphinxPostTransform

import hefting

PAGE_OF = {
    "README.md": "project/readme.md",
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "SECURITY.md": "project/security.md",
    "src/hefting/core/spatial.py": "conventions.md",
    "examples": "gallery/index.rst",
}
"""Page of the site that shows a file which is not in this folder."""
LINK = re.compile(r"\[([^\]]*)\]\(([^)#\s]*)((?:#[^)\s]*)?)\)")
COMMAND = re.compile(r"hefting ([a-z]+)")
FENCE = re.compile(r"(^```.*?^```$|^:::.*?$)", re.DOTALL | re.MULTILINE)
BACK = re.compile(r'<a class="viewcode-back"[^>]*>.*?</a>')
DOTTED = re.compile(r"hefting(\.\w+)+$")


def rewrite(app: Any, name: str, source: list[str]) -> None:
    """Let links that leave the folder lead to pages of the site (``source-read``)."""
    folder = posixpath.dirname(name)
    # made from files one folder above the site, whose links are right, or not Markdown
    if folder in ("project", "gallery"):
        return
    source[0] = outside(source[0], posixpath.join("docs", folder), folder)


def outside(text: str, folder: str, page_folder: str) -> str:
    """`text`, its links resolved from `folder` of the repository and rewritten for a
    page in `page_folder` of the site; those to a file without a page become code."""

    def link(match: re.Match[str]) -> str:
        words, target, anchor = match.groups()
        if not target or ":" in target:
            return match[0]
        path = posixpath.normpath(posixpath.join(folder, target))
        page = PAGE_OF.get(path)
        if page is None and path.startswith("docs/"):
            page = path.removeprefix("docs/")
        if page is None and path.startswith("examples/"):
            page = f"gallery/{posixpath.basename(path).removesuffix('.py')}.rst"
        if page is None:
            return words if "`" in words else f"`{words}`"
        return f"[{words}]({posixpath.relpath(page, page_folder or '.')}{anchor})"

    parts = FENCE.split(text)
    return "".join(
        part if i % 2 else LINK.sub(link, part) for i, part in enumerate(parts)
    )


def public(name: str) -> str:
    """A dotted name as ``import hefting`` gives it, where it does."""
    parts = name.split(".")
    for k in range(len(parts) - 1, 1, -1):
        own = getattr(hefting, parts[k], None) if parts[k] in hefting.__all__ else None
        with contextlib.suppress(ImportError):
            home = import_module(".".join(parts[:k]))
            if own is not None and getattr(home, parts[k], None) is own:
                return ".".join(("hefting", *parts[k:]))
    return name


def reference(name: str, page: str) -> addnodes.pending_xref:
    """Code that is a link where the site has a page of `name`."""
    return addnodes.pending_xref(
        "",
        nodes.literal(name, name, classes=["xref", "py"]),
        refdomain="py",
        reftype="obj",
        reftarget=public(name),
        refdoc=page,
        refexplicit=False,
        optional=True,
    )


def to_command(command: str, text: str, page: str) -> addnodes.pending_xref:
    """Code that is a link to the page of a command, if there is such a command."""
    return addnodes.pending_xref(
        "",
        nodes.literal(text, text, classes=["xref"]),
        refdomain="std",
        reftype="doc",
        reftarget=f"/commands/{command}",
        refdoc=page,
        refexplicit=True,
        optional=True,
    )


def known(role, rawtext, text, lineno, inliner, options=None, content=()):
    """Backquotes in docstrings: a link where there is something of that name, else
    code."""
    page = inliner.document.settings.env.docname
    return [reference(text, page)], []


def as_text(app: Any, env: Any, node: addnodes.pending_xref, shown: nodes.Node):
    """What is no link is the code alone (``missing-reference``)."""
    return shown if node.get("optional") else None


def without_ways_back(app: Any, page: str, template: str, context: dict, doctree: Any):
    """Take links from source to documentation out (``html-page-context``): they suppose
    that names are documented where they are defined, and ours are where they are used."""
    if page.startswith("_modules/"):
        context["body"] = BACK.sub("", context["body"])


class KnownNames(SphinxPostTransform):
    """Dotted names in code of Markdown pages become links."""

    default_priority = 5  # before references are resolved

    def run(self, **settings: Any) -> None:
        """Wrap each of them."""
        for node in list(self.document.findall(nodes.literal)):
            name = node.astext()
            if isinstance(node.parent, nodes.reference | addnodes.pending_xref):
                continue
            if DOTTED.match(name):
                node.replace_self(reference(name, self.env.docname))
            elif command := COMMAND.match(name):
                node.replace_self(to_command(command[1], name, self.env.docname))
