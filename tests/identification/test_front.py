"""`hefting.identify` as it is called from Python: the same answer however recording,
shape and method are given."""

import re

import numpy as np
import pandas as pd
import polars as pl
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_recordings")

SHAPE = hefting.Shape.from_mesh(hammer().mesh())
BIAS = np.array((12.0, -7.0, 14.0, 0.3, -0.2, 0.1))


@pytest.fixture(scope="module")
def recording():
    """Three seconds of an arm that wields a hammer."""
    motion = UR5.motion(random_smooth(3.0, 100.0, 1.0, seed=3))
    return simulate(
        motion, hammer().parameters, noise=hefting.Noise(0.1, 0.005), seed=3
    )


@pytest.fixture(scope="module")
def arrays(recording):
    """Its arrays by name."""
    names = ("position", "orientation", "wrench")
    values = {name: recording[name].values for name in names}
    return {"time": recording["wrench"].time, **values}


@pytest.fixture(scope="module")
def found(recording):
    return hefting.identify(recording, SHAPE)


def assert_same(one, other, rtol=1e-6, atol=1e-9):
    """The same estimate; quaternions that went through matrices differ by rounding."""
    np.testing.assert_allclose(
        one.estimate.parameters.vector,
        other.estimate.parameters.vector,
        rtol=rtol,
        atol=atol,
    )


