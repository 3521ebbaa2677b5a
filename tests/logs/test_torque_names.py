"""Joint torques in tables of other programs, read by the names of their columns."""

import numpy as np
import pandas as pd
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs.map_guess import guess_map

ROWS, JOINTS = 40, 7
RNG = np.random.default_rng(12)
TIME = 0.01 * np.arange(ROWS)
ANGLES = RNG.uniform(-1.0, 1.0, (ROWS, JOINTS))
RATES = RNG.uniform(-1.0, 1.0, (ROWS, JOINTS))
TORQUES = RNG.uniform(-20.0, 20.0, (ROWS, JOINTS))
FORMS = {
    "libfranka": ("q[{}]", "dq[{}]", "tau_J[{}]"),
    "PlotJuggler": tuple(
        f"/joint_states/{k}/{{}}" for k in ("position", "velocity", "effort")
    ),
    "JointState": ("position_{}", "velocity_{}", "effort_{}"),
    "from one": ("joint{1}", "vel{1}", "torque{1} [Nm]"),
    "units": ("Joint{1} [deg]", "Speed{1}", "JointTorque{1} [Nmm]"),
}
"""Names of angles, speeds and torques of joints counted from 0 or, ``{1}``, from 1."""


def names_of(form: str) -> list[str]:
    return [name.format(k, k + 1) for name in FORMS[form] for k in range(JOINTS)]


def table_of(form: str) -> pd.DataFrame:
    parts = [ANGLES, RATES, TORQUES]
    if form == "units":
        parts = [np.degrees(ANGLES), RATES, 1e3 * TORQUES]
    values = np.column_stack((TIME, *parts))
    return pd.DataFrame(values, columns=["time", *names_of(form)])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("beside", ["", "tau_ext_hat_filtered[{}]", "tau_J_d[{}]"])
def test_angles_and_torques_are_told_by_their_names(form, beside):
    """Not external torques, which are without the arm's, nor those that are desired."""
    table = table_of(form)
    for k in range(JOINTS if beside else 0):
        table[beside.format(k)] = RNG.normal(size=ROWS)
    got = hefting.as_recording(table, wrench_needed=False)
    np.testing.assert_allclose(got["joint_positions"].values, ANGLES, rtol=1e-12)
    np.testing.assert_allclose(got["joint_torques"].values, TORQUES, rtol=1e-12)
    assert "columns-by-name" in codes(got.warnings)
    assert "columns-doubtful" not in codes(got.warnings)


def test_joints_with_names_have_their_own_torques():
    """Columns in any order; the torques follow the positions."""
    joints = ["pan_joint", "lift_joint", "elbow_joint", "joint_4"]
    names = [f"/joint_states/{joint}/position" for joint in joints]
    names += [f"/joint_states/{joint}/effort" for joint in reversed(joints)]
    values = np.column_stack((TIME, ANGLES[:, :4], TORQUES[:, 3::-1]))
    got = hefting.as_recording(
        pd.DataFrame(values, columns=["time", *names]), wrench_needed=False
    )
    assert got.joint_names == tuple(joints)
    np.testing.assert_array_equal(got["joint_torques"].values, TORQUES[:, :4])


def test_currents_are_no_torques():
    table = table_of("libfranka")
    table.columns = [name.replace("tau_J", "motor_current") for name in table.columns]
    got = hefting.as_recording(table, wrench_needed=False)
    np.testing.assert_array_equal(got["joint_currents"].values, TORQUES)
    assert not got.has("joint_torques")


def test_where_a_wrench_is_asked_for_it_is_said_that_torques_serve():
    with pytest.raises(InputError) as caught:
        hefting.as_recording(table_of("libfranka"))
    error = caught.value
    assert "there is no wrench, but of joints" in error.what
    assert "joint_torques from tau_J[0] to tau_J[6] (N m)" in error.what
    assert "--torques" in error.fix


def test_the_map_has_them_and_lacks_no_wrench(tmp_path):
    table_of("JointState").to_csv(tmp_path / "log.csv", index=False)
    found = guess_map(tmp_path / "log.csv")
    assert found.missing == ()
    assert 'joint_torques = { columns = ["effort_0", "effort_1"' in found.text
