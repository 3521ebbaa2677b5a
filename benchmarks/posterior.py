"""Bayes: from the moments, cold and from an earlier estimate, with few points and
many."""

from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import Party, compare
from hefting import Bayes
from hefting.core.measurements import NOISE_LEVELS

NOISE = NOISE_LEVELS["moderate"]


def posterior(points: int, rounds: int) -> Section:
    """150 samples of the hammer; 56 points, and so many."""
    z = wielded(3500)[:150]
    few, many = shape(56), shape(points)
    used = Bayes(few, noise=NOISE)
    sure = Bayes(few, noise=NOISE, until="mass=1%,com=2mm,inertia=20%")
    placed = Bayes(few, noise=NOISE, pose_std=(0.005, 0.087))
    state = used.update(used.start(), z)
    earlier = used.estimate(state)  # the prior of the shape is kept from here on
    placed.estimate(state)
    times = compare(
        {
            "warm": Party(lambda _: used.estimate(state, start=earlier), calls=5),
            "cold": Party(lambda _: used.estimate(state), calls=5),
            "sure": Party(lambda _: sure.estimate(state, start=earlier), calls=5),
            "placed": Party(lambda _: placed.estimate(state), calls=5),
            "first": Party(
                lambda fresh: fresh.estimate(state), lambda: Bayes(few, noise=NOISE)
            ),
            "many": Party(
                lambda fresh: fresh.estimate(state), lambda: Bayes(many, noise=NOISE)
            ),
        },
        rounds,
    )
    warm = times["warm"]
    cold = times["cold"]
    first = times["first"]
    long = times["many"]
    return Section(
        "Bayes, from the moments of 150 samples",
        (
            Row(
                f"estimate from an earlier one, {few.n} points",
                warm,
                warm.median,
                "s",
                at_most=1e-3,
            ),
            Row("  with the accuracy it reaches", times["sure"]),
            Row("estimate", cold, cold.median, "s", at_most=5e-3),
            Row("  with a pose known to 5 mm and 5°", times["placed"]),
            Row("first estimate, the prior of the shape included", first),
            Row(f"  {many.n:,} points", long, long.median, "s", at_most=1.0),
        ),
    )
