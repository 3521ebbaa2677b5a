"""`PYTHONPATH=. python docs/mistake_pictures.py`: makes each mistake that is looked for in
a simulated recording, identifies it, and writes fails.md with what was said and a
picture of each."""

import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.given import Given, Mistake, correct
from benchmarks.mistaken import mistakes
from matplotlib.figure import Figure
from PIL import Image
from scipy.interpolate import make_interp_spline

import hefting
from hefting.cli import render
from hefting.core.files import write_atomically
from hefting.core.regressor import predict_wrench
from hefting.plots.style import COMPONENTS, INK, MEASURED, SHADOW, style
from mistake_cases import CASES, HEAD, TAIL, Case

HERE = Path(__file__).parent
FOLDER = HERE / "mistakes_seen"
COLOURS = 48
"""Of a picture: it has few, and is a third of the size so."""


GAP = 0.1
"""Time between samples from which on something was left out [s]."""
LABELS = ("force [N]", "force that remains [N]", "torque that remains [N m]")


def warming_up(given: Given, rng: np.random.Generator) -> Given:
    """6 s in which the bias settles, by 3 N and 0.15 N m at first."""
    step = np.repeat((3.0, 0.15), 3) * rng.uniform(0.5, 1.0, 6)
    given = given.wrench(lambda t, w: w + np.outer(np.exp(-(t - t[0]) / 4.0), step))
    first = float(given.recording["wrench"].time[0])
    return replace(given, recording=given.recording.slice(first, 6.0))


def hand_on_object(given: Given, rng: np.random.Generator) -> Given:
    """A force and a torque that change at random, by 1 N and 0.05 N m each 0.3 s."""
    size = np.repeat((1.0, 0.05), 3)

    def pushed(t: np.ndarray, wrench: np.ndarray) -> np.ndarray:
        instants = np.arange(t[0], t[-1] + 0.6, 0.3)
        pushes = size * rng.normal(size=(len(instants), 6))
        return wrench + make_interp_spline(instants, pushes, k=1)(t)

    return given.wrench(pushed)


OTHERS = (
    Mistake("warming up", "6 s", warming_up, frozenset({"drift-in-short"})),
    Mistake("a hand on the object", "1 N", hand_on_object, frozenset({"unexplained"})),
)
"""Besides those of `benchmarks.mistaken`."""


def main() -> None:
    """Write the page and its pictures."""
    made = {(each.name, each.strength): each for each in (*mistakes(), *OTHERS)}
    lines = [HEAD]
    for part, cases in CASES.items():
        lines.append(f"\n## {part}\n")
        for case in cases:
            lines.append(section(case, made[case.made]))
            print(case.title)
    write_atomically(HERE / "fails.md", "".join(lines) + TAIL)


def section(case: Case, mistake: Any) -> str:
    """The mistake's part of the page; its picture is written."""
    rng = np.random.default_rng([16, case.seed])
    given = mistake.make(correct(case.seed, mistake.imu), rng)
    try:
        found = hefting.identify(given.recording, **given.options)
    except hefting.InputError as error:
        raise SystemExit(f"{case.title}: {error}; another seed?") from error
    said = [*found.warnings, *found.estimate.provenance["notes"]]
    texts = [text_of(each) for each in said if code_of(each) == case.code]
    if not texts:
        raise SystemExit(f"{case.title}: {case.code} is not said; another seed?")
    name = f"mistakes_seen/{case.code}.png"
    write_atomically(
        HERE / name, picture(found, given.recording["wrench"].time[[0, -1]])
    )
    quoted = "\n".join(f"> {text}" for text in texts[:1])
    return (
        f"\n### {case.title}\n\n{case.what} Code `{case.code}`, verdict *{found.verdict}*:\n\n"
        f"{quoted}\n\n![Force and residual]({name})\n"
    )


def code_of(said: Any) -> str:
    """Code of a warning, or of a note as JSON has it."""
    return said["code"] if isinstance(said, dict) else said.code


def text_of(said: Any) -> str:
    """Its text, as the command says it."""
    text = said["text"] if isinstance(said, dict) else str(said)
    return re.sub(r"(--[a-z-]+(?: (?!and |\()[^ )]+)?)", r"`\1`", render(text))


def picture(found: hefting.Identification, ends: np.ndarray) -> bytes:
    """Force as recorded and as predicted, and what remains of force and torque; what
    was left out is grey: PNG of few colours."""
    z, estimate = found.measurements, found.estimate
    predicted = predict_wrench(z, estimate.parameters.vector)
    if estimate.bias is not None:
        predicted += estimate.bias
    time = np.array(z.time)
    starts = np.flatnonzero(np.diff(time) > GAP) + 1
    with style():
        figure = Figure(figsize=(7.2, 1.45), layout="constrained")
        force, left, turning = figure.subplots(1, 3, sharex=True)
        for i, colour in enumerate(COMPONENTS.values()):
            for part in np.split(np.arange(len(time)), starts):
                t, line = time[part], {"color": colour, "linewidth": 0.6}
                force.plot(t, z.wrench[part, i], color=colour, **MEASURED)
                force.plot(t, predicted[part, i], **line)
                left.plot(t, z.wrench[part, i] - predicted[part, i], **line)
                turning.plot(t, z.wrench[part, 3 + i] - predicted[part, 3 + i], **line)
        for axes, label in zip((force, left, turning), LABELS, strict=True):
            for low, high in (
                (ends[0], time[0]),
                *zip(time[starts - 1], time[starts], strict=True),
                (time[-1], ends[1]),
            ):
                if high - low > GAP:
                    axes.axvspan(low, high, color=SHADOW, linewidth=0.0)
            axes.set_title(label)
            axes.set_xlabel("time [s]")
        for axes, span in zip(
            (left, turning), (z.wrench[:, :3], z.wrench[:, 3:]), strict=True
        ):
            half = max(np.abs(axes.get_ylim()).max(), 0.08 * float(np.ptp(span)))
            axes.set_ylim(-half, half)
            axes.axhline(0.0, color=INK, linewidth=0.4)
        content = io.BytesIO()
        figure.savefig(content, dpi=130)
    picture, small = Image.open(content).convert("RGB"), io.BytesIO()
    picture.quantize(COLOURS).save(small, "PNG", optimize=True)
    return small.getvalue()


if __name__ == "__main__":
    main()
