"""The page of --report without a browser: what it holds, that no text in it is taken for
HTML, that it is small and the same every time."""

import html
import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh

pytest.importorskip("plotly", reason="plotly is not installed: hefting[view]")

import plotly.graph_objects as go

from commands import refused
from hefting.core.errors import MissingDependencyError
from hefting.core.measurements import Noise
from hefting.core.messages import error
from hefting.core.recording import Recording, Stream
from hefting.export import REGISTRY, export
from hefting.identification import identify
from hefting.identification.convergence import convergence
from hefting.ingest.left_out import Span
from hefting.inspection import inspect
from hefting.logs import write_log
from hefting.page import Context, identification_page, inspection_page
from hefting.page.figure import DARK, LIGHT
from hefting.page.html import Row, bars
from hefting.page.recording import MOST_SPANS, marks
from hefting.page.solid import figure_of
from hefting.scene import Body, Ellipsoid, Scene, wrench_curves
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate, sinusoids
from hefting.simulation.demo import POSE
from html_pages import Words, figures_of, sections_of, text_of

pytestmark = pytest.mark.usefixtures("same_commands")

LARGEST = 5_000_000
"""Bytes of a page at most."""


def log_of(seconds=4.0, rate=40.0):
    motion = UR5.motion(sinusoids(seconds, rate, 1.0))
    held = hammer().parameters.moved(POSE)
    return simulate(motion, held, noise=Noise(0.1, 0.005), seed=1)


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), pose=POSE)


@pytest.fixture(scope="module")
def found(shape):
    return identify(log_of(), shape)


def page_of(found, **context):
    return identification_page(
        found.estimate, found.ingested, found.estimator, Context(**context)
    )


def test_sections_in_their_order(found, shape):
    page = page_of(found, shape=shape, command="hefting identify log.csv")
    assert sections_of(page) == [
        "answer",
        "wrench",
        "recording",
        "convergence",
        "object",
        "prior",
        "assumptions",
        "command",
        "controllers",
    ]
    assert "Use it: no check found a reason against it." in text_of(page)


def test_the_curves_are_those_of_the_library(found, shape):
    figures = figures_of(page_of(found, shape=shape))
    z = found.measurements
    curves = wrench_curves(z, found.estimate, found.ingested.log_start)
    for name, first in (("force", 0), ("torque", 3)):
        traces = {t["name"]: t for t in figures[f"wrench-{name}"]["traces"]}
        for i, axis in enumerate("xyz"):
            for kind in ("measured", "predicted", "residual"):
                trace = traces[f"{kind} {axis}"]
                # seven digits are written
                expected = getattr(curves, kind)[:, first + i]
                assert trace["y"] == pytest.approx(expected, rel=1e-6, abs=1e-12)
                assert trace["x"] == pytest.approx(curves.time, rel=1e-6, abs=1e-12)
    over = convergence(found.estimator, found.ingested, found.estimate)
    mass = {t.get("name"): t for t in figures["convergence-0"]["traces"]}["mass"]
    assert mass["y"] == pytest.approx(over.values[:, 0], rel=1e-6)


def test_the_object_has_every_point_with_its_mass(found, shape):
    truth = hammer().parameters.moved(POSE)
    figure = figures_of(page_of(found, shape=shape, truth=truth))["object"]
    traces = {trace["name"]: trace for trace in figure["traces"]}
    points = traces["point masses"]
    positions = np.column_stack([points[axis] for axis in "xyz"])
    # a hundredth of a millimetre is written
    assert positions == pytest.approx(1e3 * shape.positions, abs=0.0051)
    grams = 1e3 * found.estimate.point_masses
    assert points["marker"]["color"] == pytest.approx(grams, rel=1e-6)
    assert len(traces["shape"]["x"]) == len(shape.hull)
    for name, body in (("estimate", found.estimate.parameters), ("truth", truth)):
        at = [traces[f"COM, {name}"][axis][0] for axis in "xyz"]
        assert at == pytest.approx(1e3 * body.center_of_mass, abs=0.0051)
    region = traces["95 % region of the COM"]
    low, high = found.estimate.intervals["center_of_mass"]
    # the region is wider than the intervals by 2.795 / 1.960, see hefting.scene
    wide = [np.ptp(region[axis]) for axis in "xyz"]
    assert (wide > 1e3 * (high - low)).all()


