"""What the experiment on 150 observations concludes, worked out from its scores."""

import numpy as np

from hefting.core.spatial import Array
from hefting.reproduction.experiment import Job, Result
from hefting.reproduction.observations_report import (
    ALIKE,
    COMPARED,
    GEOS,
    KINDS,
    LABELS,
    PUBLISHED,
    Scores,
    consistent,
    differences,
    error,
)
from hefting.reproduction.setting import SPEEDS
from hefting.simulation.wield import POSE_NOISE


def notes(
    results: list[tuple[Job, Result]], scores: Scores, speeds: list[float]
) -> tuple[str, ...]:
    """What the tables say, worked out from them; what it may mean is in
    ``docs/reproduction.md``."""
    return (
        _against_the_published(scores, speeds),
        _consistency(scores, speeds),
        _motion_errors(results),
        _alike(scores, speeds),
        _single_windows(scores, speeds),
        _ordering(scores, speeds),
        _evenness(results),
        _least(scores, speeds),
        f"Poses have {1e3 * POSE_NOISE[0]:.2g} mm and {np.degrees(POSE_NOISE[1]):.2g}° of noise per axis; the filters' "
        "bandwidth is the most likely one for each motion. Errors of the inertia are about the sensor's origin; the "
        "table of everything has those about the COM beside. In the figure what the paper gives as over 500 stands at "
        "500, and what is above a panel at its upper edge.",
    )


def _means(scores: Scores, kind: str, method: str, speeds: list[float]) -> Array:
    """Mean errors [%] over windows and speeds, by quantity (3,)."""
    return np.mean(
        [
            [error(scores, kind, method, s, q) for q in range(len(LABELS))]
            for s in speeds
        ],
        axis=0,
    )


def _against_the_published(scores: Scores, speeds: list[float]) -> str:
    """In how many cells PMD is worse than the published row, by kind of motion."""
    cells = [
        (q, s, PUBLISHED["PMD"][q][list(SPEEDS).index(s)])
        for q in range(len(LABELS))
        for s in speeds
    ]
    worse = {
        k: sum(error(scores, k, "PMD", s, q) > theirs for q, s, theirs in cells)
        for k in KINDS
    }
    listed = "; ".join(f"{kind}: {count or 'none'}" for kind, count in worse.items())
    return f"Cells of {len(cells)} in which PMD at the paper's hyperparameters is worse than the published: {listed}."


def _consistency(scores: Scores, speeds: list[float]) -> str:
    """Whose answers are always bodies, and how many of the others' are not [%]."""
    methods = list(dict.fromkeys(method for _, method, _ in scores))
    share = {
        m: [consistent(scores, kind, m, speeds) for kind in KINDS] for m in methods
    }
    always = [m for m in methods if min(share[m]) == 1.0]
    others = "; ".join(
        f"{m}: {', '.join(f'{100.0 - 100.0 * v:.0f} {k}' for k, v in zip(KINDS[:3], share[m], strict=False))}"
        for m in methods
        if m not in always
    )
    return (
        f"Physically consistent in every window of every kind: {'; '.join(always) or 'none'}. "
        f"Windows [%] in which others are not: {others or 'none'}."
    )


def _motion_errors(results: list[tuple[Job, Result]]) -> str:
    """How much larger errors of the accelerations are than with the warm filter."""
    rms = {
        k: np.mean([r["kinds"][k]["accelerations"][2:] for _, r in results], axis=0)
        for k in KINDS
    }
    times = {kind: rms[kind] / rms["warm"] for kind in KINDS if kind != "warm"}
    listed = "; ".join(
        f"{kind}: {linear:.2g} and {angular:.2g}"
        for kind, (linear, angular) in times.items()
    )
    return f"Errors of the linear and angular accelerations over those of the warm filter: {listed}."


def _alike(scores: Scores, speeds: list[float]) -> str:
    """How many published figures each motion comes near, and which error none does."""
    rows = differences(scores, speeds).rows
    near = {
        kind: sum(kind in str(row[-1]).split("; ") for row in rows) for kind in COMPARED
    }
    missed = {
        label: sum(row[1] == label and row[-1] == "none" for row in rows)
        for label in LABELS
    }
    return (
        f"Within a factor of {ALIKE:g} of the published are, of {len(rows)} figures (GEO's against two settings): "
        f"{'; '.join(f'{kind}: {count}' for kind, count in near.items())}. Most are with the motion "
        f"'{max(near, key=lambda kind: near[kind])}'. Near none of ours are "
        f"{', '.join(f'{count} of {label}' for label, count in missed.items())}."
    )


def _single_windows(scores: Scores, speeds: list[float]) -> str:
    """Of which method single windows rule the mean of the inertia's error most, at the
    lowest speed."""
    errors = {
        key: values[:, 2] for key, values in scores.items() if key[2] == speeds[0]
    }
    ratios = {key: float(v.mean() / np.median(v)) for key, v in errors.items()}
    kind, method, speed = worst = max(ratios, key=lambda key: ratios[key])
    return (
        f"At {speed:g} rad/s the mean of the inertia's error is furthest from the median for {method}, {kind}: "
        f"{ratios[worst]:.2g} times, with a single window of {errors[worst].max():.2g} %; the last table has medians."
    )


def _ordering(scores: Scores, speeds: list[float]) -> str:
    """Where PMD < GEO < OLS, RTLS holds for the inertia."""

    def holds(kind: str, geo: str, speed: float) -> bool:
        pmd, prior, *free = (
            error(scores, kind, method, speed, 2)
            for method in ("PMD", geo, "OLS", "RTLS")
        )
        return pmd < prior < min(free)

    counts = "; ".join(
        f"{kind}: "
        + ", ".join(
            f"{geo[5:]} {sum(holds(kind, geo, s) for s in speeds)}" for geo in GEOS
        )
        for kind in COMPARED
    )
    return (
        "The paper's order of methods for the inertia (PMD, then GEO, then OLS and RTLS) holds at so many of "
        f"{len(speeds)} speeds, by GEO's weight: {counts}."
    )


def _evenness(results: list[tuple[Job, Result]]) -> str:
    """How near the objects are to homogeneous ones, which GEO's prior is."""
    even = {job["object"]: result["homogeneous"] for job, result in results}
    worst = max(even, key=lambda name: even[name])
    return (
        f"Even masses of the true sum have an inertia error of {np.mean(list(even.values())):.3g} % in the mean, "
        f"{even[worst]:.3g} % at worst ({worst})."
    )


def _least(scores: Scores, speeds: list[float]) -> str:
    """The method of least inertia error, as mean over speeds, by kind of motion."""
    methods = list(dict.fromkeys(method for _, method, _ in scores))
    means = {
        (kind, m): _means(scores, kind, m, speeds) for kind in KINDS for m in methods
    }
    best = [min(methods, key=lambda m, k=kind: means[k, m][2]) for kind in KINDS]
    listed = (
        f"{kind}: {method} ({' / '.join(f'{v:.3g}' for v in means[kind, method])} %)"
        for kind, method in zip(KINDS, best, strict=True)
    )
    return f"Least inertia error, mean of the speeds (mass / COM / inertia): {'; '.join(listed)}."
