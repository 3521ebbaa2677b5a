"""Many points: the unknowns of the solver do not grow with them."""

from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import Party, compare
from hefting import PMD, Shape


def many_points(points: int, rounds: int) -> Section:
    """150 samples and so many points inside the hammer."""
    positions = shape(points).positions
    measurements = wielded(3500)[:150]
    used = PMD(Shape(positions), intervals=False)
    state = used.update(used.start(), measurements)
    used.estimate(state)  # the basis of its points is kept from here on
    times = compare(
        {
            "first": Party(
                lambda fresh: fresh.estimate(state),
                lambda: PMD(Shape(positions), intervals=False),
            ),
            "estimate": Party(lambda _: used.estimate(state)),
        },
        rounds,
    )
    first, estimate = times["first"], times["estimate"]
    return Section(
        f"PMD, {len(positions):,} points, 150 samples",
        (
            Row(
                "estimate, from the moments",
                estimate,
                estimate.median,
                "s",
                at_most=1.0,
            ),
            Row("first estimate, the one-off basis included", first),
            Row(
                "  the basis: difference of the two",
                figure=first.median - estimate.median,
                unit="s",
            ),
        ),
    )
