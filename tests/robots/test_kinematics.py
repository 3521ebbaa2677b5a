"""Poses from joint positions: equal to Pinocchio's and the arm's own; whatever is wrong
with a URDF is one line."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.files import MAX_DEPTH, MAX_XML
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.recording import Recording, Stream
from hefting.identification import identify
from hefting.robots import Robot, with_poses
from hefting.simulation import UR5, hammer, random_smooth, simulate
from urdfs import LIMIT, SIX, UR5_URDF, joint, urdf

ROUNDING = 1e-12  # a dozen products of rotations, metres apart, in doubles


def words(values):
    return " ".join(repr(float(v)) for v in values)


def robot_of(tmp_path, text, frame="tip"):
    path = tmp_path / "robot.urdf"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return Robot.from_urdf(path, frame)


def apart(orientation, others):
    """Largest distance between quaternions, q and -q being equal."""
    sign = np.sign((orientation * others).sum(axis=-1, keepdims=True))
    return np.abs(orientation - sign * others).max()


def followed(joints, free):
    """Positions (K,) of every movable joint of a drawn tree from those of the free
    ones, mimics one by one."""
    known = dict(free)
    while missing := [(name, mimic) for name, _, mimic in joints if name not in known]:
        for name, (other, multiplier, offset) in missing:
            if other in known:
                known[name] = multiplier * known[other] + offset
    return known


def draw(seed, links=14):
    """URDF of a random tree, the same without mimics, and name, kind and mimic of its
    movable joints.

    Mimics may be chained, may precede what they mimic, and may mimic joints of other
    branches.
    """
    rng = np.random.default_rng(seed)
    kinds = [
        str(kind)
        for kind in rng.choice(
            ["revolute", "continuous", "prismatic", "fixed"], links - 1
        )
    ]
    movable = [i for i, kind in enumerate(kinds) if kind != "fixed"]
    # a joint mimics only those of lower rank
    ranks = {i: k for k, i in enumerate(rng.permutation(movable).tolist())}
    elements, joints = [], []
    for i, kind in enumerate(kinds):
        xyz, rpy, axis = rng.normal(size=3), rng.uniform(-4, 4, 3), rng.normal(size=3)
        axis *= (kind != "fixed") / np.linalg.norm(axis)
        parent = max(0, i - int(rng.integers(0, 3)))
        inner = f'<origin xyz="{words(xyz)}" rpy="{words(rpy)}"/><axis xyz="{words(axis)}"/>'
        inner += LIMIT if kind in ("revolute", "prismatic") else ""
        mimic = None
        lower = [k for k in ranks if i in ranks and ranks[k] < ranks[i]]
        if lower and rng.random() < 0.4:
            mimic = (f"j{rng.choice(lower)}", *rng.normal(size=2).tolist())
            inner += f'<mimic joint="{mimic[0]}" multiplier="{mimic[1]!r}" offset="{mimic[2]!r}"/>'
        elements.append(joint(f"j{i}", kind, f"l{parent}", f"l{i + 1}", inner))
        if kind != "fixed":
            joints.append((f"j{i}", kind, mimic))
    text = urdf([f"l{i}" for i in range(links)], *rng.permutation(elements))
    return text, re.sub("<mimic[^>]*>", "", text), joints


@pytest.mark.parametrize("seed", range(12))
def test_poses_of_random_trees_equal_pinocchios(tmp_path, seed):
    """Pinocchio cannot chain mimics: it gets the tree without them, and the positions
    they stand for."""
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    (text, unmimicked, joints), rng = draw(seed), np.random.default_rng([1, seed])
    model = pin.buildModelFromXML(unmimicked)
    data = model.createData()
    free = {name: rng.uniform(-5, 5, 4) for name, _, mimic in joints if mimic is None}
    values = followed(joints, free)
    for frame in range(14):
        robot = robot_of(tmp_path, text, f"l{frame}")
        assert set(robot.joints) <= set(robot.all_joints)
        assert set(robot.all_joints) == set(free)
        q = np.array([free[name] for name in robot.joints]).reshape(-1, 4).T
        position, orientation = robot.poses(q)
        for k in range(4):
            configuration = pin.neutral(model)
            for name, kind, _ in joints:
                at, value = model.joints[model.getJointId(name)].idx_q, values[name][k]
                entries = (
                    (np.cos(value), np.sin(value)) if kind == "continuous" else (value,)
                )
                configuration[at : at + len(entries)] = entries
            pin.framesForwardKinematics(model, data, configuration)
            pose = data.oMf[model.getFrameId(f"l{frame}", pin.FrameType.BODY)]
            # up to 60 m away
            assert np.abs(position[k] - pose.translation).max() < 10 * ROUNDING
            assert (
                apart(orientation[k], pin.Quaternion(pose.rotation).coeffs()) < ROUNDING
            )


def test_the_random_trees_hold_what_they_should():
    texts, _, drawn = zip(*(draw(seed) for seed in range(12)), strict=True)
    mimics = [
        {name: mimic[0] for name, _, mimic in joints if mimic} for joints in drawn
    ]
    assert any(other in m for m in mimics for other in m.values()), "no chained mimic"
    assert {kind for joints in drawn for _, kind, _ in joints} == {
        "revolute",
        "continuous",
        "prismatic",
    }
    assert all('type="fixed"' in text for text in texts)


def test_mimics_equal_pinocchios_own(tmp_path):
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    second = (
        '<origin xyz=".1 .2 .3"/><mimic joint="first" multiplier="-2" offset=".5"/>'
    )
    text = urdf(
        ["base", "a", "b", "tip"],
        joint(
            "first",
            "revolute",
            "base",
            "a",
            '<origin xyz="1 2 3" rpy="1 2 3"/><axis xyz="0 1 0"/>' + LIMIT,
        ),
        joint("second", "revolute", "a", "b", second + LIMIT),
        joint(
            "third",
            "prismatic",
            "b",
            "tip",
            '<axis xyz="0 .6 .8"/><mimic joint="first" multiplier="3"/>' + LIMIT,
        ),
    )
    robot = robot_of(tmp_path, text)
    assert robot.joints == ("first",)
    model = pin.buildModelFromXML(text, mimic=True)
    data = model.createData()
    position, orientation = robot.poses([[0.7]])
    pin.framesForwardKinematics(model, data, np.array([0.7]))
    pose = data.oMf[model.getFrameId("tip")]
    assert np.abs(position[0] - pose.translation).max() < ROUNDING
    assert apart(orientation[0], pin.Quaternion(pose.rotation).coeffs()) < ROUNDING


def test_poses_of_the_ur5_equal_those_of_the_simulated_arm(tmp_path):
    robot = robot_of(tmp_path, UR5_URDF, "tool0")
    assert robot.joints == robot.all_joints == SIX
    motion = random_smooth(duration=100.0, rate=100.0, seed=3)  # more than one chunk
    exact = UR5.motion(motion)
    position, orientation = robot.poses(motion.position)
    assert np.abs(position - exact.position).max() < ROUNDING
    assert apart(orientation, exact.orientation) < ROUNDING
    assert np.abs(np.diff(orientation, axis=0)).max() < 0.05, "the quaternions jump"


@pytest.mark.parametrize(
    ("origin", "rotation"),
    [
        ('rpy="0.3 -0.4 0.5"', Rotation.from_euler("xyz", (0.3, -0.4, 0.5))),
        ('quat_xyzw="0.1 -0.5 0.7 0.5"', Rotation.from_quat((0.1, -0.5, 0.7, 0.5))),
        ('xyz="0 0 0"', Rotation.identity()),
    ],
)
def test_orientation_of_an_origin(tmp_path, origin, rotation):
    """And an axis that is not of unit length, or not given."""
    moves = joint(
        "slide",
        "prismatic",
        "base",
        "a",
        f'<origin {origin}/><axis xyz="0 -3e200 4e200"/>',
    )
    robot = robot_of(
        tmp_path,
        urdf(["base", "a", "tip"], moves, joint("turn", "continuous", "a", "tip")),
    )
    position, orientation = robot.poses([[2.0, 0.0], [2.0, np.pi / 2]])
    assert np.abs(position - rotation.apply((0.0, -1.2, 1.6))).max() < ROUNDING
    turned = rotation * Rotation.from_rotvec([(0, 0, 0), (np.pi / 2, 0, 0)])
    assert apart(orientation, turned.as_quat()) < ROUNDING


def test_what_is_no_part_of_the_tree_is_skipped(tmp_path):
    """Extensions, joints of transmissions, xacro's namespace left by its expansion,
    meshes that do not exist."""
    text = UR5_URDF.replace(
        "<robot", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'"
    ).replace(
        "</robot>",
        "<transmission name='t'><joint name='joint_1'/></transmission><gazebo><link name='base'/></gazebo>"
        "<drake:joint xmlns:drake='d' name='joint_1'/></robot>",
    )
    mesh = "<link name='tool0'><visual><geometry><mesh filename='package://no/such.dae'/></geometry></visual></link>"
    assert (
        robot_of(
            tmp_path, "\ufeff" + text.replace("<link name='tool0'/>", mesh), "tool0"
        ).joints
        == SIX
    )


def joint_log(q, **streams):
    time = np.arange(len(q)) * 0.01
    rows = 2 * np.arange(len(q)) + 3
    joints = {"joint_positions": Stream(time, q, rows)}
    return Recording(
        joints | {name: Stream(time, values) for name, values in streams.items()},
        source="log.csv",
    )


def test_a_joint_log_gives_the_poses_the_arm_had(tmp_path):
    """What was recorded in another world goes, what is in sensor axes stays; times and
    rows are the joints'."""
    robot = robot_of(tmp_path, UR5_URDF, "tool0")
    motion = random_smooth(duration=1.0, rate=100.0)
    exact = UR5.motion(motion)
    other = {
        name: np.ones((100, 3)) for name in ("linear_velocity", "position", "gyroscope")
    }
    before = replace(
        joint_log(motion.position, wrench=np.ones((100, 6)), **other),
        warnings=("a",),
        notes=("b",),
    )
    after = with_poses(before, robot)
    assert np.abs(after["position"].values - exact.position).max() < ROUNDING
    assert apart(after["orientation"].values, exact.orientation) < ROUNDING
    for name, stream in (
        (name, before["joint_positions"]) for name in ("position", "orientation")
    ):
        assert np.array_equal(
            (after[name].time, after[name].rows), (stream.time, stream.rows)
        )
    assert set(after.streams) == {
        "position",
        "orientation",
        "joint_positions",
        "wrench",
        "gyroscope",
    }
    assert all(
        after[name] is before[name]
        for name in ("joint_positions", "wrench", "gyroscope")
    )
    assert (after.source, after.warnings, after.notes[:-1]) == (
        "log.csv",
        ("a",),
        ("b",),
    )
    assert after.notes[-1].endswith(
        "in place of the recorded position, linear_velocity"
    )


