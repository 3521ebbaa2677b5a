"""Answer: what is at hand on everything that holds an estimate."""

from hefting.core.display import Shown
from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.core.verdict import Verdict


class Answer(Shown):
    """Base of results that hold an estimate in `estimate`."""

    estimate: Estimate

    def __repr__(self) -> str:
        return self.estimate.summary(type(self).__name__)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.estimate.mass

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass (3,) [m] in the sensor frame."""
        return self.estimate.center_of_mass

    @property
    def inertia(self) -> Array:
        """Inertia tensor (3, 3) [kg m²] about the centre of mass, in sensor axes."""
        return self.estimate.inertia

    def interval(self, name: str) -> Array:
        """Lower and upper ends of a 95 % interval; see `hefting.Estimate.interval`."""
        return self.estimate.interval(name)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know before trusting it."""
        return self.estimate.warnings

    @property
    def verdict(self) -> Verdict:
        """Whether to trust it, and why not: see `hefting.core.verdict`."""
        return self.estimate.verdict
