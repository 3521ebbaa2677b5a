"""Text files of the programs of labs: lists in cells, LabVIEW's measurement files, times
by twelve hours, and what robots of other makes call their angles."""

from collections.abc import Callable
from datetime import datetime, timedelta
from functools import partial

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs import read_log
from hefting.logs.map_guess import guess_map
from hefting.logs.two_files import read_with_poses

ROWS = 40
RNG = np.random.default_rng(29)
TIME = 0.01 * np.arange(ROWS)
POSITION = RNG.uniform(-1.0, 1.0, (ROWS, 3))
TURNS = Rotation.random(ROWS, random_state=11)
WRENCH = RNG.normal(size=(ROWS, 6)) * (5, 5, 5, 0.5, 0.5, 0.5)
POSE = np.hstack((POSITION, TURNS.as_quat()))
POSES = ["time", "px", "py", "pz", "qx", "qy", "qz", "qw"]
FT = ["fx", "fy", "fz", "tx", "ty", "tz"]
MATRICES = np.tile(np.eye(4), (ROWS, 1, 1))
MATRICES[:, :3, :3], MATRICES[:, :3, 3] = TURNS.as_matrix(), POSITION
PLAIN = pd.DataFrame(np.column_stack((TIME, POSE, WRENCH)), columns=[*POSES, *FT])


def is_same(got: hefting.Recording, tolerance: float = 1e-12) -> bool:
    """Whether a recording holds what was written, apart from when it began."""
    apart = Rotation.from_quat(got["orientation"].values) * TURNS.inv()
    time = got["wrench"].time - got["wrench"].time[0]
    return (
        # seconds since 1970 resolve 2.4e-7 s
        np.allclose(time, TIME, atol=5e-7)
        and np.allclose(got["position"].values, POSITION, atol=tolerance)
        and np.allclose(got["wrench"].values, WRENCH, atol=tolerance)
        and bool(apart.magnitude().max() < 1e-7)
    )


LISTS: dict[str, Callable[[np.ndarray], object]] = {
    "a list": lambda values: values.tolist(),
    "a tuple": lambda values: tuple(values.tolist()),
    "a list of NumPy's numbers": lambda values: [*values.ravel()],
    "an array": lambda values: values,
    "its representation": repr,
    "blanks": lambda values: " ".join(map(repr, values.ravel().tolist())),
}


def lists(form: Callable[[np.ndarray], object], poses: np.ndarray = POSE):
    """A frame with several numbers in a cell."""
    columns = {
        "time": TIME,
        "state": ["as it is"] * ROWS,
        "seen": [[1.0] * (1 + k % 3) for k in range(ROWS)],
        "force [N]": [form(row) for row in WRENCH[:, :3]],
        "torque": [form(row) for row in WRENCH[:, 3:]],
        "pose": [form(row) for row in poses],
    }
    return pd.DataFrame(columns)


