"""Viewer and player in a real browser: nothing on the console, nothing asked of the
network, and the page shows what the library says. Pictures are kept for a person."""

import os
from pathlib import Path

import numpy as np
import pytest

from browser import DESKTOP, PHONE, browsing, needs_browser
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
LOOKS = [(size, scheme) for size in (DESKTOP, PHONE) for scheme in ("light", "dark")]
DRAWN = 20_000
"""[ms] A processor draws what a graphics card draws at once."""
CURVES = "Object.values(window.__viserTestpoints.uplots).map(u => u.chart.data)"
"""What the plots of the page hold, as viser lays it open for tests."""


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


def keep(page, name, tmp_path):
    """A picture of a page, where a person asked for it or in pytest's folder."""
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS") or tmp_path)
    notice = page.get_by_role("alert").locator(
        "button"
    )  # that no graphics card is there
    if notice.count():
        notice.first.click()
        page.wait_for_timeout(500)
    page.screenshot(path=folder / f"{name}.png")
    return folder / f"{name}.png"


def colours_in(path):
    """How many colours the scene has in a picture, beside or above the panel: an empty
    one has one."""
    from matplotlib.image import imread

    pixels = (255 * imread(path)[..., :3]).astype(int)
    pixels = pixels[:, :1000] if pixels.shape[1] > 1000 else pixels[220:330]
    return len(np.unique(pixels.reshape(-1, 3), axis=0))


def opened(visit, viewer, scheme):
    address = address_of(viewer.server) + ("/?darkMode" if scheme == "dark" else "")
    visit.page.goto(address)
    visit.page.get_by_text("verdict:").wait_for(timeout=DRAWN)
    visit.page.wait_for_function("window.__viserTestpoints?.uplots", timeout=DRAWN)
    return visit.page


@pytest.mark.parametrize(("size", "scheme"), LOOKS)
def test_the_viewer_shows_the_answer_and_asks_for_nothing(
    viewer, size, scheme, tmp_path
):
    viewer.controls.method.value = "Bayes"
    viewer.controls.time.value = float(viewer.controls.time.max)
    viewer.follow()
    assert viewer.settle()
    with browsing(size, scheme) as visit:
        page = opened(visit, viewer, scheme)
        for number in headline_of(viewer.answer.estimate).numbers:
            page.get_by_text(number).wait_for(timeout=DRAWN)
        page.wait_for_timeout(2_000)
        picture = keep(page, f"viewer-{size[0]}-{scheme}", tmp_path)
        assert colours_in(picture) > 100
        assert page.evaluate("document.body.scrollWidth") <= size[0]
    assert visit.problems == []
    assert visit.foreign == []


def test_the_page_follows_the_controls(viewer):
    """The slider is moved by keys in the browser; the page then shows the library's
    numbers and curves."""
    viewer.controls.method.value = "Bayes"
    viewer.controls.time.value = 3.0
    viewer.follow()
    assert viewer.settle()
    with browsing() as visit:
        page = opened(visit, viewer, "light")
        slider = page.get_by_role("slider").first
        slider.focus()
        for _ in range(5):
            slider.press("ArrowRight")
        page.wait_for_timeout(1_000)
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
        page.wait_for_timeout(1_000)
        curves = page.evaluate(CURVES)
    z = viewer.playback.found.measurements[viewer.playback.samples]
    estimate = viewer.session.estimate(instant, viewer.controls.settings)
    bias = viewer.playback.bias(estimate)
    predicted = predict_wrench(z, estimate.sensed_vector) + bias
    assert len(curves) == 2
    for data, part in zip(curves, (slice(0, 3), slice(3, 6)), strict=True):
        drawn = np.array([list(each) for each in data], dtype=float)
        np.testing.assert_allclose(drawn[0], viewer.playback.times, atol=1e-12)
        np.testing.assert_allclose(drawn[1:4].T, z.wrench[:, part], atol=1e-12)
        np.testing.assert_allclose(drawn[4:7].T, predicted[:, part], atol=1e-9)
    assert visit.problems == []
    assert visit.foreign == []


@pytest.mark.parametrize(("size", "scheme"), LOOKS[::3])
def test_the_player_plays_from_disk_without_a_network(viewer, size, scheme, tmp_path):
    viewer.controls.method.value = "Bayes"
    viewer.controls.time.value = float(viewer.controls.time.max)
    viewer.follow()
    assert viewer.settle()
    file = tmp_path / "player.html"
    file.write_text(player_of(viewer, f"log.csv {HOSTILE}"))
    assert file.stat().st_size < 5_000_000
    with browsing(size, scheme, offline=True) as visit:
        page = visit.page
        page.goto(file.as_uri())
        page.get_by_text("verdict:").wait_for(timeout=DRAWN)
        for number in headline_of(viewer.answer.estimate).numbers:
            page.get_by_text(number).wait_for(timeout=DRAWN)
        assert page.title() == f"log.csv {HOSTILE}"
        assert not page.locator("img[src=x]").count()
        page.wait_for_timeout(2_000)
        first = keep(page, f"player-{size[0]}-{scheme}", tmp_path)
        assert colours_in(first) > 100
        page.wait_for_timeout(1_500)
        later = page.screenshot(path=tmp_path / "later.png")
        assert later != first.read_bytes()  # it plays
    assert visit.problems == []
    assert visit.foreign == []
