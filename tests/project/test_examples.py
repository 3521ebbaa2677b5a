"""Each example runs as a script in an empty folder, and what its text claims is so."""

import os
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="matplotlib is not installed: hefting[plot]")

import matplotlib.font_manager  # noqa: F401 (writes its cache when first imported)

from hasty_pictures import draw_hastily
from jobs_here import do_jobs_here, understand_here
from project.environments import ROOT

FOLDER = ROOT / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
MODULES = {"plot": "matplotlib", "sim": "mujoco", "robot": "pinocchio"}
"""What an extra brings."""
HEAD = re.compile(r"``pip install 'hefting\[([\w,]+)\]'( \w+)?``")
SMALLEST = {".png": 2000, ".svg": 10_000}
"""Bytes of a picture with something in it; the PNG is of few pixels here."""
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Written:
    """Paths that this process opens to write to, while it watches."""

    def __init__(self):
        self.watches, self.paths = False, []
        sys.addaudithook(self.hear)

    def hear(self, event, args):
        """Keep the path, unless Python keeps a module's bytecode there."""
        if self.watches and event == "open" and isinstance(args[0], str | os.PathLike):
            path, mode, flags = str(args[0]), args[1] or "", args[2]
            writes = set(mode) & set("wax+") or (not mode and flags & WRITES)
            if writes and "__pycache__" not in path:
                self.paths.append(Path(os.path.abspath(path)))


@pytest.fixture(scope="module")
def written():
    """One for all, as such a hook cannot be taken away."""
    return Written()


def inside(found, name, true):
    """Whether the true numbers are inside the 95 % intervals."""
    low, high = found.interval(name)
    return bool(np.all((low <= true) & (true <= high)))


def width(found, name="mass"):
    """Of a mass's interval."""
    low, high = found.interval(name)
    return float(np.max(high - low))


def codes(found):
    """Of the reasons of a verdict."""
    return [reason.code for reason in found.verdict.reasons]


def own_arrays(names, printed):
    """Found as it is, from arrays alone."""
    found, true = names["found"], names["held"].parameters
    assert found.verdict.usable
    assert inside(found, "mass", true.mass)
    assert inside(found, "center_of_mass", true.center_of_mass)


def log_step_by_step(names, printed):
    """Each fault is found; what the prediction leaves is the sensor's noise."""
    seen, found, faults = names["seen"], names["found"], names["faults"]
    assert seen.sign.name == "on-sensor"
    assert "spikes" in printed
    offset = found.ingested.conditioned
    # four standard deviations of what is found
    assert abs(offset.offset - faults.wrench_delay) < 4.0 * offset.offset_std
    np.testing.assert_allclose(seen.facts.bias, faults.bias, atol=0.05)
    noise = np.reshape(faults.wrench_noise, (2, 3)).mean(axis=1)
    # the root mean square of 600 samples is within some per cent of the deviation;
    # a prediction adds its own error
    assert np.all(np.array(names["prediction"].agreement.varying) < 1.2 * noise)


def turned_sensor(names, printed):
    """The turn is found and named, and giving it mends the answer."""
    wrong, mended, true = names["wrong"], names["mended"], names["body"]
    assert not wrong.verdict.usable
    assert "axes-turned" in codes(wrong)
    assert "z:30" in printed
    assert {span.cause for span in wrong.ingested.left_out} == {"contact"}
    assert not mended.ingested.left_out
    assert mended.verdict.usable
    assert inside(mended, "center_of_mass", true.center_of_mass)
    assert not inside(wrong, "center_of_mass", true.center_of_mass)


def without_a_mesh(names, printed):
    """Shape makes the inertia surer, and the mass hardly; the truth is inside."""
    found, true = list(names["found"].values()), names["body"]
    widths = [width(each, "inertia") for each in found]
    assert widths == sorted(widths, reverse=True)
    assert widths[0] > 2.0 * widths[1]
    masses = [width(each) for each in found]
    assert max(masses) < 1.02 * min(masses)
    assert all(inside(each, "inertia", true.inertia_at_com) for each in found)


def gripper_and_object(names, printed):
    """The gripper is subtracted, its uncertainty counts, a scale narrows."""
    alone, body = names["alone"], names["body"]
    assert inside(names["tool"], "mass", names["gripper"].mass)
    assert inside(alone, "mass", body.mass)
    assert inside(names["both"], "mass", names["gripper"].mass + body.mass)
    assert width(alone) > width(names["tool"])
    assert width(names["weighed"]) < 0.5 * width(alone)


def two_recordings(names, printed):
    """Two are surer than one; the third is named."""
    alone, together = names["alone"].values(), names["together"]
    assert all(width(together) < width(each) for each in alone)
    assert together.verdict.usable
    assert inside(together, "mass", names["body"].mass)
    assert not names["contradicting"].verdict.usable
    assert "recordings-contradict" in codes(names["contradicting"])
    assert "(3) contradicts the others" in printed


def all_methods(names, printed):
    """One is recommended; not every method finds a body that can exist."""
    compared = names["compared"]
    assert list(compared.results) == list(names["METHODS"])
    assert compared.recommended in printed
    exists = [each.physically_consistent for each in compared.results.values()]
    assert any(exists)
    assert not all(exists)