def test_joints_are_matched_by_name_or_else_by_number(tmp_path):
    finger = joint(
        "finger", "prismatic", "wrist_3", "tip", '<limit effort="1" velocity="1"/>'
    )
    shuffled = UR5_URDF.replace(
        "<link name='tool0'/>", "<link name='tool0'/><link name='tip'/>" + finger
    )
    robot = robot_of(tmp_path, shuffled, "tool0")
    assert robot.all_joints == ("finger", *SIX)
    q = np.random.default_rng(0).uniform(-1, 1, (5, 6))
    expected = robot.poses(q)[0]
    other = np.full((5, 1), 9.0)
    names = ("wheel", *SIX[::-1], "wheel")
    backwards = joint_log(np.hstack((other, q[:, ::-1], other)))
    for log, given in (
        (joint_log(q), ()),
        (joint_log(np.hstack((other, q))), ()),
        (backwards, names),
        (replace(backwards, joint_names=names), ()),
        (replace(backwards, joint_names=("x",) * 8), names),
    ):
        assert np.array_equal(
            with_poses(log, robot, given)["position"].values, expected
        )


def test_a_static_recording_stays_one(tmp_path):
    log = replace(joint_log(np.ones((4, 6)), wrench=np.ones((4, 6))), static=True)
    after = with_poses(log, robot_of(tmp_path, UR5_URDF, "tool0"))
    assert after.static
    assert np.array_equal(after["orientation"].rows, log["joint_positions"].rows)


