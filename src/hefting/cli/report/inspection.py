"""An inspection as a person reads it: what the log holds, how it moves, the wrench, the
object, what to do next."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report.printing import verdict_texts, warning_lines
from hefting.cli.report.verdict import other_warnings
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.ingest.conditioned import SIGNIFICANT

if TYPE_CHECKING:
    from hefting.ingest import Conditioned, Drift
    from hefting.inspection import Inspection, Movement, StreamFacts, WrenchFacts

EVERYDAY = "about 5 in everyday handling"
"""Nadeau et al. 2022, sec. III."""


def inspection_report(found: "Inspection") -> Group:
    """Streams, motion, wrench, object, identifiability, and what to do next."""
    lasts = (
        f"{next(iter(found.streams.values())).samples} static poses"
        if found.static
        else f"{found.duration:.4g} s"
    )
    verdict = found.verdict
    lines: list[RenderableType] = [
        *verdict_texts(verdict),
        Text(f"{found.log}: {lasts}", style="bold"),
        _streams_table(found),
    ]
    lines += [Text(f"note: {line}") for line in found.notes]
    for title, said in (
        ("motion", _motion(found)),
        ("wrench", _wrench(found)),
        ("object", _object(found)),
        ("identifiability", _identifiability(found)),
    ):
        lines += [
            Text(title, style="bold"),
            *(Text(f"  {line}") if isinstance(line, str) else line for line in said),
        ]
    lines.extend(Text(f"next: {line}", style="green") for line in found.advice)
    return Group(*lines, *warning_lines(other_warnings(found.warnings, verdict)))


def _streams_table(found: "Inspection") -> Table:
    table = _table(
        "stream",
        "samples",
        *([] if found.static else ["rate", "gaps", "missing", "jitter"]),
        "repeated",
    )
    for name, facts in found.streams.items():
        cells = [] if found.static else _sampling(facts)
        table.add_row(
            name.replace("_", " "), str(facts.samples), *cells, _share(facts.repeated)
        )
    return table


def _sampling(facts: "StreamFacts") -> list[str]:
    if not facts.rate:
        return [""] * 4
    gaps = "none"
    if facts.gaps:
        gaps = f"{facts.gaps}, longest {_time(facts.longest_gap)}"
    jitter = (
        f"{_time(facts.jitter)} ({_share(facts.jitter_share)})"
        if facts.jitter > 1e-9
        else "none"
    )
    return [f"{facts.rate:.4g} Hz", gaps, _share(facts.missing), jitter]


def _motion(found: "Inspection") -> Iterable[str]:
    m = found.movement
    if m is None:
        yield f"not known: {found.missing['motion']}"
        return
    yield f"from {m.source}"
    if not found.static:
        yield f"angular speed {m.angular_speed[0]:.3g} rad/s on average, {m.angular_speed[1]:.3g} rad/s at most"
        if m.linear_speed is not None:
            yield f"linear speed {m.linear_speed[0]:.3g} m/s on average, {m.linear_speed[1]:.3g} m/s at most"
        yield _speed_limit(m)
        if m.dynamism is not None:
            yield f"dynamism {m.dynamism:.3g} (median)"
    yield f"gravity turned by up to {np.degrees(m.turn):.0f}° in sensor axes"
    yield _gravity(found)


def _gravity(found: "Inspection") -> str:
    hint = found.gravity_hint
    vector = (
        f"gravity ({', '.join(f'{x:.4g}' for x in found.gravity)}) m/s² in world axes"
    )
    if hint is None:
        return f"{vector}, as given"
    angle, std = f"{np.degrees(hint.angle):.1f}°", f"{np.degrees(hint.std):.1f}°"
    if hint.adopted:
        return f"{vector}, as found: {angle} ± {std} from straight down"
    if hint.angle < 3.0 * hint.std or np.degrees(hint.angle) < 0.05:
        return f"{vector}, as given; the data agree (to ± {std})"
    return f"{vector}, as given; the data would have it {angle} ± {std} off (information only)"


def _speed_limit(m: "Movement") -> str:
    if m.above_limit is None:
        return f"{SPEED_LIMIT:g} m/s of ISO 10218: not known without positions"
    if m.keeps_limit:
        return f"{SPEED_LIMIT:g} m/s of ISO 10218: kept"
    return f"{SPEED_LIMIT:g} m/s of ISO 10218: exceeded for {m.above_limit:.2g} s"


def _wrench(found: "Inspection") -> Iterable["str | Table"]:
    if found.sign is not None:
        side = "on-object" if found.sign.on_object else "on-sensor"
        yield f"{side} ({'certain' if found.sign.certain else 'not certain'}, t = {abs(found.sign.t):.3g})"
    c, f = found.conditioned, found.facts
    if c is not None:
        yield _clock(c.offset, c.offset_std)
    if f is not None:
        yield _bias(f)
    if c is not None:
        yield _drift(c.bias)
        yield _outliers(c)
    else:
        yield f"clock offset, drift, outliers: not known: {found.missing['conditioning']}"
    if f is not None:
        yield f"residual {f.noise[0]:.3g} N, {f.noise[1]:.3g} N m root mean square"
        yield _channels_table(f)


def _outliers(c: "Conditioned") -> str:
    if not c.rejected.any():
        return "outliers: none"
    names = {"contact": "of contact", "spike": "by itself", "saturation": "saturated"}
    what = ", ".join(
        f"{number} {names[reason]}" for reason, number in c.reasons.items() if number
    )
    return f"outliers left out: {what} ({_share(float(np.mean(c.rejected)))} of {len(c.rejected)} samples)"


def _clock(offset: float, std: float | None) -> str:
    if std is None:
        return "clock offset between wrench and motion: nothing moves that would tell"
    if not offset:
        return "clock offset between wrench and motion: none found" + (
            f" (± {_time(std)})" if std < 1.0 else ", the motion does not tell"
        )
    return f"the wrench is {1e3 * abs(offset):.3g} ± {1e3 * std:.2g} ms {'late' if offset > 0.0 else 'early'}"


def _bias(f: "WrenchFacts") -> str:
    if f.bias is None or f.bias_t is None:
        return "bias: cannot be told from the object here"
    if np.abs(f.bias_t).max() < SIGNIFICANT:
        return "bias: none beyond three standard deviations"
    force, torque = (
        ", ".join(f"{x:.3g}" for x in part) for part in (f.bias[:3], f.bias[3:])
    )
    return f"bias as recorded ({force}) N, ({torque}) N m; largest t {np.abs(f.bias_t).max():.3g}"


def _drift(bias: "Drift") -> str:
    if bias.kind == "constant":
        return "drift: none found"
    force, torque = (
        float(np.linalg.norm(part)) for part in (bias.range[:3], bias.range[3:])
    )
    knots = f" between {len(bias.knots)} knots" if len(bias.knots) > 2 else ""
    return f"drift: {bias.kind}{knots}, by {force:.2g} N and {torque:.2g} N m"


def _channels_table(f: "WrenchFacts") -> Table:
    table = _table(
        "in sensor axes", "signal (rms)", "noise (std)", "", "signal-to-noise ratio"
    )
    for name, channels in f.channels.items():
        noise = channels.noise[:1] if np.ptp(channels.noise) == 0.0 else channels.noise
        ratios = ", ".join(_ratio(x) for x in channels.snr)
        table.add_row(
            name, _three(channels.signal), _three(noise), channels.unit, ratios
        )
    return table


def _three(values: Array) -> str:
    """Numbers of one kind: those that do not count beside the largest are 0."""
    return ", ".join(f"{x:.2g}" if x > 1e-3 * values.max() else "0" for x in values)


def _object(found: "Inspection") -> Iterable[str]:
    f = found.facts
    quick = (
        ""
        if found.quick_mass is None
        else f"|f| / |g| alone says {found.quick_mass:.4g} kg"
    )
    if f is None:
        yield f"not known: {found.missing['object']}"
        if quick:
            yield quick
        return
    yield f"mass {f.mass:.4g} kg by least squares"
    yield (
        quick
        if f.quick_mass_less_bias is None
        else f"{quick}, without the bias {f.quick_mass_less_bias:.4g} kg"
    )
    if f.gravity_dominance is not None:
        force, torque = f.gravity_dominance
        if np.isfinite(force):
            yield f"gravity takes {force:.3g} times the force of motion, {torque:.3g} times its torque ({EVERYDAY})"
        else:
            yield "gravity is all that shows: no motion"


def _identifiability(found: "Inspection") -> Iterable[str]:
    motion = found.identifiability
    if motion is None:
        yield f"not known: {found.missing['object']}"
        return
    yield (
        f"rank {motion.rank_full} of 10, condition number {motion.condition_full:.3g}; by gravity alone "
        f"{motion.rank_reduced} of 4, {motion.condition_reduced:.3g}"
    )
    yield (
        "not determined by the motion: " + ", ".join(motion.open)
        if motion.open
        else "all ten determined"
    )


def _table(first: str, *others: str) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(first, no_wrap=True)
    for name in others:
        table.add_column(name, justify="right" if name else "left", no_wrap=True)
    return table


def _share(share: float) -> str:
    if share == 0.0:
        return "0"
    return (
        "< 0.1 %"
        if share < 1e-3
        else f"{100.0 * share:.0f} %"
        if share > 0.1
        else f"{100.0 * share:.1f} %"
    )


def _time(seconds: float) -> str:
    if seconds < 1e-7:
        return "0"
    if seconds >= 1.0:
        return f"{seconds:.3g} s"
    return f"{1e3 * seconds:.3g} ms" if seconds >= 1e-4 else f"{1e6 * seconds:.2g} µs"


def _ratio(value: float) -> str:
    if not np.isfinite(value):
        return "-"
    if value >= 1e9:
        return "> 1e9"
    if value >= 1e4:
        return f"{value:.0e}".replace("e+0", "e")
    return (
        f"{value:.0f}"
        if value >= 100.0
        else f"{value:.2g}"
        if value >= 0.01
        else "< 0.01"
    )
