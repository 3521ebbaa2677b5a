"""The sensor's calibration is wrong: channels have different gains, or respond to one
another. A gain common to all channels is the same as another mass. Or one channel alone
is wrong: in another unit, of another gain, on the wire of another channel, or dead. Or
the gain depends on the load, as near the end of an amplifier's range; or the channels
have play or hysteresis.

The other five channels determine the body, and so what a wrong one should have measured.
What it did measure is fitted as any linear function of the motion, and compared.
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import WRENCH, Array, Indices, distinct
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    LinearPart,
    Rows,
    beside_body,
    correlation,
    fit_free_channels,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    fit_as_given,
    newton_euler,
    of_each_wrench,
    over_offsets,
)
from hefting.ingest.robust_rows import RobustRows
from hefting.logs.units import UNITS

GAIN, CROSS_TALK = "gain-uneven", "cross-talk"
ALL = np.arange(36)
GAINS = 7 * np.arange(6)
"""Indices of the matrix's entries, row by row, and of the gains among them."""
USUAL_ERROR = 0.03
"""Standard deviation of the matrix's errors, as a share of the channels' ranges."""
RANGES = np.repeat((1.0, 0.1), 3)
"""Ranges [N, N m] of the channels of common sensors, up to a factor."""
PASSES = 3
"""Number of times that the matrix is found, each with a better prediction of the
wrench."""


def explain(case: Case) -> Explanation | None:
    """The likeliest errors of the matrix (6, 6), to first order."""
    std = max(USUAL_ERROR, case.sensor_errors)

    def of(free: Indices) -> Explanation:
        return replace(_likeliest(case, free, std), effect=None)

    return replace(of(ALL), alternative=lambda: of(GAINS))


def errors_on_data_sheet(case: Case, times: float = 1.0) -> Explanation:
    """Errors of `times` the size that the sensor may have, which are no mistake; `effect`
    is their root mean square over that size."""
    return replace(_likeliest(case, ALL, times * case.sensor_errors), rarity=0.0)


def _likeliest(case: Case, free: Indices, std: float) -> Explanation:
    """The likeliest errors of the entries with indices `free` (q,), each with a
    standard deviation `std` as a share of the channels' ranges."""
    _, offset = fit_as_given(case)
    rows = newton_euler(case, case.motion_late(offset))
    fitted, errors, cost = fit_rows(case, rows), np.zeros(36), 0.0
    for _ in range(PASSES):
        wrench = rows.predict(fitted.solution[0, :10])[0]
        errors[free], cost = _step(fitted, wrench, errors[free], free, std)
        mended = case.wrench - wrench @ errors.reshape(6, 6).T
        other = Rows(rows.known, rows.maps, rows.used, mended[None])
        fitted = fit_rows(case, other, start=fitted)
    code, what = _largest_error(
        errors.reshape(6, 6), np.sqrt(np.mean(wrench**2, axis=0))
    )
    fix = "check its calibration matrix, or weigh something known"
    return Explanation(
        code,
        what,
        fix,
        fitted,
        len(free),
        cost=cost,
        rarity=2.0,
        effect=float(np.sqrt(np.mean(np.square(errors / _scale(std))))),
    )


def _step(
    fitted: Fitted, wrench: Array, before: Array, free: Indices, std: float
) -> tuple[Array, float]:
    """Errors (q,) of the free entries and their cost (`Explanation.cost`), given a
    prediction of the wrench (K, 6) and a fit with the errors `before` (q,) corrected.
    """
    columns = np.einsum("kj,ci->kcij", wrench, np.eye(6)).reshape(len(wrench), 6, 36)
    S, g = LinearPart.of(fitted).beside(columns[:, :, free])
    independent = 1.0 / correlation(fitted)
    S, g = independent * S, independent * g
    g = g + S @ before
    scale = _scale(std)[free]
    errors = np.linalg.solve(S + np.diag(scale**-2.0), g)
    _, logdet = np.linalg.slogdet(np.eye(len(free)) + S * scale * scale[:, None])
    cost = 0.5 * float(logdet + np.sum(np.square(errors / scale)))
    return np.array(errors, dtype=float), cost


def _scale(std: float) -> Array:
    """(36,) standard deviations of the entries, for `std` as a share of the ranges."""
    return std * np.divide.outer(RANGES, RANGES).ravel()


def _largest_error(errors: Array, size: Array) -> tuple[str, str]:
    """Code and text of the largest of the errors (6, 6), for channels of root mean
    square `size` (6,)."""
    effects = np.abs(errors) * size / RANGES[:, None]
    to, of = (int(i) for i in np.unravel_index(np.argmax(effects), effects.shape))
    if to == of:
        gain = 100.0 * errors[to, to]
        what = (
            f"the sensor's channels seem to have different gains, {WRENCH[to]} "
            f"{gain:+.1f} % against the others"
        )
        return GAIN, what
    share = 100.0 * errors[to, of] * RANGES[of] / RANGES[to]
    what = (
        f"the sensor's channels seem to respond to one another, {WRENCH[to]} to "
        f"{WRENCH[of]} by {share:+.1f} % of its range"
    )
    return CROSS_TALK, what