@pytest.mark.parametrize(
    ("kind", "limit", "reached", "warned"),
    [
        ("revolute", '<limit lower="-2" upper="2"/>', 60.0, True),
        ("revolute", '<limit lower="-2" upper="2"/>', -8.5, True),
        # less than a turn beyond
        ("revolute", '<limit lower="-2" upper="2"/>', 8.2, False),
        ("revolute", '<limit effort="1"/>', 31.0, False),  # less than five turns
        ("continuous", "", 90.0, True),
        ("continuous", "", 31.0, False),
        ("prismatic", '<limit lower="-2" upper="2"/>', 60.0, False),
    ],
)
def test_angles_that_look_like_degrees(tmp_path, kind, limit, reached, warned):
    robot = robot_of(
        tmp_path, urdf(["base", "tip"], joint("elbow", kind, "base", "tip", limit))
    )
    warnings = with_poses(joint_log([[0.0], [reached], [0.1]]), robot).warnings
    assert len(warnings) == warned
    assert all(
        f"elbow reaches {reached:.4g} rad" in w and "degrees" in w for w in warnings
    )


def test_joints_and_wrench_identify_as_poses_and_wrench_do(tmp_path):
    """Poses and no joints, or joints and no poses: the same object, up to rounding that
    the smoother magnifies."""
    motion, body = random_smooth(duration=4.0, rate=100.0, seed=5), hammer().parameters
    posed = simulate(
        UR5.motion(motion),
        body,
        noise=NOISE_LEVELS["low"],
        pose_noise=(0.0, 0.0),
        seed=1,
    )
    joints = Stream(motion.time, motion.position)
    jointed = Recording(
        {"joint_positions": joints, "wrench": posed["wrench"]}, source="joints"
    )
    logs = posed, with_poses(jointed, robot_of(tmp_path, UR5_URDF, "tool0"))
    found = [identify(log, method="OLS").estimate.parameters for log in logs]
    assert (
        np.abs(found[0].vector - found[1].vector).max()
        < 1e-8 * np.abs(found[0].vector).max()
    )
    assert found[1].mass == pytest.approx(body.mass, rel=0.02)


