"""What results show of themselves in a notebook: the library's numbers, verdict first,
and nothing from outside but text."""

import base64
import os
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import hefting
import hefting.notebook
from browser import LOOKS, browsing, needs_browser
from hasty_pictures import draw_hastily
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Message
from hefting.core.recording import Recording, Stream
from hefting.identification import Comparison, identify
from hefting.identification.agreement import Agreement
from hefting.identification.compare import compare
from hefting.notebook import KINDS, html_of
from hefting.scene import plus_minus
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids

POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)>&amp;$\\frac{$`x`"
TAGS = {"div", "b", "table", "thead", "tbody", "tr", "th", "td", "ul", "li", "code"}
TAGS |= {"img"}
VOID = {"img"}
ATTRIBUTES = {"class", "style", "alt", "src"}


class Page(HTMLParser):
    """Elements and text of a block; fails unless it is well-formed and harmless."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.open, self.words, self.cells, self.pictures = [], [], [], []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        assert tag in TAGS
        assert {name for name, _ in attrs} <= ATTRIBUTES
        self.open += [] if tag in VOID else [tag]
        if tag == "tr":
            self.cells.append([])
        if tag in ("td", "th"):
            self.cells[-1].append("")
        if tag == "img":
            self.pictures.append(dict(attrs)["src"])

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)
        if {"td", "th"} & set(self.open):
            self.cells[-1][-1] += data

    def handle_comment(self, data):
        raise AssertionError(data)

    handle_decl = handle_pi = unknown_decl = handle_comment

    @property
    def text(self):
        return "".join(self.words)


@pytest.fixture(autouse=True)
def hasty(request, monkeypatch):
    """Pictures are laid out only where one sees them."""
    if request.function is not test_in_a_browser:
        draw_hastily(monkeypatch)


@pytest.fixture(scope="module")
def log():
    tool = hammer()
    body = tool.parameters.moved(POSE)
    return simulate(
        UR5.motion(sinusoids(5.0, 100.0, 1.5)), body, pose_noise=(1e-4, 3.5e-4), seed=3
    )


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), pose=POSE)


@pytest.fixture(scope="module")
def found(log, shape):
    return identify(log, shape)


@pytest.fixture(scope="module")
def compared(log):
    """By every method."""
    return compare(log, methods="all")


def svg_of(page):
    (source,) = page.pictures
    head, _, data = source.partition(",")
    assert head == "data:image/svg+xml;base64"
    return base64.b64decode(data).decode()


def test_the_numbers_are_those_of_the_library(found):
    page = Page(found._repr_html_())
    assert page.cells[0] == ["quantity", "estimate ± 95 %", "from", "to", "unit"]
    rows = {row[0]: row[1:] for row in page.cells}
    estimate = found.estimate
    low, high = estimate.intervals["mass"]
    half = max(high - estimate.mass, estimate.mass - low)
    assert rows["mass"][0] == plus_minus(estimate.mass, half)
    assert float(rows["mass"][1]) == pytest.approx(low, abs=1e-4)
    assert float(rows["mass"][2]) == pytest.approx(high, abs=1e-4)
    assert rows["mass"][3] == "kg"
    for i, axis in enumerate("xyz"):
        value, unit = rows[f"COM {axis}"][0], rows[f"COM {axis}"][3]
        number, half = (float(part.replace("−", "-")) for part in value.split(" ± "))
        ends = 1e3 * estimate.intervals["center_of_mass"][:, i]
        center = 1e3 * estimate.center_of_mass[i]
        # two digits of the half-width are shown
        assert number == pytest.approx(center, abs=0.051 * half)
        assert half == pytest.approx(np.abs(ends - center).max(), rel=0.05)
        assert unit == "mm"
    scale = {"10⁻³ kg m²": 1e3, "kg m²": 1.0, "10⁻⁶ kg m²": 1e6}
    for name, at in {"Jxx": (0, 0), "Jzz": (2, 2), "Jxy": (0, 1)}.items():
        value, _, _, unit = rows[f"{name} at COM"]
        number, half = (float(part.replace("−", "-")) for part in value.split(" ± "))
        assert number == pytest.approx(
            scale[unit] * estimate.inertia[at], abs=0.051 * half
        )


def test_the_verdict_comes_first_then_reasons_then_warnings(found):
    doubt = Message("no-object", "nothing is held: see `tool`", "error", "tool")
    more = Message("no-shape", "no shape given: give `shape`")
    estimate = replace(found.estimate, warnings=(more, doubt))
    html = estimate._repr_html_()
    text = Page(html).text
    assert text.startswith("verdict: do not use")
    assert "nothing is held: see <code>tool</code>" in html
    places = [
        text.index(part) for part in ("nothing is held", "warning: no shape", "mass")
    ]
    assert places == sorted(places)
    assert text.count("nothing is held") == 1


def test_what_is_open_is_open(log):
    few = {
        name: Stream(np.arange(20.0), log[name].values[::25])
        for name in ("orientation", "wrench")
    }
    static = identify(Recording(few, static=True), bias="none")
    rows = {row[0]: row[1:] for row in Page(static._repr_html_()).cells}
    assert rows["Jxx at COM"][:3] == ["open", "", ""]
    assert "inertia open" in svg_of(Page(static._repr_html_()))


def test_without_intervals_there_are_none(found):
    alone = Estimate("test", found.estimate.parameters, samples=3)
    rows = {row[0]: row[1:] for row in Page(alone._repr_html_()).cells}
    assert rows["mass"] == [plus_minus(alone.mass, None), "", "", "kg"]


def test_of_nothing_there_is_a_table_too():
    """Parameters that are all zero: no COM, no moment."""
    page = Page(Estimate("OLS", InertialParameters(np.zeros(10)), 3)._repr_html_())
    assert {row[0]: row[1] for row in page.cells}["mass"] == "0"


def test_every_kind_escapes_what_comes_from_outside(compared, found, shape):
    """Names of files, methods, topics, estimates, and messages about columns."""
    message = Message("odd", f"column {HOSTILE} is odd: give `{HOSTILE}`", "error")
    hostile = replace(
        found.estimate,
        method=HOSTILE,
        warnings=(message, HOSTILE),
        provenance={**found.estimate.provenance, "log": HOSTILE},
    )
    results = {HOSTILE: hostile, "LMI": compared.results["LMI"]}
    values = (
        hostile,
        replace(found, estimate=hostile),
        Comparison(
            results, {HOSTILE: 0.1}, {"x": HOSTILE}, HOSTILE, HOSTILE, compared.ingested
        ),
        Agreement.of(results),
        replace(shape, warnings=(HOSTILE,)),
    )
    assert len(values) == len(KINDS)
    for value in values:
        page = Page(value._repr_html_())
        assert "alert(1)" in page.text
        assert "<img src=x onerror" in page.text
        for source in page.pictures:
            assert "alert" not in base64.b64decode(source.partition(",")[2]).decode()


def test_a_long_text_is_cut_and_controls_are_not_passed_on(found):
    name = "a" * 10_000 + "\u202e\x1b[31m"
    html = replace(found.estimate, method="\u202e\x1b[31m" + name)._repr_html_()
    assert "\u202e" not in html
    assert "\x1b" not in html
    assert "a" * 500 not in re.sub(r"base64,[^\"]*", "", html)


def test_a_comparison_shows_every_method(compared):
    html = compared._repr_html_()
    page = Page(html)
    start = next(i for i, row in enumerate(page.cells) if row[0] == "method")
    rows = {row[0]: row for row in page.cells[start + 1 :]}
    assert list(rows) == list(compared.shown)
    for name, estimate in compared.shown.items():
        assert rows[name][1] == estimate.verdict.level
    assert compared.reason in page.text
    for why in compared.skipped.values():
        assert why.split(";")[0] in page.text


def test_an_agreement_says_who_contradicts_whom(found):
    moved = found.estimate.parameters.moved(
        [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    other = replace(
        found.estimate,
        parameters=moved,
        intervals={
            **found.estimate.intervals,
            "center_of_mass": found.estimate.intervals["center_of_mass"]
            + np.array((0.1, 0, 0)),
        },
    )
    agreement = Agreement.of({"first": found.estimate, "second": other})
    page = Page(agreement._repr_html_())
    assert "the estimates contradict one another: first and second" in page.text
    assert "COM x" in page.text
    rows = {row[0]: row[1:] for row in page.cells}
    assert float(rows["COM x [mm]"][-1]) == pytest.approx(
        agreement.apart["first", "second"][1], abs=0.051
    )


def test_a_shape_shows_where_it_is(shape):
    page = Page(shape._repr_html_())
    rows = dict(row for row in page.cells if len(row) == 2)
    assert rows["points"] == str(shape.n)
    assert rows["bounding box [mm]"] == " × ".join(
        f"{1e3 * side:.1f}" for side in shape.extents
    )
    assert "reaches x " in page.text


@pytest.mark.parametrize("kind", ["mesh", 200, 20_000])
def test_pictures_are_small_whatever_the_shape(kind):
    """At most 100 kB: a mesh of 5,000 triangles, a cloud of few or many points."""
    if kind == "mesh":
        trimesh = pytest.importorskip("trimesh")
        ball = trimesh.creation.icosphere(subdivisions=4, radius=0.1)
        shape = Shape.from_mesh(ball, points=200)
    else:
        shape = Shape(np.random.default_rng(1).uniform(-0.1, 0.1, (kind, 3)))
    page = Page(shape._repr_html_())
    (source,) = page.pictures
    assert len(source) < 100_000
    assert svg_of(page).count("<image") >= 3  # the shape is in it, as pixels


def test_a_picture_that_would_be_larger_is_left_out(found, monkeypatch):
    monkeypatch.setattr(hefting.notebook, "LARGEST", 1000)
    assert Page(found._repr_html_()).pictures == []


def test_without_matplotlib_there_is_no_picture(found, shape, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for value in (found, shape):
        page = Page(value._repr_html_())
        assert page.pictures == []
        assert page.cells


def test_other_values_have_none_and_repr_stays(found):
    assert html_of(3) is None
    assert repr(found).startswith("Identification by Bayes, verdict: good")
    assert len(repr(found)) < 1500


def test_nothing_of_it_is_imported_before_it_is_shown():
    code = (
        "import sys, hefting; hefting.Estimate; hefting.Shape;"
        "print([m for m in sys.modules if 'notebook' in m or 'matplotlib' in m])"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(hefting.__file__).parents[1])}
    said = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    assert said.stdout.strip() == "[]"


@needs_browser
@pytest.mark.parametrize(("size", "scheme"), LOOKS, ids=["1440", "390"])
def test_in_a_browser(browser, compared, found, shape, tmp_path, size, scheme):
    """No error, nothing asked for, no page wider than the window; every picture is
    drawn. Notebooks have their own ground and ink."""
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)
    doubtful = replace(
        found.estimate,
        warnings=(Message("odd", f"nothing is held by {HOSTILE}", "error"),),
        method=HOSTILE,
    )
    values = (found, doubtful, compared, shape)
    ground, ink = {"light": ("#fff", "#111"), "dark": ("#111", "#ddd")}[scheme]
    body = "".join(value._repr_html_() for value in values)
    page = (
        "<!DOCTYPE html><meta charset=utf-8><meta name=viewport "
        f'content="width=device-width"><body style="background:{ground};color:{ink};'
        f'font-family:system-ui">{body}'
    )
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    with browsing(browser, size, scheme, offline=True) as visit:
        visit.page.goto((tmp_path / "page.html").as_uri())
        drawn = visit.page.evaluate(
            "[...document.images].map(i => i.complete && i.naturalWidth > 100)"
        )
        width = visit.page.evaluate("document.documentElement.scrollWidth")
        colour = visit.page.evaluate(
            "getComputedStyle(document.querySelector('td')).color"
        )
        visit.page.screenshot(
            path=folder / f"notebook-{size[0]}-{scheme}.png", full_page=True
        )
        assert (visit.problems, visit.foreign) == ([], [])
    assert drawn == [True] * len(values)
    assert width <= size[0]
    assert colour == {"light": "rgb(17, 17, 17)", "dark": "rgb(221, 221, 221)"}[scheme]
