"""Plausibility: where the lines are between what is said, what is refused, and what
passes."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.core.recording import Stream
from hefting.core.spatial import pose_matrix
from hefting.identification import identify
from hefting.ingest import plausibility
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.plausibility import (
    com_warnings,
    density_warnings,
    torque_sign_messages,
)
from hefting.inspection import inspect
from hefting.shapes import Shape
from hefting.simulation import UR5, random_smooth, simulate

SIDES = np.array((0.2, 0.04, 0.1))
POSE = pose_matrix([0.1, -0.2, 0.05, *Rotation.from_rotvec((0.3, -1.0, 0.6)).as_quat()])
BOX = Shape.from_mesh(trimesh.creation.box(SIDES), pose=POSE)
"""About the origin of its own frame, which stands askew."""


def told(local, std, mass=2.0):
    """Whether a COM at `local` (3,) in the box's frame, known to `std` [m], counts as
    outside."""
    com = POSE[:3, :3] @ local + POSE[:3, 3]
    return codes(com_warnings(free_fit(com, std, mass), BOX)) == {"com-outside-shape"}


def free_fit(com, std, mass=2.0):
    covariance = np.diag(
        np.concatenate(
            ([(0.01 * mass) ** 2], np.full(3, (mass * std) ** 2), np.full(6, 1e-6))
        )
    )
    vector = np.concatenate(([mass], mass * com, np.zeros(6)))
    return FreeFit(vector, None, covariance, Noise(), np.ones(16))


def test_without_a_shape_a_com_is_far_from_0_4_m_and_three_deviations_on():
    away = np.array((0.6, 0.0, 0.8))
    for distance, std, is_far in (
        (0.39, 1e-6, False),
        (0.41, 1e-6, True),
        (0.4 + 2.9 * 0.01, 0.01, False),
        (0.4 + 3.1 * 0.01, 0.01, True),
        (1.0, np.inf, False),
    ):
        said = com_warnings(free_fit(distance * away, std), None)
        assert (codes(said) == {"com-far-from-sensor"}) == is_far


@pytest.mark.parametrize(
    ("moments", "common", "tool", "said"),
    [
        ((-5e-3, 0.0, 0.0), None, None, True),  # five deviations of all three
        ((-3e-3, 1e-3, -1e-3), None, None, False),
        ((-5e-3, 0.0, 0.0), 1e-6, None, False),  # of errors that samples share, too
        ((-5e-3, 0.0, 0.0), None, "gripper", False),  # whose errors may be that large
    ],
)
def test_no_body_has_a_negative_sum_of_moments(moments, common, tool, said):
    fit = free_fit(np.zeros(3), 0.01)
    fit.vector[[4, 7, 9]] = moments
    fit.covariance[4:, 4:] = np.eye(6) * 1e-6 / 3.0
    errors = None if common is None else common * np.eye(10)
    found = SimpleNamespace(fit=fit, common_errors=errors, tool=tool)
    assert bool(torque_sign_messages(cast(Any, found), True)) is said


@pytest.mark.parametrize(
    ("moments", "std", "tool", "shape", "said"),
    [
        (3e-3, 1e-3, None, None, True),  # of four deviations
        (-3e-3, 1e-3, None, None, True),
        (5e-3, 1e-3, None, None, False),
        (-5e-3, 1e-3, None, None, False),  # an error by itself
        (0.0, np.inf, None, None, True),  # static poses
        (0.0, np.inf, "gripper", None, False),
        (0.0, np.inf, None, BOX, False),
    ],
)
def test_the_sign_of_the_torques_is_assumed_where_the_inertia_is_open(
    moments, std, tool, shape, said
):
    fit = free_fit(np.array((0.03, -0.02, 0.05)), 1e-3)
    fit.vector[4] = moments
    fit.covariance[4:, 4:] = np.diag((std**2, *5 * (0.0,)))
    found = SimpleNamespace(fit=fit, common_errors=None, tool=tool)
    messages = torque_sign_messages(cast(Any, found), shape is not None)
    assert ("torque-sign-assumed" in codes(messages)) is said
    assert not said or "(-30, 20, -50) mm" in messages[0]


def test_a_com_whose_mirror_image_is_inside_is_of_torques_of_the_other_sign():
    inside = POSE[:3, 3] + POSE[:3, :3] @ (0.4 * SIDES)
    for times, inertia, severity in (
        (-1.0, 0.0, "error"),
        (-1.0, -3.0, "error"),
        (-1.0, 5.0, "warning"),  # which shows the sign of the torques
        (-3.0, 0.0, "warning"),
    ):
        (message,) = com_warnings(free_fit(times * inside, 1e-3), BOX, inertia)
        assert message.code == "com-outside-shape"
        assert message.severity == severity
        assert ('"-tx"' in message) == (severity == "error")


def test_static_poses_with_a_force_in_kgf_are_in_doubt():
    """They fit a tenth of the mass ten times as far away, which had been *good*."""
    rng = np.random.default_rng(1)
    turns = Rotation.random(20, random_state=2)
    force = turns.inv().apply((0.0, 0.0, -9.80665 * 0.5))
    torque = np.cross((0.03, -0.02, 0.05), force)
    wrench = np.hstack((force / 9.80665, torque))
    wrench += rng.normal(size=wrench.shape) * np.repeat((0.005, 0.003), 3)
    found = identify(orientation=turns.as_quat(), wrench=wrench + 0.3)
    assert "com-far-from-sensor" in codes(found.warnings)
    assert found.verdict.level == "usable with care"


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_com_is_outside_from_three_quarters_of_the_sides_and_three_deviations_on(
    axis, side
):
    outward = side * np.eye(3)[axis]
    limit = 0.75 * SIDES[axis]
    assert not told(0.98 * limit * outward, 1e-6)
    assert told(1.02 * limit * outward, 1e-6)
    assert not told((limit + 2.9 * 0.004) * outward, 0.004)
    assert told((limit + 3.1 * 0.004) * outward, 0.004)
    assert not told(1.02 * limit * outward, np.inf)


@pytest.mark.parametrize("share", [0.7, 0.8])
def test_a_com_outside_is_told_of_a_recording(share):
    """A body whose COM is known to a tenth of a millimetre, by so much of the box's
    longest side beside its middle."""
    com = POSE[:3, :3] @ (share * SIDES * (1.0, 0.0, 0.0)) + POSE[:3, 3]
    log = simulate(
        UR5.motion(random_smooth(4.0, 100.0, 1.0, 0)),
        InertialParameters.from_com(1.0, com, 1e-3 * np.eye(3)),
        noise=Noise(0.01, 0.0005),
        exact=True,
    )
    assert (
        "com-outside-shape" in codes(identify(log, BOX, method="OLS").estimate.warnings)
    ) == (share > 0.75)


@pytest.mark.parametrize("denser", [0.95, 1.05])
def test_a_shape_holds_no_more_than_osmium(denser):
    """23,000 kg/m³ in all of the bounding box: more is a wrong unit, and said to be."""
    mass = denser * 23_000.0 * float(np.prod(SIDES))
    log = simulate(
        UR5.motion(random_smooth(4.0, 100.0, 1.0, 0)),
        InertialParameters.from_com(mass, POSE[:3, 3], 0.1 * np.eye(3)),
        noise=Noise(0.01, 0.0005),
        exact=True,
    )
    if denser > 1.0:
        with pytest.raises(
            InputError, match="in a shape of at most 800 cm³; check the shape"
        ):
            identify(log, BOX, method="OLS")
    else:
        assert identify(
            log, BOX, method="OLS"
        ).estimate.parameters.mass == pytest.approx(mass, rel=1e-3)


@pytest.mark.parametrize("method", ["Bayes", "PMD"])
def test_a_shape_out_of_reach_is_refused(method):
    """Farther than ten metres: nearer ones are told, as a unit or pose that is wrong."""
    log = simulate(
        UR5.motion(random_smooth(4.0, 100.0, 1.0, 0)),
        InertialParameters.from_com(1.0, (0.0, 0.0, 0.1), 1e-3 * np.eye(3)),
        noise=Noise(0.1, 0.005),
        seed=1,
    )
    pose = pose_matrix([0.0, 0.0, 1e4, 0.0, 0.0, 0.0, 1.0])
    far = Shape.from_mesh(trimesh.creation.box(SIDES), pose=pose)
    with pytest.raises(
        InputError, match=r"1e\+04 m away from the sensor; check the unit"
    ):
        identify(log, far, method=method)


@pytest.mark.parametrize(("speed", "told"), [(0.2, False), (2.5, True)])
def test_gravity_alone_is_told_where_the_motion_is_fast(speed, told):
    """Parts of exact masses and places: nothing but accelerations, which HPS leaves out,
    is unexplained."""
    corners = np.indices((2, 2, 2)).reshape(3, 8).T * (0.1, 0.2, 0.06) + (
        0.0,
        0.0,
        0.05,
    )
    parts = Shape(corners, labels=np.arange(8) % 4 // 2)
    body = InertialParameters(parts.matrix @ np.where(parts.labels, 0.1, 0.4))
    log = simulate(
        UR5.motion(random_smooth(10.0, 100.0, speed, 0)),
        body,
        noise=Noise(0.1, 0.005),
        seed=1,
    )
    limits = {"max_acceleration": 20.0, "max_angular_acceleration": 20.0}
    found = identify(log, parts, method="HPS", **limits).estimate
    warnings = found.warnings
    assert ("misfit" in codes(warnings)) == told
    assert any("too fast for gravity alone" in line for line in warnings) == told


@pytest.mark.parametrize("shape", [None, BOX])
def test_an_answer_that_does_not_fit_the_wrench_is_not_to_be_used(shape):
    """What is left of an object less a gripper that was not there is no body: the answer
    is the nearest one, which had been *usable with care*. In the shape, too, as the answer
    is then without it."""
    held = InertialParameters.from_com(1.2, (0.0, 0.0, 0.2), 8e-3 * np.eye(3))
    other = InertialParameters.from_com(0.9, (0.0, 0.0, 0.1), 2e-3 * np.eye(3))
    log = simulate(
        UR5.motion(random_smooth(8.0, 100.0, 1.0, 0)),
        InertialParameters(held.vector - other.vector),
        noise=Noise(0.1, 0.005),
        seed=1,
    )
    found = identify(log, shape)
    assert found.verdict.level == "do not use"
    assert ("misfit", "error") in {(m.code, m.severity) for m in found.verdict.reasons}


@pytest.mark.parametrize("tool", [None, 0.8])
def test_a_mass_is_refused_where_it_is_negative_not_where_it_is_uncertain(
    tool, monkeypatch
):
    """In its standard deviations: half of one may be an object of a few grams."""
    monkeypatch.setattr(plausibility, "check_wrench", lambda *_: None)
    gripper = tool and SimpleNamespace(parameters=SimpleNamespace(mass=tool))

    def refused(mass_t: float) -> bool:
        fit = SimpleNamespace(
            mass_t=mass_t,
            mass_is_open=False,
            mass=mass_t,
            mass_std=1.0,
        )
        found = SimpleNamespace(
            fit=fit,
            given_bias=None,
            bias="none",
            tool=gripper,
            log="a.csv",
            warnings=(),
        )
        try:
            plausibility._require_mass(cast(Any, found), None)
        except NotIdentifiableError:
            return True
        return False

    assert [refused(t) for t in (-3.0, -0.5, 0.5, 3.0)] == [True, True, False, False]


def test_a_very_short_recording_asks_for_the_unit_of_time():
    """Four seconds that are said to be four milliseconds."""
    log = simulate(
        UR5.motion(random_smooth(4.0, 100.0, 1.0, 0)),
        InertialParameters.from_com(1.0, (0.0, 0.02, 0.05), 1e-3 * np.eye(3)),
    )
    streams = {
        name: Stream(1e-3 * stream.time, stream.values)
        for name, stream in log.streams.items()
    }
    with pytest.raises(NotIdentifiableError, match="is its time in seconds"):
        identify(replace(log, streams=streams))


@pytest.mark.parametrize(
    ("scale", "doubted"),
    [
        (0.4, {"shape-too-small"}),
        *((scale, set()) for scale in (0.7, 1.0, 5.0)),
        (10.0, {"shape-too-large"}),
    ],
)
def test_a_shape_far_too_small_or_too_large_is_doubted(scale, doubted):
    """A body of 0.8 litres has a thousandth of its density in a shape of ten times its
    length, and sixteen times as much in one of inches taken for centimetres; of a large
    box that only holds the object nothing follows."""
    shape = Shape.from_mesh(trimesh.creation.box(scale * SIDES))
    fit = FreeFit(  # 3,000 kg/m³
        np.array([2.4, *[0.0] * 9]), None, 1e-6 * np.eye(10), Noise(), np.ones(16)
    )
    said = codes(density_warnings(fit, shape))
    assert said == doubted
    around = Shape.from_box(*(10.0 * np.array((-0.1, 0.1, -0.1, 0.1, -0.1, 0.1))))
    assert not density_warnings(fit, around)
    inside = Shape.from_box(*np.outer(0.2 * SIDES, (-1.0, 1.0)).ravel())
    assert codes(density_warnings(fit, inside)) == {"shape-too-small"}


@pytest.mark.parametrize(
    ("content", "said"),
    [(0.0, set()), (0.5, {"shape-hollow"}), (3.0, {"shape-hollow"})],
)
@pytest.mark.parametrize("closed", [False, True])
def test_walls_of_a_vessel_that_are_too_heavy_are_doubted(closed, content, said):
    """A mug of ceramics, open or closed, empty or with 0.5 or 3 times its own mass in
    it; a bracket of the same walls, a tube, and the filled mug, may be of steel, as may
    the empty one."""
    mug = trimesh.creation.cylinder(radius=0.04, height=0.1)
    inside = trimesh.creation.cylinder(radius=0.036, height=0.092 + 0.01 * (not closed))
    inside.apply_translation((0.0, 0.0, 0.005 * (not closed)))
    walls = trimesh.boolean.difference([mug, inside], engine="manifold")
    bracket = trimesh.util.concatenate(
        [
            trimesh.creation.box((0.1, 0.05, 0.004)),
            trimesh.creation.box((0.004, 0.05, 0.2)),
        ]
    )
    tube = trimesh.creation.annulus(r_min=0.036, r_max=0.04, height=0.1)

    def doubted(mesh, density):
        shape = Shape.from_mesh(mesh, pose=POSE)
        vector = np.array([density * shape.volume, *[0.0] * 9])
        fit = FreeFit(vector, None, 1e-6 * np.eye(10), Noise(), np.ones(16))
        found = density_warnings(fit, shape)
        return codes(m for m in found if m.severity == "warning")

    assert doubted(walls, 2400.0 * (1.0 + content)) == said
    assert not any(doubted(each, 7800.0) for each in (mug, bracket, tube, walls))


@pytest.mark.parametrize(
    ("mass", "factor", "said"),
    [
        (
            0.5,
            1e-3,
            "0.5 g: is the wrench in newtons and newton-metres, not kN and kN m",
        ),
        (
            0.5,
            1e3,
            "500 kg: is the wrench in newtons and newton-metres, not mN and mN m",
        ),
        (0.009, 1.0, ""),  # a light object, by the noise of a real sensor
        (0.02, 1.0, ""),
        (90.0, 1.0, ""),
    ],
)
def test_a_wrench_of_which_all_is_in_a_far_unit_is_in_doubt(mass, factor, said):
    """It had been *good*, with a thousandth or a thousand times the mass."""
    log = simulate(
        UR5.motion(random_smooth(6.0, 100.0, 1.0, 0)),
        InertialParameters.from_com(mass, (0.0, 0.02, 0.05), mass * 1e-3 * np.eye(3)),
        noise=Noise(0.01, 5e-4),
    )
    wrench = log["wrench"]
    scaled = Stream(wrench.time, factor * wrench.values)
    log = replace(log, streams={**log.streams, "wrench": scaled})
    for found in (identify(log), inspect(log)):
        told = [m for m in found.warnings if m.code == "mass-unusual"]
        assert [m for m in told if said in m] == told
        assert len(told) == bool(said)


@pytest.mark.parametrize(("share", "refused"), [(0.95, False), (1.05, True)])
def test_a_lever_is_refused_from_a_distance_by_the_size_of_the_shape(
    share, refused, monkeypatch
):
    """One and a half times its farthest point, and twice its diagonal."""
    reach = 1.5 * np.linalg.norm(BOX.positions, axis=1).max()
    reach += 2.0 * np.linalg.norm(BOX.extents)
    monkeypatch.setattr(plausibility, "lever", lambda *_: share * reach)
    fit = SimpleNamespace(mass_is_open=False, mass=1.0, bias=None)
    found = cast(Any, SimpleNamespace(fit=fit, log="a.csv", state=None))
    if not refused:
        plausibility.check_wrench(found, BOX)
        return
    with pytest.raises(InputError, match="give torque in newton-metres"):
        plausibility.check_wrench(found, BOX)


def test_a_torque_of_the_other_sign_is_of_no_body():
    """In slow motion it had been *good*, with the COM on the other side of the sensor."""
    body = InertialParameters.from_com(1.0, (0.05, 0.1, 0.1), 2e-3 * np.eye(3))
    motion = UR5.motion(random_smooth(12.0, 100.0, 0.4, 1))
    log = simulate(motion, body, noise=Noise(0.1, 0.005), seed=1)
    wrench = log["wrench"]
    signs = np.repeat((1.0, -1.0), 3)
    other = Stream(wrench.time, wrench.values * signs)
    log = replace(log, streams={**log.streams, "wrench": other})
    assert not identify(log).verdict.usable