def test_arrays_and_tables_give_the_answer_of_the_recording(
    recording, arrays, found, tmp_path
):
    assert_same(hefting.identify(**arrays, shape=SHAPE), found)
    assert_same(hefting.identify(arrays, SHAPE), found)
    turned = Rotation.from_quat(np.array(arrays["orientation"]))
    poses = np.tile(np.eye(4), (len(turned), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = turned.as_matrix(), arrays["position"]
    same = {"time": arrays["time"], "wrench": arrays["wrench"]}
    assert_same(hefting.identify(pose=poses, shape=SHAPE, **same), found)
    same["position"] = arrays["position"]
    assert_same(hefting.identify(orientation=turned, shape=SHAPE, **same), found)
    write_log(recording, tmp_path / "log.parquet")
    assert_same(hefting.identify(tmp_path / "log.parquet", SHAPE), found)
    frame = pd.read_parquet(tmp_path / "log.parquet")
    assert_same(hefting.identify(frame, SHAPE), found)
    assert_same(hefting.identify(pl.from_pandas(frame), SHAPE), found)


def test_a_wrench_on_its_own_clock(arrays, found):
    """Every second sample, half a step off: the answer within its interval."""
    time, wrench = arrays["time"], arrays["wrench"]
    between = 0.5 * (time[:-1] + time[1:])
    middle = np.column_stack([np.interp(between, time, w) for w in wrench.T])
    poses = {name: arrays[name] for name in ("time", "position", "orientation")}
    apart = hefting.identify(
        **poses, wrench=middle[::2], wrench_time=between[::2], shape=SHAPE
    )
    low, high = found.interval("mass")
    assert low < apart.mass < high


@pytest.mark.parametrize(
    "shape", [hammer().mesh(), SHAPE], ids=["a mesh of trimesh", "a shape"]
)
def test_shapes(recording, found, shape):
    assert_same(hefting.identify(recording, shape), found)


def test_unit_and_pose_of_the_shape(recording, found, tmp_path):
    pose = np.eye(4)
    pose[:3, 3] = 0.1, 0.0, 0.0
    mesh = hammer().mesh().copy()
    mesh.apply_translation(-pose[:3, 3]).apply_scale(1e3).export(tmp_path / "h.stl")
    given = hefting.identify(recording, tmp_path / "h.stl", unit="mm", object_pose=pose)
    # an STL file has single precision: 1e-5 mm of the hammer's 0.3 m
    assert_same(given, found, rtol=1e-4, atol=1e-6)


def test_methods_by_name_class_and_value(recording):
    named = hefting.identify(recording, SHAPE, method="LMI")
    assert_same(hefting.identify(recording, SHAPE, method=hefting.LMI), named)
    fitted = hefting.OLS().fit(named.measurements)
    valued = hefting.identify(recording, method=hefting.OLS())
    np.testing.assert_allclose(
        valued.estimate.parameters.vector, fitted.parameters.vector, rtol=1e-9
    )
    assert valued.estimate.residual is not None  # it has the checks of every answer


@pytest.mark.parametrize("methods", [["LMI", "OLS"], (hefting.LMI, hefting.OLS)])
def test_several_methods_are_compared(recording, methods, tmp_path):
    several = hefting.identify(recording, SHAPE, method=methods)
    assert isinstance(several, hefting.Comparison)
    assert set(several.results) == {"LMI", "OLS"}
    best = several.results[several.recommended]
    assert several.mass == best.mass
    assert several.verdict == best.verdict
    assert several.warnings == best.warnings
    several.save(tmp_path / "found.json")
    assert hefting.Estimate.load(tmp_path / "found.json").mass == best.mass
    assert len(repr(several)) < 1500
    _, of_each = repr(several).split(f"recommended: {several.reason}\n")
    for line, (name, each) in zip(
        of_each.splitlines(), several.results.items(), strict=True
    ):
        assert line.split()[0] == name
        assert float(line.split()[1]) == pytest.approx(each.mass, rel=1e-3)  # rounded
    named = hefting.identify(recording, method="LMI, OLS")
    assert (named.mass, set(named.results)) == (several.mass, {"LMI", "OLS"})


def test_all_methods_and_hyperparameters_of_some(recording):
    every = hefting.identify(recording, SHAPE, method="all", c1=100.0)
    assert isinstance(every, hefting.Comparison)
    assert set(hefting.identify(recording, SHAPE, method=["all"]).results) == set(
        every.results
    )
    assert len(repr(every)) < 1500


def test_what_is_at_hand(found):
    assert len(repr(found)) < 1500
    assert found.mass == found.estimate.parameters.mass
    np.testing.assert_array_equal(found.inertia, found.estimate.inertia)
    np.testing.assert_array_equal(found.center_of_mass, found.estimate.center_of_mass)
    np.testing.assert_array_equal(
        found.interval("mass"), found.estimate.intervals["mass"]
    )
    assert found.warnings == found.estimate.warnings
    assert found.verdict.usable


def test_the_sign_is_given_beside_arrays_and_as_before(recording, arrays, found):
    flipped = arrays | {"wrench": -arrays["wrench"]}
    assert_same(hefting.identify(**flipped, sign="on-sensor", shape=SHAPE), found)
    before = hefting.identify(recording, SHAPE, wrench="on-object")
    assert_same(before, hefting.identify(recording, SHAPE, sign="on-object"))
    with pytest.raises(hefting.NotIdentifiableError, match="`sign`"):
        hefting.identify(recording, SHAPE, sign="on-sensor")


def test_quaternions_with_w_first_are_named(arrays):
    wxyz = arrays | {"orientation": arrays["orientation"][:, [3, 0, 1, 2]]}
    found = hefting.identify(**wxyz, shape=SHAPE)
    assert not found.verdict.usable
    assert found.verdict.reasons[0].code == "quaternion-order"


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8)])
def test_what_is_advised_for_turned_axes_is_taken_as_it_is_said(arrays, found, axis):
    """The object is found in the axes that the sensor has."""
    turn = Rotation.from_rotvec(np.radians(50.0) * np.array(axis))
    wrench = turn.apply(np.array(arrays["wrench"]).reshape(-1, 3)).reshape(-1, 6)
    turned = arrays | {"wrench": wrench}
    said = hefting.identify(**turned).verdict.reasons[0]
    assert said.code == "axes-turned"
    name, value = re.search(r"`(\w+)`='([^']+)'", str(said)).groups()
    mended = hefting.identify(**turned, **{name: value})
    assert mended.verdict.usable
    assert mended.mass == pytest.approx(found.mass, rel=5e-3)
    # 5 mm: a turn that is found to 1 degree, of a COM 0.25 m away
    com = turn.apply(np.array(found.center_of_mass))
    np.testing.assert_allclose(mended.center_of_mass, com, atol=5e-3)


def test_a_sensor_elsewhere_is_said_once(arrays):
    with pytest.raises(InputError, match="give one of them"):
        hefting.identify(**arrays, sensor_turned="z:45", sensor_pose_in_log=np.eye(4))
    with pytest.raises(InputError, match="z:45"):
        hefting.identify(**arrays, sensor_turned="w:45")


