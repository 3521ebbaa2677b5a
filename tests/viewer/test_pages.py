"""Viewer and player in a real browser: nothing on the console, nothing asked of the
network, and the page shows what the library says. Pictures are kept for a person."""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from browser import COARSE, DESKTOP, PHONE, browsing, needs_browser
from hefting.core.regressor import predict_wrench
from hefting.robots import Arm
from hefting.scene import headline_of
from hefting.viewer.player import player_of
from hefting.viewer.server import address_of, serving
from hefting.viewer.viewer import Viewer
from viewing import HOSTILE, POSE, held, viewed, write_arm

pytest.importorskip("viser")
pytest.importorskip("playwright")
pytestmark = needs_browser
DRAWN = 60_000
"""[ms] A processor draws what a graphics card draws at once."""
SCENE = {"x": 0, "y": 330, "width": 390, "height": 400}
"""[pixels] Below the answer of the player on a phone, above the bar that moves."""
COLOURS = 100
"""The scene has more once it is drawn."""
CURVES = "Object.values(window.__viserTestpoints.uplots).map(u => u.chart.data)"
"""What the plots of the page hold, as viser lays it open for tests."""
GROUND = "document.documentElement.getAttribute('data-mantine-color-scheme')"
"""The colour scheme in which the page is drawn."""


@pytest.fixture(scope="module")
def viewer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arm")
    truth = held().parameters.moved(POSE)
    session, playback, recording = viewed(truth=truth)
    arm = Arm.from_urdf(write_arm(folder), "tool0", recording)
    with serving() as server:
        viewer = Viewer(server, session, playback, arm)
        yield viewer
        viewer.close()


@pytest.fixture(scope="module")
def visit(viewer, browser):
    """The page of the viewer in one window, which the tests share: to draw a scene for
    the first time takes a processor seconds."""
    with browsing(browser) as visit:
        page = visit.page
        page.goto(f"{address_of(viewer.server)}/{COARSE}")
        page.get_by_text("verdict:").wait_for(timeout=DRAWN)
        page.wait_for_function("window.__viserTestpoints?.uplots", timeout=DRAWN)
        yield visit


def show_end(viewer):
    """The answer by Bayes after the whole recording."""
    viewer.controls.method.value = "Bayes"
    viewer.controls.time.value = float(viewer.controls.time.max)
    viewer.follow()
    assert viewer.settle()


def keep(page, name, tmp_path):
    """Path of a picture of a page once its scene is drawn, where a person asked for it
    or in pytest's folder."""
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS") or tmp_path)
    # that no graphics card is there
    notice = page.get_by_role("alert").locator("button")
    if notice.count():
        notice.first.click()
        notice.wait_for(state="detached")
    picture = folder / f"{name}.png"
    wait_until(lambda: colours_in(pictured(page, picture)) > COLOURS, page)
    return picture


def pictured(page, path):
    page.screenshot(path=path)
    return path


def wait_until(condition, page):
    """Fails where it has not come by `DRAWN`."""
    ends = time.monotonic() + DRAWN / 1000
    while not condition():
        assert time.monotonic() < ends
        page.wait_for_timeout(100)


def colours_in(path):
    """How many colours the scene has in a picture, beside or above the panel: an empty
    one has one."""
    from matplotlib.image import imread

    pixels = (255 * imread(path)[..., :3]).astype(int)
    pixels = pixels[:, :1000] if pixels.shape[1] > 1000 else pixels[220:330]
    return len(np.unique(pixels @ (1 << 16, 1 << 8, 1)))


def curves_of(page):
    """Of each plot, what is drawn, (rows, samples)."""
    plots = page.evaluate(CURVES)
    return [np.array([list(row) for row in plot], dtype=float) for plot in plots]


