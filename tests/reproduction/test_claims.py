"""The closing claims of Nadeau et al. 2022 (sec. V-F) on when each method suits, and an
ablation of the blended model.

Each test states its verdict and the figures behind it, mean errors in percent over
`wielding.things` and noise: "COM and inertia" are the paper's errors, the inertia about
the sensor origin. Tables are printed: `pytest -s`. The noise is seeded; margins lie
about halfway, in ratio, between the figures seen and another verdict.
"""

from functools import cache

import numpy as np
import pytest

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.estimators import GEO, OLS, PMD, RTLS
from hefting.estimators.geo import weight_by_rule
from hefting.estimators.quadratic import Quadratic
from hefting.estimators.sample_state import SampleState
from hefting.ingest.free_fit import fit_freely
from wielding import Method, Score, Thing, asymptotic, score, things, wielded

HOMOGENEOUS = ("uniform H", "uniform hammer")
TWO_MATERIALS = ("half H", "hammer")


def residual_noise(z: Measurements) -> Noise:
    """Levels of force and torque that least squares leaves: the wrench's own and what
    the motion's noise adds."""
    return fit_freely(z, False).noise


METHODS: dict[str, Method] = {
    "OLS": lambda thing, z: OLS(),
    "RTLS": lambda thing, z: RTLS(),
    "RTLS, noise known": lambda thing, z: RTLS(noise=z.noise),
    "GEO": lambda thing, z: GEO(thing.shape),
    "GEO, noise known": lambda thing, z: GEO(thing.shape, noise=residual_noise(z)),
    "PMD": lambda thing, z: PMD(thing.shape),
}
"""As published, and where noise levels make a difference, with them."""
MODELS: dict[str, Method] = {
    "OLS, full": METHODS["OLS"],
    "OLS, blended": lambda thing, z: OLS(model="blended"),
    "OLS, reduced": lambda thing, z: OLS(model="reduced"),
    "GEO, full": METHODS["GEO"],
    "GEO, blended": lambda thing, z: GEO(thing.shape, model="blended"),
    "GEO, reduced": lambda thing, z: GEO(thing.shape, model="reduced"),
    "PMD, full": lambda thing, z: PMD(thing.shape, model="full"),
    "PMD, blended": METHODS["PMD"],
    "PMD, reduced": lambda thing, z: PMD(thing.shape, model="reduced"),
}
"""The ablation: three methods with each model of the motion."""


@cache
def scored(method: str, duration: float, speed: float, noise: str) -> Score:
    """Of one of `METHODS` or `MODELS`."""
    return score((METHODS | MODELS)[method], duration, speed, noise)


def table(title: str, rows: dict[str, Score]) -> None:
    """Print the rows under their headings."""
    print(f"\n{title:34s}{'mass':>8}{'COM':>9}{'J':>9}{'J at COM':>9}{'bodies':>9}")
    for label, values in rows.items():
        print(f"{label:34s}{values}")


# 1. OLS "performs well with high-speed manoeuvres, but does not guarantee physical
# consistency"


def test_ols_is_good_at_high_speed_and_inconsistent():
    """Confirmed. At 4 rad/s its answers are good, and most are bodies; at 1 and 2 rad/s
    none is.

    Moderate noise, 10 s. COM and inertia: 1.9 and 260 at 1 rad/s, 0.3 and 4.6 at 4
    rad/s, where PMD has 0.3 and 3.1. At 4 rad/s the share of bodies is 1 with low
    noise, 3/4 with moderate and 1/3 with high.
    """
    speeds = (1.0, 2.0, 3.0, 4.0)
    rows = {
        (m, s): scored(m, 10.0, s, "moderate") for m in ("OLS", "PMD") for s in speeds
    }
    table(
        "moderate noise, 10 s",
        {f"{m}, {s:g} rad/s": row for (m, s), row in rows.items()},
    )
    fast, slow = rows["OLS", 4.0], rows["OLS", 1.0]
    assert all(
        rows["OLS", s].inertia > 1.5 * rows["OLS", s + 1.0].inertia for s in speeds[:-1]
    )
    assert fast.inertia < slow.inertia / 20
    assert fast.inertia < 2 * rows["PMD", 4.0].inertia
    assert fast.center_of_mass < 1.5 * rows["PMD", 4.0].center_of_mass
    assert slow.inertia > 5 * rows["PMD", 1.0].inertia
    assert slow.consistent == rows["OLS", 2.0].consistent == 0.0
    assert (
        scored("OLS", 10.0, 4.0, "high").consistent
        < 0.6
        < scored("OLS", 10.0, 4.0, "low").consistent
    )


