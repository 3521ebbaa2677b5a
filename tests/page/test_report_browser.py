"""The page of --report in a real browser, opened from disk without a network: it asks
for nothing, has no error, and draws what the library found."""

import json
import os
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("plotly", reason="plotly is not installed: hefting[view]")

from browser import DESKTOP, LOOKS, PHONE, browsing, needs_browser
from hefting.core.estimate import Estimate
from hefting.core.measurements import Noise
from hefting.export import export
from hefting.identification import identify
from hefting.logs import read_log, write_log
from hefting.page.figure import DARK, LIGHT
from hefting.scene import wrench_curves
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate, truth
from hefting.simulation.demo import POSE

pytestmark = needs_browser
HELD = "0,-0.08,0.06,-0.7071068,0,0,0.7071068"
VIEWS = (*LOOKS, (DESKTOP, "dark"), (PHONE, "light"))
DATA = """() => Object.fromEntries([...document.querySelectorAll('.js-plotly-plot')]
  .map(place => [place.id, place.data.map(trace => ({...trace}))]))"""
GROUND = "getComputedStyle(document.body).backgroundColor"
EYE = """() => document.getElementById('figure-object')
  ._fullLayout.scene._scene.getCamera().eye"""
MOST_GESTURES = 30
"""After so many a slow machine has drawn one of them."""
MOVED = f"""before => {{
  const eye = ({EYE})();
  return Math.max(...["x", "y", "z"].map(k => Math.abs(before[k] - eye[k]))) > 0.1;
}}"""
"""Whether the eye is elsewhere than before, by more than a tenth of the distance."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log with drift, spikes and a contact; the mesh, the truth and reports."""
    folder = tmp_path_factory.mktemp("browser")
    motion = UR5.motion(random_smooth(20.0, 100.0, 1.0, seed=2))
    held = hammer().parameters.moved(POSE)
    log = simulate(motion, held, noise=Noise(0.1, 0.005), seed=2)
    values = log["wrench"].values.copy()
    values[[300, 700, 701, 1500]] += 30.0
    values[900:950, :3] += 6.0
    values += np.linspace(0.0, 1.0, len(values))[:, None] * np.repeat((2.0, 0.1), 3)
    log.streams["wrench"].values.setflags(write=True)
    log.streams["wrench"].values[:] = values
    write_log(log, folder / "log.csv")
    mesh = hammer().mesh()
    large = mesh.copy().apply_scale(1e3)
    (folder / "hammer.stl").write_bytes(large.export(file_type="stl"))
    facts = truth(held, mesh.extents, np.eye(4), name="hammer")
    (folder / "truth.json").write_text(json.dumps(facts))
    return folder


def words_of(folder, command):
    """What is typed for the page of a command."""
    log, page = folder / "log.csv", folder / f"{command}.html"
    shape = "--shape", folder / "hammer.stl", "--unit", "mm", "--object-pose", HELD
    known = "--truth", folder / "truth.json"
    return {
        "identify": ("identify", log, *shape, *known, "--output", folder / "e.json"),
        "methods": ("identify", log, *shape, *known, "--method", "all"),
        "inspect": ("inspect", log),
        "calibrate": ("calibrate", log, "--output", folder / "tool.json"),
        "predict": ("predict", folder / "e.json", log),
    }[command] + ("--report", page)


@pytest.fixture
def page(run, folder):
    """Path of the page of a command, made once."""

    def page(command):
        path = folder / f"{command}.html"
        if command == "predict":
            page("identify")
        if not path.exists():
            status, out, err = run(*words_of(folder, command))
            assert (status, err) == (0, "")
            assert f"wrote {path}" in " ".join(out.split())
        return path

    return page


def opened(visit, path):
    visit.page.goto(path.as_uri())
    visit.page.wait_for_selector("body[data-drawn]", timeout=60_000)
    return visit.page


@pytest.fixture(scope="module")
def open_visits():
    """Those of `visit`, by the page and the window, and what closes them."""
    with ExitStack() as stack:
        yield {}, stack