def test_the_player_plays_from_disk_without_a_network(viewer, browser, tmp_path):
    """On a phone whose scheme is dark, then on a screen, in one window."""
    show_end(viewer)
    file = tmp_path / "player.html"
    file.write_text(player_of(viewer, f"log.csv {HOSTILE}"))
    assert file.stat().st_size < 5_000_000
    with browsing(browser, PHONE, "dark", offline=True) as visit:
        page = visit.page
        page.goto(file.as_uri() + COARSE)
        assert not page.get_by_text("verdict:").is_visible()  # it would hide the object
        page.locator("#hefting > summary").press("Enter")
        page.get_by_text("verdict:").wait_for(timeout=DRAWN)
        for number in headline_of(viewer.answer.estimate).numbers:
            page.get_by_text(number).wait_for(timeout=DRAWN)
        assert page.title() == f"log.csv {HOSTILE}"
        assert not page.locator("img[src=x]").count()
        page.wait_for_function(f"{GROUND} === 'dark'")
        keep(page, f"player-{PHONE[0]}-dark", tmp_path)
        first = page.screenshot(clip=SCENE)
        wait_until(lambda: page.screenshot(clip=SCENE) != first, page)  # it plays
        page.set_viewport_size({"width": DESKTOP[0], "height": DESKTOP[1]})
        keep(page, f"player-{DESKTOP[0]}-dark", tmp_path)
    assert visit.problems == []
    assert visit.foreign == []


def test_the_viewer_shows_the_answer_and_asks_for_nothing(viewer, visit, tmp_path):
    """On a screen in the light, on a phone in the dark."""
    show_end(viewer)
    page = visit.page
    for size, ground in ((DESKTOP, "light"), (PHONE, "dark")):
        if ground == "dark":
            page.get_by_label("dark", exact=True).click()
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.wait_for_function(f"{GROUND} === '{ground}'")
        for number in headline_of(viewer.answer.estimate).numbers:
            page.get_by_text(number).wait_for(timeout=DRAWN)
        keep(page, f"viewer-{size[0]}-{ground}", tmp_path)
        assert page.evaluate("document.body.scrollWidth") <= size[0]
    assert visit.problems == []
    assert visit.foreign == []


def test_the_page_follows_the_controls(viewer, visit):
    """The slider is moved by keys in the browser; the page then shows the library's
    numbers and curves."""
    viewer.controls.method.value = "Bayes"
    viewer.controls.time.value = 3.0
    viewer.follow()
    assert viewer.settle()
    page = visit.page
    slider = page.get_by_role("slider").first

    def shown() -> float:
        return float(slider.get_attribute("aria-valuenow") or "nan")

    # a key that comes before the page has the value moves the slider from elsewhere
    wait_until(lambda: shown() == pytest.approx(3.0), page)
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    wait_until(lambda: viewer.controls.time.value > 3.045, page)
    assert viewer.controls.time.value == pytest.approx(3.05)
    assert viewer.settle()
    page.get_by_text("first 3.05 of").wait_for(timeout=DRAWN)
    instant = viewer.playback.found.measurements.time[0] + 3.05
    estimate = viewer.session.estimate(instant, viewer.controls.settings)
    for number in headline_of(estimate).numbers:
        page.get_by_text(number).wait_for(timeout=DRAWN)
    viewer.controls.method.value = "PMD"
    assert viewer.settle()
    page.get_by_text("PMD, first 3.05").wait_for(timeout=DRAWN)
    page.get_by_text("lambda").wait_for(timeout=DRAWN)
    z = viewer.playback.found.measurements[viewer.playback.samples]
    estimate = viewer.session.estimate(instant, viewer.controls.settings)
    bias = viewer.playback.bias(estimate)
    predicted = predict_wrench(z, estimate.sensed_vector) + bias
    # the curves come after the text
    wait_until(lambda: np.allclose(curves_of(page)[1][4:7].T, predicted[:, 3:]), page)
    curves = curves_of(page)
    assert len(curves) == 2
    for drawn, part in zip(curves, (slice(0, 3), slice(3, 6)), strict=True):
        np.testing.assert_allclose(drawn[0], viewer.playback.times, atol=1e-12)
        np.testing.assert_allclose(drawn[1:4].T, z.wrench[:, part], atol=1e-12)
        np.testing.assert_allclose(drawn[4:7].T, predicted[:, part], atol=1e-9)
    assert visit.problems == []
    assert visit.foreign == []
