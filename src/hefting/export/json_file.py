"""JSON: the estimate itself, in sensor axes and SI units, whether or not a body can
have it."""

from hefting.core.estimate import Estimate
from hefting.export.target import Target


def write(estimate: Estimate, name: str) -> str:
    """What `Estimate.load` reads back; the name is not in it."""
    import json

    return json.dumps(estimate.to_dict(), indent=1) + "\n"


TARGET = Target(
    name="json",
    description="the estimate itself, which Hefting reads back",
    suffixes=(".json",),
    write_estimate=write,
    is_read_back=True,
)
