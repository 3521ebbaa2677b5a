"""docs/batch.md: its manifests, commands and code work as written, one after the other,
on three small recordings and a broken one; it names every column."""

import re
import shlex
from pathlib import Path

import pytest

pytest.importorskip("plotly", reason="plotly is not installed: hefting[view]")
pytest.importorskip("duckdb")

from hefting.batches.columns import columns
from hefting.cli import build_parser, main
from hefting.core.measurements import Noise
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE
from jobs_here import do_jobs_here

PAGE = Path(__file__).parents[2] / "docs" / "batch.md"
TEXT = PAGE.read_text()
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", TEXT, flags=re.DOTALL)


def write_recordings(folder):
    """Three of the demo's hammer, one without a sample, and the mesh."""
    folder.mkdir()
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4)}
    held = hammer()
    body = held.parameters.moved(POSE)
    for k in (1, 2, 3):
        log = simulate(
            UR5.motion(sinusoids(4.0, 50.0, 1.0 + 0.2 * k)), body, seed=k, **noise
        )
        write_log(log, folder / f"{k}.csv")
    (folder / "broken.csv").write_text("time,fx\n")
    held.mesh().export(folder.parent / "hammer.ply")


def run_as_written(words):
    """A command of the page. One on a cluster is only read: there is none."""
    if "--scheduler" in words:
        build_parser(words).parse_args(words)
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["hefting", *words])
        main()


def test_every_block_works_as_written(tmp_path, monkeypatch, capsys):
    """In this process: four recordings are too few for others."""
    do_jobs_here(monkeypatch)
    write_recordings(tmp_path / "monday")
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for language, text in BLOCKS:
        if language in ("csv", "toml"):
            Path(f"manifest.{language}").write_text(text)
        elif language == "sh":
            for line in text.splitlines():
                run_as_written(shlex.split(line)[1:])
        elif language == "python":
            exec(compile(text, PAGE.name, "exec"), names)
    printed = capsys.readouterr().out
    assert "4 recordings in" in printed
    assert "columns 'fy', 'fz'" in printed
    # of four rows one fails, with every manifest and from Python
    assert names["found"].summary.failed == 1
    assert Path("monday.html").stat().st_size > 1_000_000
    # DuckDB's table; the mass of the hammer is 0.67 kg
    assert re.search(r"hammer\s*│\s*2\s*│\s*0\.67", printed)
    good = names["good"]
    assert good["mass"].tolist() == pytest.approx([0.67] * 3, rel=0.02)


def test_the_page_names_every_column():
    section = TEXT.split("| column | |", 1)[1].split("\n\n", 1)[0]
    cells = [line.split("|")[1] for line in section.splitlines() if line.count("|") > 2]
    named = [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]
    assert sorted(named) == sorted(columns().names)


def typed_for_dask():
    """Words after ``dask`` of every command of the page, in consoles and containers."""
    yaml = pytest.importorskip("yaml")
    for language, text in BLOCKS:
        if language == "console":
            commands = re.findall(r"\bdask ([^&|\n]*)", text)
            yield from (
                shlex.split(each.replace("$(", "").replace(")", ""))
                for each in commands
            )
        elif language == "yaml":
            spec = yaml.safe_load(text)["spec"]
            for part in ("worker", "scheduler"):
                (container,) = spec[part]["spec"]["containers"]
                assert container["command"][0] == "dask"
                yield container["command"][1:]


def test_what_is_typed_for_a_cluster_is_known_to_dask():
    """By the parsers of the installed packages: SSH, Kubernetes and Slurm."""
    pytest.importorskip("distributed")
    from distributed.cli import dask_scheduler, dask_ssh, dask_worker

    parsers = {"ssh": dask_ssh, "worker": dask_worker, "scheduler": dask_scheduler}
    typed = list(typed_for_dask())
    assert sorted(words[0] for words in typed) == [
        *("scheduler", "scheduler", "ssh", "worker", "worker")
    ]
    for name, *words in typed:
        context = parsers[name].main.make_context(name, words)
        if name != "scheduler":
            assert context.params["nthreads"] == 1