PLAIN = urdf(["base", "tip"], joint("elbow", "revolute", "base", "tip"))
BAD_FILES = {
    "not well-formed XML": "not XML",
    "not well-formed": "",
    "not URDF: its root is <sdf>": "<sdf/>",
    "document type declaration": '<!DOCTYPE r [<!ENTITY a "aaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>',
    "is not UTF-8": b"<robot>\xff</robot>",
    "larger than 16,777,216 bytes": "<robot>" + " " * MAX_XML + "</robot>",
    "nested deeper": "<robot>" + "<a>" * MAX_DEPTH,
    "expand it first: xacro": "<robot xmlns:xacro='x'><xacro:macro name='arm'/></robot>",
    "is xacro, not URDF": PLAIN.replace("elbow", "${prefix}elbow"),
    "elbow': is xacro": PLAIN.replace(
        "</joint>", '<origin xyz="0 0 ${height}"/></joint>'
    ),
    "has no links": "<robot/>",
    "has more than 2,000 links": "<robot>" + "<link name='a'/>" * 2_001,
    "a <link> has no name": urdf([" "]),
    "a <link> has too long a name": urdf(["x" * 10_000]),
    "two links are named 'tip'": urdf(["base", "tip", "tip"]),
    "two joints are named 'a'": urdf(
        ["base", "b", "tip"], *(joint("a", "fixed", "base", c) for c in ("b", "tip"))
    ),
    "its type is 'revolut' (did you mean 'revolute'?)": PLAIN.replace(
        '"revolute"', '"revolut"'
    ),
    "joint 'elbow': its <child> has no link": PLAIN.replace('<child link="tip"/>', ""),
    "there is no link 'tipp' (did you mean 'tip'?)": PLAIN.replace(
        'child link="tip"', 'child link="tipp"'
    ),
    "roots are other, base": PLAIN.replace("<link", "<link name='other'/><link", 1),
    "the child of two joints ('elbow', 'b')": PLAIN.replace(
        "</robot>", joint("b", "fixed", "base", "tip") + "</robot>"
    ),
    "loop through tip, a": urdf(
        ["base", "tip", "a"],
        joint("b", "fixed", "tip", "a"),
        joint("c", "fixed", "a", "tip"),
    ),
    "loop through tip; ": urdf(["base", "tip"], joint("b", "fixed", "tip", "tip")),
}
BAD_JOINTS = {
    "the axis is zero": '<axis xyz="0 0 0"/>',
    "the axis is '0 0 nan', not 3 finite": '<axis xyz="0 0 nan"/>',
    "the axis is '0 1', not 3 finite numbers": '<axis xyz="0 1"/>',
    "xyz is '1 inf 0'": '<origin xyz="1 inf 0"/>',
    "xyz is '1 1e999 0'": '<origin xyz="1 1e999 0"/>',
    "xyz is '0,1 0 0'": '<origin xyz="0,1 0 0"/>',
    "xyz is '1_0 0 0'": '<origin xyz="1_0 0 0"/>',
    "rpy is '1 2 3 4'": '<origin rpy="1 2 3 4"/>',
    "not of unit norm": '<origin quat_xyzw="1e300 1 1 1"/>',
    "the mimic's multiplier is 'two', not a finite": '<mimic joint="elbow" multiplier="two"/>',
    "the mimic's offset is 'inf'": '<mimic joint="elbow" offset="inf"/>',
    "the mimic has no joint": "<mimic/>",
    "lower is 'x'": '<limit lower="x"/>',
    "mimics 'elbo', which is not there (did you mean 'elbow'?)": '<mimic joint="elbo"/>',
    "it mimics itself": '<mimic joint="elbow"/>',
    "it mimics 'weld', which is fixed": '<mimic joint="weld"/>',
    "mimics itself (by way of elbow, other)": '<mimic joint="other"/>',
}