WRONG_CHANNEL = "channel-wrong"
SMALLEST_FACTOR = 1.2
"""Gain, or its inverse, up to which the error is left to the matrix."""
CHANNEL_RARITY = 5.0
"""See `Explanation.rarity`: there are some 36 pairs of channels, each with a gain."""
ALIKE = 0.8
"""A channel counts as measuring what it should, rather than another, if that explains
more than this share of what the other explains."""
DEAD = 0.5
"""A channel is dead unless what some channel should measure explains more than this share
of it, and more than the noise."""
NEAR = 0.06
"""Largest relative difference of the logarithms of a gain and of a unit that is named."""


def explain_channel(case: Case) -> Explanation | None:
    """The faulty channel, as a gain times what it or another channel should measure."""
    rows = newton_euler(case, case.motion_late(case.likely_offsets))
    c, of, gain = _measured(fit_free_channels(case, rows.known, rows.used), rows)
    if of == c and 1.0 / SMALLEST_FACTOR < abs(gain) < SMALLEST_FACTOR:
        return None
    fitted, _ = over_offsets(
        case, lambda motion: _with(newton_euler(case, motion), c, of, gain)
    )
    return Explanation(
        WRONG_CHANNEL,
        f"the channel {WRENCH[c]} seems to {_description(c, of, gain)}",
        "check its wire, unit and gain, and correct it where the log is written",
        fitted,
        1,
        rarity=CHANNEL_RARITY,
        is_grave=True,
    )


def _with(rows: Rows, c: int, of: int, gain: float) -> Rows:
    """Rows in which channel `c` is `gain` times what channel `of` should measure."""
    maps = rows.maps.copy()
    maps[:FEATURES, c] = gain * rows.maps[:FEATURES, of]
    return Rows(rows.known, maps, rows.used)


def _measured(free: RobustRows, rows: Rows) -> tuple[int, int, float]:
    """The faulty channel c, the channel `of` whose wrench it measures, and the gain, zero
    if it measures noise; from a fit of free channels."""
    best = free.best
    known = np.sqrt(free.weights[best])[:, None] * rows.known[best]
    # 12 virtual samples of the features, from which any bias is eliminated
    biases = known.shape[1] - FEATURES
    R = np.linalg.qr(np.roll(known, -FEATURES, axis=1)).R[biases:, biases:]
    model = np.tensordot(R, REGRESSOR_BY_FEATURE, 1)
    wrench = R @ free.solution[best].reshape(-1, 6)[:FEATURES]
    scale = np.repeat(free.scale[best], 3)
    c, body = _odd_channel(model / scale[:, None], wrench / scale)
    expected, measured = model @ body, wrench[:, c]
    square = np.maximum(np.square(expected).sum(axis=0), 1e-300)
    gains = measured @ expected / square
    share = gains**2 * square / max(float(measured @ measured), 1e-300)
    of = int(np.argmax(share))
    if share[c] > ALIKE * share[of]:
        of = c
    # any function of the motion may be the likeliest in noise alone
    noise = scale[c] ** 2 * float(free.weights[best].sum())
    alive = share[of] > DEAD and gains[of] ** 2 * square[of] > noise
    return c, of, float(gains[of]) if alive else 0.0


def _odd_channel(model: Array, wrench: Array) -> tuple[int, Array]:
    """The channel without which one body (10,) explains the others best, and that body,
    from regressors (n, 6, 10) and wrenches (n, 6) over their noise."""
    left, bodies = np.zeros(6), np.zeros((6, 10))
    for c in range(6):
        A = np.delete(model, c, axis=1).reshape(-1, 10)
        b = np.delete(wrench, c, axis=1).ravel()
        bodies[c] = np.linalg.lstsq(A, b)[0]
        left[c] = np.square(b - A @ bodies[c]).sum()
    c = int(np.argmin(left))
    return c, bodies[c]


def _description(c: int, of: int, gain: float) -> str:
    if gain == 0.0:
        return "measure nothing but noise"
    if of != c:
        return f"measure what {WRENCH[of]} should"
    said = f"be {gain:.3g} times what the other channels tell"
    for unit in UNITS["force" if c < 3 else "torque"].values():
        ratio = abs(gain) * float(unit.to_si(np.ones(1))[0])
        if abs(np.log(ratio)) < NEAR * abs(np.log(abs(gain))):
            return f"{said}, as if in {unit.name}"
    return said


HYSTERESIS = "hysteresis"
SHARES = np.array((0.005, 0.01, 0.02, 0.03, 0.05, 0.1))
"""Play over the range of each channel that is tried."""
PLAY_PASSES = 2
"""Number of times that the play is found, from improved predictions of the load."""


