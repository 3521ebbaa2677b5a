"""hefting predict: what it prints, writes and draws, which motions it takes, and what
it refuses."""

import csv
import json
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from commands import refused
from hasty_pictures import draw_hastily
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import WRENCH
from hefting.logs import write_log
from hefting.prediction import predict
from hefting.robots import Robot
from hefting.simulation import UR5, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_commands")

BODY = InertialParameters.from_com(
    1.7, (0.05, -0.11, 0.08), np.diag((0.020, 0.030, 0.015))
)
ENDS = tuple(f"{name}_{end}" for name in WRENCH for end in ("low", "high"))
MOTION = UR5.motion(random_smooth(3.0, 100.0, 1.0, seed=3))


def streams(**values) -> dict[str, Stream]:
    return {name: Stream(MOTION.time, value) for name, value in values.items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An estimate with a covariance and one without, and a planned motion: poses
    alone."""
    folder = tmp_path_factory.mktemp("predict")
    spread = np.diag(np.repeat((1e-2, 1e-3, 1e-4), (1, 3, 6)) ** 2)
    Estimate("OLS", BODY, 100, covariance=spread).save(folder / "estimate.json")
    Estimate("PMD", BODY, 100).save(folder / "bare.json")
    write_log(
        Recording(streams(position=MOTION.position, orientation=MOTION.orientation)),
        folder / "plan.csv",
    )
    return folder


def peak_of(run, *words) -> float:
    status, out, err = run("predict", *words, "--json")
    assert (status, err) == (0, "")
    return json.loads(out)["peaks"]["force"]["value"]


def test_the_table_says_what_was_predicted_and_assumed(run, folder):
    status, out, err = run("predict", folder / "estimate.json", folder / "plan.csv")
    assert (status, err) == (0, "")
    found = predict(folder / "estimate.json", folder / "plan.csv")
    force = found.peaks["force"]
    for text in (
        f"{force.value:.2f}",
        f"{force.reach:.2g}",
        f"{force.time:.3f}",
        "± 95 %",
        "300 instants",
    ):
        assert text in out
    _, told, _ = run(
        "predict", folder / "estimate.json", folder / "plan.csv", "--verbose"
    )
    for text in (
        "gravity (0, 0, -9.80665) m/s²",
        "poses, smoothed",
        "in sensor axes",
        "not a sensor's noise and bias",
    ):
        assert text in " ".join(told.split())
    lowest = found.extremes["tz"][0]
    row = next(
        line.split() for line in out.splitlines() if line.strip().startswith("tz")
    )
    assert row[1:4] == [
        f"{lowest.value:.4f}",
        f"{lowest.reach:.2g}",
        f"{lowest.time:.3f}",
    ]
    assert "measured" not in out


def test_a_tool_is_borne_as_well(run, folder):
    estimate, plan = folder / "estimate.json", folder / "plan.csv"
    alone = peak_of(run, estimate, plan)
    twice = peak_of(run, estimate, plan, "--tool", estimate)
    assert twice == pytest.approx(2.0 * alone)


def test_json_table_and_library_agree(run, folder, tmp_path):
    words = (
        "predict",
        folder / "estimate.json",
        folder / "plan.csv",
        "--start",
        "0.5",
        "--duration",
        "1",
    )
    status, out, _ = run(*words, "--json", "--output", tmp_path / "loads.csv")
    assert status == 0
    said = json.loads(out)
    found = predict(
        folder / "estimate.json", folder / "plan.csv", start=0.5, duration=1.0
    )
    assert (said["schema"], said["samples"], said["frame"]) == (
        "hefting.prediction/1",
        100,
        "sensor",
    )
    with open(tmp_path / "loads.csv", newline="") as stream:
        header, *rows = csv.reader(stream)
    assert header == ["time", *WRENCH, *ENDS]
    table = np.array(rows, dtype=float)
    # text keeps every digit in both
    np.testing.assert_array_equal(table[:, 0], said["time"])
    np.testing.assert_array_equal(table[:, 1:7], said["wrench"])
    np.testing.assert_array_equal(table[:, 7::2], said["low"])
    np.testing.assert_array_equal(table[:, 8::2], said["high"])
    np.testing.assert_array_equal(said["wrench"], found.wrench)
    np.testing.assert_array_equal(said["high"], found.high)
    for name, part in (("force", slice(0, 3)), ("torque", slice(3, 6))):
        size = np.linalg.norm(found.wrench[:, part], axis=1)
        peak = said["peaks"][name]
        assert (peak["value"], peak["time"]) == (size.max(), found.time[size.argmax()])
        assert peak["low"] < peak["value"] < peak["high"]
    assert said["extremes"]["fy"]["highest"]["value"] == found.wrench[:, 1].max()
    assert said["agreement"] is None


def test_without_a_covariance(run, folder, tmp_path):
    status, out, _ = run(
        "predict",
        folder / "bare.json",
        folder / "plan.csv",
        "--output",
        tmp_path / "loads.csv",
    )
    assert status == 0
    assert "warning: the estimate (PMD) has no covariance" in out
    assert "95 %" not in out
    assert (tmp_path / "loads.csv").read_text().startswith("time,fx,fy,fz,tx,ty,tz\n")
    _, out, _ = run("predict", folder / "bare.json", folder / "plan.csv", "--json")
    said = json.loads(out)
    assert (said["low"], said["high"], said["peaks"]["force"]["high"]) == (
        None,
        None,
        None,
    )


def test_a_measured_wrench_is_compared(run, folder, tmp_path):
    log = simulate(MOTION, BODY, noise=Noise(0.1, 0.005), on_sensor=True, seed=1)
    write_log(log, tmp_path / "log.csv")
    words = ("predict", folder / "estimate.json", tmp_path / "log.csv", "--verbose")
    _, out, _ = run(*words)
    for text in (
        "measured (on-sensor) minus predicted: 0.",
        "less its mean",
        "itself leaves",
        "95 % are expected",
    ):
        assert text in " ".join(out.split())
    _, out, _ = run("predict", folder / "estimate.json", tmp_path / "log.csv", "--json")
    said = json.loads(out)["agreement"]
    assert said["wrench"] == "on-sensor"
    # 900 numbers, and the poses' noise
    np.testing.assert_allclose(said["rms"], (0.1, 0.005), rtol=0.15)


def test_gravity_and_static_poses(run, folder, tmp_path):
    still = streams(orientation=MOTION.orientation)
    write_log(
        Recording({name: stream[:4] for name, stream in still.items()}, static=True),
        tmp_path / "still.csv",
    )
    assert peak_of(
        run, folder / "bare.json", tmp_path / "still.csv", "--gravity", "0,0,-2"
    ) == pytest.approx(3.4)
    _, out, _ = run(
        "predict",
        folder / "estimate.json",
        tmp_path / "still.csv",
        "--output",
        tmp_path / "out.csv",
    )
    assert "4 static poses" in out
    assert "in row" in out
    first = (
        predict(folder / "estimate.json", tmp_path / "still.csv").extremes["fx"][0].time
    )
    assert (
        next(line.split()[3] for line in out.splitlines() if line.startswith(" fx"))
        == f"{first + 1:.0f}"
    )
    header, *rows = (tmp_path / "out.csv").read_text().splitlines()
    assert header.startswith("fx,fy")
    assert len(rows) == 4


# motions without a wrench, in every format


@pytest.fixture(scope="module")
def planned(folder):
    return predict(folder / "estimate.json", folder / "plan.csv").peaks["force"].value


@pytest.mark.parametrize("name", ["plan.parquet", "plan.bag", "plan.mcap", "plan"])
def test_formats(run, folder, tmp_path, planned, name):
    if name != "plan.parquet":
        pytest.importorskip(
            "rosbags", reason="rosbags is not installed (pip install 'hefting[ros]')"
        )
    write_log(
        Recording(streams(position=MOTION.position, orientation=MOTION.orientation)),
        tmp_path / name,
    )
    # a bag's nanoseconds differ from the CSV's time by rounding
    assert peak_of(run, folder / "estimate.json", tmp_path / name) == pytest.approx(
        planned, rel=1e-6
    )


ARM = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/><link name="sensor"/>
  <joint name="swing" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.1 0 0.3" rpy="0.5 0 1"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="lower"/><child link="sensor"/>
    <origin xyz="0.4 0 0" rpy="0.1 0.2 0.3"/></joint></robot>"""


@pytest.mark.parametrize("name", ["joints.csv", "joints.mcap"])
def test_joint_angles_and_a_urdf(run, folder, tmp_path, name):
    """The same as from the poses that the joints make."""
    if name.endswith("mcap"):
        pytest.importorskip(
            "rosbags", reason="rosbags is not installed (pip install 'hefting[ros]')"
        )
    (tmp_path / "arm.urdf").write_text(ARM)
    robot = Robot.from_urdf(tmp_path / "arm.urdf", "sensor")
    joints = np.column_stack((np.sin(MOTION.time), np.cos(2.0 * MOTION.time)))
    position, orientation = robot.poses(joints)
    write_log(
        Recording(streams(position=position, orientation=orientation)),
        tmp_path / "poses.csv",
    )
    write_log(
        Recording(streams(joint_positions=joints), joint_names=robot.joints),
        tmp_path / name,
    )
    words = (folder / "estimate.json", tmp_path / name)
    found = peak_of(
        run, *words, "--urdf", tmp_path / "arm.urdf", "--sensor-frame", "sensor"
    )
    # the same poses; a bag's times are in whole nanoseconds
    assert found == pytest.approx(
        peak_of(run, folder / "estimate.json", tmp_path / "poses.csv"), rel=1e-7
    )
    assert refused(run("predict", *words), "orientation")


def test_column_map_and_ur_record_without_a_wrench(run, folder, tmp_path, planned):
    lines = (folder / "plan.csv").read_text().splitlines()
    (tmp_path / "other.csv").write_text(
        "\n".join(["t,x,y,z,a,b,c,d", *lines[1:]]) + "\n"
    )
    (tmp_path / "map.toml").write_text(
        'time = "t"\nposition = ["x", "y", "z"]\norientation = { columns = ["a", "b", "c", "d"], form = "xyzw" }\n'
    )
    words = (
        folder / "estimate.json",
        tmp_path / "other.csv",
        "--map",
        tmp_path / "map.toml",
    )
    assert peak_of(run, *words) == planned
    assert refused(run("identify", *words[1:]), "map.toml", "gives no wrench")
    names = ["timestamp", *(f"actual_TCP_pose_{i}" for i in range(6))]
    turns = Rotation.from_quat(MOTION.orientation).as_rotvec()
    table = np.column_stack((MOTION.time, MOTION.position, turns)).tolist()
    record = tmp_path / "record.csv"
    record.write_text(
        "\n".join([" ".join(names), *(" ".join(map(repr, row)) for row in table)])
        + "\n"
    )
    # rotation vectors of the same turns, by rounding
    assert peak_of(run, folder / "estimate.json", record) == pytest.approx(
        planned, rel=1e-6
    )
    _, out, _ = run("predict", folder / "estimate.json", record)
    assert "payload" not in out, "that would be about the wrench"
    assert refused(run("identify", record), "there is no wrench")


def test_identify_still_needs_a_wrench(run, folder, tmp_path):
    assert refused(
        run("identify", folder / "plan.csv"), "plan.csv", "there is no wrench"
    )
    blank = [
        line + ",,,,,," for line in (folder / "plan.csv").read_text().splitlines()[1:]
    ]
    header = "time,px,py,pz,qx,qy,qz,qw,fx,fy,fz,tx,ty,tz"
    (tmp_path / "blank.csv").write_text("\n".join([header, *blank]) + "\n")
    assert refused(
        run("identify", tmp_path / "blank.csv"),
        "there is no wrench: all its cells are blank",
    )
    status, out, _ = run("predict", folder / "estimate.json", tmp_path / "blank.csv")
    assert status == 0
    assert "columns fx..tz are all blank" in out


# pictures


def test_pictures_of_every_format(run, folder, tmp_path, monkeypatch):
    pytest.importorskip(
        "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
    )
    draw_hastily(monkeypatch)
    paths = [tmp_path / f"loads.{suffix}" for suffix in ("png", "svg", "pdf")]
    outputs = [word for path in paths for word in ("--output", path)]
    first = run("predict", folder / "estimate.json", folder / "plan.csv", *outputs)
    assert first[0] == 0
    assert all(str(path) in first[1].replace("\n", "") for path in paths)
    before = [path.read_bytes() for path in paths]
    run("predict", folder / "estimate.json", folder / "plan.csv", *outputs)
    assert [path.read_bytes() for path in paths] == before, "the same every time"
    assert before[0].startswith(b"\x89PNG")
    assert ElementTree.fromstring(before[1]).tag.endswith("svg")
    assert before[2].startswith(b"%PDF")


@pytest.mark.parametrize("kind", ["band", "measured", "bare", "static", "open"])
def test_what_is_drawn(folder, kind):
    pytest.importorskip(
        "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
    )
    from hefting.plots.prediction import plot_prediction

    estimate = Estimate.load(
        folder / ("bare.json" if kind in ("bare", "measured") else "estimate.json")
    )
    plan = Recording(streams(position=MOTION.position, orientation=MOTION.orientation))
    if kind == "measured":
        plan = simulate(MOTION, BODY, noise=Noise(0.1, 0.005), seed=1)
    elif kind == "static":
        plan = Recording({"orientation": plan["orientation"][:1]}, static=True)
    elif kind == "open":
        covariance = np.array(estimate.covariance)
        covariance[4, 4] = np.inf
        estimate = replace(estimate, covariance=covariance)
    found = predict(estimate, plan)
    rows = plot_prediction(found).axes
    names = {
        "bare": ["Force [N]", "Torque [N m]"],
        "measured": ["Force [N]", "[N]", "Torque [N m]", "[N m]"],
    }
    assert [axes.get_ylabel() for axes in rows] == names.get(
        kind, ["Force [N]", "± [N]", "Torque [N m]", "± [N m]"]
    )
    assert rows[-1].get_xlabel() == ("Pose" if kind == "static" else "Time [s]")
    for first, whole in ((0, rows[0]), (3, rows[len(rows) // 2])):
        lines = whole.lines[1::2] if kind == "measured" else whole.lines
        for i in range(3):
            np.testing.assert_array_equal(
                lines[i].get_ydata(), found.wrench[:, first + i]
            )
    if kind == "measured":
        np.testing.assert_array_equal(
            rows[3].lines[2].get_ydata(), found.agreement.difference[:, 5]
        )
    if kind == "band":
        half = [line.get_ydata() for line in rows[3].lines]
        np.testing.assert_allclose(
            np.array(half).T, (found.high - found.low)[:, 3:] / 2.0, rtol=1e-12
        )
        edges = rows[2].collections[1].get_paths()[0].vertices
        assert edges[:, 1].max() == pytest.approx(found.high[:, 4].max())
    if kind == "open":
        assert np.isnan(rows[3].lines[0].get_ydata()).all()
        assert "open in part" in rows[3].get_title(loc="right")
        assert "open in part" not in rows[1].get_title(loc="right")


# what is refused: one line, exit status 2, no file left behind


def test_bad_input_is_one_line(run, folder, tmp_path):
    estimate, plan = folder / "estimate.json", folder / "plan.csv"
    for words, said in (
        ((), "ESTIMATE.json"),
        ((estimate,), "TRAJECTORY"),
        ((tmp_path / "none.json", plan), "none.json"),
        ((plan, plan), "not JSON"),
        ((estimate, tmp_path / "none.csv"), "does not exist"),
        ((estimate, estimate), "not a log format"),
        ((estimate, plan, "--gravity", "estimate"), "--gravity"),
        ((estimate, plan, "--gravity", "0,0,0"), "not all zero"),
        ((estimate, plan, "--motion", "up"), "smooth"),
        ((estimate, plan, "--motion", "columns"), "linear_acceleration"),
        ((estimate, plan, "--start", "99"), "it lasts"),
        ((estimate, plan, "--duration", "nan"), "duration"),
        ((estimate, plan, "--duration", "0.05"), "too few"),
        ((estimate, plan, "--sensor-frame", "tool"), "--urdf"),
        ((estimate, plan, "--output", tmp_path / "loads.xyz"), ".xyz"),
        ((estimate, plan, "--output", tmp_path / "no" / "loads.csv"), "folder"),
        ((estimate, plan, "--output", plan), "input"),
    ):
        assert refused(run("predict", *words), said), words


def test_hostile_estimates(run, folder, tmp_path):
    whole = json.loads((folder / "estimate.json").read_text())
    tilted = np.array(whole["covariance"])
    tilted[0, 1] = 1.0
    for number, (change, word) in enumerate((
        ({"covariance": tilted.tolist()}, "covariance"),
        ({"covariance": (-np.eye(10)).tolist()}, "covariance"),
        ({"covariance": [[1.0]]}, "covariance"),
        ({"vector": [1e308] * 10}, "vector holds a number beyond"),
        ({"vector": [None] * 10}, "vector"),
        ({"schema": "other"}, "schema"),
    )):  # fmt: skip
        path = tmp_path / f"{number}.json"
        path.write_text(json.dumps(whole | change))
        assert refused(run("predict", path, folder / "plan.csv"), word)
    (tmp_path / "huge.json").write_text(
        json.dumps(whole | {"covariance": (1e30 * np.eye(10)).tolist()})
    )
    status, out, _ = run("predict", tmp_path / "huge.json", folder / "plan.csv")
    assert status == 0
    assert "e+15" in out


def test_nothing_is_left_half_written(run, folder, tmp_path):
    out = tmp_path / "loads.csv"
    out.write_text("old")
    words = ("predict", folder / "estimate.json", folder / "plan.csv", "--output", out)
    assert refused(run(*words, "--output", tmp_path / "loads.doc"), ".doc")
    assert refused(run(*words, "--gravity", "0,0,0"), "gravity")
    assert out.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["loads.csv"]
    assert run(*words)[0] == 0
    assert out.read_text() != "old"


def test_titles_of_a_picture_are_no_wider_than_its_rows(folder):
    """One had begun left of its axes, beside a number of them."""
    pytest.importorskip(
        "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
    )
    from matplotlib.text import Text

    from hefting.plots.prediction import plot_prediction

    log = simulate(MOTION, BODY, noise=Noise(0.11, 0.0048), seed=1)
    figure = plot_prediction(predict(Estimate.load(folder / "estimate.json"), log))
    for axes in figure.axes:
        said = axes.get_title(loc="right")
        for text in axes.findobj(Text):
            if said and text.get_text() == said:
                assert text.get_window_extent().x0 > axes.get_window_extent().x0


def test_the_bias_that_the_text_speaks_of_is_drawn(folder):
    """A sensor zeroed elsewhere: its mean difference is a dashed line, and the
    prediction with it lies on what was measured."""
    pytest.importorskip(
        "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
    )
    from hefting.plots.prediction import plot_prediction

    bias = np.array((5.0, -3.0, 8.0, 0.4, 0.2, -0.3))
    noise = Noise(0.1, 0.005)
    log = simulate(MOTION, BODY, noise=noise, bias=bias, seed=1)
    found = predict(Estimate.load(folder / "estimate.json"), log)
    assert "constant-difference" in codes(found.warnings)
    figure = plot_prediction(found)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["Force [N]", "[N]", "± [N]", "Torque [N m]", "[N m]", "± [N m]"]
    # the mean of 300 samples of noise is within a fifth of its deviation
    for rows, part, level in ((figure.axes[:3], 0, 0.1), (figure.axes[3:], 3, 0.005)):
        means = [line.get_ydata()[0] for line in rows[1].lines[3:6]]
        np.testing.assert_allclose(means, bias[part : part + 3], atol=0.5 * level)
        shifted = np.array([line.get_ydata() for line in rows[0].lines[-3:]]).T
        mean = found.agreement.difference.mean(axis=0)
        np.testing.assert_allclose(shifted, (found.wrench + mean)[:, part : part + 3])
    title = figure.get_suptitle()
    assert "most of the difference is constant" in " ".join(title.split())
    assert "usable with care" in title
    peak = found.peaks["force"]
    assert f"{peak.value:.1f}" in title
