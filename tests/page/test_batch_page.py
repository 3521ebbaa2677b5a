"""The page of a batch: its numbers are those of the table, its links lead to the
recordings, its commands can be typed, and it is small however many rows there are."""

import json
import re
import shlex
from pathlib import Path
from urllib.parse import unquote, urlparse

import numpy as np
import pytest

pytest.importorskip("plotly", reason="plotly is not installed: hefting[view]")

import plotly.graph_objects as go
from batch_rows import batch_of, doubted, failed, identified, spread, start

from hefting.cli import build_parser
from hefting.cli.report.batch import batch_report
from hefting.page import Context
from hefting.page.batch import LONGEST, MOST_REASONS, batch_page
from hefting.page.figure import LIGHT, histogram
from hefting.request.request import given_options
from html_pages import Words, figures_of, sections_of, text_of

LARGEST = 5_000_000
"""Bytes of a page at most."""
HOSTILE = "</script><img src=x onerror=\"alert('1')\"> $(x)\n&amp;#%.csv"


def links_of(page):
    return [dict(a)["href"] for tag, a in Words(page).tags if tag == "a"]


def commands_of(page):
    """The commands that look at a row, as they would be copied."""
    found = re.findall(r'<pre class="wrap" id="look-\d+">(.*?)</pre>', page, re.DOTALL)
    return [" ".join(Words(each).words) if each else "" for each in found]


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """Thirty good rows, one far off, two in doubt, one not to use, some that failed."""
    rows = [
        *spread(30),
        identified("far.csv", residual=(9.0, 0.005)),
        doubted("a.csv", "stiff", "see `gravity`"),
        doubted("b.csv", "stiff", "see `gravity`"),
        doubted("never.csv", "wrong", "it is wrong", "do not use"),
        *(failed(f"empty-{k}.csv", "the file is empty") for k in range(7)),
        failed("text.csv", "row 7: 'x' is not a number"),
    ]
    return batch_of(tmp_path_factory.mktemp("mixed"), rows)


def test_the_numbers_are_those_of_the_table(mixed):
    page = batch_page(mixed)
    text = text_of(page)
    assert "34 of 42 identified" in text
    assert "Good 31 (73.8 %)" in text
    assert "Usable with care 2 (4.76 %)" in text
    assert "Do not use 1 (2.38 %)" in text
    assert "Failed 8 (19 %)" in text
    assert "7 the file is empty InputError" in text
    assert "2 stiff see `gravity`" in text
    assert "42 recordings in 10.0 s, 4.2 a second" in text
    # seconds of each of 42 rows: 0.1, 0.2, 0.6, 0.1
    assert "conditioning 25.2 s (60 %)" in text
    assert sections_of(page) == [
        *("verdicts", "outliers", "failures", "doubts", "sizes", "times"),
    ]


def test_the_readers_names_and_the_command(mixed):
    context = Context(command="hefting batch 'a b'", say=lambda text: text.upper())
    text = text_of(batch_page(mixed, context))
    assert "SEE `GRAVITY`" in text
    assert "hefting batch 'a b'" in text


def test_outliers_have_a_link_and_a_command_that_can_be_typed(mixed):
    page = batch_page(mixed)
    outliers = mixed.summary.outliers
    assert [each.name for each in outliers] == ["never.csv", "far.csv"]
    assert "times the median" in text_of(page)
    targets = [urlparse(link) for link in links_of(page)]
    paths = [Path(unquote(each.path)) for each in targets if each.scheme == "file"]
    for outlier in outliers:
        assert Path(outlier.recording).absolute() in paths
    commands = commands_of(page)
    assert len(commands) == 2
    for words, outlier in zip(map(shlex.split, commands), outliers, strict=True):
        typed = build_parser(words[1:]).parse_args(words[1:])
        assert typed.log == [outlier.recording]
        assert typed.report == f"{Path(outlier.recording).stem}.html"
        assert (typed.shape, typed.gravity) == ("a mug.stl", "-1,0,-9.7")


