"""One identification of a random body, and whether the intervals held."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from benchmarks.bodies import Body, ends, sixteen
from benchmarks.wrong_shapes import WRONG
from hefting.core.accuracy import errors_between
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.estimators import LMI, PMD, Bayes
from hefting.estimators.raw_motion import white_noise
from hefting.estimators.sample_state import SampleState
from hefting.simulation import UR5, random_smooth, sinusoids, stop_and_go, wield
from hefting.simulation.arm import SensorMotion

RATE = 100.0
SAMPLES = (150, 500, 1000)
"""Lengths of streams."""
SPANS = (150, 1000)
"""Samples of an identification."""
LEVELS = ("low", "moderate", "high")
LOOKS = (50, 100, 250, 600)
"""Samples of a stream after which it is looked at, besides the end."""


@dataclass(frozen=True, eq=False)
class Run:
    """What came of one identification."""

    body: Body
    samples: int
    held95: Array
    """(10,) booleans: mass, COM, inertia about the sensor"""
    held50: Array
    errors: Array
    """(3,) [%] of mass, COM and inertia about the sensor"""
    beside: Array
    """the same of PMD on the same samples; of an unknown shape, of LMI"""
    beyond: bool
    """whether a number is further from its interval's middle than twice its ends"""
    outside: bool
    """whether the estimate is outside its own intervals"""
    unknown: bool
    """whether no shape was given"""
    widths: Array
    """(3,) [%] width of the 95 % intervals of mass, COM (of the mean side) and trace of
    the inertia"""


@cache
def motions() -> tuple[SensorMotion, ...]:
    """Ten seconds each: the paper's sinusoids, smooth random motion and stop-and-go at
    several speeds."""
    joints = [sinusoids(10.0, RATE, speed) for speed in (1.0, 2.0, 3.0)]
    joints += [
        random_smooth(10.0, RATE, speed, seed=seed)
        for seed, speed in enumerate((0.7, 1.5, 2.5))
    ]
    joints += [stop_and_go(10.0, RATE, seed=seed) for seed in range(3)]
    return tuple(UR5.motion(j) for j in joints)


def identified(body: Body, case: str, count: int, seed: tuple[int, ...]) -> Run:
    """Wield a body once more, for `count` samples; `case` is one of
    `benchmarks.calibration.CASES`."""
    rng = np.random.default_rng(seed)
    motion = motions()[rng.integers(len(motions()))]
    level = NOISE_LEVELS[LEVELS[rng.integers(len(LEVELS))]]
    exact = wield(motion, body.parameters)
    first = int(rng.integers(len(exact) - count + 1))
    exact = exact[first : first + count]
    estimator = Bayes(body.shape)
    if case in WRONG:
        make, settings = WRONG[case]
        estimator = Bayes(make(body, rng), **settings)
    if case.startswith("AR"):
        z = with_colour(
            exact.with_noise(replace(level, force=0.0, torque=0.0), seed),
            level,
            float(case[3:]),
            rng,
        )
        found = white_noise(z)
        z = replace(
            z,
            motion_noise=MotionNoise(
                found.linear_acceleration, found.angular_acceleration
            ),
        )
    else:
        z = exact.with_noise(level, seed)
        estimator = replace(
            estimator, noise=white_noise(z) if case == "estimated" else level
        )
    state = estimator.update(estimator.start(), z)
    return judged(body, estimator, state, z)


def streamed(
    body: Body, case: str, seed: tuple[int, ...], looks: tuple[int, ...] = LOOKS
) -> dict[int, Run]:
    """Samples in small pieces, and what an estimate says after so many: at all `looks`
    that are reached.

    `case` is ``"white"`` or as ``"AR 0.9"``; the wrench's noise is found by the state,
    that of the motion is given.
    """
    rng = np.random.default_rng(seed)
    motion = motions()[rng.integers(len(motions()))]
    level = NOISE_LEVELS[LEVELS[rng.integers(len(LEVELS))]]
    count = int(rng.choice(SAMPLES))
    exact = wield(motion, body.parameters)
    first = int(rng.integers(len(exact) - count + 1))
    noisy = exact[first : first + count].with_noise(
        replace(level, force=0.0, torque=0.0), seed
    )
    z = with_colour(noisy, level, 0.0 if case == "white" else float(case[3:]), rng)
    known = MotionNoise(level.linear_acceleration, level.angular_acceleration)
    z = replace(z, noise=None, motion_noise=known)
    estimator, found = Bayes(body.shape), {}
    state, seen, estimate = estimator.start(), 0, None
    for look in sorted({*(look for look in looks if look < count), count}):
        while seen < look:
            piece = min(int(rng.integers(1, 20)), look - seen)
            state, seen = estimator.update(state, z[seen : seen + piece]), seen + piece
        estimate = estimator.estimate(state, start=estimate)
        found[count if look == count else look] = judged(
            body, estimator, state, z[:look]
        )
    return found


def judged(body: Body, estimator: Bayes, state: SampleState, z: Measurements) -> Run:
    """Whether the intervals from a state hold the body, and its errors beside PMD's on
    the samples z."""
    mixture = estimator.posterior(state).mixture
    estimate = estimator.estimate(state)
    truth, sides = body.numbers[:10], body.shape.extents
    low, high = ends(mixture.intervals(0.95))
    axes = body.shape.pose[:3, :3]

    def errors(found: InertialParameters) -> Array:
        e = errors_between(found, body.parameters, sides, axes)
        return np.array((e.mass, e.center_of_mass, e.inertia_at_origin))

    found = estimate.parameters
    rival = LMI() if estimator.shape.known == "reach" else PMD(estimator.shape)
    if isinstance(rival, LMI) and isinstance(estimator.noise, Noise):
        rival = replace(rival, noise=estimator.noise)
    middle, width = 0.5 * (low + high), high - low
    widths = (
        width[0] / truth[0],
        width[1:4].mean() / sides.mean(),
        width[[4, 7, 9]].sum() / truth[[4, 7, 9]].sum(),
    )
    return Run(
        body,
        state.samples,
        (low <= truth) & (truth <= high),
        np.logical_and(
            *(
                (s * (truth - e) >= 0.0)
                for s, e in zip((1, -1), ends(mixture.intervals(0.5)), strict=True)
            )
        ),
        errors(found),
        errors(rival.fit(z).parameters),
        bool((np.abs(truth - middle) > width).any()),
        bool(((sixteen(found)[:10] < low) | (sixteen(found)[:10] > high)).any()),
        estimator.shape.known == "reach",
        100.0 * np.array(widths),
    )


def with_colour(
    exact: Measurements, level: Noise, rho: float, rng: np.random.Generator
) -> Measurements:
    """With wrench noise of the given levels, each sample's `rho` times the last one's,
    and the rest new."""
    from scipy.signal import lfilter

    new = rng.normal(size=(len(exact), 6)) * np.sqrt(1.0 - rho**2)
    new[0] /= np.sqrt(1.0 - rho**2)
    noise = np.asarray(lfilter([1.0], [1.0, -rho], new, axis=0)) * np.repeat(
        (level.force, level.torque), 3
    )
    return replace(
        exact, force=exact.force + noise[:, :3], torque=exact.torque + noise[:, 3:]
    )
