"""The page of a batch in a real browser, opened from disk without a network: it asks for
nothing, has no error, is no wider than the window, and draws every histogram."""

import os
from pathlib import Path

import pytest

pytest.importorskip("plotly", reason="plotly is not installed: hefting[view]")

import itertools

from batch_rows import batch_of, doubted, failed, identified, spread

from browser import DESKTOP, LOOKS, PHONE, browsing, needs_browser
from hefting.page import Context
from hefting.page.batch import batch_page

pytestmark = needs_browser
LONG = "/data/cell 3/2026-03-14/a-very-long-name-of-a-recording-without-a-space.csv"
DOUBT = "the residuals are five times the noise; see `gravity`"
VIEWS = LOOKS
if "HEFTING_SCREENSHOTS" in os.environ:  # for a person to look at
    VIEWS += ((DESKTOP, "dark"), (PHONE, "light"))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Path of a page with every section."""
    folder = tmp_path_factory.mktemp("page")
    left_out = [{"recording": LONG, "error": "InputError", "error_text": "is empty"}]
    rows = [
        *spread(400),
        identified(LONG, residual=(9.0, 0.005)),
        *(doubted(f"d{k}.csv", "misfit", DOUBT) for k in range(20)),
        doubted("never.csv", "wrong", DOUBT, "do not use", left_out=left_out),
        *(failed(f"{k}{LONG}", "the file is empty") for k in range(9)),
    ]
    path = folder / "batch.html"
    context = Context(command="hefting batch data --output results --report batch.html")
    path.write_text(batch_page(batch_of(folder / "results", rows), context))
    return path


@pytest.fixture
def kept(tmp_path):
    """Where a picture of a page goes for a person to look at."""
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return lambda name: str(folder / f"{name}.png")


@pytest.mark.parametrize(
    ("size", "scheme"), VIEWS, ids=[f"{size[0]}-{scheme}" for size, scheme in VIEWS]
)
def test_the_page_opens_from_disk_and_draws_all(page, browser, kept, size, scheme):
    with browsing(browser, size, scheme, offline=True) as visit:
        shown = visit.page
        shown.goto(page.as_uri())
        shown.wait_for_selector("body[data-drawn]", timeout=60_000)
        assert shown.locator(".js-plotly-plot").count() == 3
        for place in shown.locator(".js-plotly-plot .main-svg").all()[:1]:
            assert place.bounding_box()["height"] > 100
        assert shown.evaluate("document.documentElement.scrollWidth") <= size[0]
        # a link to a recording leads to a file, whose path is whole
        target = shown.get_by_role("link", name=LONG).first.get_attribute("href")
        assert target == "file://" + LONG.replace(" ", "%20")
        shown.screenshot(path=kept(f"batch-{size[0]}-{scheme}"), full_page=True)
        assert visit.problems == []
        assert visit.foreign == []


def test_labels_of_nearly_equal_numbers_do_not_overlap(tmp_path, browser):
    """On a phone: they have many digits."""
    rows = [
        identified(
            f"{k}.csv", 1.112 + 0.001 * k, (0.0992 + 4e-4 * k, 0.00442 + 4e-5 * k)
        )
        for k in range(3)
    ]
    path = tmp_path / "batch.html"
    path.write_text(batch_page(batch_of(tmp_path / "r", rows), Context()))
    ends = (
        "[...document.querySelectorAll('.js-plotly-plot')].map(plot => "
        "[...plot.querySelectorAll('.xtick text')].map(each => "
        "(r => [r.left, r.right])(each.getBoundingClientRect())))"
    )
    with browsing(browser, PHONE, "light", offline=True) as visit:
        visit.page.goto(path.as_uri())
        visit.page.wait_for_selector("body[data-drawn]", timeout=60_000)
        plots = visit.page.evaluate(ends)
    assert len(plots) == 3
    for labels in map(sorted, plots):
        assert len(labels) > 1
        for (_, right), (left, _) in itertools.pairwise(labels):
            assert right < left
