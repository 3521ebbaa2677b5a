"""JSON: the estimate itself, in sensor axes and SI units, even if not consistent."""

from hefting.core.estimate import Estimate
from hefting.export.target import Target


def write(estimate: Estimate, name: str) -> str:
    """JSON that `Estimate.load` reads; it does not hold the name."""
    import json

    return json.dumps(estimate.to_dict(), indent=1) + "\n"


TARGET = Target(
    name="json",
    description="the estimate itself, which Hefting reads back",
    suffixes=(".json",),
    write_estimate=write,
    is_read_back=True,
)