def test_a_bias_that_an_estimator_leaves_in_is_not_passed_over(arrays, found):
    biased = arrays | {"wrench": arrays["wrench"] + BIAS}
    with pytest.raises(InputError, match=r"make it OLS\(..., bias='estimate'\)"):
        hefting.identify(**biased, method=hefting.OLS())
    hefting.identify(**biased, method=hefting.OLS(), bias="none")  # as asked for
    unbiased = hefting.identify(**biased, method=hefting.OLS(bias="estimate"))
    assert unbiased.mass == pytest.approx(found.mass, rel=0.02)


def test_a_tare_is_the_mean_wrench_of_its_time(recording):
    wrench = recording["wrench"]
    mean = wrench.values[wrench.time - recording.start <= 0.5].mean(axis=0)
    tared = hefting.identify(recording, bias="tare:0,0.5")
    assert_same(tared, hefting.identify(recording, bias=mean), rtol=1e-12)
    text = ",".join(map(repr, mean.tolist()))
    assert_same(tared, hefting.identify(recording, bias=text), rtol=1e-12)
    with pytest.raises(InputError, match="is for recordings"):
        hefting.LiveIdentifier(bias="tare:0,0.5")


def test_a_tool_from_its_file(recording, tmp_path):
    tool = hefting.calibrate(recording)
    tool.save(tmp_path / "tool.json")
    heavier = hefting.InertialParameters(2.0 * hammer().parameters.vector)
    motion = UR5.motion(random_smooth(3.0, 100.0, 1.0, seed=4))
    both = simulate(motion, heavier, noise=hefting.Noise(0.1, 0.005), seed=4)
    from_file = hefting.identify(both, tool=tmp_path / "tool.json")
    low, high = from_file.interval("mass")
    assert low < hammer().parameters.mass < high
    assert_same(hefting.identify(both, tool=tool), from_file, rtol=1e-9)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"method": "LIM"}, "unknown method 'LIM'"),
        ({"method": 5}, "unknown method '5'"),
        ({"method": []}, "no method is named"),
        ({"method": ["OLS", 5]}, "unknown method '5'"),
        ({"method": [hefting.LMI()], "c1": 3.0}, "none of LMI has a 'c1'"),
        ({"method": hefting.LMI(), "c1": 3.0}, "`c1` is given beside an estimator"),
        (
            {"method": hefting.PMD(SHAPE), "shape": "box:0,1,0,1,0,1"},
            "`shape` is given",
        ),
        ({"gravty": (0, 0, -9.8)}, r"no argument 'gravty' \(did you mean 'gravity'"),
        ({"nothing_like_it": 1}, "Bayes has no 'nothing_like_it'"),
        ({"latitude": 59.9}, r"hefting.Gravity.at\(latitude"),
        ({"truth": "truth.json"}, "hefting.errors_between"),
        ({"urdf": "a.urdf", "sensor_frame": "b"}, "hefting.with_poses"),
        ({"sensor_frame": "b"}, r"read_log\(log, sensor_frame=...\)"),
        ({"map": "map.toml"}, r"as_recording\(log, column_map=...\)"),
        ({"hull": True}, r"load_shape\(file, hull=...\)"),
        ({"torques": True}, "by_torques.ByTorques"),
        ({"output": "held.urdf"}, r"export\(found, ...\)"),
        ({"sensor_turned": 45}, "'45' is no turn"),
        ({"bias": "tare:2,1"}, "ends before it begins"),
        ({"bias": "tare:50,60"}, "no wrench between 50 and 60 s"),
        ({"gravity": "down"}, "unknown gravity 'down'; use X,Y,Z"),
        ({"start": "2"}, "start is '2', not a number of seconds"),
        ({"duration": [1.0]}, "not a number of seconds"),
        ({"sensor_pose_in_log": [0.0] * 6}, r"shape \(6,\).*x, y, z, qx, qy, qz, qw"),
        ({"shape": 3}, "is not a shape"),
        ({"unit": "mm"}, "those of a shape's file"),
        ({"sign": "upwards"}, "unknown wrench convention 'upwards'"),
        ({"tool": "nothing.json"}, "nothing.json"),
        ({"time": [0.0, 1.0]}, "both a recording and `time`"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(recording, options, match):
    with pytest.raises(InputError, match=match) as refused:
        hefting.identify(recording, **options)
    assert "\n" not in str(refused.value)


def test_without_a_recording_or_what_a_method_needs(recording):
    with pytest.raises(InputError, match="no recording is given"):
        hefting.identify()
    with pytest.raises(hefting.NeedError, match="PMD needs a shape"):
        hefting.identify(recording, method="PMD")