# 2. RTLS "has the lowest asymptotic error for trajectories with large signal-to-noise
# ratios, but converges more
#    slowly and does not guarantee physical consistency"


def test_rtls_has_the_lowest_asymptotic_error_if_it_knows_the_noise():
    """Confirmed on the condition that it knows the levels of the noise, of
    accelerations too; as published, hardly.

    Low noise, 4 rad/s, 40 recordings of 35 s as one. COM and inertia: 0.004 and 0.04
    and still falling where it knows them. The others stand still: as published, all
    entries of regressor and wrench equally noisy, at 0.018 and 0.42; OLS at 0.016 and
    0.45; those with a shape at 0.02 to 0.2 and 0.6 to 4.
    """
    rows = asymptotic(METHODS, 4.0, "low", recordings=40)
    table("low noise, 4 rad/s, 1400 s", rows)
    known = rows["RTLS, noise known"]
    others = [row for label, row in rows.items() if label != "RTLS, noise known"]
    assert all(known.center_of_mass < row.center_of_mass / 2 for row in others)
    assert all(known.inertia < row.inertia / 3 for row in others)
    assert rows["RTLS"].inertia == min(row.inertia for row in others)
    assert rows["RTLS"].inertia > 0.8 * rows["OLS"].inertia
    assert rows["RTLS"].center_of_mass > 0.8 * rows["OLS"].center_of_mass


def test_rtls_converges_more_slowly():
    """Confirmed: as published as slowly as OLS, and where it knows the noise, more
    slowly still at low speed.

    Moderate noise, inertia after 1.5 s: at 4 rad/s 13 (OLS 13, GEO 5, PMD 5), at 1
    rad/s 520 (OLS 510, GEO 8, PMD 19). Where it knows the noise, 7 and 4,000; after 35
    s at 4 rad/s it has passed them all, 1.2 to 2 or more.
    """
    times = {1.0: (1.5,), 4.0: (1.5, 35.0)}
    rows = {
        (m, s, t): scored(m, t, s, "moderate")
        for s in times
        for t in times[s]
        for m in METHODS
    }
    table(
        "moderate noise",
        {f"{m}, {s:g} rad/s, {t:g} s": row for (m, s, t), row in rows.items()},
    )
    for speed in times:
        slow, ols = rows["RTLS", speed, 1.5].inertia, rows["OLS", speed, 1.5].inertia
        assert slow == pytest.approx(ols, rel=0.1)
        assert all(
            slow > 1.5 * rows[shaped, speed, 1.5].inertia
            for shaped in ("GEO", "GEO, noise known", "PMD")
        )
    assert (
        rows["RTLS, noise known", 1.0, 1.5].inertia > 2 * rows["OLS", 1.0, 1.5].inertia
    )
    late = {m: rows[m, 4.0, 35.0].inertia for m in METHODS}
    known = late.pop("RTLS, noise known")
    assert all(known < 0.75 * other for other in late.values())


def test_rtls_is_inconsistent():
    """Confirmed: as published no answer at 1 rad/s is a body, after 1.5 or 10 s, at any
    level of noise.

    Where it knows the noise, none after 1.5 s, and a minority after 10 s.
    """
    cases = [
        (noise, duration)
        for noise in ("low", "moderate", "high")
        for duration in (1.5, 10.0)
    ]
    methods = ("RTLS", "RTLS, noise known")
    rows = {(m, n, t): scored(m, t, 1.0, n) for m in methods for n, t in cases}
    table("1 rad/s", {f"{m}, {n}, {t:g} s": row for (m, n, t), row in rows.items()})
    assert all(rows["RTLS", n, t].consistent == 0.0 for n, t in cases)
    assert all(
        rows["RTLS, noise known", n, 1.5].consistent == 0.0
        for n in ("low", "moderate", "high")
    )
    assert all(rows["RTLS, noise known", n, t].consistent <= 0.6 for n, t in cases)


# 3. GEO "performs better than RTLS under high noise and guarantees physical
# consistency, but requires a good initial
#    guess and a well-tuned regularization factor"