def line(error):
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600
    return str(error.value)


@pytest.mark.parametrize("message", BAD_FILES)
def test_a_bad_file_is_one_line(tmp_path, message):
    with pytest.raises(InputError) as error:
        robot_of(tmp_path, BAD_FILES[message])
    assert message in line(error)
    assert "robot.urdf" in line(error)


@pytest.mark.parametrize("message", BAD_JOINTS)
def test_a_bad_joint_is_one_line(tmp_path, message):
    more = joint("weld", "fixed", "base", "a") + joint(
        "other", "revolute", "base", "b", '<mimic joint="elbow"/>'
    )
    text = urdf(
        ["base", "a", "b", "tip"],
        joint("elbow", "revolute", "base", "tip", BAD_JOINTS[message]),
        more,
    )
    with pytest.raises(InputError) as error:
        robot_of(tmp_path, text)
    assert message in line(error)
    assert "robot.urdf, joint 'elbow'" in line(error)


def test_a_frame_that_is_not_there(tmp_path):
    with pytest.raises(
        InputError,
        match=r"frame is named 'tool' \(did you mean 'tool0'\?\).*base, shoulder,.*tool0",
    ):
        robot_of(tmp_path, UR5_URDF, "tool")
    with pytest.raises(
        InputError, match=r"'flange' \(a joint is; its link is 'tool0'\)"
    ):
        robot_of(tmp_path, UR5_URDF, "flange")
    with pytest.raises(InputError, match=r"cannot be read \(No such file"):
        Robot.from_urdf(tmp_path / "none.urdf", "tool0")


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_kinds_that_have_no_single_position_are_refused_only_on_the_way(tmp_path, kind):
    text = urdf(
        ["base", "tip", "side"],
        joint("j", "revolute", "base", "tip"),
        joint("k", kind, "base", "side"),
    )
    assert robot_of(tmp_path, text).all_joints == ("j",)
    with pytest.raises(
        InputError, match=f"joint 'k': it is {kind}, and lies between 'base' and 'side'"
    ):
        robot_of(tmp_path, text, "side")


def test_joints_that_do_not_match_are_one_line(tmp_path):
    robot = robot_of(tmp_path, UR5_URDF, "tool0")
    log = joint_log(np.zeros((3, 6)))
    named = {
        "lacks joint joint_2, joint_6 of": (*SIX[:1], "joint_02", *SIX[2:5], "x"),
        "(did you mean 'joint_02'?); it has joint_1, joint_02,": (
            *SIX[:1],
            "joint_02",
            *SIX[2:5],
            "x",
        ),
        "5 joint names for 6 columns": SIX[:5],
        "two columns of joint positions are named 'joint_1'": (*SIX, "joint_1"),
    }
    for message, names in named.items():
        with pytest.raises(InputError) as error:
            with_poses(
                joint_log(np.zeros((3, 7))) if len(names) == 7 else log, robot, names
            )
        assert message in line(error)
    with pytest.raises(
        InputError,
        match=r"log.csv: has 4 unnamed joints.*'tool0' is moved by 6 \(joint_1, .*name the",
    ):
        with_poses(joint_log(np.zeros((3, 4))), robot)
    with pytest.raises(InputError, match="no joint moves the frame 'base'"):
        with_poses(log, robot_of(tmp_path, UR5_URDF, "base"))
    with pytest.raises(InputError, match=r"log.csv: has no joint positions"):
        with_poses(
            Recording({"wrench": Stream([0.0], np.zeros((1, 6)))}, source="log.csv"),
            robot,
        )
    with pytest.raises(InputError, match=r"shape \(3, 5\), not \(K, 6\)"):
        robot.poses(np.zeros((3, 5)))


def test_poses_beyond_all_bounds(tmp_path):
    """Finite numbers whose sums are not."""
    far = '<origin xyz="1.7e308 0 0"/>'
    chain = [
        joint("a", "prismatic", "base", "b", far),
        joint("c", "continuous", "b", "tip", far),
    ]
    with pytest.raises(InputError, match="'tip' is infinitely far away"):
        robot_of(tmp_path, urdf(["base", "b", "tip"], *chain))
    robot = robot_of(
        tmp_path, urdf(["base", "tip"], joint("a", "prismatic", "base", "tip", far))
    )
    with pytest.raises(InputError, match="sample 2 give no finite pose"):
        robot.poses([[1.0], [1e308]])
