"""docs/tutorial.md: its commands run as written, one after the other, from an empty
folder, and print the lines that it shows."""

import re
import shlex
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib", reason="the demo draws: hefting[plot]")

from hasty_pictures import draw_hastily
from hefting.cli import main

pytestmark = pytest.mark.usefixtures("same_commands")

TEXT = (Path(__file__).parents[2] / "docs" / "tutorial.md").read_text()
BLOCKS = re.findall(r"```(sh|text)\n(.*?)```", TEXT, re.DOTALL)


def masked(line):
    """Without the numbers, whose last digits depend on the machine, and the width of a
    table."""
    return re.sub(r"[-+]?\d[\d.]*|[─━ ]+", "#", line)


def test_every_command_and_what_it_shows(tmp_path, monkeypatch, capsys):
    draw_hastily(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    printed = ""
    shown = 0
    for kind, text in BLOCKS:
        if kind == "sh":
            for line in text.splitlines():
                monkeypatch.setattr(sys, "argv", shlex.split(line))
                main()
            printed, error = capsys.readouterr()
            assert error == ""
            continue
        said = {masked(line) for line in printed.splitlines()}
        for line in text.splitlines():
            assert masked(line) in said, line
            shown += 1
    assert shown > 10
    for name in ("demo/log.csv", "hammer.json", "hammer.xml"):
        assert (tmp_path / name).stat().st_size > 0


def test_the_shape_narrows_the_inertia_as_said():
    """The numbers of the text are those of the demo, to their digits."""
    import hefting
    from hefting.core.measurements import NOISE_LEVELS
    from hefting.simulation import UR5, hammer, simulate, sinusoids
    from hefting.simulation.demo import NOISE, POSE, SEED
    from hefting.simulation.wield import POSE_NOISE

    held = hammer()
    log = simulate(
        UR5.motion(sinusoids(10.0, 100.0, 1.0)),
        held.parameters.moved(POSE),
        noise=NOISE_LEVELS[NOISE],
        pose_noise=POSE_NOISE,
        seed=SEED,
    )
    said = re.search(
        r"Jyy goes from ([\d.]+) to ([\d.]+) kg m²\s+down to ([\d.]+) to ([\d.]+)", TEXT
    )
    assert said
    without = hefting.identify(log).interval("inertia")[:, 1, 1]
    shape = hefting.Shape.from_mesh(held.mesh(), pose=POSE)
    with_it = hefting.identify(log, shape).interval("inertia")[:, 1, 1]
    numbers = [float(each) for each in said.groups()]
    # half of the last digit that is shown, and as much for another machine
    assert numbers[:2] == pytest.approx(without, abs=1e-4)
    assert numbers[2:] == pytest.approx(with_it, abs=1e-5)