def explain_hysteresis(case: Case) -> Explanation | None:
    """The likeliest play of channels that follow only after the load has moved by some
    share of its range."""
    if not case.path.moves:
        return None
    given, late = fit_as_given(case)
    # play looks like a delay, which the recording as given may have taken it for
    offsets = distinct((0.0, 0.5 * late, late))
    rows = newton_euler(case, case.motion_late(offsets))
    fitted = fit_rows(case, rows)
    load = case.wrench - fitted.residual[fitted.best]
    for _ in range(PLAY_PASSES):
        wrenches = case.wrench - _lags(load, SHARES)
        fitted = of_each_wrench(case, rows, wrenches)
        if is_hopeless(case, fitted, given):
            return None
        index = fitted.best // len(offsets)
        load = wrenches[index] - fitted.residual[fitted.best]
    what = (
        f"the sensor seems to follow the load with some {100.0 * SHARES[index]:.2g} % of "
        "play or hysteresis"
    )
    fix = "check how it is mounted, and its cable"
    # intervals allow for as much as the sensor may have
    effect = 0.0 if SHARES[index] <= case.sensor_errors else None
    return Explanation(
        HYSTERESIS,
        what,
        fix,
        fitted,
        1,
        rarity=2.0,
        of_many_laws=True,
        effect=effect,
    )


def _lags(load: Array, shares: Array) -> Array:
    """(S, K, 6) readings of followers with play of each of the shares (S,), less their
    load (K, 6)."""
    half = 0.5 * shares[:, None] * np.ptp(load, axis=0)
    shown = np.empty((len(load), *half.shape))
    shown[0] = load[0]
    low, high = load[:, None] - half, load[:, None] + half
    for k in range(1, len(load)):
        np.minimum(np.maximum(shown[k - 1], low[k]), high[k], out=shown[k])
    return np.swapaxes(shown - load[:, None], 0, 1)


BY_LOAD = "gain-by-load"
LAW_PASSES = 2
"""Number of times that the reading without noise is predicted, with improved laws."""
SMALLEST_CHANGE = 0.01
"""Change of the gain within a recording from which on it is reported; data sheets allow
half."""
LARGEST_CHANGE = 1.0
"""Change of the gain beyond which it is another error."""
LAW_UNKNOWNS = 2
LAW_ERRORS = np.eye(6)[:, :, None] * np.repeat(np.eye(2), 3, axis=0)[:, None]
"""(6, 6, 2) columns of the errors of force and torque, per unit of each channel's."""
LAW_RARITY = 15.0
"""See `Explanation.rarity`. Different gains are far more common, and sensors follow
such a law slightly: in recordings of three real ones it explains a fifth of what is
unexplained, with an evidence of up to 3."""


def explain_by_load(case: Case) -> Explanation | None:
    """The likeliest law by which the gain depends on the load, at the clock offset of the
    recording as given.

    A channel that reads x has an error in proportion to x |x| or x³, with x counted from
    no load or from zero, where its gain is right. The factor is common to the forces and
    to the torques, as if all gauges had the same range.
    """
    if not case.path.moves:
        return None
    fitted, loads = _fit_laws(case)
    law = fitted.best
    load = np.abs(loads[law % 2]).reshape(-1, 2, 3)
    # (2,) each, of force and torque
    largest, varies = load.max(axis=(0, 2)), np.ptp(load, axis=0).max(axis=1)
    powers = largest if law < 2 else largest**2
    changes = powers * fitted.solution[law, 10:12]
    of = int(np.argmax(np.abs(changes) * largest / fitted.scale[law]))
    change = abs(changes[of])
    seen = change * varies[of] / max(largest[of], 1e-300)
    if not (seen > SMALLEST_CHANGE and change < LARGEST_CHANGE):
        return None
    name, unit = (("force", "N"), ("torque", "N m"))[of]
    what = (
        f"the sensor's gain seems to change with the load, the {name}'s "
        f"by {100.0 * changes[of]:+.2g} % at {largest[of]:.2g} {unit}"
    )
    fix = "zero it first, check its calibration, or use one of a larger range"
    return Explanation(BY_LOAD, what, fix, fitted, LAW_UNKNOWNS, rarity=LAW_RARITY)


def _fit_laws(case: Case) -> tuple[Fitted, Array]:
    """Fit of four laws, and the loads (2, K, 6) [N, N m] without noise, counted from no
    load and from zero: x |x| of each of these loads, then x³ of each."""
    fitted, offset = fit_as_given(case)
    motion = case.motion_late(offset)
    features = case.features(motion)
    loads = np.empty((2, *case.wrench.shape))
    for _ in range(LAW_PASSES):
        body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best, :10]
        reading = case.wrench - fitted.residual[fitted.best]
        loads = np.stack((features[0] @ body, reading))
        laws = np.concatenate([loads * np.abs(loads), loads**3])
        each = np.broadcast_to(features, (len(laws), *features.shape[1:]))
        used = np.broadcast_to(motion.known, laws.shape[:2])
        known = np.concatenate((each, laws), axis=2)
        fitted = fit_rows(case, with_bias(case, known, beside_body(LAW_ERRORS), used))
    return fitted, loads
