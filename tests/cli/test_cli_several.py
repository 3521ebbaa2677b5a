"""Several logs and several estimates on the command line."""

import json
from dataclasses import replace

import numpy as np
import pytest

import hefting
from commands import refused
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Noise
from hefting.core.messages import error
from hefting.core.spatial import inverse_pose, pose_matrix
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate, truth

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two logs of a hammer, one of another body; each with a bias of its own."""
    folder = tmp_path_factory.mktemp("several")
    held = hammer().parameters
    other = type(held)(1.3 * held.vector)
    for seed, (name, body) in enumerate(dict(a=held, b=held, other=other).items()):  # noqa: C408
        motion = UR5.motion(random_smooth(5.0, 100.0, 1.2, seed=seed))
        bias = np.random.default_rng(seed).uniform(-1.0, 1.0, 6) * np.repeat((20, 1), 3)
        log = simulate(
            motion,
            body,
            noise=Noise(0.1, 0.005),
            pose_noise=(1e-4, 3.5e-4),
            bias=bias,
            seed=seed,
        )
        write_log(log, folder / f"{name}.csv")
    facts = truth(held, hammer().mesh().extents, np.eye(4), name="hammer")
    (folder / "truth.json").write_text(json.dumps(facts))
    return folder


def identified(run, folder, *names):
    """Path of the estimate of these logs."""
    path = folder / f"{'-'.join(names)}.json"
    run("identify", *(folder / f"{name}.csv" for name in names), "--output", path)
    return path


def test_several_logs_are_one_object(run, folder):
    logs = folder / "a.csv", folder / "b.csv"
    status, out, err = run("identify", *logs, "--truth", folder / "truth.json")
    assert (status, err) == (0, "")
    said = " ".join(out.split())
    assert "in 2 recordings, taken to be of one object, grasp and sensor frame" in said
    _, out, _ = run("identify", *logs, "--verbose")
    said = " ".join(out.split())
    assert (
        "assumed: 2 recordings of one object in one grasp, in the same sensor" in said
    )
    assert "- a.csv: " in out
    assert "- b.csv: " in out
    assert "verdict: good" in out


def test_json_tells_each_recording_and_its_bias(run, folder):
    status, out, _ = run("identify", folder / "a.csv", folder / "b.csv", "--json")
    found = json.loads(out)
    assert status == 0
    assert np.shape(found["bias"]) == (2, 6)
    assert [one["name"] for one in found["provenance"]["recordings"]] == [
        "a.csv",
        "b.csv",
    ]
    path = identified(run, folder, "a", "b")
    np.testing.assert_allclose(Estimate.load(path).bias, found["bias"])
    status, out, _ = run("export", path, "--to", "urdf")
    assert status == 0


def test_methods_are_compared_on_several_logs(run, folder):
    logs = folder / "a.csv", folder / "b.csv"
    status, out, _ = run("identify", *logs, "--method", "OLS,LMI", "--json")
    assert status == 0
    for found in json.loads(out)["results"]:
        assert np.shape(found["bias"]) == (2, 6)


def test_logs_that_contradict_are_not_to_be_used(run, folder):
    logs = (folder / f"{name}.csv" for name in ("a", "b", "other"))
    urdf = folder / "wrong.urdf"
    status, out, _ = run("identify", *logs, "--output", urdf, "--json")
    found = json.loads(out)
    assert status == 3
    (said,) = (m for m in found["messages"] if m["code"] == "recordings-contradict")
    assert said["recordings"] == ["other.csv"]
    assert said["severity"] == "error"
    assert not urdf.exists()


def test_options_apply_to_each_log(run, folder):
    logs = folder / "a.csv", folder / "b.csv"
    status, out, _ = run("identify", *logs, "--start", "1", "--duration", "3", "--json")
    each = json.loads(out)["provenance"]["recordings"]
    assert status == 0
    assert [one["duration"] for one in each] == pytest.approx([3.0, 3.0], abs=0.05)


def test_an_output_does_not_overwrite_any_log(run, folder):
    log = folder / "b.json"
    log.write_bytes((folder / "b.csv").read_bytes())
    result = run("identify", folder / "a.csv", log, "--output", log)
    assert refused(result, "b.json", "is an input and would be overwritten")
    assert refused(run("identify", log, log), "b.json", "given twice")
    options = "--poses", "--sensor-pose-in-log", "--sensor-pose-in-flange", "--empty"
    for option in (*options, "--arm", "--truth", "--bias"):
        result = run("identify", folder / "a.csv", option, log, "--output", log)
        assert refused(result, "b.json", "is an input and would be overwritten")


def test_a_loop_of_links_and_an_empty_name_are_refused_in_one_line(run, tmp_path):
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    log = str(tmp_path / "loop.csv")
    assert refused(run("identify", log), "loop.csv", "is a link to no file")
    assert refused(run("identify", log, "x.csv"), "loop.csv", "is a link to no file")
    assert refused(run("identify", ""), "an argument is empty")
    assert refused(run("identify", log, ""), "an argument is empty")
    with pytest.raises(InputError, match="is given twice"):
        hefting.identify([log, log])


# compare


def test_estimates_of_one_object_agree(run, folder):
    paths = [identified(run, folder, name) for name in "ab"]
    status, out, err = run("compare", *paths)
    assert (status, err) == (0, "")
    assert out.startswith("they agree: ")
    assert "the same object in the same grasp, and the same sensor frame" in out
    assert max(map(len, out.splitlines()[1:-3])) <= 80
    status, out, _ = run("compare", *paths, "--json")
    found = json.loads(out)
    assert found["agree"]
    values = [one["values"] for one in found["estimates"]]
    body = Estimate.load(paths[0]).parameters
    moments = np.linalg.eigvalsh(body.inertia_at_com)
    np.testing.assert_allclose(values[0], (body.mass, *body.center_of_mass, *moments))


def test_estimates_of_two_objects_contradict(run, folder):
    paths = [identified(run, folder, name) for name in ("a", "b", "other")]
    status, out, err = run("compare", *paths)
    assert (status, err) == (3, "")
    assert out.startswith("they contradict one another: ")
    assert "other, mass " in out.splitlines()[0]
    status, out, _ = run("compare", *paths, "--json")
    assert status == 3
    assert not json.loads(out)["agree"]


def in_grasps(run, folder):
    """Paths of estimates of the hammer in two grasps, with its pose."""
    held = Estimate.load(identified(run, folder, "a"))
    turned = (0.02, -0.01, 0.03, 0.0, 0.0, 0.6, 0.8)
    poses = {"one": (0, 0, 0, 0, 0, 0, 1), "two": turned}
    for name, pose in poses.items():
        grasped = hefting.in_frame(
            held, inverse_pose(pose_matrix(pose)), frame="sensor"
        )
        text = ",".join(map(str, pose))
        made = held.provenance | {"shape": "hammer.stl", "object_pose": text}
        replace(grasped, provenance=made).save(folder / f"{name}.json")
    return [folder / f"{name}.json" for name in poses]


def test_one_object_in_two_grasps_agrees_in_its_own_frame(run, folder):
    paths = in_grasps(run, folder)
    status, out, _ = run("compare", *paths)
    assert (status, out.split(":")[0]) == (3, "they contradict one another")
    status, out, err = run("compare", *paths, "--object-frame")
    assert (status, err) == (0, "")
    assert "the same object at the poses that are given, in its frame. ± 95 %" in out
    assert "same grasp" not in out
    _, out, _ = run("compare", *paths, "--object-frame", "--json")
    ends = np.array([one["intervals"] for one in json.loads(out)["estimates"]])
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-6, atol=1e-9)
    wide = run("compare", *paths, "--object-frame", "--pose-std", "3mm,0deg", "--json")
    wider = np.array(json.loads(wide[1])["estimates"][0]["intervals"])
    half = 0.5 * np.diff([ends[0], wider], axis=1)[:, 0, 1:4]
    np.testing.assert_allclose(half[1], np.hypot(half[0], 1.96 * 3e-3), rtol=1e-2)
    assert refused(run("compare", *paths, "--pose-std", "3mm,0deg"), "--object-frame")
    nowhere = identified(run, folder, "a"), paths[1]
    assert refused(run("compare", *nowhere, "--object-frame"), "where the object is")


def test_an_inertial_in_the_objects_frame(run, folder):
    path = in_grasps(run, folder)[1]
    held = Estimate.load(folder / "one.json")
    status, out, err = run("export", path, "--to", "csv", "--object-frame")
    assert (status, err) == (0, "")
    row = dict(zip(*(line.split(",") for line in out.splitlines()), strict=True))
    assert row["frame"] == "object"
    com = [float(row[name]) for name in ("cx", "cy", "cz")]
    np.testing.assert_allclose(com, held.center_of_mass, rtol=1e-9, atol=1e-12)
    _, out, _ = run("export", path, "--to", "urdf", "--object-frame")
    assert "link frame: object" in out
    for name in ("held.usd", "held.mjcf", "held.sdf"):
        status, _, err = run("export", path, "--output", folder / name)
        assert status == 0
    assert err == ""
    assert "<sdf" in (folder / "held.sdf").read_text()
    robot = folder / "robot.urdf"
    robot.write_text('<robot name="r"><link name="tool"/></robot>')
    _, out, _ = run("export", path, "--into", robot, "--link", "tool")
    assert "<inertial>" in out
    assert refused(
        run("export", path, "--output", folder / "held.txt"), "--to: missing"
    )
    exported = "export", path, "--to", "json", "--object-frame"
    _, out, _ = run(*exported, "--object-pose", "0,0,0")
    com = json.loads(out)["center_of_mass"]
    np.testing.assert_allclose(com, Estimate.load(path).center_of_mass, rtol=1e-9)
    assert refused(run("export", path, "--to", "ur", "--object-frame"), "sensor axes")


def test_an_estimate_in_doubt_is_told(run, folder):
    path = identified(run, folder, "a")
    bad = replace(Estimate.load(path), warnings=(error("unexplained", "no fit"),))
    bad.save(folder / "bad.json")
    status, out, _ = run("compare", path, folder / "bad.json")
    assert status == 0
    assert "bad: do not use\n- no fit\n" in out
    assert "a: " not in out.split("┏")[0]
    _, out, _ = run("compare", path, folder / "bad.json", "--json")
    found = json.loads(out)
    assert found["schema"] == "hefting.agreement/1"
    assert found["version"] == hefting.__version__
    told = [(one["verdict"], one["reasons"]) for one in found["estimates"]]
    assert told == [("good", []), ("do not use", ["no fit"])]


def test_compare_refuses_in_one_line(run, folder):
    path = identified(run, folder, "a")
    assert refused(run("compare", path), "a.json", "nothing to compare it with")
    assert refused(run("compare", path, path), "a.json", "given twice")
    assert refused(run("compare", path, folder / "a.csv"), "a.csv", "is not JSON")
    assert refused(run("compare"), "ESTIMATE.json", "hefting compare --help")