def static_poses(names, printed):
    """Mass and COM are found, the inertia stays open everywhere."""
    found, body = names["found"], names["body"]
    assert inside(found, "mass", body.mass)
    assert inside(found, "center_of_mass", body.center_of_mass)
    assert found.estimate.undetermined.inertia_at_com.all()
    assert "xx open, xy open, xz open" in printed
    assert "set_target_payload(" in printed
    assert "mjcf needs an inertia" in printed


def joint_torques(names, printed):
    """An empty run tells more than a published arm."""
    published, known = names["found"].values()
    assert [warning.code for warning in published.warnings] == ["arm-published"]
    assert not known.warnings
    true = names["held"].parameters
    for each in (published, known):
        assert inside(each, "mass", true.mass)
        assert inside(each, "center_of_mass", true.center_of_mass)
    assert width(known) < 0.2 * width(published)


def live_until_sure(names, printed):
    """It stops before the end, when what was asked for is met, and rightly so."""
    last, true = names["last"], names["held"].parameters
    assert last.sufficient
    assert names["stopped"] < 0.9 * names["time"][-1]
    assert not names["history"][-2][1].sufficient
    assert names["asked"].met_by(last.accuracy)
    assert inside(last, "mass", true.mass)


def next_motion(names, printed):
    """The plan is better than another motion by hand, about as forecast."""
    by_hand, planned = names["twice"], names["planned"]
    widths = [
        np.diag(each.estimate.half_widths["inertia_at_com"]).max()
        for each in (by_hand, planned)
    ]
    assert widths[1] < 0.2 * widths[0]
    forecast = np.diag(names["plan"].forecast.inertia[-1]).max()
    assert 0.5 < widths[1] / forecast < 2.0
    assert names["plan"].usage["corner_speed"] <= 1.0


def many_recordings(names, printed):
    """All but the broken one are identified; its row says why."""
    found = names["found"]
    failed = [name for name, *_, error in found if error]
    assert failed == ["sledge"]
    assert len(found) == 2 * len(names["HEADS"])
    assert names["done"].summary.verdicts["good"] == len(found) - 1
    for name, mass, low, high, error in found:
        assert error or low < names["body_of"](names["HEADS"][name]).mass < high
        assert error or low < mass < high


def drop_in_mujoco(names, printed):
    """Dropped, all fall alike; thrown, the identified one follows the true one."""
    off = {
        (how, name): np.linalg.norm(path - each["true"], axis=1).max()
        for how, each in names["paths"].items()
        for name, path in each.items()
    }
    assert max(off["dropped", name] for name in names["models"]) < 1e-9
    assert off["thrown", "identified"] < 0.01 * off["thrown", "even density"]
    fall = names["paths"]["dropped"]["true"]
    time = 1e-3 * np.arange(1, len(fall) + 1)
    # MuJoCo's gravity is 9.81 m/s²; a fall under it, by a method of the fourth order
    np.testing.assert_allclose(fall[:, 2] - names["HEAD"][2], -0.5 * 9.81 * time**2)


def in_a_notebook(names, printed):
    """Everything that is shown is on the page, which has no scripts."""
    page = Path("in_a_notebook.html").read_text(encoding="utf-8")
    assert page.count('class="hefting"') == len(names["parts"])
    assert "<script" not in page


def error_by_speed(names, printed):
    """Least squares needs speed; what knows the shape is better at the slowest."""
    table = names["table"]
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    slow = [row for row in rows if row["rad/s"] == 1.0 and row["noise"] != "none"]
    assert len(slow) == 3
    for row in slow:
        known = max(row["GEO: inertia %"], row["PMD: inertia %"])
        assert known < 0.2 * min(row["OLS: inertia %"], row["RTLS: inertia %"])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_keeps_its_word(
    path, written, tmp_path, monkeypatch, capsys
):
    text = path.read_text(encoding="utf-8")
    head = HEAD.search(text.replace("\n", " "))
    assert head, "the head says what to install"
    assert f"``python examples/{path.name}``" in text.replace("\n", " ")
    for extra in head[1].split(","):
        pytest.importorskip(MODULES[extra], reason=f"needs hefting[{extra}]")
    if head[2]:
        pytest.importorskip(head[2].strip())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    draw_hastily(monkeypatch)
    do_jobs_here(monkeypatch)
    understand_here(monkeypatch)
    written.watches, written.paths = True, []
    try:
        names = runpy.run_path(str(path), run_name="__main__")
    finally:
        written.watches = False
    printed, errors = capsys.readouterr()
    assert errors == ""
    assert re.search(r"\d", printed)
    assert not re.search(r"\b(nan|inf)\b", printed)
    here = tmp_path.resolve()
    assert written.paths
    assert not [each for each in written.paths if here not in each.resolve().parents]
    for suffix, smallest in SMALLEST.items():
        assert (tmp_path / f"{path.stem}{suffix}").stat().st_size > smallest
    globals()[path.stem](names, printed)


def test_what_an_example_writes_elsewhere_is_seen(written, tmp_path):
    written.watches, written.paths = True, []
    try:
        (tmp_path / "a").write_text("b")
        (tmp_path / "a").read_text()
        os.close(os.open(tmp_path / "c", os.O_WRONLY | os.O_CREAT))
    finally:
        written.watches = False
    assert written.paths == [tmp_path / "a", tmp_path / "c"]
