"""Objects wielded by a simulated arm along the paper's sinusoids: what claims about
methods are tested on."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.accuracy import errors_between
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.estimators.point_estimator import PointEstimator
from hefting.shapes import Shape
from hefting.simulation import (
    UR5,
    Assembly,
    Part,
    SensorMotion,
    hammer,
    sinusoids,
    wield,
)

RATE = 100.0
"""Samples a second."""
POINTS = 56
"""Of the paper's discretization."""
PLASTIC = 491.0
"""Density [kg/m³] of the paper's test object, printed with 20 % infill."""


@dataclass(frozen=True, eq=False)
class Thing:
    """An object in the sensor frame: what is true of it, and what is known of its
    shape."""

    body: InertialParameters
    shape: Shape

    @classmethod
    def of(cls, assembly: Assembly) -> "Thing":
        """An assembly given in the sensor frame."""
        return cls(assembly.parameters, Shape.from_mesh(assembly.mesh(), points=POINTS))

    def displaced(self, offset: float, degrees: float, seed: int) -> Shape:
        """The shape at a wrong pose: `offset` [m] aside and turned about its middle,
        both in random directions."""
        rng = np.random.default_rng([7, seed])
        aside, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        R = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix()
        middle = self.shape.homogeneous.center_of_mass
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = R, middle - R @ middle + offset * aside
        return Shape(
            self.shape.positions @ R.T + pose[:3, 3],
            self.shape.volumes,
            extents=self.shape.extents,
            pose=pose,
            homogeneous=self.shape.homogeneous.moved(pose),
        )

    @property
    def box(self) -> Shape:
        """Its bounding box, filled."""
        sides = np.column_stack(
            (self.shape.hull.min(axis=0), self.shape.hull.max(axis=0))
        )
        return Shape.from_box(*sides.ravel(), points=POINTS)


def _bars(*densities: float) -> tuple[Part, ...]:
    """An H of 200 x 300 x 50 mm, the paper's test object without its holes, held by its
    large face off the middle."""
    places = ((-0.025, 0.150, 0.025), (-0.025, 0.025, 0.025), (-0.025, -0.100, 0.025))
    sizes = ((0.2, 0.05, 0.05), (0.05, 0.2, 0.05), (0.2, 0.05, 0.05))
    return tuple(
        Part("box", size, rho, at)
        for size, rho, at in zip(sizes, densities, places, strict=True)
    )


@cache
def things() -> dict[str, Thing]:
    """Two shapes, each of one density and of two, of 0.74, 0.46, 0.98 and 0.67 kg."""
    uniform = tuple(
        Part(p.solid, p.size, 2000.0, p.center, p.axes) for p in hammer().parts
    )
    return {
        "uniform H": Thing.of(Assembly("uniform H", _bars(PLASTIC, PLASTIC, PLASTIC))),
        "uniform hammer": Thing.of(Assembly("uniform hammer", uniform)),
        "half H": Thing.of(Assembly("half H", _bars(2.0 * PLASTIC, PLASTIC, PLASTIC))),
        "hammer": Thing.of(hammer()),
    }


@cache
def motion(duration: float, speed: float) -> SensorMotion:
    """`duration` [s] of the paper's sinusoids at a mean angular `speed` [rad/s]."""
    return UR5.motion(sinusoids(duration, RATE, angular_speed=speed))


@cache
def wielded(name: str, duration: float, speed: float) -> Measurements:
    """Exact measurements of a thing."""
    return wield(motion(duration, speed), things()[name].body)


Method = Callable[[Thing, Measurements], PointEstimator]
"""A method that is told of a thing's shape and of a recording."""


@dataclass(frozen=True)
class Score:
    """Mean errors in percent, as the paper defines them, over things and realisations
    of the noise."""

    mass: float
    center_of_mass: float
    inertia: float
    """About the sensor origin."""
    inertia_at_com: float
    consistent: float
    """Share of the answers that are those of a body."""

    def __str__(self) -> str:
        errors = f"{self.mass:8.3g}{self.center_of_mass:9.3g}{self.inertia:9.3g}{self.inertia_at_com:9.3g}"
        return f"{errors}{100 * self.consistent:7.0f} %"


def score(
    method: Method,
    duration: float,
    speed: float,
    noise: str,
    names: Iterable[str] = (),
    seeds: int = 4,
) -> Score:
    """Of `method` on `duration` [s] of things wielded at `speed` [rad/s], with one of
    the paper's levels of noise."""
    rows = []
    for name in names or things():
        for seed in range(seeds):
            z = wielded(name, duration, speed).with_noise(
                NOISE_LEVELS[noise], [1, seed]
            )
            estimator = _point(method(things()[name], z))
            rows.append(_row(things()[name], estimator.fit(z)))
    return Score(*np.mean(rows, axis=0).tolist())


def asymptotic(
    methods: dict[str, Method], speed: float, noise: str, recordings: int
) -> dict[str, Score]:
    """Of methods on so many recordings of the paper's 35 s, alike but for their noise,
    taken as one."""
    rows: dict[str, list[tuple[float, ...]]] = {label: [] for label in methods}
    for name, thing in things().items():
        exact = wielded(name, 35.0, speed)
        estimators = {
            m: _point(method(thing, exact.with_noise(NOISE_LEVELS[noise], [2, 0])))
            for m, method in methods.items()
        }
        states = {label: estimator.start() for label, estimator in estimators.items()}
        for seed in range(recordings):
            z = exact.with_noise(NOISE_LEVELS[noise], [2, seed])
            states = {
                label: estimators[label].update(state, z)
                for label, state in states.items()
            }
        for label, estimator in estimators.items():
            rows[label].append(_row(thing, estimator.estimate(states[label])))
    return {
        label: Score(*np.mean(values, axis=0).tolist())
        for label, values in rows.items()
    }


def _point(estimator: PointEstimator) -> PointEstimator:
    """The same without intervals, which no score looks at: they take most of the
    time and move no parameter."""
    return replace(estimator, intervals=False)


def _row(thing: Thing, found: Estimate) -> tuple[float, ...]:
    e = errors_between(found.parameters, thing.body, thing.shape.extents)
    return (
        e.mass,
        e.center_of_mass,
        e.inertia_at_origin,
        e.inertia_at_com,
        float(found.physically_consistent),
    )
