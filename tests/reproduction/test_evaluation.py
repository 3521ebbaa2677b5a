"""Running the paper's experiments: whole and in part, interrupted, on processes and on
a cluster, and the page."""

import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
from base64 import b64decode
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import pytest

from browser import CHROMIUM, needs_browser
from clusters import local_cluster
from hefting.cli import main
from hefting.core.errors import HeftingError, InputError
from hefting.jobs import Jobs, Lost
from hefting.plots.style import picture_of
from hefting.reproduction import EXPERIMENTS, reproduce, run_experiments
from hefting.reproduction.experiment import Table, shown
from jobs_here import do_jobs_here

pytest.importorskip("mujoco", reason="mujoco is not installed")


def tables(folder: Path) -> dict[str, str]:
    """Contents of all tables, but for the times of density, which are measured."""
    found = {
        str(path.relative_to(folder)): path.read_text()
        for path in folder.glob("*/*.csv")
    }
    assert len(found) > 15
    return {name: text for name, text in found.items() if name != "density/times.csv"}


@pytest.fixture(scope="module", autouse=True)
def one_object():
    """The experiment that takes longest has jobs of one object only; with all of those
    of a quick run it is tested beside."""
    whole = EXPERIMENTS["observations"]
    few = [job for job in whole.jobs(True) if job["object"] == "tee"]
    assert len(few) == 3
    short = replace(whole, jobs=lambda quick: few)
    with patch.dict(EXPERIMENTS, observations=short):
        yield


def drawn_once(figure, suffix):
    """In place of `picture_of`: each figure is drawn for one of its two files, the
    other is of one pixel. That both hold what is drawn is tested in plots/."""
    return PIXEL if suffix == ".png" else picture_of(figure, suffix)


