"""What links and object keep clear of, against MuJoCo's distances of the same bodies."""

import mujoco
import numpy as np
import pytest

from folding_arm import JOINTS, SIZES, folding_arm
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.messages import codes
from hefting.planning import solids
from hefting.planning.space import FAR, Space
from urdfs import joint

BOX = np.array(
    [[x, y, z] for x in (-0.1, 0.15) for y in (-0.05, 0.05) for z in (0.01, 0.2)]
)
"""Corners of a held box in the tool's frame [m]."""
ADJACENT = (
    {"base", "turret"},
    {"turret", "upper"},
    {"upper", "lower"},
    {"lower", "hand"},
)
SAMPLES = np.random.default_rng(0).uniform(-2.9, 2.9, (300, 4))


def in_mujoco(path):
    """A URDF as MuJoCo's model, every link a body."""
    compiler = "<mujoco><compiler fusestatic='false'/></mujoco>"
    text = path.read_text().replace("<robot name='r'>", f"<robot name='r'>{compiler}")
    return mujoco.MjModel.from_xml_string(text)


def mujoco_distances(path, q, is_checked):
    """Smallest distance (K,) [m] of the pairs of geometries with a name `is_checked`."""
    model = in_mujoco(path)
    data, found = mujoco.MjData(model), []
    names = [model.body(model.geom_bodyid[g]).name for g in range(model.ngeom)]
    for sample in q:
        data.qpos[:] = sample
        mujoco.mj_forward(model, data)
        found.append(
            min(
                mujoco.mj_geomDistance(model, data, i, j, FAR, None)
                for j in range(model.ngeom)
                for i in range(j)
                if is_checked({names[i], names[j]})
            )
        )
    return np.array(found)


def held_box(tmp_path):
    """The arm, its box a body of the tool."""
    middle, sides = BOX.mean(axis=0), np.ptp(BOX, axis=0)
    size, place = (" ".join(map(str, each)) for each in (sides, middle))
    box = (
        f'<link name="held"><collision><origin xyz="{place}"/><geometry>'
        f'<box size="{size}"/></geometry></collision></link>'
    )
    return folding_arm(tmp_path, extra=box + joint("grip", "fixed", "tool", "held", ""))


def test_distances_of_links_are_those_of_mujoco(tmp_path):
    path = folding_arm(tmp_path)
    found = Space.of(path, "tool").clearance(SAMPLES)
    wanted = mujoco_distances(path, SAMPLES, lambda pair: pair not in ADJACENT)
    apart = wanted > 0.0
    assert 0.2 < apart.mean() < 0.95  # both happen
    np.testing.assert_array_equal(found > 0.0, apart)
    # both iterate to about 1e-6 m; depths of overlaps are not unique to their methods
    np.testing.assert_allclose(found[apart], wanted[apart], atol=1e-5)


def test_the_object_is_checked_against_all_but_its_holder(tmp_path):
    found = Space.of(folding_arm(tmp_path), "tool", corners=BOX).clearance(SAMPLES)
    own = ({"hand", "held"}, *ADJACENT)
    wanted = mujoco_distances(held_box(tmp_path), SAMPLES, lambda pair: pair not in own)
    apart = wanted > 0.0
    np.testing.assert_array_equal(found > 0.0, apart)
    np.testing.assert_allclose(found[apart], wanted[apart], atol=1e-5)


@pytest.mark.parametrize("keep", ["z>=0.02", "x<=0.5", "1,1,0>=-0.6"])
def test_half_spaces_hold_every_corner(tmp_path, keep):
    """Corners of every link by the links' poses in MuJoCo, and the inequality."""
    path = held_box(tmp_path)
    model = in_mujoco(path)
    data = mujoco.MjData(model)
    space = Space.of(folding_arm(tmp_path), "tool", keep=[keep], corners=BOX)
    half, wanted = space.half_spaces[0], []
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for sample in SAMPLES:
        data.qpos[:] = sample
        mujoco.mj_forward(model, data)
        least = {}
        for g in range(model.ngeom):
            corners = signs * model.geom_size[g]
            corners = corners @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
            name = model.body(model.geom_bodyid[g]).name
            least[name] = half.clearance(corners).min()
        least.pop("base")  # does not move
        if keep.startswith("z"):
            least.pop("turret")  # turns about z, and comes no nearer
        wanted.append(min(least.values()))
    alone = Space(space.half_spaces, space.links, space.solids, space.outside, None)
    found = alone.clearance(SAMPLES)
    # exact kinematics on both sides
    np.testing.assert_allclose(found, np.minimum(wanted, FAR), atol=1e-9)
    assert (found < 0.0).any()


def test_what_is_nearest_is_named(tmp_path):
    space = Space.of(folding_arm(tmp_path), "tool", keep=["z>=-0.5"], corners=BOX)
    stretched = np.zeros(4)
    down = np.array([0.0, 2.8, 0.0, 0.0])
    folded = np.array([0.0, 0.0, 2.9, 0.0])
    assert space.nearest(stretched)[0] > 0.0
    assert space.nearest(down) == (
        pytest.approx(space.clearance(down[None])[0]),
        "the object and z>=-0.5",
    )
    distance, names = space.nearest(np.array([stretched, folded]))
    assert distance < 0.0
    assert names == "link 'turret' and the object"