@pytest.mark.parametrize("form", LISTS)
@pytest.mark.parametrize("poses", [POSE, MATRICES], ids=["seven", "matrix"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_lists_in_cells(tmp_path, form, poses, separator):
    path = tmp_path / "log.csv"
    decimal = "," if separator == ";" else "."
    lists(LISTS[form], poses).to_csv(path, index=False, sep=separator, decimal=decimal)
    got = read_log(path)
    # NumPy writes eight digits of an array, on several lines where it is long
    assert is_same(got, 5e-8 if "its" in form or "array" in form else 1e-12)
    starts = [
        k for k, line in enumerate(path.read_text().splitlines(), 1) if "as it" in line
    ]
    assert got["wrench"].rows.tolist() == starts
    (tmp_path / "map.toml").write_text(guess_map(path).text)
    again = read_log(path, tmp_path / "map.toml")
    np.testing.assert_array_equal(again["wrench"].values, got["wrench"].values)


@pytest.mark.parametrize("block", [900, 1500])
def test_lists_on_several_lines_in_whatever_block(tmp_path, monkeypatch, block):
    """The names and the first rows, of which the last is cut, are in the first."""
    path = tmp_path / "log.csv"
    lists(LISTS["an array"], MATRICES).to_csv(path, index=False)
    monkeypatch.setattr("hefting.logs.csv_file.READ", block)
    monkeypatch.setattr("hefting.logs.csv_cells.ENOUGH", block)
    assert is_same(read_log(path), 5e-8)


def in_marks(marks: str, row: list[float]) -> str:
    return marks.format(str(row)[1:-1])


@pytest.mark.parametrize("separator", [",", ", ", ";", "\t", " "])
@pytest.mark.parametrize("form", [list, tuple, np.array, "p[{}]", "{{{}}}"])
def test_lists_without_quotes_as_python_prints_them(tmp_path, separator, form):
    """Or URScript, and others; the last row, which was cut in one, is left out."""
    made = partial(in_marks, form) if isinstance(form, str) else form
    path = tmp_path / "log.csv"
    rows = [
        f"{t}{separator}{made(p.tolist())}{separator}{made(w.tolist())}".replace(
            "\n", ""
        )
        for t, p, w in zip(
            TIME.tolist(), MATRICES.reshape(ROWS, 16), WRENCH, strict=True
        )
    ]
    names = separator.join(("time", "pose", "wrench"))
    path.write_text("\n".join((names, *rows, rows[0][:12])))
    got = read_log(path)
    assert is_same(got, 5e-8 if form is np.array else 1e-12)
    assert "end-left-out" in codes(got.warnings)


def test_a_number_of_a_column_stays_beside_lists(tmp_path):
    """Those of lists come behind all others."""
    frame = lists(LISTS["a list"]).join(PLAIN[FT])
    frame.to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "map.toml").write_text(
        'time = 1\nwrench = [7, 8, 9, 10, 11, 12]\norientation = ["pose_3", "pose_4", '
        '"pose_5", "pose_6"]\nposition = "pose_{0..2}"\n'
    )
    assert is_same(read_log(tmp_path / "log.csv", tmp_path / "map.toml"))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"[', '"[1, ', r"row 6, column force_0 \[N\]: '\[1, .* is not a number"),
        ('"[', '"[up, ', r"row 6, column force_0 \[N\]: '\[up, .* is not a number"),
        (']"', '"', r"row 6, column force_0 \[N\]: '\["),
        ('"[', "[", r"row 6: there are \d+ cells under 6 column names"),
        ('"[', '"__import__("os")[', "row 6: there are|row 6, column force_0"),
        (']"', ']"""', "row 6: there are|row 6, column force_0"),
        ("as it is", "a" * 140_000, r"row 6: is no row of cells \(field larger"),
    ],
)
def test_a_list_that_is_none_is_named(tmp_path, old, new, words):
    frame = lists(LISTS["a list"]).drop(columns="seen")
    frame.insert(2, "none", 0.0)
    frame.to_csv(tmp_path / "log.csv", index=False)
    lines = (tmp_path / "log.csv").read_text().splitlines()
    lines[5] = lines[5].replace(old, new, 1)
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=words) as caught:
        read_log(tmp_path / "log.csv")
    assert "\n" not in str(caught.value)


def test_a_blank_list_and_one_that_was_cut(tmp_path):
    frame = lists(LISTS["a list"])
    frame.loc[3, ["force [N]", "torque"]] = None
    frame.loc[4, ["force [N]", "torque"]] = "[]"
    frame.to_csv(tmp_path / "log.csv", index=False)
    text = (tmp_path / "log.csv").read_text()
    (tmp_path / "log.csv").write_text(text.rstrip()[:-20])
    got = read_log(tmp_path / "log.csv")
    kept = np.delete(np.arange(ROWS - 1), [3, 4])
    np.testing.assert_array_equal(got["wrench"].values, WRENCH[kept])
    assert len(got["position"]) == ROWS - 1
    assert "end-left-out" in codes(got.warnings)