PIXEL = b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAA"
    "SUVORK5CYII="
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A quick run of everything, by the command, in this process; its pictures are not
    laid out, which takes most of the time and is tested beside."""
    folder = tmp_path_factory.mktemp("reproduction")
    words = ["reproduce", "--quick", "--jobs", "2", "--output", str(folder)]
    out, err = StringIO(), StringIO()
    with (
        patch("sys.argv", ["hefting", *words]),
        patch("hefting.plots.style.picture_of", drawn_once),
        patch("matplotlib.figure.Figure.draw_without_rendering"),
        pytest.MonkeyPatch.context() as monkeypatch,
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        do_jobs_here(monkeypatch)
        main()
    assert out.getvalue() == f"wrote {folder / 'index.html'}\n"
    assert err.getvalue() == ""
    return folder


class Page(HTMLParser):
    def __init__(self, text: str):
        super().__init__()
        self.links, self.anchors, self.open = [], set(), []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.anchors.add(found.get("id"))
        self.links += [found[name] for name in ("href", "src") if name in found]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_shows_every_experiment_and_its_files_are_there(folder):
    text = (folder / "index.html").read_text()
    page = Page(text)
    assert len(page.links) > 60
    for link in page.links:
        assert (
            link[1:] in page.anchors
            if link.startswith("#")
            else (folder / link).stat().st_size > 50
        ), link
    for experiment in EXPERIMENTS.values():
        assert f'<h2 id="{experiment.name}">' in text
    assert "A reduced run" in text
    assert re.search(r"hefting \d.*mujoco \d", text)
    assert "4 jobs: object hammer, half-n-half; speed 1, 2; seed 1" in text
    for block in text.split("<h2")[1:]:
        details = block.find("<details>")
        assert details < 0 or 0 < block.find("<table>") < details, (
            "the first table is not folded away"
        )


@needs_browser
def test_the_page_in_a_browser(folder, tmp_path):
    """It is as wide as the window, or scrolls inside; every picture is drawn."""
    script = (
        "<script>addEventListener('load', () => document.title = JSON.stringify({"
        "wide: document.documentElement.scrollWidth > innerWidth,"
        "broken: [...document.images].filter(i => !i.naturalWidth).length, pictures: document.images.length}))</script>"
    )
    page = folder / "checked.html"
    page.write_text(
        (folder / "index.html").read_text().replace("</body>", script + "</body>")
    )
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-background-networking",
    ]
    command += [
        "--no-first-run",
        "--disable-component-update",
        "--disable-sync",
        "--disable-quic",
    ]
    command += [
        f"--user-data-dir={tmp_path}",
        "--window-size=1000,800",
        "--virtual-time-budget=5000",
        "--dump-dom",
    ]
    done = subprocess.run(
        [*command, page.as_uri()], capture_output=True, text=True, check=True
    )
    page.unlink()
    found = json.loads(re.search(r"<title>(.*?)</title>", done.stdout)[1])
    assert found == {
        "wide": False,
        "broken": 0,
        "pictures": len(list(folder.glob("*/*.png"))),
    }


def test_published_figures_stand_beside_ours(folder):
    text = (folder / "observations" / "observations.md").read_text()
    for figure in ("1.34", "9.83", "44.1", "97.5"):
        assert figure in text


def test_a_second_run_does_nothing_again(folder):
    counts = []
    run_experiments(
        EXPERIMENTS.values(),
        folder,
        quick=True,
        progress=lambda *seen: counts.append(seen),
    )
    assert len(counts) == len(EXPERIMENTS)  # each told once, as done
    assert all(done == total > 0 for _, done, total in counts)


def test_a_stopped_run_goes_on(folder, tmp_path, monkeypatch):
    do_jobs_here(monkeypatch)
    shutil.copytree(folder / "results", tmp_path / "results")
    kept = sorted((tmp_path / "results" / "noise").iterdir())
    kept[0].unlink()
    kept[1].write_text('{"job"')  # cut short
    counts = []
    experiment = EXPERIMENTS["noise"]
    again = run_experiments(
        [experiment],
        tmp_path,
        quick=True,
        workers=1,
        progress=lambda *seen: counts.append(seen),
    )
    total = len(experiment.jobs(True))
    assert [done for _, done, _ in counts] == [total - 2, total - 1, total]
    assert again == run_experiments([experiment], folder, quick=True)


def test_a_killed_worker_costs_nothing_but_time(folder, tmp_path):
    killed = []

    def kill_one(name, done, total):
        if done == 1 and not killed:
            killed.extend(multiprocessing.active_children()[:1])
            killed[0].kill()

    experiment = EXPERIMENTS["stop-and-go"]  # two short jobs
    results = run_experiments(
        [experiment], tmp_path, quick=True, workers=1, progress=kill_one
    )
    assert killed
    assert results == run_experiments([experiment], folder, quick=True)


def test_a_cluster_gives_the_same_tables(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("hefting.plots.style.picture_of", drawn_once)
    pytest.importorskip("distributed", reason="distributed is not installed")
    # of several jobs and tables each, and quick: their pictures are drawn anew
    names = ("condition", "gravity", "stop-and-go")
    with local_cluster(1, processes=False, protocol="tcp") as cluster:
        reproduce(names, tmp_path, quick=True, scheduler=cluster.scheduler_address)
    ours = tables(folder)
    theirs = {
        str(p.relative_to(tmp_path)): p.read_text() for p in tmp_path.glob("*/*.csv")
    }
    assert len(theirs) > 5
    assert theirs == {name: ours[name] for name in theirs}


def test_what_cannot_be_run(tmp_path, monkeypatch, capsys):
    with pytest.raises(
        InputError,
        match=r"no experiment 'nois' \(did you mean 'noise'\?\); use objects, ",
    ):
        reproduce(["nois"], tmp_path)
    with pytest.raises(InputError, match="at least one process"):
        reproduce(["noise"], tmp_path, workers=0)
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made"):
        reproduce(["noise"], tmp_path / "file" / "folder")
    monkeypatch.setattr(sys, "argv", ["hefting", "reproduce", "--list"])
    main()
    lines = capsys.readouterr().out.splitlines()
    # what does not fit a line goes on, indented
    names = [line.split()[0] for line in lines if not line.startswith(" ")]
    assert names == list(EXPERIMENTS)


@pytest.mark.parametrize("taken", ["results", "results/stop-and-go", "stop-and-go"])
def test_a_folder_that_cannot_be_made_is_said(tmp_path, monkeypatch, taken):
    do_jobs_here(monkeypatch)
    (tmp_path / taken).parent.mkdir(exist_ok=True)
    (tmp_path / taken).write_text("")
    with pytest.raises(
        InputError, match=rf"^{re.escape(str(tmp_path / taken))}: cannot be made"
    ):
        reproduce(["stop-and-go"], tmp_path, quick=True)


def test_a_lost_scheduler_is_said_and_what_was_done_is_kept(
    tmp_path, capfd, monkeypatch
):
    monkeypatch.setattr("hefting.jobs.cluster.PATIENCE", "1s")
    distributed = pytest.importorskip(
        "distributed", reason="distributed is not installed"
    )
    cluster = distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        dashboard_address="127.0.0.1:0",
        host="127.0.0.1",
        silence_logs=60,
    )

    def close_at_first(name, done, total):
        if done == 1:
            cluster.close()

    address = cluster.scheduler_address
    with pytest.raises(
        HeftingError, match="the Dask scheduler was lost; the same command goes on"
    ):
        run_experiments(
            [EXPERIMENTS["noise"]],
            tmp_path,
            True,
            scheduler=address,
            progress=close_at_first,
        )
    assert len(list((tmp_path / "results" / "noise").iterdir())) == 1
    assert "Traceback" not in capfd.readouterr().err


def test_a_job_that_kills_its_worker_stops_no_other(tmp_path, monkeypatch):
    class OneLost(Jobs):
        def run(self, function, tasks, window=None):
            yield 0, Lost("its worker was killed")
            yield from ((k, {}) for k in range(1, len(tasks)))

    monkeypatch.setattr("hefting.reproduction.Jobs", OneLost)
    experiment = EXPERIMENTS["noise"]
    with pytest.raises(
        HeftingError, match=r"^a job of noise is lost: its worker was k"
    ):
        run_experiments([experiment], tmp_path, quick=True)
    kept = list((tmp_path / "results" / "noise").iterdir())
    assert len(kept) == len(experiment.jobs(True)) - 1


def test_threads_are_left_as_they_were(folder, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    run_experiments([EXPERIMENTS["stop-and-go"]], folder, quick=True)
    assert os.environ["OMP_NUM_THREADS"] == "3"


@pytest.mark.parametrize(
    ("cell", "text"),
    [
        (25e3, "25000"),
        (4543.2, "4540"),
        (999.6, "1000"),
        (1.22e6, "1.22e+06"),
        (3.5e-10, "3.5e-10"),
        (1500, "1500"),
    ],
)
def test_cells_as_they_are_read(cell, text):
    assert shown(cell) == text


def test_tables_in_three_forms():
    table = Table(
        "t",
        "A table",
        ("name", "x %", "y"),
        (("a", 1.23456, None), ("b, c", 2.0, "> 500")),
    )
    assert table.csv() == 'name,x %,y\na,1.23456,\n"b, c",2.0,> 500\n'
    assert json.loads(table.json())[1] == {"name": "b, c", "x %": 2.0, "y": "> 500"}
    assert (
        table.markdown()
        == "| name | x % | y |\n| --- | --- | --- |\n| a | 1.23 |  |\n| b, c | 2 | > 500 |\n"
    )