def test_geo_beats_rtls_under_high_noise_and_is_always_consistent():
    """Confirmed as published; refuted where RTLS knows the noise and the motion is fast
    and long.

    High noise, COM and inertia at 1, 2, 4 rad/s: 2.6, 3.3, 1.3 and 26, 24, 8 against
    RTLS's 6.9, 9.2, 3.2 and 700, 730, 36 after 1.5 s; 1.3, 1.5, 0.5 and 17, 15, 4
    against 3.4, 4.7, 0.9 and 360, 200, 12 after 10 s. Inertia after 35 s at 4 rad/s:
    3.5 against 2.2 of RTLS that knows the noise. All answers are bodies.
    """
    cases = [(t, s) for t in (1.5, 10.0) for s in (1.0, 2.0, 4.0)]
    rows = {
        (m, t, s): scored(m, t, s, "high") for t, s in cases for m in ("RTLS", "GEO")
    }
    long = {
        m: scored(m, 35.0, 4.0, "high")
        for m in ("RTLS, noise known", "GEO", "GEO, noise known")
    }
    table(
        "high noise",
        {f"{m}, {t:g} s, {s:g} rad/s": row for (m, t, s), row in rows.items()},
    )
    table("high noise, 35 s, 4 rad/s", long)
    for case in cases:
        geo, rtls = rows["GEO", *case], rows["RTLS", *case]
        assert geo.consistent == 1.0
        assert geo.center_of_mass < 0.75 * rtls.center_of_mass
        assert geo.inertia < 0.6 * rtls.inertia
    assert (
        long["RTLS, noise known"].inertia
        < 0.8 * long["GEO"].inertia
        < long["GEO, noise known"].inertia
    )


def prior(
    thing: Thing, z: Measurements, mass: float = 1.0, aside: float = 0.0
) -> InertialParameters:
    """Homogeneous, as heavy as least squares says times `mass`, moved `aside` [m]."""
    pose = np.eye(4)
    pose[:3, 3] = aside / np.sqrt(3.0)
    return InertialParameters(
        mass
        * OLS(intervals=False).fit(z).parameters.mass
        * thing.shape.homogeneous.vector
    ).moved(pose)


@pytest.mark.parametrize("known", [False, True], ids=["noise unknown", "noise known"])
def test_geo_needs_a_good_initial_guess(known):
    """Confirmed as published; where the noise is known, at the default weight, no guess
    matters as much.

    Homogeneous things, moderate noise, 10 s at 2 rad/s, COM and inertia. As published
    0.3 and 3 with the right prior, 0.6 and 20 with that of the bounding box, 0.3 and 50
    with one three times as heavy, 36 and 180 with one 9 cm aside. Where the noise is
    known (as the residual's) 0.4 to 0.6 and 19 to 23 with all four: the right one is
    trusted less.
    """

    def told(z: Measurements) -> Noise | None:
        return residual_noise(z) if known else None

    guesses: dict[str, Method] = {
        "right": lambda thing, z: GEO(thing.shape, noise=told(z)),
        "of its bounding box": lambda thing, z: GEO(thing.box, noise=told(z)),
        "three times as heavy": lambda thing, z: GEO(
            prior=prior(thing, z, mass=3.0), noise=told(z)
        ),
        "9 cm aside": lambda thing, z: GEO(
            prior=prior(thing, z, aside=0.09), noise=told(z)
        ),
    }
    rows = {
        guess: score(method, 10.0, 2.0, "moderate", HOMOGENEOUS)
        for guess, method in guesses.items()
    }
    table("homogeneous things", rows)
    assert all(row.consistent == 1.0 for row in rows.values())
    right = rows.pop("right")
    if known:
        assert all(0.67 < row.inertia / right.inertia < 1.5 for row in rows.values())
        assert all(
            0.5 < row.center_of_mass / right.center_of_mass < 1.5
            for row in rows.values()
        )
    else:
        assert all(row.inertia > 3 * right.inertia for row in rows.values())
        assert rows["9 cm aside"].center_of_mass > 20 * right.center_of_mass


