"""Column maps guessed from names and numbers: read back, they give the recording that
was written."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs import read_log
from hefting.logs.map_guess import guess_map

ROWS = 40
RNG = np.random.default_rng(5)
TIME = 0.01 * np.arange(ROWS)
POSITION = RNG.uniform(-1.0, 1.0, (ROWS, 3))
TURNS = Rotation.random(ROWS, random_state=3)
WRENCH = RNG.normal(size=(ROWS, 6)) * (5, 5, 5, 0.5, 0.5, 0.5)


def split(text: str) -> list[str]:
    return text.split()


CASES = {
    "plain": (
        split("time px py pz qx qy qz qw fx fy fz tx ty tz"),
        (TIME, POSITION, TURNS.as_quat(), WRENCH),
    ),
    "ros": (
        ["/ft/header/stamp"]
        + [f"/pose/position/{c}" for c in "xyz"]
        + [f"/pose/orientation/{c}" for c in "xyzw"]
        + [f"/ft/wrench/{kind}/{c}" for kind in ("force", "torque") for c in "xyz"],
        (TIME, POSITION, TURNS.as_quat(), WRENCH),
    ),
    "units in brackets": (
        split("t[ms] X[mm] Y[mm] Z[mm] rx[deg] ry[deg] rz[deg] Fx[N] Fy[N] Fz[N]")
        + split("Mx[Nmm] My[Nmm] Mz[Nmm]"),
        (
            1e3 * TIME,
            1e3 * POSITION,
            np.degrees(TURNS.as_euler("xyz")),
            WRENCH * ((1.0,) * 3 + (1e3,) * 3),
        ),
    ),
    "units by size": (
        split("time_ms pos_x pos_y pos_z roll pitch yaw forceX forceY forceZ")
        + split("torqueX torqueY torqueZ"),
        (
            1e3 * TIME,
            1e3 * POSITION,
            TURNS.as_euler("xyz", degrees=True),
            WRENCH * ((1.0,) * 3 + (1e3,) * 3),
        ),
    ),
    "numbered": (
        ["timestamp"]
        + [f"actual_TCP_pose_{k}" for k in range(6)]
        + [f"ft_{k}" for k in range(6)],
        (TIME, POSITION, TURNS.as_rotvec(), WRENCH),
    ),
    "Euler angles": (
        split("time x y z A B C F_X F_Y F_Z T_X T_Y T_Z"),
        (TIME, POSITION, TURNS.as_euler("ZYX", degrees=True), WRENCH),
    ),
}


def written(path, names, parts, separator=","):
    """The table of a case."""
    table = np.column_stack(parts)
    lines = [separator.join(names)]
    lines += [separator.join(repr(float(x)) for x in row) for row in table]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_the_map_gives_back_what_was_written(tmp_path, case, separator):
    log = written(tmp_path / "log.csv", *CASES[case], separator)
    found = guess_map(log)
    assert found.missing == ()
    (tmp_path / "map.toml").write_text(found.text)
    got = read_log(log, tmp_path / "map.toml")
    # a conversion of units there and back: rounding
    np.testing.assert_allclose(got["wrench"].time, TIME, atol=1e-12)
    np.testing.assert_allclose(got["position"].values, POSITION, rtol=1e-12)
    np.testing.assert_allclose(got["wrench"].values, WRENCH, rtol=1e-12)
    apart = Rotation.from_quat(got["orientation"].values) * TURNS.inv()
    # Euler angles near their singularity lose half of the digits
    assert apart.magnitude().max() < 1e-7


def test_units_below_the_header_and_decimal_commas(tmp_path):
    text = (
        "stamp;x;y;z;A;B;C;ft_0;ft_1;ft_2;ft_3;ft_4;ft_5;note\n"
        "ms;mm;mm;mm;deg;deg;deg;N;N;N;Nmm;Nmm;Nmm;-\n"
        "0;812,5;1,5;300;10,5;20;-170;1;2;-9,8;100;3;4;7\n"
        "10;812,6;1,5;300;10,5;20;-170;1;2;-9,8;100;3;4;7\n"
    )
    (tmp_path / "log.csv").write_text(text)
    found = guess_map(tmp_path / "log.csv")
    for line in ('"N mm"', 'unit = "mm"', 'unit = "ms"'):
        assert line in found.text
    assert "# not used: note" in found.text
    (tmp_path / "map.toml").write_text(found.text)
    got = read_log(tmp_path / "log.csv", tmp_path / "map.toml")
    assert got["position"].values[0].tolist() == [0.8125, 0.0015, 0.3]


GUESSED = {
    "rx[rad] ry[rad] rz[rad]": ("rotation-vector", 'or "rpy", or "euler"'),
    "rx[deg] ry[deg] rz[deg]": ("rpy", 'in degrees; or "euler"'),
    "rotvec_x rotvec_y rotvec_z": ("rotation-vector", ""),
    "A B C": ("euler", "as of KUKA"),
    "theta_x theta_y theta_z": ("rpy", 'or "euler"'),
    "rx[ticks] ry[ticks] rz[ticks]": ("rotation-vector", "unit 'ticks' is not known"),
}


@pytest.mark.parametrize("names", GUESSED)
def test_what_is_guessed_of_angles_is_marked(tmp_path, names):
    form, remark = GUESSED[names]
    header = f"time x y z {names} fx fy fz tx ty tz".split()
    log = written(
        tmp_path / "log.csv", header, (TIME, POSITION, TURNS.as_rotvec(), WRENCH)
    )
    [line] = [s for s in guess_map(log).text.splitlines() if s.startswith("orient")]
    before, _, after = line.partition("#")
    assert f'form = "{form}"' in before
    assert remark in after


def test_an_orientation_that_is_missing_may_be_angles(tmp_path):
    names = split("time x y z fx fy fz tx ty tz")
    found = guess_map(written(tmp_path / "log.csv", names, (TIME, POSITION, WRENCH)))
    assert 'form = "euler", order = "ZYX", unit = "deg"' in found.text


def test_joints_and_what_is_missing(tmp_path):
    names = ["time", *(f"joint_{k}" for k in range(1, 8))]
    degrees = np.degrees(RNG.uniform(-2.0, 2.0, (ROWS, 7)))
    found = guess_map(written(tmp_path / "log.csv", names, (TIME, degrees)))
    assert "joint_positions = " in found.text
    assert 'unit = "deg"' in found.text
    assert [line.split()[0] for line in found.missing] == ["wrench"]


def test_a_column_whose_name_is_not_its_own_is_given_by_number(tmp_path):
    names = ['a"b', "fx", "fx", *split("fy fz tx ty tz qx qy qz qw")]
    parts = (TIME, WRENCH[:, 0], WRENCH, TURNS.as_quat())
    log = written(tmp_path / "log.csv", names, parts)
    found = guess_map(log)
    (tmp_path / "map.toml").write_text(found.text)
    assert len(read_log(log, tmp_path / "map.toml")["wrench"]) == ROWS


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("log.csv", "a1,b2\n1,2\n", "no column has a name"),
        ("log.csv", "fx,fy\nup,down\n", "no rows of numbers"),
        ("log.csv", "", "empty"),
        ("log.bag", "", "needs no column map"),
        ("none.csv", None, "does not exist"),
    ],
)
def test_what_has_no_map(tmp_path, name, text, words):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words):
        guess_map(tmp_path / name)


ROLLS = TURNS.as_euler("xyz")


@pytest.mark.parametrize("frame", ["sensor", "wrist", "sensor_in_base", "link7"])
@pytest.mark.parametrize("turns", ["roll pitch yaw", "qx qy qz qw"])
def test_a_position_named_by_its_frame_is_read(tmp_path, frame, turns):
    values = ROLLS if turns.startswith("roll") else TURNS.as_quat()
    names = [
        "t",
        *(f"{frame}_{c}" for c in "xyz"),
        *split(f"{turns} fx fy fz tx ty tz"),
    ]
    log = written(tmp_path / "log.csv", names, (TIME, POSITION, values, WRENCH))
    got = read_log(log)
    np.testing.assert_array_equal(got["position"].values, POSITION)
    assert "columns-doubtful" not in codes(got.warnings)


@pytest.mark.parametrize(
    "names", ["ft_sensor_x ft_sensor_y ft_sensor_z", "tracker_x tracker_y tracker_z"]
)
@pytest.mark.parametrize("time", ["t", "time"])  # the second is a canonical name
def test_what_may_be_the_position_is_told_and_not_read(tmp_path, names, time):
    header = [time, *split(f"{names} qx qy qz qw fx fy fz tx ty tz")]
    parts = (TIME, POSITION, TURNS.as_quat(), WRENCH)
    got = read_log(written(tmp_path / "log.csv", header, parts))
    assert not got.has("position")
    [doubt] = [m for m in got.warnings if m.code == "columns-doubtful"]
    listed = ", ".join(f'"{name}"' for name in names.split())
    assert f"position = {{ columns = [{listed}] }}" in doubt


NO_POSITIONS = {
    "still": ("tracker_x tracker_y tracker_z", 0.0 * POSITION),
    "newtons": ("sensor_x[N] sensor_y[N] sensor_z[N]", 10.0 * WRENCH[:, :3]),
    "field": ("mag_x mag_y mag_z", POSITION),
    "speed": ("sensor_vel_x sensor_vel_y sensor_vel_z", POSITION),
    "another place": ("marker_x marker_y marker_z", POSITION),
}


@pytest.mark.parametrize("case", NO_POSITIONS)
def test_other_columns_x_y_z_are_no_position(tmp_path, case):
    names, values = NO_POSITIONS[case]
    header = split(f"t {names} roll pitch yaw fx fy fz tx ty tz")
    got = read_log(written(tmp_path / "log.csv", header, (TIME, values, ROLLS, WRENCH)))
    assert not got.has("position")
    told = "columns-doubtful" in codes(got.warnings)
    assert told == (case == "newtons")
