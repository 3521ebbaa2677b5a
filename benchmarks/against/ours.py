"""Hefting's own parties."""

from collections.abc import Callable
from dataclasses import replace

from benchmarks.against.party import Answer, Party, Task
from benchmarks.bodies import ends
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.estimators import GEO, LMI, OLS, PMD, Bayes, Estimator
from hefting.shapes import Shape

BARE = ", without intervals"
"""Ends the names of parties that leave the intervals out."""


METHODS: dict[str, Callable[[Shape, Noise, bool], Estimator]] = {
    "Bayes": lambda shape, noise, intervals: Bayes(shape, noise=noise),
    "PMD": lambda shape, noise, intervals: PMD(shape, intervals=intervals),
    "GEO": lambda shape, noise, intervals: GEO(shape, noise=noise, intervals=intervals),
    "LMI": lambda shape, noise, intervals: LMI(noise=noise, intervals=intervals),
    "OLS": lambda shape, noise, intervals: OLS(noise=noise, intervals=intervals),
}
"""By name: of shape, noise, and whether with intervals, which Bayes always has."""


def told(task: Task) -> Measurements:
    """The measurements, which say how noisy their accelerations are: every method's
    intervals count that."""
    noise = task.noise
    known = MotionNoise(noise.linear_acceleration, noise.angular_acceleration)
    return replace(task.z, motion_noise=known)


def unused(task: Task) -> Shape:
    """The shape without what was worked out from it before."""
    return replace(task.shape)


def hefting(name: str, intervals: bool) -> Party:
    """One of `METHODS`, which is made, folds all samples and estimates."""

    def identify(task: Task, shape: Shape) -> Answer:
        estimate = METHODS[name](shape, task.noise, intervals).fit(told(task))
        if estimate.intervals is None:
            return Answer(estimate.parameters)
        return Answer(estimate.parameters, *ends(estimate.intervals))

    label = f"Hefting {name}" + ("" if intervals else BARE)
    return Party(label, identify, unused, method="Hefting", calls=3)


def parties() -> list[Party]:
    """Every method with its intervals, then those that can do without."""
    bare = [hefting(name, False) for name in METHODS if name != "Bayes"]
    return [hefting(name, True) for name in METHODS] + bare
