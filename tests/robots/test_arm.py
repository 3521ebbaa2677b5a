"""Links of an arm where Pinocchio has them; those behind unknown joints are left out."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.robots import Arm
from hefting.robots.arm import MOST_LINKS
from urdfs import LINKS, SIX, UR5_URDF, joint, urdf

ROUNDING = 1e-12  # a dozen products of rotations, a metre apart, in doubles


def log(q, names=()):
    time = np.arange(len(q)) * 0.1
    return Recording({"joint_positions": Stream(time, q)}, joint_names=names)


def arm_of(tmp_path, text, recording, frame="tool0"):
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    return Arm.from_urdf(path, frame, recording)


@pytest.mark.parametrize("names", [(), SIX, SIX[::-1]])
def test_links_are_where_pinocchio_has_them(tmp_path, names):
    pin = pytest.importorskip("pinocchio")
    q = np.random.default_rng(4).uniform(-3.0, 3.0, (7, 6))
    recorded = q[:, ::-1] if names == SIX[::-1] else q
    arm = arm_of(tmp_path, UR5_URDF, log(recorded, names))
    assert [link.name for link in arm.links] == list(LINKS)
    position, orientation = arm.poses(recorded)
    model = pin.buildModelFromXML(UR5_URDF)
    data = model.createData()
    for k, angles in enumerate(q):
        pin.framesForwardKinematics(model, data, angles)
        for i, link in enumerate(arm.links):
            pose = data.oMf[model.getFrameId(link.name)]
            np.testing.assert_allclose(position[k, i], pose.translation, atol=ROUNDING)
            turned = pin.Quaternion(orientation[k, i]).matrix()
            np.testing.assert_allclose(turned, pose.rotation, atol=ROUNDING)


def test_each_link_but_the_first_is_borne_by_another(tmp_path):
    arm = arm_of(tmp_path, UR5_URDF, log(np.zeros((2, 6))))
    assert [link.parent for link in arm.links] == [None, *range(len(LINKS) - 1)]


def test_links_of_joints_that_were_not_recorded_are_left_out(tmp_path):
    finger = joint("finger", "prismatic", "tool0", "left", "<axis xyz='1 0 0'/>")
    behind = joint("nail", "fixed", "left", "nail")
    floats = joint("loose", "floating", "tool0", "ball")
    inner = UR5_URDF.replace("</robot>", f"{finger}{behind}{floats}</robot>")
    extra = "".join(f"<link name='{name}'/>" for name in ("left", "nail", "ball"))
    text = inner.replace("<link name='base'/>", f"<link name='base'/>{extra}")
    arm = arm_of(tmp_path, text, log(np.zeros((2, 6)), SIX))
    assert [link.name for link in arm.links] == list(LINKS)


def test_no_more_links_than_can_be_drawn(tmp_path):
    names = [f"l{i}" for i in range(MOST_LINKS + 50)]
    joints = [joint("turn", "revolute", names[0], names[1], "<axis xyz='0 0 1'/>")]
    joints += [
        joint(f"j{i}", "fixed", names[i], names[i + 1])
        for i in range(1, len(names) - 1)
    ]
    arm = arm_of(tmp_path, urdf(names, *joints), log(np.zeros((2, 1))), names[-1])
    assert len(arm.links) == MOST_LINKS


def test_joints_that_do_not_fit_are_one_line(tmp_path):
    with pytest.raises(InputError, match="has 4 unnamed joints"):
        arm_of(tmp_path, UR5_URDF, log(np.zeros((2, 4))))
    bare = replace(log(np.zeros((2, 6))), joint_names=("a", "b", "c", "d", "e", "f"))
    with pytest.raises(InputError, match="lacks joint joint_1"):
        arm_of(tmp_path, UR5_URDF, bare)
    still = Recording({"position": Stream(np.zeros(1), np.zeros((1, 3)))})
    with pytest.raises(InputError, match="no joint positions"):
        arm_of(tmp_path, UR5_URDF, still)