def test_of_recordings_that_are_alike_none_is_far_off(tmp_path):
    """Copies of one, and one with 1.4 times their residual; 1.6 times is."""
    for times, told in ((1.4, 0), (1.6, 1)):
        rows = [identified(f"{k}.csv", residual=(0.1, 0.005)) for k in range(30)]
        rows.append(identified("far.csv", residual=(0.1, times * 0.005)))
        found = batch_of(tmp_path / str(times), rows)
        assert len(found.summary.outliers) == told


def test_a_recording_is_worth_a_look_once(tmp_path):
    """Also where its verdict and its residual are."""
    never = doubted("never.csv", "wrong", "it is wrong", "do not use")
    rows = [*spread(30), never | {"residual": [9.0, 0.005]}]
    [outlier] = batch_of(tmp_path / "results", rows).summary.outliers
    assert outlier.why.startswith("do not use: it is wrong; force residual of 9 N")


@pytest.mark.parametrize("name", [HOSTILE, "-x.csv", "a b'c.csv", "ü:y?.csv"])
def test_hostile_names_are_only_text(tmp_path, name):
    """In links, texts and commands, which say nothing else to a shell."""
    rows = [
        doubted(name, name, f"{name} is wrong", "do not use"),
        failed(name + "2", "no"),
    ]
    page = batch_page(batch_of(tmp_path / "results", rows))
    tags = Words(page).tags
    assert not [tag for tag, _ in tags if tag == "img"]
    assert not [a for _, names in tags for a in names if a.startswith("on")]
    paths = [unquote(urlparse(link).path) for link in links_of(page)]
    assert str(Path(name).absolute()) in paths
    words = re.search(r'<pre class="wrap" id="look-0">(.*?)</pre>', page, re.DOTALL)[1]
    typed = shlex.split("".join(Words(words).words))
    assert Path(typed[2]) == Path(name)
    assert not typed[2].startswith("-")
    report = typed[-1]
    assert "/" not in report
    assert not report.startswith("-")


def test_every_option_of_a_row_is_one_of_the_command(tmp_path):
    options = given_options(
        {"hull": True, "points": 40, "start": 1.5, "pose_std": "1mm,1deg"}
    )
    row = doubted("log.csv", "x", "wrong", "do not use")
    row["options"] = json.dumps(options)
    page = batch_page(batch_of(tmp_path / "results", [row]))
    [words] = map(shlex.split, commands_of(page))
    typed = vars(build_parser(words[1:]).parse_args(words[1:]))
    assert {name: typed[name] for name in options} == options


def test_objects_of_several_recordings(tmp_path):
    """An object has no path: its command names all its recordings, if they are few."""
    left_out = [
        {"recording": f"{k}.csv", "error": "InputError", "error_text": f"{k}.csv: no"}
        for k in range(3)
    ]
    rows = [
        doubted(None, "x", "wrong", "do not use", object="mug", left_out=left_out)
        | {"recordings": ["a.csv", "b.csv"]},
        doubted(None, "x", "wrong", "do not use", object="cup")
        | {"recordings": [f"{k}.csv" for k in range(500)]},
        start(None, object="jar", error="InputError", error_text="z/1.csv: gone")
        | {"left_out": [left_out[0] | {"recording": "z/1.csv"}]},
    ]
    found = batch_of(tmp_path / "results", rows)
    page = batch_page(found)
    [reason] = found.summary.left_out
    assert (reason.text, reason.count) == ("no", 3)
    assert found.summary.reasons[0].text == "gone"
    assert "left-out" in sections_of(page)
    assert "3 recordings; what the others say" in text_of(page)
    [words] = map(shlex.split, commands_of(page))
    assert words[2:4] == ["a.csv", "b.csv"]
    assert words[-1] == "mug.html"
    assert "and 500" not in page


@pytest.mark.parametrize(
    ("rows", "sections"),
    [
        ([], ["verdicts", "times"]),
        ([failed("a.csv", "no")], ["verdicts", "failures", "times"]),
        ([identified("a.csv")], ["verdicts", "sizes", "times"]),
        ([identified("a.csv", residual=None)], ["verdicts", "sizes", "times"]),
    ],
    ids=["none", "all failed", "one", "no residual"],
)
def test_a_page_has_what_there_is(tmp_path, rows, sections):
    page = batch_page(batch_of(tmp_path / "results", rows))
    assert sections_of(page) == sections
    names = list(figures_of(page))
    if rows and rows[0].get("residual"):
        assert names == ["force", "torque", "mass"]
    elif "sizes" in sections:
        assert names == ["mass"]
        assert "1 rows have no residual" in text_of(page)


