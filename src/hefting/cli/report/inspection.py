"""An inspection as a readable report: content of the log, motion, wrench, object, and
what to do next."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report import with_reach
from hefting.cli.report.estimate import MORE
from hefting.cli.report.printing import doubt_lines, plain_table
from hefting.core.quantity import wrench_text
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.ingest.conditioned import SIGNIFICANT
from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING

if TYPE_CHECKING:
    from hefting.ingest import Conditioned, Drift
    from hefting.inspection import Inspection, Movement, StreamFacts, WrenchFacts

DEVIATIONS = 1.96
"""Half-width of a 95 % interval in standard deviations."""
EVERYDAY = "about 5 in everyday handling"
"""Nadeau et al. 2022, sec. III."""


def inspection_report(found: "Inspection", verbose: bool) -> Group:
    """Verdict and warnings, streams, motion, wrench, object, and what to do next; with
    `verbose` also the numbers behind them."""
    lasts = (
        f"{next(iter(found.streams.values())).samples} static poses"
        if found.static
        else f"{found.duration:.4g} s"
    )
    lines: list[RenderableType] = [
        *doubt_lines(found.verdict, found.warnings),
        Text(f"{found.log}: {lasts}", style="bold"),
        _streams_table(found),
    ]
    lines += [Text(f"note: {line}") for line in found.notes]
    for title, section in (
        ("motion", _motion(found, verbose)),
        ("wrench", _wrench(found, verbose)),
        ("object", _object(found, verbose)),
    ):
        lines += [
            Text(title, style="bold"),
            *(Text(f"  {each}") if isinstance(each, str) else each for each in section),
        ]
    lines.extend(Text(f"next: {line}", style="green") for line in found.advice)
    return Group(*lines) if verbose else Group(*lines, Text(MORE))


def _streams_table(found: "Inspection") -> Table:
    table = plain_table(
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


def _motion(found: "Inspection", verbose: bool) -> Iterable[str]:
    m = found.movement
    if m is None:
        yield f"not known: {found.missing['motion']}"
        return
    if verbose:
        yield f"from {m.source}"
    if not found.static:
        yield _speed("angular", m.angular_speed, "rad/s", verbose)
        if m.linear_speed is not None:
            yield _speed("linear", m.linear_speed, "m/s", verbose)
        yield _speed_limit(m)
        if verbose and m.dynamism is not None:
            yield f"dynamism {m.dynamism:.3g} (median)"
    yield f"gravity turned by up to {np.degrees(m.turn):.0f}° in sensor axes"
    yield _gravity(found)


def _speed(kind: str, speed: tuple[float, float], unit: str, verbose: bool) -> str:
    """Largest speed, with `verbose` also the mean."""
    mean = f"{speed[0]:.3g} {unit} on average, " if verbose else ""
    return f"{kind} speed {mean}{speed[1]:.3g} {unit} at most"


def _gravity(found: "Inspection") -> str:
    hint = found.gravity_hint
    vector = (
        f"gravity ({', '.join(f'{x:.4g}' for x in found.gravity)}) m/s² in world axes"
    )
    if hint is None:
        return f"{vector}, as given"
    angle, degrees = f"{np.degrees(hint.angle):.1f}°", float(np.degrees(hint.std))
    std = f"{degrees:.1f}°" if degrees >= 0.1 else f"{degrees:.1g}°"
    if hint.adopted:
        return f"{vector}, as found: {angle} ± {std} from straight down"
    if hint.angle < 3.0 * hint.std:
        return f"{vector}, as given; the data agree (to ± {std})"
    return f"{vector}, as given; the data suggest {angle} ± {std} from it"


def _speed_limit(m: "Movement") -> str:
    if m.above_limit is None:
        return f"{SPEED_LIMIT:g} m/s of ISO 10218: not known without positions"
    if m.keeps_limit:
        return f"{SPEED_LIMIT:g} m/s of ISO 10218: kept"
    return f"{SPEED_LIMIT:g} m/s of ISO 10218: exceeded for {m.above_limit:.2g} s"


def _wrench(found: "Inspection", verbose: bool) -> Iterable["str | Table"]:
    if found.sign is not None:
        side = "on-object" if found.sign.on_object else "on-sensor"
        size = f", t = {abs(found.sign.t):.3g}" if verbose else ""
        yield f"{side} ({'certain' if found.sign.certain else 'not certain'}{size})"
    c, f = found.conditioned, found.facts
    if c is not None:
        yield _clock(c.offset, c.offset_std)
    if f is not None:
        yield _bias(f, verbose)
    if c is not None:
        short = not found.static and found.duration < SHORTEST_DRIFTING_RECORDING
        yield (
            "drift: not looked for in recordings shorter than 8 s"
            if short
            else _drift(c.bias, verbose)
        )
        yield _outliers(c)
    else:
        why = found.missing["conditioning"]
        yield f"clock offset, drift, outliers: not known: {why}"
    if f is not None and verbose:
        yield f"residual {f.noise[0]:.3g} N, {f.noise[1]:.3g} N m root mean square"
        yield _channels_table(f)


def _outliers(c: "Conditioned") -> str:
    if not c.rejected.any():
        return "outliers: none"
    names = {
        "contact": "in contact",
        "spike": "single spikes",
        "saturation": "saturated",
    }
    what = ", ".join(
        f"{number} {names[reason]}" for reason, number in c.reasons.items() if number
    )
    return f"outliers left out: {what} ({_share(float(np.mean(c.rejected)))} of {len(c.rejected)} samples)"


def _clock(offset: float, std: float | None) -> str:
    if std is None:
        return "clock offset between wrench and motion: open, as nothing moves"
    if not offset:
        return "clock offset between wrench and motion: none found" + (
            f" (± {_time(std)})" if std < 1.0 else ", the motion does not tell"
        )
    return f"the wrench is {1e3 * abs(offset):.3g} ± {1e3 * std:.2g} ms {'late' if offset > 0.0 else 'early'}"


def _bias(f: "WrenchFacts", verbose: bool) -> str:
    if f.bias is None or f.bias_t is None:
        return "bias: cannot be told from the object here"
    if np.abs(f.bias_t).max() < SIGNIFICANT:
        return "bias: none beyond three standard deviations"
    size = f"; largest t {np.abs(f.bias_t).max():.3g}" if verbose else ""
    return f"bias as recorded {wrench_text(f.bias)}{size}"


def _drift(bias: "Drift", verbose: bool) -> str:
    if bias.kind == "constant":
        return "drift: none found"
    force, torque = (
        float(np.linalg.norm(part)) for part in (bias.range[:3], bias.range[3:])
    )
    if not verbose:
        return f"drift: by {force:.2g} N and {torque:.2g} N m"
    knots = f" between {len(bias.knots)} knots" if len(bias.knots) > 2 else ""
    return f"drift: {bias.kind}{knots}, by {force:.2g} N and {torque:.2g} N m"


def _channels_table(f: "WrenchFacts") -> Table:
    table = plain_table(
        "in sensor axes", "signal (rms)", "noise (std)", "", "signal-to-noise"
    )
    for name, channels in f.channels.items():
        noise = channels.noise[:1] if np.ptp(channels.noise) == 0.0 else channels.noise
        ratios = ", ".join(_ratio(x) for x in channels.snr)
        table.add_row(
            name, _three(channels.signal), _three(noise), channels.unit, ratios
        )
    return table


def _three(values: Array) -> str:
    """Numbers of one kind; those negligible against the largest are 0."""
    return ", ".join(f"{x:.2g}" if x > 1e-3 * values.max() else "0" for x in values)


def _object(found: "Inspection", verbose: bool) -> Iterable[str]:
    f, motion = found.facts, found.identifiability
    if f is None or verbose:
        yield from _quick_mass(found)
    if f is None or motion is None:
        yield f"not known: {found.missing['object']}"
        return
    reach = DEVIATIONS * f.mass_std
    if np.isfinite(reach):
        mass = with_reach([f.mass], reach)
        yield f"mass {mass} kg by least squares (± by noise alone)"
    else:
        yield f"mass {f.mass:.4g} kg by least squares, open"
    yield (
        "not determined by the motion: " + ", ".join(motion.open)
        if motion.open
        else "all ten parameters can be found"
    )
    if not verbose:
        return
    if f.gravity_dominance is not None:
        yield _dominance(*f.gravity_dominance)
    yield (
        f"rank {motion.rank_full} of 10, condition number {motion.condition_full:.3g}"
        f"; by gravity alone {motion.rank_reduced} of 4, {motion.condition_reduced:.3g}"
    )


def _quick_mass(found: "Inspection") -> Iterable[str]:
    """The mass by the size of the forces alone."""
    if found.quick_mass is None:
        return
    text = f"|f| / |g| alone says {found.quick_mass:.4g} kg"
    mass = None if found.facts is None else found.facts.quick_mass_less_bias
    yield text if mass is None else f"{text}, without the bias {mass:.4g} kg"


def _dominance(force: float, torque: float) -> str:
    if not np.isfinite(force):
        return "gravity is all that shows: no motion"
    return (
        f"gravity takes {force:.3g} times the force of motion, {torque:.3g} times its "
        f"torque ({EVERYDAY})"
    )


def _share(share: float) -> str:
    if share == 0.0:
        return "0"
    if share < 1e-3:
        return "< 0.1 %"
    return f"{100.0 * share:.{0 if share > 0.1 else 1}f} %"


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
    if value < 0.01:
        return "< 0.01"
    return f"{value:.0f}" if value >= 100.0 else f"{value:.2g}"
