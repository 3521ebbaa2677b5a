"""Many points: the unknowns of the solver do not grow with them."""

from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import Party, compare
from hefting import PMD, PointMasses


def many_points(points: int, rounds: int) -> Section:
    """150 samples and so many points inside the hammer."""
    positions = shape(points).positions
    measurements = wielded(3500)[:150]
    used = PMD(PointMasses(positions))
    used.estimate(used.update(used.start(), measurements))  # its basis is kept from here on

    def fresh() -> PMD:
        return PMD(PointMasses(positions))

    times = compare(
        {
            "first": Party(lambda pmd: pmd.fit(measurements), fresh),
            "estimate": Party(used.estimate, lambda: used.update(used.start(), measurements)),
        },
        rounds,
    )
    first, estimate = times["first"], times["estimate"]
    return Section(
        f"PMD, {len(positions):,} points, 150 samples",
        (
            Row("estimate, from the moments", estimate, estimate.median, "s", at_most=1.0),
            Row("first fit, with the one-off basis of the points", first),
            Row("  the basis", figure=first.median - estimate.median, unit="s"),
        ),
    )