def test_why_a_row_is_not_to_be_used_is_short(tmp_path):
    reasons = [f"reason {k}" for k in range(40)]
    row = doubted("a.csv", "x", "reason 0", "do not use") | {"reasons": reasons}
    [outlier] = batch_of(tmp_path / "results", [row]).summary.outliers
    assert outlier.why == "do not use: reason 0 (and 39 more)"


@pytest.mark.parametrize(
    ("rows", "step"), [(1, 1), (5, 1), (6, 2), (26, 10), (5_000, 1_000)]
)
def test_rows_are_counted_in_whole_numbers(rows, step):
    """Plotly's own steps are halves where there are few, and rounded to 0, 1, 1, 2."""
    figure = histogram("h", "force", "N", np.full(rows, 2.0))
    assert figure.layout["yaxis"]["dtick"] == step


def test_histograms_count_every_value_once():
    """Oracle: the area under the curve over bins, and the median."""
    rng = np.random.default_rng(1)
    values = np.concatenate((rng.lognormal(size=999), [0.0, -1.0, np.nan, np.inf]))
    figure = histogram("h", "force", "N", values)
    x, y = figure.traces[0]["x"], figure.traces[0]["y"]
    assert sum(y[1:-1:2]) == 999
    assert x[0] == pytest.approx(values[:999].min(), rel=1e-6)  # seven digits
    assert x[-1] == pytest.approx(values[:999].max(), rel=1e-6)
    mark = figure.layout["shapes"][0]["x0"]
    assert mark == pytest.approx(np.median(values[:999]), rel=1e-6)
    assert histogram("h", "force", "N", np.array([np.nan, 0.0])) is None
    same = histogram("h", "force", "N", np.full(8, 2.0))
    assert sum(same.traces[0]["y"][1:-1:2]) == 8


def test_plotly_knows_every_attribute(mixed):
    """Oracle: plotly's own schema, which refuses what it does not know."""
    for figure in figures_of(batch_page(mixed)).values():
        text = re.sub(r'"@([\w-]+)"', lambda m: f'"{LIGHT[m[1]]}"', json.dumps(figure))
        plain = json.loads(text)
        go.Figure(plain["traces"], plain["layout"])


def test_a_page_of_many_rows_is_small(tmp_path):
    """Each failure says something else, in words, at length. A page of ten times as many
    rows is larger by 1.4 %, as its histograms have finer bins; 11 bytes of each row
    would make it 5 %."""
    words = ["".join(chr(97 + int(d)) for d in str(k)) for k in range(900)]
    rows = [
        *spread(100),
        *(failed(f"{word}.csv", f"{word} " + "long " * 500) for word in words),
    ]
    few = batch_page(batch_of(tmp_path / "few", rows))
    found = batch_of(tmp_path / "results", rows, copies=10)
    page = batch_page(found)
    assert found.summary.total == 10_000
    assert len(few.encode()) < len(page.encode()) < 1.05 * len(few.encode())
    assert len(page.encode()) < LARGEST
    assert "more for" in text_of(page)
    # one of the reasons that are shown stands for all after the first 500
    assert page.count("<td>InputError</td>") == MOST_REASONS - 1
    assert "4,000 other reasons" in " ".join(text_of(page).split())
    assert max(len(each) for each in Words(page).words) < LONGEST + 500


def test_the_same_bytes_every_time(mixed):
    assert batch_page(mixed) == batch_page(mixed)


def test_the_printed_report_names_the_page_that_shows_the_rest(tmp_path):
    rows = [doubted(f"{k}.csv", "wrong", "why", "do not use") for k in range(8)]
    found = batch_of(tmp_path / "r", rows)
    for page, said in ((None, "--report"), ("a.html", "a.html")):
        lines = map(str, batch_report(found, str, page))
        assert any(f"and 3 more; {said} shows them" in line for line in lines)