def test_what_an_srdf_disables_is_not_checked(tmp_path):
    path, srdf = folding_arm(tmp_path), tmp_path / "arm.srdf"
    pair = 'link1="upper" link2="hand"'
    srdf.write_text(f'<robot name="r"><disable_collisions {pair}/></robot>')
    found = Space.of(path, "tool", srdf=srdf).clearance(SAMPLES)
    left = ({"upper", "hand"}, *ADJACENT)
    wanted = mujoco_distances(path, SAMPLES, lambda pair: pair not in left)
    np.testing.assert_array_equal(found > 0.0, wanted > 0.0)
    assert (found > Space.of(path, "tool").clearance(SAMPLES) + 1e-3).any()


def test_what_touches_always_is_left_out_and_named(tmp_path):
    """A hand so large that it holds the elbow in."""
    path = folding_arm(tmp_path)
    path.write_text(path.read_text().replace(SIZES["hand"][0], "0.9 0.9 0.9"))
    space = Space.of(path, "tool")
    (message,) = space.messages
    assert message.code == "plan-pairs-unchecked"
    assert "link 'upper' and link 'hand'" in message


def test_a_link_outside_wherever_the_arm_is_is_left_out_and_named(tmp_path):
    space = Space.of(folding_arm(tmp_path), "tool", keep=["z>=0.12"])
    (message,) = space.messages
    assert message.code == "plan-half-space-unchecked"
    assert "link 'turret' of z>=0.12" in message
    assert space.clearance(np.zeros((1, 4)))[0] > 0.0


def test_an_object_outside_wherever_the_arm_is_is_refused(tmp_path):
    with pytest.raises(InputError, match="the object is outside z>=5"):
        Space.of(folding_arm(tmp_path), "tool", keep=["z>=5"], corners=BOX)


def test_looks_serve_where_there_is_no_collision_geometry(tmp_path):
    wanted = Space.of(folding_arm(tmp_path), "tool").clearance(SAMPLES)
    path = folding_arm(tmp_path, part="visual")
    np.testing.assert_array_equal(Space.of(path, "tool").clearance(SAMPLES), wanted)


def test_without_any_geometry_origins_are_kept_in(tmp_path):
    path = folding_arm(tmp_path, part="inertial")
    space = Space.of(path, "tool", keep=["z>=0.1"], corners=BOX)
    assert "plan-links-without-geometry" in codes(space.messages)
    assert space.contacts is None or all(
        space.contacts.solids[i].name == "the object"
        for i in np.unique(space.contacts.pairs)
    )
    low = np.array([[0.0, 2.0, 0.0, 0.0]])  # the elbow is at 0.2 + 0.4 cos 2 m
    solids = [space.solids[s] for s, _ in space.outside]
    assert {solid.name for solid in solids} >= {"link 'lower'", "the object"}
    elbow = next(i for i, s in enumerate(space.solids) if s.name == "link 'lower'")
    alone = Space(
        space.half_spaces, space.links, space.solids, ((elbow, 0),), None, None
    )
    assert alone.clearance(low)[0] == pytest.approx(0.1 + 0.4 * np.cos(2.0))


def test_without_coal_half_spaces_are_still_kept_and_it_is_said(tmp_path, monkeypatch):
    class Missing:
        def __init__(self, *_):
            raise MissingDependencyError("coal", "robot")

    monkeypatch.setattr("hefting.planning.space.Contacts", Missing)
    space = Space.of(folding_arm(tmp_path), "tool", keep=["z>=0"])
    (message,) = space.messages
    assert message.code == "plan-collisions-unchecked"
    assert "pip install 'hefting[robot]'" in message
    assert (space.clearance(SAMPLES) < 0.0).any()


def test_joints_that_do_not_move_the_tip_rest(tmp_path):
    """A finger that slides from 0.1 m on, and so is far from the hand."""
    finger = (
        '<link name="finger"><collision><geometry><sphere radius="0.01"/></geometry>'
        "</collision></link>"
    )
    slide = joint(
        "slide",
        "prismatic",
        "hand",
        "finger",
        '<axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/>',
    )
    path = folding_arm(tmp_path, joints=(*JOINTS, slide), extra=finger)
    space = Space.of(path, "tool", keep=["z>=-5"])
    link = next(link for link in space.links if link.name == "finger")
    hand = next(link for link in space.links if link.name == "hand")
    assert link.columns == (0, 1, 2, 3, -1)
    np.testing.assert_allclose(link.pose(SAMPLES)[0], hand.pose(SAMPLES)[0], atol=1e-12)


def test_configurations_are_checked_many_at_a_time(tmp_path):
    """One by one gives the same: spheres only leave out what cannot be nearest."""
    space = Space.of(folding_arm(tmp_path), "tool", keep=["z>=0"], corners=BOX)
    together = space.clearance(SAMPLES[:50])
    single = [space.clearance(sample[None])[0] for sample in SAMPLES[:50]]
    # a pair's distance may depend in its last digits on how it was begun
    np.testing.assert_allclose(together, single, atol=1e-9)
    assert solids.Contacts is type(space.contacts)
