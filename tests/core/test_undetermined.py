"""What is open of an estimate: from parameters at the origin to the COM, and its JSON."""

import numpy as np
import pytest

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.spatial import PARAMETERS, vector_to_tensor
from hefting.core.undetermined import LONGEST_ORIGIN, Undetermined
from random_problems import random_body


@pytest.mark.parametrize("index", range(10))
def test_open_at_the_com_is_what_depends_on_what_is_open_at_the_origin(index):
    """The Jacobian of mass, COM and inertia at the COM has a column of each
    parameter."""
    body = random_body(np.random.default_rng(2))  # COM with three coordinates
    depends = com_jacobian(body)[:, index] != 0.0
    found = Undetermined.of_parameters([PARAMETERS[index]], "the method")
    assert found.mass == depends[0]
    assert np.array_equal(found.center_of_mass, depends[1:4])
    assert np.array_equal(found.inertia_at_com, vector_to_tensor(depends[4:]) > 0)
    assert found


def test_nothing_is_open_by_itself():
    found = Undetermined.of_parameters([], "the method")
    assert not found
    assert found.filled_from is None
    assert (found.position, found.inertia) == ("", False)


def test_words():
    assert Undetermined.of_parameters(["mcz"], "x").position == "COM z"
    assert Undetermined.of_parameters(["mcx", "mcz"], "x").position == "COM x and COM z"
    assert Undetermined.of_parameters(["m"], "x").position == "the mass and the COM"
    assert Undetermined.of_parameters(["Jxy"], "x").position == ""


def test_masks_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        Undetermined().center_of_mass[0] = True


def test_by_default_what_has_no_end():
    body = InertialParameters.from_com(1.0, (0, 0, 0.1), np.eye(3) * 1e-3)
    covariance = np.diag([1e-6] * 6 + [np.inf] + [1e-6] * 3)  # of Jxz
    found = Estimate("OLS", body, 1, covariance=covariance).undetermined
    assert found.inertia_at_com.tolist() == [
        [False, False, True],
        [False, False, False],
        [True, False, False],
    ]
    assert not Estimate("OLS", body, 1).undetermined


def written(tmp_path, **changes):
    """An estimate's file with another `undetermined`."""
    import json

    estimate = Estimate("OLS", random_body(np.random.default_rng(1)), 1)
    data = estimate.to_dict()
    data["undetermined"] = data["undetermined"] | changes
    (tmp_path / "e.json").write_text(json.dumps(data))
    return tmp_path / "e.json"


def test_long_origins_are_cut(tmp_path):
    found = Estimate.load(written(tmp_path, filled_from="a" * 10**5))
    assert found.undetermined.filled_from == "a" * LONGEST_ORIGIN


@pytest.mark.parametrize(
    "changes",
    [
        {"mass": 1},
        {"mass": None},
        {"center_of_mass": [True, False]},
        {"center_of_mass": [True, False, "yes"]},
        {"inertia_at_com": [[True] * 3] * 2},
        {"inertia_at_com": True},
        {"filled_from": 7},
    ],
)
def test_what_is_no_mask_is_refused(tmp_path, changes):
    from hefting.core.errors import InputError

    with pytest.raises(InputError, match="not a whole estimate"):
        Estimate.load(written(tmp_path, **changes))


def test_numbers_whose_intervals_have_no_end_are_undetermined():
    """Unless it is said what is; also by a covariance that is infinite."""
    body = random_body(np.random.default_rng(3))
    ends = {
        "mass": np.array((0.0, 2.0)),
        "center_of_mass": np.array(((-1.0, -np.inf, -1.0), (1.0, np.inf, 1.0))),
        "inertia_at_com": np.array((-np.eye(3), np.eye(3))),
        "inertia_at_origin": np.array((-np.eye(3), np.eye(3))),
    }
    found = Estimate("OLS", body, 10, 1.0, intervals=ends).undetermined
    assert found is not None
    assert not found.mass
    assert found.center_of_mass.tolist() == [False, True, False]
    assert not found.inertia_at_com.any()
