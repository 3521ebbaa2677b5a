"""Tables as robots, sensors and their programs write them, read by what their names and
lines say, beside columns that hold something else."""

from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs import read_log
from hefting.logs.map_guess import guess_map
from hefting.logs.units import find_unit
from known_rows import (
    CANONICAL,
    PLAIN,
    POSITION,
    QUATERNION,
    ROWS,
    TIME,
    TURNS,
    WRENCH,
    frame_of,
    same,
)
from layouts_seen import (
    BASIC,
    BESIDE,
    ELSE,
    FT,
    NAMES,
    POSE,
    RNG,
    SMALL,
    WXYZ,
    ZYX,
    each,
    numbered,
)


@pytest.mark.parametrize("case", [*BESIDE, *NAMES])
@pytest.mark.parametrize("form", ["csv", "memory"])
def test_names_are_read_beside_others(tmp_path, case, form):
    frame = frame_of(*(BESIDE | NAMES)[case])
    if form == "memory":
        got = hefting.as_recording(frame)
    else:
        frame.to_csv(tmp_path / "log.csv", index=False)
        got = read_log(tmp_path / "log.csv")
    small = Rotation.from_rotvec(SMALL)
    assert same(got, small if case in ("an inertial sensor", "Simulink") else TURNS)
    estimated = {"payload-unknown"} if case == "KUKA's DataRecorder" else set()
    assert codes(got.warnings) - {"time-shifted"} == {"columns-by-name"} | estimated


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (
            f"{BASIC} {each('ft1_*', FT)} {each('ft2_*', FT)}",
            "the wrench may begin with ft1_fx or with ft2_fx",
        ),
        (
            f"time {each('a/*', POSE)} {each('b/*', POSE)} {each('F*')} {each('M*')}",
            "the orientation may begin with a/qx or with b/qx",
        ),
        (
            f"{BASIC} {each('F*')} {each('T*')} {each('M*')} a b c",
            "the wrench may begin with Fx or with Mx",
        ),
        (f"{BASIC} {each('F*[mV]')} {each('T*[mV]')}", "its unit 'mV' is not known"),
    ],
)
def test_what_may_be_meant_as_well_is_a_doubt(names, words):
    count = len(names.split())
    frame = pd.DataFrame(RNG.normal(size=(ROWS, count)), columns=names.split())
    frame["time"] = TIME
    turning = [name for name in frame.columns if "q" in name]
    frame[turning] = np.hstack([QUATERNION] * (len(turning) // 4))
    got = hefting.as_recording(frame)
    [said] = [each for each in got.warnings if each.code == "columns-doubtful"]
    assert words in said


def test_columns_of_two_levels(tmp_path):
    """Of pandas, whose names are tuples, in memory and as Parquet has them."""
    levels = [("time", "")] + [("position", c) for c in "xyz"]
    levels += [("orientation", c) for c in "xyzw"]
    levels += [(kind, c) for kind in ("force", "torque") for c in "xyz"]
    table = np.column_stack((TIME, POSITION, QUATERNION, WRENCH))
    frame = pd.DataFrame(table, columns=pd.MultiIndex.from_tuples(levels))
    frame.to_parquet(tmp_path / "log.parquet")
    assert same(hefting.as_recording(frame))
    assert same(read_log(tmp_path / "log.parquet"))


def test_of_long_names_the_ends_are_said():
    """As of a topic, whose beginnings are one."""
    topics = [f"/the_broadcaster_of_the_state/robot_state/{k}/pose/" for k in "ab"]
    turns = [each(f"{topic}orientation/*", "x y z w") for topic in topics]
    names = f"time {' '.join(turns)} {FT}"
    got = hefting.as_recording(frame_of(names, (TIME, QUATERNION, QUATERNION, WRENCH)))
    [said] = [each for each in got.warnings if each.code == "columns-doubtful"]
    for k in "ab":
        assert f"robot_state/{k}/pose/orientation/x" in said


def test_what_stands_in_brackets_may_be_no_unit():
    names = f"{BASIC} {each('F*(tool)')} {each('T*(tool)')}"
    got = hefting.as_recording(frame_of(names, (TIME, POSITION, QUATERNION, WRENCH)))
    assert codes(got.warnings) == {"columns-by-name"}


def test_a_count_of_rows_and_a_temperature_are_no_time():
    rows = np.tile(np.column_stack((WRENCH, POSITION, QUATERNION)), (2, 1))
    warmer = np.floor(np.linspace(20.0, 22.0, 2 * ROWS))
    for name, values in (("time_step", np.arange(2 * ROWS)), ("T_motor", warmer)):
        names = f"{name} {each('F*')} {each('M*')} {POSE}"
        with pytest.raises(InputError, match="no column seems to be the time"):
            hefting.as_recording(frame_of(names, (values, rows)))


def test_canonical_names_are_taken_before_those_of_a_tool():
    names = f"{' '.join(CANONICAL)} {each('tcp_*', FT)}"
    got = hefting.as_recording(frame_of(names, (*PLAIN, ELSE[:, :6])))
    assert same(got)
    assert codes(got.warnings) == {"columns-ignored"}


def test_a_few_rows_without_a_time_are_static_poses(tmp_path):
    """As a sheet of a calibration has them, numbered or not; but not where another
    column may be a time of an unknown name."""
    names = (
        f"{each('*[mm]', 'X Y Z')} {each('*[deg]', 'A B C')} {each('F*')} {each('M*')}"
    )
    parts = 1e3 * POSITION, np.degrees(ZYX), WRENCH
    frame = frame_of(f"No {names}", (np.arange(ROWS), *parts))
    frame.to_csv(tmp_path / "log.csv", index=False)
    for got in (read_log(tmp_path / "log.csv"), hefting.as_recording(frame)):
        assert got.static
        assert codes(got.warnings) == {"columns-by-name"}
        np.testing.assert_allclose(got["position"].values, POSITION, atol=1e-12)
    frame = frame_of(f"Takt {names}", (TIME, *parts))
    with pytest.raises(InputError, match="the time: unknown are 'Takt'"):
        hefting.as_recording(frame)


def test_a_translation_of_another_frame_is_no_torque():
    """As in the logs of mc_rtc, whose torques are ``cx cy cz``."""
    base = f"{each('ff_q*', 'w x y z')} {each('ff_t*')}"
    names = f"t {base} {each('EEForceSensor_f*')} {each('EEForceSensor_c*')}"
    frame = frame_of(names, (TIME, WXYZ, POSITION, WRENCH))
    with pytest.raises(InputError, match=r"the wrench: .*'EEForceSensor_cx'"):
        hefting.as_recording(frame)
    frame.columns = [name.replace("r_c", "r_m") for name in frame.columns]
    assert same(hefting.as_recording(frame))


@pytest.mark.parametrize("unit", ["Meters", "Centimeters", "Millimeters"])
def test_motive_states_the_unit_of_lengths_above_the_names(tmp_path, unit):
    kinds = ["Rotation"] * 4 + ["Position"] * 3
    text = [f"Format Version,1.23,Length Units,{unit},Coordinate Space,Global", ""]
    text += [
        f",{one},{','.join([word] * 7)}"
        for one, word in (("Type", "Rigid Body"), ("Name", "Tool"), ("ID", "A1"))
    ]
    text += [f",,{','.join(kinds)}", "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z"]
    scale = {"Meters": 1.0, "Centimeters": 100.0, "Millimeters": 1000.0}[unit]
    table = np.column_stack((np.arange(ROWS), TIME, QUATERNION, scale * POSITION))
    text += [",".join(map(repr, row)) for row in table.tolist()]
    (tmp_path / "take.csv").write_text("\n".join(text))
    frame = frame_of(f"time {FT}", (TIME, WRENCH))
    frame.to_csv(tmp_path / "ft.csv", index=False)
    assert same(read_log(tmp_path / "ft.csv", poses=tmp_path / "take.csv"))


@pytest.mark.parametrize(
    "name", ["tool_external_wrench_*", "ft_ext_*", "toolExternal_*"]
)
def test_an_external_wrench_is_less_the_load(name):
    names = f"{BASIC} {each(name, FT)}"
    got = hefting.as_recording(frame_of(names, (TIME, POSITION, QUATERNION, WRENCH)))
    assert codes(got.warnings) == {"columns-by-name", "payload-unknown"}


@pytest.mark.parametrize(
    "names",
    [
        each("compensated_*", FT),
        numbered("force_", 4) + " " + each("T*"),
        numbered("wrench_", 12),
    ],
)
def test_what_is_no_wrench_is_not_taken_for_one(names):
    count = len(names.split())
    parts = (TIME, POSITION, QUATERNION, RNG.normal(size=(ROWS, count)))
    with pytest.raises(InputError, match="no column seems to be the wrench"):
        hefting.as_recording(frame_of(f"{BASIC} {names}", parts))


HEAD, *LINES = frame_of(CANONICAL, PLAIN).to_csv(index=False).splitlines()
SPACED = [line.replace(",", " ") for line in LINES]
QUOTED = [
    ",".join(f'"{cell}"' for cell in line.replace(".", "#").split(",")).replace(
        "#", ","
    )
    for line in LINES
]
TEXTS = {
    "a comma more in the rows": [HEAD, *(line + "," for line in LINES)],
    "a comma more in the names": [HEAD + ",", *LINES],
    "spaces under commas": [HEAD, *SPACED],
    "commas under tabs": [HEAD.replace(",", "\t"), *LINES],
    "bars": [HEAD.replace(",", "|"), *(line.replace(",", "|") for line in LINES)],
    "decimal commas in quotes": [HEAD, *QUOTED],
    "groups over components": [
        "Time,Position,,,Orientation,,,,Force,,,Torque,,",
        "s,X,Y,Z,X,Y,Z,W,X,Y,Z,X,Y,Z",
        *LINES,
    ],
    "groups that repeat": [
        ",pose,pose,pose,quat,quat,quat,quat,force,force,force,torque,torque,torque",
        "time,x,y,z,x,y,z,w,x,y,z,x,y,z",
        *LINES,
    ],
    "two levels and an index, each with a name": [
        "device,tcp,tcp,tcp,tcp,tcp,tcp,tcp,ft,ft,ft,ft,ft,ft",
        "axis,px,py,pz,qx,qy,qz,qw,fx,fy,fz,tx,ty,tz",
        "time,,,,,,,,,,,,,",
        *LINES,
    ],
    "units after spaces": [
        "t [s] X [m] Y [m] Z [m] qx qy qz qw "
        "Fx (N) Fy (N) Fz (N) Tx (Nm) Ty (Nm) Tz (Nm)",
        *SPACED,
    ],
}


@pytest.mark.parametrize("case", TEXTS)
def test_lines_that_are_written_in_other_ways(tmp_path, case):
    path = tmp_path / "log.dat"
    path.write_text("\n".join(TEXTS[case]) + "\n")
    got = read_log(path)
    assert same(got)
    assert codes(got.warnings) <= {"columns-by-name", "columns-ignored"}
    if codes(got.warnings) & {"columns-by-name"}:  # as a map of it reads it
        (tmp_path / "map.toml").write_text(guess_map(path).text)
        assert same(read_log(path, tmp_path / "map.toml"))


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_a_degree_sign_of_any_encoding(tmp_path, encoding):
    names = ["Zeit in s", *(f"{c} in mm" for c in "xyz"), *(f"{c} [°]" for c in "ABC")]
    names += [f"Kraft {c} [N]" for c in "XYZ"] + [f"Drehmoment {c} [Nm]" for c in "XYZ"]
    frame = frame_of(names, (TIME, 1e3 * POSITION, np.degrees(ZYX), WRENCH))
    text = frame.to_csv(index=False, sep=";", decimal=",")
    (tmp_path / "log.csv").write_bytes(text.encode(encoding))
    assert same(read_log(tmp_path / "log.csv"))


WAYS = {
    "slashes": "%Y/%m/%d %H:%M:%S.%f",
    "a comma": "%Y-%m-%d %H:%M:%S,%f",
    "colons only": "%H:%M:%S:%f",
    "no zero": "9:%M:%S.%f",
    "a duration": "0 days 00:%M:%S.%f",
}


@pytest.mark.parametrize("way", WAYS)
def test_times_that_are_written_in_other_ways(tmp_path, way):
    began = datetime(2026, 1, 31, 9, 5, 59, 900000)
    times = [(began + timedelta(seconds=t)).strftime(WAYS[way]) for t in TIME]
    lines = [
        HEAD,
        *(f"{t},{x.partition(',')[2]}" for t, x in zip(times, LINES, strict=True)),
    ]
    if way == "a comma":
        lines[1:] = [
            ";".join((t, *x.split(",")[1:])) for t, x in zip(times, LINES, strict=True)
        ]
        lines[0] = HEAD.replace(",", ";")
    (tmp_path / "log.csv").write_text("\n".join(lines))
    assert same(read_log(tmp_path / "log.csv"))


def test_durations_of_matlab(tmp_path):
    rows = [
        f"{t:.5g} sec,{x.partition(',')[2]}" for t, x in zip(TIME, LINES, strict=True)
    ]
    (tmp_path / "log.csv").write_text("\n".join((HEAD, *rows)))
    assert same(read_log(tmp_path / "log.csv"))


def test_a_table_of_poses_alone_is_said_to_be_the_second():
    frame = frame_of("Time X Y Z A B C", (TIME, POSITION, ZYX))
    with pytest.raises(InputError, match="a table with it, and this one as `poses`"):
        hefting.as_recording(frame)


def test_names_without_rows_are_said_to_be_so(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Time,X,Y,Z,A,B,C,Fx,Fy,Fz,Mx,My,Mz\n")
    with pytest.raises(InputError, match="no rows of numbers below the header"):
        read_log(path)


def test_of_a_time_by_another_name_it_is_said_what_is_read(tmp_path):
    lines = [HEAD.replace("time", "Stamp"), "3-Apr-2026 13:31:07" + LINES[0][3:]]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=r"column Stamp: '3-Apr.*or as 2026-01-31T12"):
        read_log(tmp_path / "log.csv")


def test_the_first_cell_that_is_no_number_is_said(tmp_path):
    lines = ["t,position,force,torque", "0,'{'x': 1}','{'x': 2}',up"] * 3
    (tmp_path / "log.csv").write_text("\n".join(lines[:1] + lines[1::2]))
    said = r"no rows of numbers below the header: .*'x': 1.* is not a number; write"
    with pytest.raises(InputError, match=said):
        read_log(tmp_path / "log.csv")


def test_lists_without_names_are_numbers(tmp_path):
    """As the stream of a Robotiq sensor, which a map reads by its numbers."""
    rows = (f"( {' , '.join(map(str, row))} )" for row in WRENCH.tolist())
    (tmp_path / "ft.txt").write_text("\n".join(rows) + "\n")
    with pytest.raises(InputError, match=r"is numbers, not column names"):
        read_log(tmp_path / "ft.txt")
    frame_of(CANONICAL[:8], PLAIN[:3]).to_csv(tmp_path / "robot.csv", index=False)
    text = "header = false\ntime = { rate = 100 }\nwrench = [2, 3, 4, 5, 6, 7]\n"
    (tmp_path / "map.toml").write_text(text)
    found = read_log(
        tmp_path / "ft.txt", tmp_path / "map.toml", poses=tmp_path / "robot.csv"
    )
    assert same(found)


@pytest.mark.parametrize("begin", ["", "1700000000,5,ft,"])
def test_numbers_without_names_are_told_so(tmp_path, begin):
    (tmp_path / "log.csv").write_text("\n".join(begin + line for line in LINES))
    with pytest.raises(InputError, match=r"is numbers.*header = false"):
        read_log(tmp_path / "log.csv")


@pytest.mark.parametrize(
    ("kind", "unit", "factor"),
    [
        ("time", "msec", 1e-3),
        ("length", "millimeters", 1e-3),
        ("angle", "Degrees", np.pi / 180.0),
        ("force", "Newtons", 1.0),
        ("force", "lb", 4.4482216152605),
        ("torque", "N-mm", 1e-3),
        ("torque", "Newton-meters", 1.0),
        ("torque", "in-lb", 4.4482216152605 * 0.0254),
        ("torque", "kgf cm", 0.0980665),
    ],
)
def test_units_by_other_words(kind, unit, factor):
    assert find_unit(unit, kind, "test").to_si(np.ones(1)) == pytest.approx(
        factor, rel=1e-15
    )