def test_geo_needs_a_well_tuned_weight():
    """Confirmed, for what is not homogeneous; of what is, the prior is the truth, and
    more weight is better.

    Moderate noise, 10 s at 2 rad/s, inertia at 1e-4, 1 and 1e4 times the authors'
    weight: 34, 3 and 0.1 of homogeneous things, 28, 8 and 76 of those of two materials.
    """

    def weighted(factor: float) -> Method:
        def method(thing: Thing, z: Measurements) -> GEO:
            A = Quadratic.of(SampleState.of(z)).A
            return GEO(thing.shape, gamma=factor * weight_by_rule(A))

        return method

    factors = (1e-4, 1e-2, 1.0, 1e2, 1e4)
    kinds = {"homogeneous": HOMOGENEOUS, "two materials": TWO_MATERIALS}
    rows = {
        (kind, f): score(weighted(f), 10.0, 2.0, "moderate", kinds[kind])
        for kind in kinds
        for f in factors
    }
    table(
        "weight over the authors'",
        {f"{kind}, {f:g}": row for (kind, f), row in rows.items()},
    )
    inertia = {key: row.inertia for key, row in rows.items()}
    assert all(
        inertia["homogeneous", f] > 1.5 * inertia["homogeneous", 100 * f]
        for f in factors[:-1]
    )
    assert inertia["two materials", 1.0] < 0.5 * inertia["two materials", 1e-4]
    assert inertia["two materials", 1.0] < 0.25 * inertia["two materials", 1e4]
    assert all(row.consistent == 1.0 for row in rows.values())


# 4. PMD "is fast, more robust for small signal-to-noise ratios, and guarantees physical
# consistency, but requires
#    knowledge of the shape and pose of the object"


def test_pmd_is_more_robust_at_small_signal_to_noise_ratios():
    """Confirmed with a condition: it is the blend of models that is robust, and GEO
    with the same blend is better.

    1.5 s at 1 rad/s, COM and inertia with low and with high noise: PMD 3.1 and 18, 2.7
    and 20; GEO 0.4 and 6, 2.6 and 26; OLS 3.0 and 420, 6.6 and 660; RTLS the same. GEO
    blended 1.8 and 9 with either. So with low noise GEO is three times as good as PMD,
    whose error is that of ignoring slow motion; all of PMD's answers are bodies.
    """
    methods = (*METHODS, "GEO, blended")
    rows = {
        (m, n): scored(m, 1.5, 1.0, n)
        for m in methods
        for n in ("low", "moderate", "high")
    }
    table("1.5 s, 1 rad/s", {f"{m}, {n}": row for (m, n), row in rows.items()})

    def growth(method: str) -> float:
        return rows[method, "high"].inertia / rows[method, "low"].inertia

    assert growth("PMD") < 1.2 < growth("OLS")
    assert growth("GEO") > 3
    assert all(
        rows["PMD", "high"].inertia < rows[m, "high"].inertia
        for m in METHODS
        if m != "PMD"
    )
    assert all(
        rows["PMD", "high"].inertia < rows[m, "high"].inertia / 10
        for m in ("OLS", "RTLS")
    )
    assert all(
        rows["PMD", "high"].center_of_mass < rows[m, "high"].center_of_mass / 1.5
        for m in ("OLS", "RTLS")
    )
    assert rows["GEO, blended", "high"].inertia < 0.7 * rows["PMD", "high"].inertia
    assert rows["GEO", "low"].inertia < 0.5 * rows["PMD", "low"].inertia
    assert all(rows["PMD", n].consistent == 1.0 for n in ("low", "moderate", "high"))


def test_pmd_is_fast():
    """Confirmed: for 150 observations a handful of linear systems of 16 unknowns, 6
    here; with `make bench` beside what else solves the paper's problem."""
    found = PMD(things()["hammer"].shape).fit(wielded("hammer", 1.5, 1.0))
    assert found.certificate.converged
    assert found.certificate.iterations <= 12


