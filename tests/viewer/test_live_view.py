"""The live view: what it shows is what was estimated, also to a browser that comes late,
and many of them lose no sample."""

import os
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import hefting
from browser import COARSE, browsing, needs_browser
from hefting.scene import headline_of
from hefting.viewer.live import LAST, LiveView, live_html
from hefting.viewer.server import address_of, serving
from viewing import held, recorded

pytest.importorskip("viser")
DRAWN = 60_000
"""[ms] A processor draws what a graphics card draws at once."""
CURVES = "Object.values(window.__viserTestpoints.uplots).map(u => u.chart.data)"
BROWSERS = 10


@pytest.fixture(scope="module")
def estimates():
    """What a stream of five seconds tells, as fast as it goes."""
    return list(hefting.live(recorded(), speed=float("inf")))


@pytest.fixture
def view():
    with serving() as server:
        view = LiveView(server)
        yield view
        view.close()


def shown(view, estimates):
    for found in estimates:
        view.show(found)
        assert view.settle()
    return [found for found in estimates if found.estimate is not None]


def test_text_and_curves_are_those_of_the_estimates(view, estimates):
    known = shown(view, estimates)
    assert len(known) > 10
    last = known[-1]
    assert view.text.content == live_html(estimates[-1])
    assert view.drawing is not None
    for number in headline_of(last.estimate).numbers:
        assert number in view.text.content
    times, mass, low, high = view.intervals.handles[0].data
    assert np.array_equal(times, [found.time for found in known])
    assert np.array_equal(mass, [found.estimate.mass for found in known])
    ends = np.array([found.estimate.interval("mass") for found in known]).T
    ends[~np.isfinite(ends)] = np.nan
    assert np.array_equal((low, high), ends, equal_nan=True)
    force, torque = view.wrench.handles
    assert np.ptp(force.data[0]) <= LAST
    residual = np.array(force.data[1:4]) - np.array(force.data[4:7])
    assert 0.01 < np.sqrt(np.nanmean(residual**2)) < 0.3  # noise of 0.1 N
    assert not np.array_equal(force.data[1], torque.data[1])


def test_what_is_said_is_escaped(estimates):
    from dataclasses import replace

    from hefting.core.messages import note

    told = replace(estimates[-1], messages=(note("x", "<img src=x>"),))
    assert "<img" not in live_html(told)
    assert "- &lt;img" in live_html(told)


def test_another_object_begins_a_curve_of_its_own(view, estimates):
    from dataclasses import replace

    known = [found for found in estimates if found.estimate is not None][:3]
    later = replace(known[-1], object=2, time=known[-1].time + 1.0)
    shown(view, [*known, later])
    assert np.isnan(view.intervals.handles[0].data[1]).sum() == 1
    assert "object 2" in view.text.content


def test_curves_begin_with_a_number_and_no_object_is_drawn_without_an_estimate(
    view, estimates
):
    """After an empty hand the curves had begun with NaN, and the plots were blank; what had
    been put down was drawn on."""
    from dataclasses import replace

    known = [replace(e, object=2) for e in estimates if e.estimate is not None]
    shown(view, known)
    assert all(
        np.isfinite(np.array(h.data)[:, 0]).all() for h in view.intervals.handles
    )
    assert view.drawing is not None
    nodes = view.drawing._nodes
    assert nodes["estimate/com"].visible
    empty = replace(known[-1], state="too little motion", estimate=None, object=3)
    shown(view, [replace(empty, time=empty.time + 0.1)])
    assert not nodes["estimate/com"].visible


def test_curves_of_another_clock_begin_anew(view, estimates):
    """Set back by an hour, they had gone backwards, and the wrench had stood still; the
    digits of a wall clock do not fit beside one another."""
    from dataclasses import replace

    def at(found, shift):
        recent = found.recent
        if recent is not None:
            recent = replace(recent, time=recent.time + shift)
        return replace(found, time=found.time + shift, recent=recent)

    known = [found for found in estimates if found.estimate is not None]
    shown(view, [at(found, 1.7e9) for found in known])
    later = [at(found, 1.7e9 - 3600.0) for found in known]
    shown(view, later)
    times = view.intervals.handles[0].data[0]
    np.testing.assert_allclose(times, [f.time - later[0].time for f in later])
    drawn = np.asarray(view.wrench.handles[0].data[0])
    assert abs(drawn[-1] - times[-1]) < 1.0


@needs_browser
def test_a_browser_that_comes_late_sees_the_whole(view, estimates, browser, tmp_path):
    pytest.importorskip("playwright")
    known = shown(view, estimates)
    with browsing(browser) as visit:
        visit.page.goto(f"{address_of(view.server)}/{COARSE}")
        visit.page.get_by_text("verdict:").wait_for(timeout=DRAWN)
        for number in headline_of(known[-1].estimate).numbers:
            assert visit.page.get_by_text(number).count() == 1
        visit.page.wait_for_function(
            "Object.keys(window.__viserTestpoints?.uplots ?? {}).length == 4",
            timeout=DRAWN,
        )
        drawn = visit.page.evaluate(CURVES)
        masses = [found.estimate.mass for found in known]
        assert any(np.allclose(each[1], masses) for each in drawn if len(each) == 4)
        visit.page.screenshot(path=picture(tmp_path))
        assert not visit.problems
        assert not visit.foreign


def picture(tmp_path):
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS") or tmp_path)
    return folder / "live.png"


def test_many_browsers_lose_no_sample(view):
    """Each takes all that the server sends, as a page does."""
    websockets = pytest.importorskip("websockets.sync.client")
    viser = pytest.importorskip("viser")
    address = address_of(view.server).replace("http", "ws")
    log, ended = recorded(), threading.Event()
    read = [0] * BROWSERS

    def browse(k):
        protocol = f"viser-v{viser.__version__}"
        with websockets.connect(
            address, subprotocols=[protocol], max_size=None, compression=None
        ) as page:
            while not ended.is_set():
                try:
                    read[k] += len(page.recv(timeout=0.2))
                except TimeoutError:
                    continue

    pages = [threading.Thread(target=browse, args=(k,)) for k in range(BROWSERS)]
    for page in pages:
        page.start()
    with hefting.LiveIdentifier() as live:
        names = ("wrench", "position", "orientation")
        for k in range(0, 500, 10):
            for name in names:
                part = slice(k, k + 10)
                live.add(name, log[name].time[part], log[name].values[part])
            found = live.latest
            if found is not None:
                view.show(found)
            time.sleep(0.02)
        last = live.close()
    assert view.settle()
    ended.set()
    for page in pages:
        page.join()
    assert min(read) > 1_000
    assert last.counts.get("dropped", 0) == 0
    assert last.counts["samples"] == 500 * len(names)
    low, high = last.estimate.interval("mass")
    assert low < held().parameters.mass < high