@pytest.mark.parametrize("size", [(1, 1, 1), (0, 0, 1), (0.002, 1, 0.5), (1, 0, 0)])
def test_the_whole_object_is_in_view(size):
    """Oracle: a pinhole camera of 45 degrees, as plotly's."""
    far = 0.5 * np.array(size) + 0.01
    ball = Body("estimate", np.zeros(3), ellipsoid=Ellipsoid(far, np.diag(far)))
    figure = figure_of(Scene((ball,)))
    layout = figure.layout["scene"]
    eye, ratio, look = (
        np.array([where[axis] for axis in "xyz"])
        for where in (
            layout["camera"]["eye"],
            layout["aspectratio"],
            layout["camera"]["center"],
        )
    )
    low, high = np.array([layout[f"{axis}axis"]["range"] for axis in "xyz"]).T
    assert np.ptp(ratio / (high - low)) < 1e-6  # alike along all axes
    towards = (look - eye) / np.linalg.norm(look - eye)
    right = np.cross(towards, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, towards)
    for trace in figure.traces:
        points = np.column_stack([np.array(trace[axis], float) for axis in "xyz"])
        assert ((points > low) & (points < high)).all()
        seen = ratio * ((points - low) / (high - low) - 0.5) - eye
        depth = seen @ towards
        # beside what is as wide as the picture an axis has its title, on a phone too
        sideways = 0.65 if size == (1, 0, 0) else 1.0
        for direction, share in ((right, sideways), (up, 1.0)):
            assert (np.abs(seen @ direction) < share * np.tan(np.pi / 8) * depth).all()


def test_plotly_knows_every_attribute(found, shape):
    """Oracle: plotly's own schema, which refuses what it does not know."""
    truth = hammer().parameters.moved(POSE)
    for figure in figures_of(page_of(found, shape=shape, truth=truth)).values():
        text = re.sub(r'"@([\w-]+)"', lambda m: f'"{LIGHT[m[1]]}"', json.dumps(figure))
        plain = json.loads(text)
        go.Figure(plain["traces"], plain["layout"])
        assert all(f'"@{name}' not in text for name in LIGHT)


def test_both_schemes_have_every_colour():
    assert LIGHT.keys() == DARK.keys()


HOSTILE = '</script><img src=x onerror="alert(1)">&amp;.csv'


def test_hostile_names_are_only_text(found, shape):
    """In the log's name, a message and the command; also where JSON stands in HTML."""
    made = found.estimate.provenance | {"log": HOSTILE, "motion": HOSTILE}
    bad = error("x", f"wrong in {HOSTILE}")
    estimate = replace(found.estimate, provenance=made, warnings=(bad,))
    context = Context(shape, command=f"hefting identify {HOSTILE}")
    page = identification_page(estimate, found.ingested, found.estimator, context)
    plain = page_of(found, shape=shape, command="hefting identify log.csv")
    hostile, usual = Words(page), Words(plain)
    assert [tag for tag, _ in hostile.tags if tag in ("img", "script")] == [
        tag for tag, _ in usual.tags if tag in ("img", "script")
    ]
    assert not any("onerror" in attrs for _, attrs in hostile.tags)
    assert text_of(page).count(HOSTILE) >= 4
    assert "A reason below makes it wrong" in text_of(page)


def test_nothing_is_fetched(found, shape):
    page = page_of(found, shape=shape)
    assert "default-src 'none'" in page
    for tag, attributes in Words(page).tags:
        assert tag not in ("iframe", "object", "embed", "base")
        target = attributes.get("href") or attributes.get("src") or ""
        assert target == "" or target.startswith(("#", "data:"))


def test_the_same_bytes_every_time(found, shape):
    assert page_of(found, shape=shape) == page_of(found, shape=shape)


def test_static_poses_have_no_time_axis():
    log = log_of()
    poses = {name: log[name][::8] for name in ("orientation", "wrench")}
    page = page_of(identify(Recording(poses, static=True)))
    assert "recording" not in sections_of(page)
    figures = figures_of(page)
    force = figures["wrench-force"]
    assert force["layout"]["xaxis"]["title"]["text"] == "Pose"
    assert force["traces"][0]["x"][0] == 1.0
    assert {t["mode"] for t in force["traces"]} == {"markers"}
    assert "No shape was given" in text_of(page)
    assert "shape" not in {t["name"] for t in figures["object"]["traces"]}