def test_pmd_needs_shape_and_pose():
    """Confirmed of the pose, beyond 1 cm and 10 degrees; of the shape a bounding box
    will do.

    Moderate noise, 10 s at 2 rad/s, COM and inertia: 2.2 and 30 at the right pose, the
    same when off by 1 cm or 5 degrees; 5 and 38 at 2 cm, 20 and 105 at 5 cm, 2.2 and 38
    at 10 degrees, 6.6 and 117 at 45; 0.6 and 24 with the bounding box: noise in the
    accelerations makes inertia seem smaller, and less shape distorts the COM less.
    """

    def wrong(millimetres: float, degrees: float) -> Score:
        directions = [
            score(
                lambda thing, z, d=d: PMD(
                    thing.displaced(1e-3 * millimetres, degrees, d)
                ),
                10.0,
                2.0,
                "moderate",
                (),
                1,
            )
            for d in range(4)
        ]
        return Score(
            *np.mean([list(vars(s).values()) for s in directions], axis=0).tolist()
        )

    offsets, angles = (0.0, 5.0, 10.0, 20.0, 50.0), (5.0, 10.0, 20.0, 45.0)
    rows = {f"{offset:g} mm": wrong(offset, 0.0) for offset in offsets}
    rows |= {f"{angle:g} degrees": wrong(0.0, angle) for angle in angles}
    rows["bounding box"] = score(
        lambda thing, z: PMD(thing.box), 10.0, 2.0, "moderate", (), 1
    )
    table("moderate noise, 10 s, 2 rad/s", rows)
    right = rows["0 mm"]
    for label in ("5 mm", "10 mm", "5 degrees"):
        assert rows[label].inertia < 1.25 * right.inertia
        assert rows[label].center_of_mass < 1.25 * right.center_of_mass
    assert rows["50 mm"].center_of_mass > 4 * right.center_of_mass
    assert rows["50 mm"].inertia > 2 * right.inertia
    assert rows["45 degrees"].inertia > 2 * right.inertia
    assert rows["bounding box"].inertia < 1.2 * right.inertia
    assert rows["bounding box"].center_of_mass < 0.7 * right.center_of_mass
    assert all(row.consistent == 1.0 for row in rows.values())


# the ablation


def test_reduced_full_and_blended_model():
    """The reduced model pays where motion is slow and its noise high, and for COM and
    inertia, not for the mass.

    1.5 s; COM and inertia. High noise at 1 rad/s: OLS 6.6 and 660 full, 3.6 and no
    inertia reduced; PMD 3.9 and 40 full, 3.0 and 17 reduced, 2.7 and 20 blended; GEO
    2.6 and 26, 1.9 and 9, 1.9 and 9. But the mass of all three is better by the full
    one, 0.4 to 0.8. At 2 rad/s, looked at for PMD, nothing is gained; at 4 rad/s the reduced one is off by
    14 to 27 in the COM and blended is full, within 5 %. Low noise at 1 rad/s: PMD 0.4
    and 11 full, 3.1 and 19 blended.
    """
    cases = (("high", 1.0), ("high", 2.0), ("high", 4.0), ("low", 1.0))
    told = dict.fromkeys(cases[::2], MODELS)
    told |= {case: [m for m in MODELS if m.startswith("PMD")] for case in cases[1::2]}
    rows = {
        (m, *case): scored(m, 1.5, case[1], case[0])
        for case in cases
        for m in told[case]
    }
    for case in cases:
        table(
            f"{case[0]} noise, 1.5 s, {case[1]:g} rad/s",
            {m: rows[m, *case] for m in told[case]},
        )
    for method in ("OLS", "GEO", "PMD"):
        full, blended, reduced = (
            rows[f"{method}, {model}", "high", 1.0]
            for model in ("full", "blended", "reduced")
        )
        assert reduced.center_of_mass < 0.9 * full.center_of_mass
        assert blended.center_of_mass < 0.9 * full.center_of_mass
        assert blended.inertia < 0.7 * full.inertia
        assert full.mass < 0.7 * reduced.mass
        full, blended, reduced = (
            rows[f"{method}, {model}", "high", 4.0]
            for model in ("full", "blended", "reduced")
        )
        assert reduced.center_of_mass > 2 * full.center_of_mass
        assert reduced.inertia > 2 * full.inertia
        assert blended.inertia == pytest.approx(full.inertia, rel=0.05)
    # the blend keeps PMD's inertia near the better of the two, at any speed
    for speed in (1.0, 2.0, 4.0):
        best = min(
            rows[f"PMD, {model}", "high", speed].inertia
            for model in ("full", "reduced")
        )
        assert rows["PMD, blended", "high", speed].inertia < 1.3 * best
    assert (
        rows["PMD, blended", "low", 1.0].center_of_mass
        > 3 * rows["PMD, full", "low", 1.0].center_of_mass
    )