def labview(
    columns: str = "One",
    separator: str = "\t",
    decimal: str = ".",
    unit: str = "N",
    dimension: str = "Time",
    segments: int = 1,
) -> str:
    """The wrench as LabVIEW writes it, in segments that count time anew."""
    labels = [unit] * 3 + [unit.replace("N", "N m")] * 3
    rows = [
        ["LabVIEW Measurement", ""],
        ["Separator", "Comma" if separator == "," else "Tab"],
        ["Decimal_Separator", decimal],
        ["X_Columns", columns],
        ["***End_of_Header***", ""],
    ]
    for k, wrench in enumerate(WRENCH):
        row = k % (ROWS // segments)
        if row == 0:
            began = datetime(2026, 1, 31, 23, 59, 59, 900000)
            stamp = began + timedelta(seconds=TIME[k])
            rows += [
                [""],
                ["Channels", "6"],
                ["Date", *[f"{stamp:%Y/%m/%d}"] * 6],
                ["Time", *[f"{stamp:%H:%M:%S}{decimal}{stamp:%f}0789063"] * 6],
                ["Y_Unit_Label", *labels] if unit else ["Notes", "none"],
                ["X_Dimension", *[dimension] * 6],
                ["Delta_X", *[f"0{decimal}010000"] * 6],
                ["***End_of_Header***", *[""] * 7],
                ["X_Value", *map(str.title, FT), "Comment"],
            ]
        numbers = [TIME[row], *wrench]
        cells = [repr(float(x)).replace(".", decimal) for x in numbers]
        cells[0] = "" if columns == "No" else cells[0]
        rows.append([*cells, *["moved, or so"][: k % 7 == 0]])
    return "".join(separator.join(row) + "\r\n" for row in rows)


MEASURED = {
    "as a rule": {},
    "no column of times": {"columns": "No"},
    "decimal commas": {"decimal": ","},
    "commas between": {"separator": ","},
    "no units": {"unit": ""},
    "segments": {"segments": 4},
    "segments, no times, commas": {"segments": 20, "columns": "No", "decimal": ","},
}


@pytest.mark.parametrize("case", MEASURED)
@pytest.mark.parametrize("block", [2**20, 1500])
def test_measurement_files_of_labview(tmp_path, monkeypatch, case, block):
    path, poses = tmp_path / "ft.lvm", tmp_path / "robot.csv"
    path.write_text(labview(**MEASURED[case]), newline="")
    PLAIN[POSES].to_csv(poses, index=False)
    monkeypatch.setattr("hefting.logs.csv_file.READ", block)
    got = read_with_poses(path, poses)
    assert is_same(got)
    assert codes(got.warnings) == {"columns-by-name"}
    if MEASURED[case].get("segments", 1) == 1:
        assert got["wrench"].rows.tolist() == list(range(15, 15 + ROWS))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"columns": "Multi"}, "no one time for all channels"),
        ({"dimension": "Frequency"}, "no one time for all channels"),
    ],
)
def test_measurement_files_without_one_time(tmp_path, given, words):
    (tmp_path / "ft.lvm").write_text(labview(**given), newline="")
    with pytest.raises(InputError, match=words):
        read_log(tmp_path / "ft.lvm")


def test_measured_voltages_are_a_doubt(tmp_path):
    """LabVIEW writes its channels in volts where nobody told it of forces."""
    (tmp_path / "ft.lvm").write_text(labview(unit="Volts"), newline="")
    PLAIN[POSES].to_csv(tmp_path / "robot.csv", index=False)
    got = read_with_poses(tmp_path / "ft.lvm", tmp_path / "robot.csv")
    [said] = [each for each in got.warnings if each.code == "columns-doubtful"]
    assert "its unit 'Volts' is not known" in said


def twelve(at: datetime) -> str:
    """A time of day by twelve hours, without a zero before the hour."""
    return f"{at.hour % 12 or 12}:{at:%M:%S.%f} {'AP'[at.hour >= 12]}M"


@pytest.mark.parametrize("way", ["%M:%S.%f", "%M:%S,%f", "%H:%M:%S,%f"])
def test_minutes_and_seconds_as_excel_writes_them(tmp_path, way):
    """And times of day with decimal commas, where semicolons separate cells."""
    began = datetime(2026, 3, 4, 12, 34, 59, 700000)
    times = [f"{began + timedelta(seconds=t):{way}}" for t in TIME]
    decimal = "," if "," in way else "."
    PLAIN.assign(time=times).to_csv(
        tmp_path / "log.csv", index=False, sep=";", decimal=decimal
    )
    assert is_same(read_log(tmp_path / "log.csv"))


