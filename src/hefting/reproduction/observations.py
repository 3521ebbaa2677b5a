"""After 150 observations: four methods at three speeds, their motion by a Kalman
filter."""

from collections.abc import Iterator

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.core.spatial import tensor_to_vector
from hefting.estimators import GEO, Estimator
from hefting.ingest.free_fit import fit_freely
from hefting.reproduction.experiment import (
    DURATION,
    OBJECTS,
    Experiment,
    Job,
    Method,
    Report,
    Result,
    Results,
    Thing,
    pmd,
    thing,
    wielded,
)
from hefting.reproduction.experiment import METHODS as PAPERS
from hefting.reproduction.filtered import (
    OBSERVATIONS,
    Observed,
    begun_with,
    causal_filter,
    motions,
    score,
    weak_geo,
    windows,
)
from hefting.reproduction.observations_report import (
    FIRST,
    SHARP,
    figure,
    pooled,
    tables,
)
from hefting.simulation import WRENCH_NOISE, Wielding
from hefting.simulation.wield import POSE_NOISE

ANGULAR = (1.0, 1.5, 2.0)
"""Average angular speeds [rad/s]."""
STARTS = 10
"""How often the motion is started, each time with other noise."""
SHARPER = 0.1
"""Of the pose noise: in a simulator poses are exact."""
QUICK = ("tee", "half-n-half")
NOTE = (
    f"Poses have {1e3 * POSE_NOISE[0]:.2g} mm and {np.degrees(POSE_NOISE[1]):.2g}° of noise per axis; the filters' "
    "bandwidth is the most likely one for each motion. Errors of the inertia are about the sensor's origin; the "
    "table of everything has those about the COM beside. In the figure what the paper gives as over 500 stands at "
    "500, and what is above a panel at its upper edge."
)
"""What tables and figure do not say; what they may mean is in ``docs/reproduction.md``."""


def found(subject: Thing, z: Measurements) -> Estimator:
    """GEO with the noise that least squares leaves, in which errors that last count
    once."""
    fit = fit_freely(z, False)
    longer = float(np.sqrt(fit.autocorrelation))
    return GEO(
        subject.shape,
        noise=Noise(longer * fit.noise.force, longer * fit.noise.torque),
        intervals=False,
    )


def doubled(subject: Thing, z: Measurements) -> Estimator:
    """GEO whose prior was moved from the COM to the sensor twice, as in public code of
    the paper's authors."""
    body = subject.shape.homogeneous
    inertia = 2.0 * body.inertia_at_origin - body.inertia_at_com
    unit = np.concatenate(((1.0,), body.center_of_mass, tensor_to_vector(inertia)))
    mass = float(fit_freely(z, False).vector[0])
    return GEO(prior=InertialParameters(mass * unit), intervals=False)


METHODS: dict[str, Method] = {
    "OLS": PAPERS["OLS"],
    "RTLS": PAPERS["RTLS"],
    "GEO, weak": weak_geo,
    "GEO, literature": PAPERS["GEO"],
    "GEO, noise found": found,
    "PMD": PAPERS["PMD"],
    "PMD, c1 = 3": pmd(3.0),
    "PMD, c1 = 30": pmd(30.0),
    "PMD, c1 = 5e3": pmd(5e3),
    "GEO, wrench noise known": lambda thing, z: GEO(
        thing.shape, noise=NOISE_LEVELS["moderate"], intervals=False
    ),
    "GEO, prior moved twice": doubled,
}
"""Those of the main table first; the literature's weight of GEO is 1e-5 tr(A'A)."""


def jobs(quick: bool) -> list[Job]:
    """For each object and speed."""
    objects, duration, starts = (
        (QUICK, 6.0, 2) if quick else (OBJECTS, DURATION, STARTS)
    )
    return [
        {
            "object": name,
            "speed": speed,
            "duration": duration,
            "starts": starts,
            "seed": 1,
        }
        for speed in ANGULAR
        for name in objects
    ]


def run(job: Job) -> Result:
    """By kind of motion: each method's scores (windows, 5); rms accelerations and
    errors."""
    subject = thing(job["object"])
    exact = wielded(job["object"], job["speed"], duration=job["duration"])
    kinds = {}
    for kind, each in _motions(job, exact):
        scores: dict[str, list] = {name: [] for name in METHODS}
        accelerations = []
        for window, z in each:
            for name, method in METHODS.items():
                scores[name].append(score(subject, method(subject, z), z))
            true = exact.measurements[window]
            wrong = (
                z.linear_acceleration - true.linear_acceleration,
                z.angular_acceleration - true.angular_acceleration,
            )
            accelerations.append(
                (true.linear_acceleration, true.angular_acceleration, *wrong)
            )
        rms = [
            float(np.sqrt(np.mean(np.square(part))))
            for part in zip(*accelerations, strict=True)
        ]
        kinds[kind] = {"scores": scores, "accelerations": rms}
    even = InertialParameters(
        subject.held.parameters.mass * subject.shape.homogeneous.vector
    )
    homogeneous = subject.errors(Estimate("homogeneous", even, 0)).inertia_at_origin
    return {"kinds": kinds, "homogeneous": homogeneous}


def _motions(
    job: Job, exact: Wielding
) -> Iterator[tuple[str, Iterator[tuple[slice, Measurements]]]]:
    seed = (job["seed"], OBJECTS.index(job["object"]), round(10 * job["speed"]))
    observed = Observed.of(exact, WRENCH_NOISE["moderate"], seed)
    places = windows(job["duration"])
    for kind, each in motions(observed).items():
        yield kind, zip(places, each, strict=True)
    for kind, share in ((FIRST, 1.0), (SHARP, SHARPER)):
        yield kind, _first(exact, seed, job["starts"], share)


def _first(
    exact: Wielding, seed: tuple[int, ...], count: int, share: float
) -> Iterator[tuple[slice, Measurements]]:
    """The motion's first observations, with a filter that begins with them, `count`
    times with other noise."""
    window, live = slice(0, OBSERVATIONS), None
    for k in range(count):
        noise = share * POSE_NOISE[0], share * POSE_NOISE[1]
        observed = Observed.of(exact, WRENCH_NOISE["moderate"], (*seed, k), noise)
        live = live or causal_filter(observed)
        yield window, begun_with(observed[window], live)


def report(results: Results) -> Report:
    """Tables and figure."""
    scores = pooled(results)
    speeds = list(dict.fromkeys(job["speed"] for job, _ in results))
    figures = {"observations": figure(scores, speeds)}
    return Report(tables(results, scores, speeds), figures, (NOTE,))


EXPERIMENT = Experiment(
    "observations",
    "After 150 observations",
    "Table on a limited number of observations (about 150)",
    jobs,
    run,
    report,
)