def test_what_is_open_is_said_and_not_drawn():
    """Static poses leave the inertia open to a method without a prior."""
    log = log_of()
    poses = {name: log[name][::8] for name in ("orientation", "wrench")}
    found = identify(Recording(poses, static=True), method="OLS")
    page = page_of(found)
    assert "prior" not in sections_of(page)
    assert page.count('class="open"') == 6
    assert "No ellipsoid of equal inertia (estimate): inertia open." in text_of(page)


def test_what_is_open_has_no_value_although_a_prior_bounds_it():
    log = log_of()
    poses = {name: log[name][::8] for name in ("orientation", "wrench")}
    page = page_of(identify(Recording(poses, static=True)))
    shown, _, _ = page.partition('id="wrench"')
    assert shown.count('class="open"') == 6
    assert shown.count('class="at"') == 4
    for title in ("Moments of inertia", "Products of inertia"):
        group = shown.partition(title)[2].partition('class="scale"')[2]
        assert group.startswith("></div>")  # a scale without numbers
    figures = figures_of(page)
    for first, known in ((0, True), (1, True), (4, False), (5, False)):
        traces = figures[f"convergence-{first}"]["traces"]
        lines = [trace for trace in traces if trace["mode"] == "lines+markers"]
        assert all((y is not None) == known for line in lines for y in line["y"])
    assert "What is open has no line." in text_of(page)


def test_spans_are_marked_once_in_the_legend_and_are_not_too_many():
    spans = [Span("spike", float(i), i + 0.001, 1) for i in range(1_000)]
    spans += [Span("contact", 3.0, 4.0, 100)]
    shapes = list(marks(spans))
    assert sum(shape["showlegend"] for shape in shapes) == 2
    own = [shape for shape in shapes if shape["legendgroup"] == "spike"]
    assert len(own) == MOST_SPANS
    assert (own[0]["x0"], own[-1]["x1"]) == (0.0, 999.001)
    # joined, not dropped
    for spike in spans[:-1]:
        assert any(s["x0"] <= spike.start and spike.end <= s["x1"] for s in own)


def test_spikes_of_a_log_are_in_the_figure_and_in_words():
    log = log_of(10.0, 100.0)
    values = log["wrench"].values.copy()
    values[[200, 500, 501]] += 30.0
    wrench = Stream(log["wrench"].time, values)
    spiky = identify(replace(log, streams={**log.streams, "wrench": wrench}))
    page = page_of(spiky)
    shapes = figures_of(page)["wrench-force"]["layout"]["shapes"]
    ends = [(s["x0"], s["x1"]) for s in shapes if s["legendgroup"] == "spike"]
    assert len(ends) == 2
    assert np.array(ends) == pytest.approx(
        np.array(((2.0, 2.0), (5.0, 5.01))), abs=0.01
    )
    assert "Spikes of the sensor: 3 samples" in text_of(page)


def test_long_recordings_are_thinned_and_it_says_so():
    motion = UR5.motion(random_smooth(30.0, 100.0, 1.0, 2))
    log = simulate(motion, hammer().parameters.moved(POSE), noise=Noise(0.1, 0.005))
    found = identify(log, method="OLS")
    assert len(found.measurements) > 2_500
    page = page_of(found)
    assert "thinned for drawing" in text_of(page)
    for figure in figures_of(page).values():
        assert all(len(trace["x"]) <= 2_100 for trace in figure["traces"])
    curves = wrench_curves(found.measurements, found.estimate)
    drawn = figures_of(page)["wrench-force"]["traces"]
    residual = next(t for t in drawn if t["name"] == "residual x")
    assert max(residual["y"]) == pytest.approx(curves.residual[:, 0].max(), rel=1e-6)


def test_a_page_with_a_large_mesh_is_small_enough(found):
    ball = trimesh.creation.icosphere(subdivisions=7, radius=0.1)
    assert len(ball.faces) > 300_000
    large = Shape.from_mesh(ball, points=200)
    assert len(page_of(found, shape=large).encode()) <= LARGEST


def test_controllers_are_those_of_the_export(found, shape):
    page = html.unescape(page_of(found, shape=shape, flange=POSE))
    for name in ("ur", "franka", "kuka", "xarm-ft"):
        pose = None if REGISTRY[name].in_sensor_axes else POSE
        assert export(found.estimate, name, pose).text.rstrip("\n") in page