@pytest.fixture
def visit(page, browser, open_visits):
    """A visit to the page of a command in a window, opened once: a processor takes
    seconds to draw the figures."""
    visits, stack = open_visits

    def visit(command, look=LOOKS[0]):
        if (command, look) not in visits:
            found = stack.enter_context(browsing(browser, *look, offline=True))
            opened(found, page(command))
            visits[command, look] = found
        return visits[command, look]

    return visit


def rgb(colour):
    """A colour as a browser tells it."""
    return f"rgb({', '.join(str(int(colour[i : i + 2], 16)) for i in (1, 3, 5))})"


def kept(tmp_path, name):
    """Where a picture of a page goes for a person to look at."""
    folder = Path(os.environ.get("HEFTING_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return str(folder / f"{name}.png")


@pytest.mark.parametrize(
    ("command", "views"),
    [
        ("identify", LOOKS[:1]),
        ("methods", LOOKS[:1]),
        ("inspect", LOOKS[1:]),
        ("calibrate", LOOKS[:1]),
        ("predict", LOOKS[1:]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_every_page_opens_from_disk_and_draws_all(
    page, visit, tmp_path, command, views
):
    """For a person (HEFTING_SCREENSHOTS) in all views, with a picture of each section.
    What only a narrow window or the dark does to the first is looked at below."""
    path, wanted = page(command), "HEFTING_SCREENSHOTS" in os.environ
    assert path.stat().st_size <= 5_000_000
    for size, scheme in VIEWS if wanted else views:
        seen = visit(command, (size, scheme))
        shown = seen.page
        figures = shown.evaluate("read('figures').length")
        assert figures >= 3
        assert shown.locator(".js-plotly-plot").count() == figures
        # the drawing of each has a size, that of the object a canvas for WebGL
        for place in shown.locator(".js-plotly-plot .main-svg").all()[:1]:
            assert place.bounding_box()["height"] > 100
        assert shown.locator("#figure-object canvas").count() == 1
        palette = LIGHT if scheme == "light" else DARK
        assert shown.evaluate(GROUND) == rgb(palette["paper"])
        # nothing is wider than the window
        assert shown.evaluate("document.documentElement.scrollWidth") <= size[0]
        name = f"report-{command}-{size[0]}-{scheme}"
        shown.screenshot(path=kept(tmp_path, name))
        for section in shown.locator("section").all() if wanted else ():
            part = section.get_attribute("id")
            section.screenshot(path=kept(tmp_path, f"{name}-{part}"))
        assert seen.problems == []
        assert seen.foreign == []


def test_what_is_seen_is_what_the_library_says(visit, folder):
    shown = visit("identify").page
    shape = Shape.from_mesh(folder / "hammer.stl", unit="mm", pose=POSE)
    found = identify(read_log(folder / "log.csv"), shape)
    saved = Estimate.load(folder / "e.json")
    curves = wrench_curves(found.measurements, saved, found.ingested.log_start)
    drawn = shown.evaluate(DATA)
    for name, first in (("force", 0), ("torque", 3)):
        traces = {t["name"]: t for t in drawn[f"figure-wrench-{name}"]}
        for i, axis in enumerate("xyz"):
            trace = traces[f"predicted {axis}"]
            expected = curves.predicted[:, first + i]
            # seven digits; the pose typed has as many, so that the body of the
            # command differs from this one's by up to 1e-7 of its size
            seen = [y for y in trace["y"] if y is not None]
            # no line is drawn over the contact
            assert len(seen) == len(expected) < len(trace["y"])
            assert seen == pytest.approx(expected, rel=1e-5, abs=1e-5)
    solid = {t["name"]: t for t in drawn["figure-object"]}
    assert len(solid["point masses"]["x"]) == len(saved.point_masses)
    grams = solid["point masses"]["marker"]["color"]
    assert grams == pytest.approx(1e3 * saved.point_masses, rel=1e-6, abs=1e-9)
    assert len(solid["shape"]["i"]) == len(shape.faces)
    at = [solid["COM, estimate"][axis][0] for axis in "xyz"]
    assert at == pytest.approx(1e3 * saved.center_of_mass, abs=0.0051)
    causes = shown.evaluate(
        "document.getElementById('figure-wrench-force').layout.shapes.map(s => s.legendgroup)"
    )
    assert {"spike", "contact"} <= set(causes)
    assert "figure-drift" in drawn
    last = {t["name"]: t for t in drawn["figure-convergence-0"] if "name" in t}
    assert last["mass"]["y"][-1] == pytest.approx(saved.mass, rel=1e-6)


def test_scheme_and_size_are_followed_while_it_is_open(visit):
    """From a desktop in the light to a phone in the dark and back: drawn anew in the
    scheme's colours, and never wider than the window."""
    seen = visit("identify")
    shown = seen.page
    colour = "document.getElementById('figure-motion').layout.font.color"
    wide = "document.documentElement.scrollWidth"
    drawn = "[...document.querySelectorAll('.js-plotly-plot .main-svg')]"
    widest = f"Math.max(...{drawn}.map(each => each.getBoundingClientRect().width))"
    for size, scheme in (*LOOKS, LOOKS[0]):
        palette = LIGHT if scheme == "light" else DARK
        shown.set_viewport_size({"width": size[0], "height": size[1]})
        shown.emulate_media(color_scheme=scheme)
        shown.wait_for_function(f"{colour} === '{palette['ink']}'")
        assert shown.evaluate(GROUND) == rgb(palette["paper"])
        # every figure follows
        shown.wait_for_function(f"{widest} <= {size[0]}")
        assert shown.evaluate(wide) <= size[0]
    assert seen.problems == []


def test_the_object_turns_by_mouse_and_by_touch(visit):
    shown = visit("identify", LOOKS[0]).page

    def by_mouse(x, y):
        shown.mouse.move(x, y)
        shown.mouse.down()
        for step in range(1, 4):  # as a hand: each is drawn before the next one comes
            shown.wait_for_timeout(30)
            shown.mouse.move(x + 50 * step, y)
        shown.wait_for_timeout(30)
        shown.mouse.up()

    turn(shown, by_mouse)
    touched = visit("predict", LOOKS[1]).page
    session = touched.context.new_cdp_session(touched)

    def by_touch(x, y):
        for kind, at in [
            ("touchStart", x),
            *(("touchMove", x + 30 * i) for i in range(1, 4)),
            ("touchEnd", None),
        ]:
            points = [] if at is None else [{"x": at, "y": y}]
            event = {"type": kind, "touchPoints": points}
            session.send("Input.dispatchTouchEvent", event)
            touched.wait_for_timeout(30)

    turn(touched, by_touch)


def turn(shown, gesture):
    """Make a gesture until the object has turned: a slow machine draws nothing between
    the events of one, or is not ready for it."""
    before, x, y = eye_and_middle(shown)
    for _ in range(MOST_GESTURES):
        gesture(x, y)
        if shown.evaluate(MOVED, before):
            return
    pytest.fail(f"nothing has turned by {MOST_GESTURES} gestures")


def eye_and_middle(shown):
    """Where the figure of the object is seen from, and its middle in the window."""
    place = shown.locator("#figure-object")
    place.scroll_into_view_if_needed()
    box = place.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    return shown.evaluate(EYE), *middle


def test_a_controller_is_chosen_and_its_text_shown(visit, folder):
    seen = visit("identify")
    shown, saved = seen.page, Estimate.load(folder / "e.json")
    texts = shown.locator("#controller-texts > div:visible")
    assert texts.count() == 1
    assert "set_target_payload(" in texts.inner_text()
    shown.select_option("#controller", "kuka")
    assert texts.count() == 1
    pasted = texts.locator("pre").text_content()
    assert pasted == export(saved, "kuka").text
    words = shown.locator("#command-text").inner_text()
    assert words.startswith("hefting identify ")
    assert seen.problems == []
