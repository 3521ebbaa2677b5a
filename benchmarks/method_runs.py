"""One recording, identified by every method but Bayes, and whether their intervals
held."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.bodies import FINE, SOLIDS, Body, ends, sixteen
from benchmarks.calibration_runs import LEVELS, SAMPLES, motions, with_colour
from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.estimators import GEO, HPS, LMI, OLS, PMD, RTLS, Estimator
from hefting.shapes import Shape
from hefting.simulation import wield

PART_POINTS = 1500
"""Points of a shape whose parts are labelled: as of a segmented scan."""


@dataclass(frozen=True, eq=False)
class MethodRun:
    """One method's answer to one recording."""

    method: str
    kind: str
    free_bias: bool
    held: Array
    """(10,) booleans: mass, COM, inertia about the sensor"""
    widths: Array
    """(3,) [%] width of the intervals of mass, COM (of the mean side) and trace of the
    inertia"""


def methods_for(body: Body) -> list[Estimator]:
    """Every method but Bayes, and its variants, that can identify the body."""
    shape = body.shape
    found: list[Estimator] = [
        OLS(),
        OLS(model="blended"),
        RTLS(),
        LMI(),
        LMI(ellipsoid=shape),
        GEO(shape),
        GEO(shape, model="blended"),
        PMD(shape),
        PMD(shape, model="full"),
        PMD(shape, model="reduced"),
    ]
    return [*found, HPS(shape)] if shape.labels is not None else found


def identified_by_all(
    body: Body, case: str, seed: tuple[int, ...], chosen: tuple[str, ...] = ()
) -> list[MethodRun]:
    """Wield a body and identify it by every method, or those `chosen` by name.

    `case` is ``"white"`` or as ``"AR 0.9"``: the wrench's noise is found by the state;
    in ``"given"`` it is white and methods that take it are told. That of the motion is
    given; every second recording has a bias, which is found too.
    """
    rng = np.random.default_rng(seed)
    level = NOISE_LEVELS[LEVELS[rng.integers(len(LEVELS))]]
    z, free_bias = recorded(body, case, level, seed, rng), bool(rng.integers(2))
    if free_bias:
        bias = rng.normal(size=6) * np.repeat((10.0, 0.3), 3)
        z = replace(z, force=z.force + bias[:3], torque=z.torque + bias[3:])
    runs: list[MethodRun] = []
    for estimator in methods_for(body):
        if chosen and estimator.name not in chosen:
            continue
        estimator = replace(estimator, bias="estimate" if free_bias else "none")
        if case == "given" and "noise" in estimator.hyperparameters():
            estimator = replace(estimator, noise=level)
        try:
            runs.append(judged(body, estimator.fit(z), free_bias))
        except NotIdentifiableError:
            continue
    return runs


def recorded(
    body: Body,
    case: str,
    level: Noise,
    seed: tuple[int, ...],
    rng: np.random.Generator,
) -> Measurements:
    """150 to 1,000 samples of one motion, drawn by `rng`."""
    motion = motions()[rng.integers(len(motions()))]
    count = int(rng.choice(SAMPLES))
    exact = wield(motion, body.parameters)
    first = int(rng.integers(len(exact) - count + 1))
    noisy = exact[first : first + count].with_noise(
        replace(level, force=0.0, torque=0.0), seed
    )
    rho = float(case[3:]) if case.startswith("AR") else 0.0
    z = with_colour(noisy, level, rho, rng)
    known = MotionNoise(level.linear_acceleration, level.angular_acceleration)
    return replace(z, noise=None, motion_noise=known)


def judged(body: Body, estimate: Estimate, free_bias: bool) -> MethodRun:
    """Whether the intervals of an estimate hold the body."""
    assert estimate.intervals is not None
    low, high = ends(estimate.intervals)
    truth, width = body.numbers[:10], high - low
    widths = (
        width[0] / truth[0],
        width[1:4].mean() / body.shape.extents.mean(),
        width[[4, 7, 9]].sum() / truth[[4, 7, 9]].sum(),
    )
    own = sixteen(estimate.parameters)[:10]
    known = np.isfinite(own)  # no mass has no COM
    assert ((low <= own) & (own <= high))[known].all(), estimate.method
    return MethodRun(
        estimate.method,
        body.kind,
        free_bias,
        (low <= truth) & (truth <= high),
        100.0 * np.array(widths),
    )


def body_of_parts(seed: int) -> Body:
    """A body of two to four parts, each homogeneous: slices of a random solid across
    its longest side, of densities that differ up to tenfold."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng([seed, 7])
    solid = list(SOLIDS)[rng.integers(len(SOLIDS))]
    mesh = SOLIDS[solid](rng)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    reach = 0.5 * float(np.ptp(mesh.vertices, axis=0).max())
    aside = rng.normal(size=3)
    pose[:3, 3] = rng.uniform(0.2, 1.0) * reach * aside / np.linalg.norm(aside)
    axis = int(np.argmax(np.ptp(mesh.vertices, axis=0)))
    low, high = mesh.vertices[:, axis].min(), mesh.vertices[:, axis].max()
    parts = int(rng.integers(2, 5))
    cuts = low + (high - low) * np.sort(rng.uniform(0.15, 0.85, parts - 1))

    def labelled(points: int) -> Shape:
        shape = Shape.from_mesh(mesh, pose=pose, points=points)
        along = ((shape.positions - pose[:3, 3]) @ pose[:3, :3])[:, axis]
        return replace(shape, labels=np.searchsorted(cuts, along))

    fine = labelled(FINE)
    assert fine.volumes is not None
    assert fine.labels is not None
    density = np.exp(rng.uniform(0.0, np.log(10.0), parts))
    masses = fine.volumes * density[fine.labels.astype(int)]
    mass = float(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))
    truth = InertialParameters(fine.cell_matrix @ (mass * masses / masses.sum()))
    shares = fine.volumes / fine.volumes.sum()
    mean = float(shares @ density[fine.labels.astype(int)])
    square = float(shares @ density[fine.labels.astype(int)] ** 2)
    contrast = float(np.sqrt(max(square / mean**2 - 1.0, 0.0)))
    return Body("parts", solid, labelled(PART_POINTS), truth, mesh, contrast)