def test_what_is_not_to_be_used_has_nothing_to_paste(found, shape):
    bad = replace(found.estimate, warnings=(error("x", "it was upside down"),))
    page = identification_page(bad, found.ingested, found.estimator, Context(shape))
    said = text_of(page)
    assert "Do not use." in said
    assert said.count("Nothing to paste: the estimate is not to be used") > 5
    assert "set_target_payload(" not in said


def test_several_recordings(shape):
    motion = UR5.motion(random_smooth(4.0, 50.0, 1.0, 5))
    held = hammer().parameters.moved(POSE)
    other = simulate(motion, held, noise=Noise(0.1, 0.005), seed=5)
    found = identify([log_of(), other], shape)
    page = page_of(found, shape=shape)
    time = figures_of(page)["wrench-force"]["traces"][0]["x"]
    # no line is drawn from one to the next
    first = len(found.ingested.recordings[0].measurements)
    assert [k for k, t in enumerate(time) if t is None] == [first]
    kept = [t for t in time if t is not None]
    assert len(kept) == len(found.measurements)
    assert kept == sorted(kept)
    for figure in figures_of(page).values():
        if "xaxis" in figure["layout"]:
            title = figure["layout"]["xaxis"]["title"]["text"]
            assert title == "Time, one recording after the other [s]"


def test_a_recording_that_tells_nothing_is_inspected_all_the_same():
    log = log_of()
    page = inspection_page(inspect(Recording({"orientation": log["orientation"]})))
    assert sections_of(page) == ["answer", "streams"]
    assert "Do not use." in text_of(page)
    assert figures_of(page) == {}
    assert 'id="plotly"' not in page


def test_bars_clip_what_is_wider_and_hatch_what_is_open():
    shown = bars(
        [
            Row("a", 1.0, 0.5, 1.5),
            Row("b", 1.0, -50.0, 50.0, matters=False),
            Row("c", 1.0, -np.inf, np.inf),
            Row("d", 1.0, np.nan, np.nan, truth=1.2),
        ],
        "kg",
    )
    assert shown.count('class="range"') == 2
    assert shown.count('class="open"') == 1
    assert shown.count('class="at"') == 3
    assert shown.count('class="true"') == 1
    assert "width:100.000%" in shown
    assert "1.00 ± 0.50 kg" in shown
    shares = [float(x) for x in re.findall(r"width:([\d.]+)%", shown)]
    assert all(0.0 <= share <= 100.0 for share in shares)


# on the command line


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    write_log(log_of(), folder / "log.csv")
    return folder


def test_names_that_cannot_be_written(run, folder, tmp_path):
    log = folder / "log.csv"
    assert refused(run("identify", log, "--report", tmp_path / "r.pdf"), ".html")
    nowhere = tmp_path / "no" / "r.html"
    assert refused(run("inspect", log, "--report", nowhere), "folder does not exist")
    page = tmp_path / "log.html"
    page.write_bytes(log.read_bytes())
    before = page.read_bytes()
    words = "identify", log, "--map", page, "--report", page
    assert refused(run(*words), "is an input")
    assert page.read_bytes() == before


def test_json_stays_one_object_beside_a_report(run, folder, tmp_path):
    path = tmp_path / "r.html"
    status, out, err = run("identify", folder / "log.csv", "--json", "--report", path)
    assert (status, err) == (0, "")
    assert json.loads(out)["method"] == "Bayes"
    assert path.read_text().startswith("<!doctype html>")
    said = text_of(path.read_text())
    assert f"hefting identify {folder / 'log.csv'} --json --report {path}" in said


def test_what_to_install_is_said_before_anything_is_read(
    run, folder, tmp_path, monkeypatch
):
    import hefting.page.html as html_

    monkeypatch.setattr(html_, "find_spec", lambda name: None)
    path = tmp_path / "r.html"
    status, out, err = run("identify", folder / "no.csv", "--report", path)
    assert status in (1, 2)
    assert out == ""
    assert "hefting[view]" in err
    with pytest.raises(MissingDependencyError, match="plotly"):
        html_.require_plotly()
    assert not path.exists()


def test_nothing_of_it_is_imported_without_a_report(run, folder, monkeypatch):
    for name in [n for n in sys.modules if n.startswith("hefting.page")]:
        monkeypatch.delitem(sys.modules, name)
    assert run("identify", folder / "log.csv")[0] == 0
    assert not [n for n in sys.modules if n.startswith("hefting.page")]
