"""As many digits as the intervals are worth, in any frame; no digits of rounding, no
angles of bodies that have none."""

import re

import numpy as np
import pytest
from test_export_bodies import CONTROLLERS, POSE, from_principal, make, symmetric
from test_export_controllers import READERS

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import rotation_matrices
from hefting.export import export
from hefting.export.body import THINNEST, Body, HalfWidths, rounded_inertia

MASS, COM = 1.23456789, np.array((0.01234567, -0.0234567, 0.25))
TENSOR = symmetric(2.345678e-3, 3.456789e-3, 4.567891e-3, 1.2e-4, -7e-19, 2.34e-4)


def with_intervals(mass=3.1e-3, com=4.2e-4, inertia=1.3e-4) -> Estimate:
    """An estimate with these half-widths."""
    body = InertialParameters.from_com(MASS, COM, TENSOR)
    values = {
        "mass": (np.array(MASS), mass),
        "center_of_mass": (COM, com),
        "inertia_at_com": (TENSOR, inertia),
        "inertia_at_origin": (body.inertia_at_origin, inertia),
    }
    ends = {k: np.array([v - h, v + h]) for k, (v, h) in values.items()}
    return Estimate("test", body, 1, intervals=ends)


def test_two_digits_of_the_half_width():
    text = export(with_intervals(), "ur").text.splitlines()[-1]
    com, tensor = "0.01235, -0.02346, 0.25", "0.00235, 0.00346, 0.00457, 0.00012, 0.0"
    assert text == f"set_target_payload(1.2346, [{com}], [{tensor}, 0.00023])"


def test_a_tensor_known_badly_keeps_two_digits():
    text = export(with_intervals(inertia=0.5), "ur").text.splitlines()[-1]
    assert text.endswith("[0.0023, 0.0035, 0.0046, 0.0001, 0.0, 0.0002])")


@pytest.mark.parametrize("target", CONTROLLERS)
def test_in_flange_axes_within_the_rounding(target):
    """The steps are those of the largest half-width, as axes mix; a tenth of it."""
    mass, com, tensor = READERS[target](export(with_intervals(), target, POSE).text)
    R = POSE[:3, :3]
    assert mass == pytest.approx(MASS, abs=0.5e-4)
    np.testing.assert_allclose(com, R @ COM + POSE[:3, 3], atol=0.51e-5)
    if tensor is None:
        return
    truth = R @ TENSOR @ R.T
    if target == "fanuc":
        truth = np.diag(np.diag(truth))
    # at most four steps in principal axes, see test_export_bodies
    np.testing.assert_allclose(tensor, truth, atol=4e-5)


def test_half_widths_turn_with_the_axes():
    """As standard deviations of independent errors do, by random draws."""
    rng = np.random.default_rng(5)
    half = HalfWidths(1.0, np.array((1.0, 2.0, 3.0)), np.ones((3, 3)))
    R = rotation_matrices(np.array((0.1, 0.7, -0.5, 0.5)))
    draws = rng.normal(size=(20_000, 3)) * half.center_of_mass @ R.T
    # 20,000 draws tell a deviation to 0.5 %; four of those
    np.testing.assert_allclose(
        half.turned(R).center_of_mass, draws.std(axis=0), rtol=0.02
    )
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    open_ = HalfWidths(1.0, np.array((np.inf, 2.0, 3.0)), np.diag((np.inf, 1.0, 2.0)))
    turned = open_.turned(quarter)  # x becomes y
    assert turned.center_of_mass.tolist() == [2.0, np.inf, 3.0]
    assert turned.inertia.diagonal().tolist() == [1.0, np.inf, 2.0]


@pytest.mark.parametrize("kind", ["flat", "rod", "light rod"])
@pytest.mark.parametrize("places", [3, 5, 7])
def test_rounding_leaves_a_body_that_can_exist(kind, places):
    estimate, _ = make(kind, 0)
    body = Body.from_parameters(estimate.parameters, "object", "sensor")
    found, most = rounded_inertia(body.inertia, np.full((3, 3), places))
    second = np.linalg.eigvalsh(0.5 * np.trace(found) * np.eye(3) - found)
    assert second[0] >= 0.5 * THINNEST * second.sum()
    assert np.abs(found - body.inertia).max() <= 0.5 * 10.0**-most * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_no_angles_of_isotropic_bodies(seed):
    estimate, _ = make("cube", seed)
    assert "A 0.0, B 0.0, C 0.0" in export(estimate, "kuka", POSE).text
    assert "[1.0, 0.0, 0.0, 0.0]" in export(estimate, "abb", POSE).text
    assert "principalAxes = (1.0, 0.0, 0.0, 0.0)" in export(estimate, "usd", POSE).text


@pytest.mark.parametrize("seed", range(5))
def test_a_body_of_revolution_has_only_the_angles_of_its_axis(seed):
    """One of its two equal axes lies in a plane of the frame's axes, as it may."""
    estimate, truth = make("cylinder-like", seed)
    body = Body.from_parameters(estimate.parameters, "o", "sensor")
    body = body.moved(POSE, "flange").rounded()
    moments, axes = body.principal()
    # an eigenvector of six digits of the tensor is off by about 1e-5
    assert np.abs(axes).min() < 1e-4
    tensor = axes @ np.diag(moments) @ axes.T
    np.testing.assert_allclose(tensor, truth.tensor, atol=4 * body.inertia_step)


def test_angles_have_as_many_digits_as_the_tensor_is_worth():
    """A turn by 1e-5 / (difference of moments, 2 g m²) is 0.3 deg."""
    text = export(with_intervals(), "kuka").text
    angles = re.search(r"A (-?[\d.]+), B (-?[\d.]+), C (-?[\d.]+)", text)
    assert angles is not None
    for angle in angles.groups():
        assert re.fullmatch(r"-?\d+\.\d", angle)


def test_no_digits_of_rounding():
    """Half a millimetre in mm, and a product of inertia of 7e-19."""
    text = export(with_intervals(), "xarm").text
    assert text.endswith("arm.set_tcp_load(1.2346, [12.35, -23.46, 250.0])\n")
    for target in ("urdf", "mjcf", "sdf"):
        assert "e-19" not in export(with_intervals(), target).text


def test_a_quaternion_stays_one():
    """RAPID refuses one whose square is not 1 to about 1e-5."""
    for seed in range(5):
        text = export(make("box", seed)[0], "abb", POSE).text
        (found,) = re.findall(r", \[([^]]*)\], [^\[\]]*\];$", text)
        q = np.fromstring(found, sep=",")
        assert q @ q == pytest.approx(1.0, abs=3e-7)  # single precision
        assert from_principal((1.0, 1.0, 1.0), q) == pytest.approx(np.eye(3), abs=1e-6)