WAYS: dict[str, Callable[[datetime], str]] = {
    "the month first": lambda at: f"{at.month}/{at.day}/{at.year} {twelve(at)}",
    "the day first": lambda at: f"{at.day}/{at.month}/{at.year} {at:%H:%M:%S.%f}",
    "hyphens": lambda at: f"{at:%d-%m-%Y %H:%M:%S.%f}",
    "no zeros": lambda at: f"{at:%Y/%m/%d} {at.hour}:{at:%M:%S.%f}",
    "a narrow blank": lambda at: f"{at.month}/{at.day}/{at.year} {twelve(at)}".replace(
        " AM", "\u202fAM"
    ),
    "MATLAB": lambda at: f"{at:%d-%b-%Y %H:%M:%S.%f}",
    "Java": lambda at: f"{at:%b} {at.day}, {at.year} {twelve(at)}",
    "no hyphens": lambda at: f"{at:%Y%m%d %H:%M:%S.%f}",
    "no date": lambda at: twelve(at).lower().replace("m", ".m."),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "began",
    [
        datetime(2026, 3, 4, 13, 31, 7),
        datetime(2026, 3, 4, 23, 59, 59, 900000),
        datetime(2026, 3, 12, 23, 59, 59, 900000),
        datetime(2026, 1, 31, 23, 59, 59, 900000),
        datetime(2026, 4, 4, 11, 59, 59, 900000),
        datetime(2026, 12, 31, 0, 59, 59, 900000),
    ],
    ids=str,
)
@pytest.mark.parametrize("separator", [",", "\t"])
def test_dates_with_the_day_or_the_month_first(tmp_path, way, began, separator):
    """Which of them it is does not matter: a day ends at midnight."""
    times = [WAYS[way](began + timedelta(seconds=t)) for t in TIME]
    frame = PLAIN.assign(time=times)
    frame.to_csv(tmp_path / "log.csv", index=False, sep=separator)
    assert is_same(read_log(tmp_path / "log.csv"))


@pytest.mark.parametrize("separator", [" ", ", "])
def test_a_date_in_a_column_of_its_own(tmp_path, separator):
    """It stays one where the times are not those of ISO 8601."""
    lines = ["Date,Time," + ",".join(PLAIN.columns[1:])]
    for t, row in zip(TIME, PLAIN.to_numpy()[:, 1:], strict=True):
        cells = map(repr, row.tolist())
        lines.append(f"1/31/2026,12:00:00:{round(1e3 * t):03},{','.join(cells)}")
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines).replace(",", separator))
    assert is_same(read_log(path))


@pytest.mark.parametrize("form", ["counts", "units", "commas"])
def test_counts_of_ati_under_what_a_unit_has_of_them(tmp_path, form):
    """Later versions of the program divide them, and write the same above."""
    above = """Start Time: 11/27/26 10:12 AM
RDT Sample Rate: 100
"PLEASE NOTE: The sample rate is read from the Net F/T, and may be incorrect."
Force Units: lbf
Counts per Unit Force: 4448221.5
Torque Units: lbf-in
Counts per Unit Torque: 1000000.0
Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time
"""
    counts = np.array([4448221.5] * 3 + [1e6] * 3)
    pounds = np.array([4.4482216152605] * 3 + [4.4482216152605 * 0.0254] * 3)
    values = WRENCH / pounds * (1.0 if form == "units" else counts)
    lines = [above.replace(": ", ":,") if form == "commas" else above]
    for t, row in zip(TIME, values, strict=True):
        cells = map(repr if form == "units" else "{:.0f}".format, row.tolist())
        time = f"10:12:3{t:.2f} AM"
        words = ["80000000", "1", "7", *cells, time]
        lines.append(",".join(f'"{word}"' for word in words) + "\n")
    path = tmp_path / "ft.csv"
    path.write_text("".join(lines))
    PLAIN[POSES].assign(time=36750.0 + TIME).to_csv(tmp_path / "arm.csv", index=False)
    got = read_with_poses(path, tmp_path / "arm.csv")
    assert is_same(got, 1e-5)


