"""The site is built without a warning, none of its links is dead, and every public name
and command has a page."""

import os
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

pytest.importorskip("sphinx", reason="sphinx is not installed: hefting[docs]")

import hefting
from hefting.cli import COMMANDS

ROOT = Path(__file__).parents[2]
MADE = ("_build", "api", "commands", "drawn", "gallery", "project")
"""Parts of docs/ that an earlier build wrote."""
STRICT = ("-n", "-W", "--keep-going", "-q")
SPHINX = """
import logging
import sys
from pathlib import PurePosixPath

import furo
from matplotlib.figure import Figure
from sphinx.cmd.build import main
from sphinx.search.en import SearchEnglish

import hefting.plots.style

logging.disable(logging.INFO)
SearchEnglish.stem = lambda self, word: word
Figure.draw_without_rendering = lambda figure: None
Figure.get_layout_engine = lambda figure: None
hefting.plots.style.DPI = 60
find, known = furo._compute_navigation_tree, {}

def found_once(context):
    folder = PurePosixPath(context["pagename"]).parent
    if folder not in known:
        known[folder] = find(context)
    return known[folder]

furo._compute_navigation_tree = found_once
sys.exit(main(sys.argv[1:]))
"""
"""Sphinx, for which the list of all pages, beside the text of each, is found once for all
pages of a folder. From these its links are the same; which of them is shown as open is
not looked at here. For each page anew it took a fifth of the time. Words to search for
are left as they are, figures are drawn as hastily as in `hasty_pictures.py`, and nothing
below a warning is logged: none of it is looked at here."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of a whole build, from a copy of the sources."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(
        ROOT / "docs",
        folder / "docs",
        ignore=lambda path, names: MADE if Path(path) == ROOT / "docs" else (),
    )
    shutil.copytree(ROOT / "examples", folder / "examples")
    shutil.copytree(ROOT / "benchmarks", folder / "benchmarks")  # draws its figures
    for path in ROOT.glob("*.md"):
        shutil.copy(path, folder)
    paths = (str(Path(hefting.__file__).parents[1]), os.environ.get("PYTHONPATH", ""))
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            SPHINX,
            *STRICT,
            "-D",
            "sphinx_gallery_conf.plot_gallery=0",  # test_examples.py runs them
            "-d",
            folder / "trees",
            folder / "docs",
            folder / "html",
        ],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    return folder / "html"


class Page(HTMLParser):
    """What a page can be linked to by, what it links to, and what it shows or runs."""

    def __init__(self, text: str):
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.own_links: list[str] = []
        """of its text, without the list of all pages beside it"""
        self._in_text = False
        self.parts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        """Keep the attributes that matter."""
        of = dict(attrs)
        self.anchors.update(of[name] for name in ("id", "name") if of.get(name))
        self._in_text = self._in_text or tag == "article"
        if tag == "a" and of.get("href"):
            self.links.append(of["href"])
            if self._in_text:
                self.own_links.append(of["href"])
        address = of.get("href" if tag == "link" else "src")
        if tag in ("link", "script", "img") and address:
            self.parts.append(address)

    def handle_endtag(self, tag):
        """Note where the text ends."""
        if tag == "article":
            self._in_text = False


@pytest.fixture(scope="module")
def pages(site):
    """Every page by its path in the site."""
    return {
        path.relative_to(site).as_posix(): Page(path.read_text())
        for path in sorted(site.rglob("*.html"))
    }


def dead(pages, present):
    """Links within a site that lead nowhere: page, address."""
    found = []
    for name, page in pages.items():
        for address in dict.fromkeys((*page.links, *page.parts)):
            if address.startswith(("https://", "data:")):
                continue
            target, anchor = urldefrag(unquote(address))
            path = os.path.normpath(os.path.join(os.path.dirname(name), target))
            path = (path if target else name).partition("?")[0]
            there = path in present
            if there and anchor and path in pages:
                there = anchor in pages[path].anchors
            if not there:
                found.append((name, address))
    return found


def test_no_link_within_the_site_is_dead(site, pages):
    present = {
        path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()
    }
    assert sum(len(page.links) for page in pages.values()) > 1000
    assert not dead(pages, present)


def test_make_docs_is_as_strict():
    (line,) = [
        line
        for line in (ROOT / "Makefile").read_text().splitlines()
        if "-m sphinx" in line
    ]
    assert {"-m", "sphinx", *STRICT} <= set(line.split())


def test_dead_links_are_seen():
    page = Page('<p id="a"><a href="#a"><a href="#b"><a href="x.html"><img src="y">')
    missing = dead({"one/p.html": page}, {"one/p.html", "one/z"})
    assert [address for _, address in missing] == ["#b", "x.html", "y"]


def test_pages_fetch_nothing_from_elsewhere(pages):
    for name, page in pages.items():
        assert not [part for part in page.parts if "//" in part], name


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_a_page(command, pages, site):
    assert f"commands/{command}.html" in pages
    text = (site / "commands" / f"{command}.html").read_text()
    assert "common options" in text or "usage" in text
    assert f"{command}.html" in pages["commands/index.html"].own_links


def test_each_example_has_a_page(pages, site):
    """With its script and its notebook."""
    examples = {path.stem for path in (ROOT / "examples").glob("*.py")}
    shown = {path for path in pages if path.startswith("gallery/")}
    assert shown == {f"gallery/{name}.html" for name in (*examples, "index")}
    for name in examples:
        assert f"{name}.html" in pages["gallery/index.html"].own_links
        suffixes = {
            Path(link).suffix for link in pages[f"gallery/{name}.html"].own_links
        }
        assert {".py", ".ipynb"} <= suffixes


def test_each_public_name_has_a_page(pages):
    for name in hefting.__all__:
        (path,) = [
            path
            for path in pages
            if path.startswith("api/") and path.endswith(f"/{name}.html")
        ]
        assert f"hefting.{name}" in pages[path].anchors
        assert path.removeprefix("api/") in pages["api/index.html"].own_links