ROBOTS = {
    "KUKA's RSI": (
        "IPOC RIst_X RIst_Y RIst_Z RIst_A RIst_B RIst_C RSol_X RSol_Y RSol_Z RSol_A "
        "RSol_B RSol_C",
        (
            4e3 + 1e3 * TIME,
            1e3 * POSITION,
            TURNS.as_euler("ZYX", degrees=True),
            POSE[:, :6],
        ),
    ),
    "KUKA's trace": (
        "Zeit[s] $POS_ACT_MES.X $POS_ACT_MES.Y $POS_ACT_MES.Z $POS_ACT_MES.A "
        "$POS_ACT_MES.B $POS_ACT_MES.C",
        (TIME, 1e3 * POSITION, TURNS.as_euler("ZYX", degrees=True)),
    ),
    "Kawasaki": (
        "t X Y Z O A T",
        (TIME, 1e3 * POSITION, TURNS.as_euler("ZYZ", degrees=True)),
    ),
}


def of_robot(names: str, parts: tuple) -> pd.DataFrame:
    columns = [*names.split(), *FT]
    return pd.DataFrame(np.column_stack((*parts, WRENCH)), columns=columns)


@pytest.mark.parametrize("case", ROBOTS)
def test_robots_that_turn_about_axes_of_their_own(case):
    got = hefting.as_recording(of_robot(*ROBOTS[case]))
    assert is_same(got)
    assert codes(got.warnings) == {"columns-by-name"}


def test_of_angles_that_makes_turn_differently_it_is_said_what_to_give(tmp_path):
    parts = (TIME, 1e3 * POSITION, TURNS.as_euler("ZYX", degrees=True))
    path = tmp_path / "log.csv"
    frame = of_robot("time X Y Z U V W", parts)
    frame.rename(columns={"U": "U[deg]"}).to_csv(path, index=False)
    with pytest.raises(InputError) as caught:
        read_log(path)
    told = 'form = "euler", order = "ZYX", unit = "deg"'
    assert f"U, V, W of Epson have {told}" in caught.value.fix
    text = guess_map(path).text
    text += f'orientation = {{ columns = ["U[deg]", "V", "W"], {told} }}\n'
    (tmp_path / "map.toml").write_text(text)
    assert is_same(read_log(path, tmp_path / "map.toml"))


@pytest.mark.parametrize(
    ("begin", "step", "rows", "doubtful", "lasts"),
    [
        (0.0, 2.0, 40, True, None),
        (0.0, 30.0, 40, True, 1.17),
        (0.0, 100.0, 40, True, 3.9),
        (0.0, 4.0, 2000, False, 7.996),
        (0.0, 0.01, 40, False, 0.39),
        (1.7e12, 2.0, 40, False, 0.078),  # since 1970
        (1.7e9, 2.0, 40, False, None),
    ],
)
def test_steps_that_may_be_of_two_units_are_a_doubt(begin, step, rows, doubtful, lasts):
    """Static poses every 2 s had been a motion at 500 Hz; rows at 10 Hz that count
    milliseconds one at 10 kHz."""
    frame = pd.concat([PLAIN] * (rows // ROWS), ignore_index=True)
    frame["time"] = begin + step * np.arange(rows)
    got = hefting.as_recording(frame.rename(columns={"time": "stamp"}))
    said = [each for each in got.warnings if each.code == "columns-doubtful"]
    assert bool(said) == doubtful
    assert all("the time its unit is not known" in each for each in said)
    assert got.static == (lasts is None)
    assert got.static or got.duration == pytest.approx(lasts)


def test_numbers_of_four_columns_that_are_no_quaternion_are_no_warning():
    """Where they overflow a norm, a fuzzed file had made one of NumPy."""
    frame = PLAIN.rename(columns={f"q{c}": f"quat_{i}" for i, c in enumerate("xyzw")})
    frame["quat_0"] = 1e300
    with pytest.raises(InputError, match="no column seems to be the orientation"):
        hefting.as_recording(frame.rename(columns={"px": "x", "py": "y", "pz": "z"}))


def test_a_pose_that_is_blank_for_a_row_stays_one_by_rows():
    names = [f"pose_{i}" for i in range(16)]
    frame = PLAIN[["time", *FT]].join(
        pd.DataFrame(MATRICES.reshape(ROWS, 16), columns=names)
    )
    frame.loc[3, names] = np.nan
    assert len(hefting.as_recording(frame)["position"]) == ROWS - 1
