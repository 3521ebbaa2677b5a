"""Putting an inertial into an existing file: the right place, no other byte changed,
hostile ones refused."""

from xml.etree import ElementTree

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.files import MAX_XML
from hefting.core.inertia import InertialParameters
from hefting.export import export

TENSOR = np.array([[2e-3, 1e-4, -2e-4], [1e-4, 3e-3, 3e-4], [-2e-4, 3e-4, 4e-3]])
COM = (0.01, -0.02, 0.05)
ESTIMATE = Estimate("test", InertialParameters.from_com(0.932, COM, TENSOR), samples=10)

URDF = """<?xml version="1.0" encoding="utf-8"?>
<!-- a <link name="tool0"> in a comment is no link; ünïcode -->
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base"/>
  <link name="tool0" />
  <link  name = 'gripper' note="a > b"><!-- keep --><visual><geometry><box size="1 1 1"/></geometry></visual>
    <inertial>
      <origin xyz="9 9 9"/><mass value="77"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial><collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
\t<link name="finger">
\t</link>
  <link name="empty"></link>
  <joint name="a" type="floating"><parent link="base"/><child link="tool0"/></joint>
  <joint name="b" type="floating"><parent link="tool0"/><child link="gripper"/></joint>
  <joint name="c" type="floating"><parent link="gripper"/><child link="finger"/></joint>
  <joint name="d" type="floating"><parent link="gripper"/><child link="empty"/></joint>
  <gazebo><plugin><link name="finger">not a link of the robot</link></plugin></gazebo>
</robot>
"""
MJCF = """<mujoco model="m">
  <worldbody>
    <body name="outer"><freejoint/><geom size="0.1"/>
      <body><inertial pos="0 0 1" mass="3" diaginertia="1 1 1"/>
        <body name="inner" pos="0 0 1">
          <inertial pos="0 0 0" mass="5" diaginertia="1 1 1"></inertial>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
SDF = """<sdf version="1.7"><world name="w"><model name="m">
  <link name="hand"><pose>0 0 1 0 0 0</pose></link>
  <joint name="j" type="fixed"><parent>world</parent><child>hand</child></joint>
</model></world></sdf>
"""


def put(tmp_path, content, target, link, **arguments):
    path = tmp_path / "file.xml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return export(ESTIMATE, target, into=path, link=link, **arguments)


def outline(text: str, holder: str, link: str):
    """The document as nested tuples with comments, without the inertial of one
    element."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))

    def walk(e):
        skip = e.tag == holder and e.get("name") == link
        children = [walk(c) for c in e if not (skip and c.tag == "inertial")]
        return str(e.tag), dict(e.attrib), (e.text or "").strip(), children

    return walk(ElementTree.fromstring(text.encode(), parser))


@pytest.mark.parametrize("link", ["base", "tool0", "gripper", "empty"])
def test_urdf_link(tmp_path, link):
    pin = pytest.importorskip("pinocchio")
    exported = put(tmp_path, URDF, "urdf", link)
    assert outline(exported.text, "link", link) == outline(URDF, "link", link)
    assert exported.frame == "sensor"
    assert f"frame of '{link}'" in exported.warnings[0]
    codes = [warning.code for warning in exported.warnings]
    assert ("inertial-replaced" in codes) == (link == "gripper")
    assert ("root-inertial-dropped" in codes) == (link == "base")
    assert ("77" in exported.text) == (link != "gripper")
    model = pin.buildModelFromXML(exported.text)
    body = model.inertias[{"base": 0, "tool0": 1, "gripper": 2, "empty": 4}[link]]
    assert body.mass == 0.932
    np.testing.assert_allclose(body.lever, COM, atol=1e-15)
    # J at the COM came back from J at the origin
    np.testing.assert_allclose(body.inertia, TENSOR, atol=1e-15)
    again = put(tmp_path, exported.text, "urdf", link)
    assert again.text == exported.text
    assert "replaced" in again.warnings[-1]


@pytest.mark.parametrize(
    ("content", "target", "link"),
    [
        (URDF, "urdf", "tool0"),
        (URDF, "urdf", "finger"),
        (MJCF, "mjcf", "outer"),
        (SDF, "sdf", "hand"),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_every_other_byte_is_unchanged(tmp_path, content, target, link, newline):
    content = content.replace("\n", newline)
    text = put(tmp_path, content, target, link).text
    assert newline == "\n" or text.count("\n") == text.count("\r\n")
    start = text.index("<inertial", text.index(f'name="{link}"'))
    end = (
        text.index("</inertial>", start) + 11
        if target != "mjcf"
        else text.index("/>", start) + 2
    )
    before, after = text[:start].rstrip(), text[end:]
    if link == "tool0":  # it was <link name="tool0" />
        assert before.endswith('<link name="tool0">')
        assert after.lstrip().startswith("</link>")
        before, after = before[:-1] + " />", after.lstrip()[len("</link>") :]
    assert before + after == content


def test_mjcf_body(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    for name, index, replaced in (("outer", 1, False), ("inner", 3, True)):
        exported = put(tmp_path, MJCF, "mjcf", name)
        assert outline(exported.text, "body", name) == outline(MJCF, "body", name)
        model = mujoco.MjModel.from_xml_string(exported.text)
        others = {1: mujoco.MjModel.from_xml_string(MJCF).body_mass[1], 2: 3.0, 3: 5.0}
        assert model.body_mass[1:].tolist() == list((others | {index: 0.932}).values())
        np.testing.assert_allclose(model.body_ipos[index], COM, atol=1e-15)
        had = "an inertial" if replaced else "the mass of its 1 geom"
        assert any(f"had {had}: it was replaced" in w for w in exported.warnings)
    # what has no mass is not replaced; a frame only moves what is in it, and
    # <replicate> repeats it
    for geoms, count in (
        ('<geom mass="0.0"/>', 0),
        ("<frame><geom/></frame><geom/>", 2),
        ('<replicate count="4"><geom/><geom/></replicate>', 2),
    ):
        text = MJCF.replace('<geom size="0.1"/>', geoms)
        said = " ".join(put(tmp_path, text, "mjcf", "outer").warnings)
        assert f"its {count} geoms" in said if count else "replaced" not in said
    with pytest.raises(InputError, match="did you mean 'inner'"):
        put(tmp_path, MJCF, "mjcf", "iner")
    ignoring = MJCF.replace(
        "<worldbody>", '<compiler inertiafromgeom="true"/><worldbody>'
    )
    assert any(
        "inertiafromgeom" in w
        for w in put(tmp_path, ignoring, "mjcf", "outer").warnings
    )
    for mass, scales in (("5", True), ("-1", False)):
        scaled = ignoring.replace('inertiafromgeom="true"', f'settotalmass="{mass}"')
        codes = {w.code for w in put(tmp_path, scaled, "mjcf", "outer").warnings}
        assert ("masses-scaled" in codes) == scales
    for bound, raised in (("boundmass='1'", True), ("boundinertia='0.0'", False)):
        text = ignoring.replace('inertiafromgeom="true"', bound)
        exported = put(tmp_path, text, "mjcf", "outer")
        mass = mujoco.MjModel.from_xml_string(exported.text).body_mass[1]
        assert (mass > 0.932) == raised
        assert ("inertials-raised" in {w.code for w in exported.warnings}) is raised


@pytest.mark.parametrize("before", ["", "<geom size='.1'/>"])
@pytest.mark.parametrize(
    "inertial",
    [
        '<inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>',
        "<inertial pos='0 0 0' mass='3' diaginertia='1 1 1'></inertial>",
    ],
)
def test_mjcf_inertial_in_a_frame_is_replaced(tmp_path, before, inertial):
    """A frame moves what it holds: the new inertial is not in one."""
    mujoco = pytest.importorskip("mujoco")
    text = f"""<mujoco><worldbody>
  <body name="tool">{before}<freejoint/>
    <frame pos="0 0 1"><frame euler="90 0 0">
      {inertial}
      <geom size=".1" contype="0"/>
    </frame></frame>
    <frame><body><inertial pos="0 0 0" mass="7" diaginertia="1 1 1"></inertial></body></frame>
  </body>
</worldbody></mujoco>"""
    assert mujoco.MjModel.from_xml_string(text).body_mass[1] == 3.0
    exported = put(tmp_path, text, "mjcf", "tool")
    model = mujoco.MjModel.from_xml_string(exported.text)
    assert model.body_mass.tolist() == [0.0, 0.932, 7.0]
    np.testing.assert_allclose(model.body_ipos[1], COM, atol=1e-15)
    assert any("had an inertial in a <frame>" in w for w in exported.warnings)
    start = exported.text.index("<inertial")
    end = exported.text.index("/>", start) + 2
    rest = exported.text[:start].rstrip() + exported.text[end:]
    assert rest == text.replace("\n      " + inertial, "")
    again = put(tmp_path, exported.text, "mjcf", "tool")
    assert again.text == exported.text
    both = exported.text.replace("<frame pos", f"<frame>{inertial}</frame><frame pos")
    with pytest.raises(InputError, match="'tool' has two inertials; remove one"):
        put(tmp_path, both, "mjcf", "tool")


def test_a_frame_of_another_format_is_no_frame(tmp_path):
    text = SDF.replace("</pose></link>", "</pose><frame><inertial/></frame></link>")
    exported = put(tmp_path, text, "sdf", "hand")
    assert exported.text.count("<inertial") == 2
    assert [w.code for w in exported.warnings] == ["link-frame-assumed"]


@pytest.mark.parametrize(
    ("setting", "code"),
    [
        ('inertiafromgeom="true"', "inertials-ignored"),
        ('boundmass="5"', "inertials-raised"),
        ('boundinertia="1"', "inertials-raised"),
        ('settotalmass="9"', "masses-scaled"),
        ('inertiafromgeom="auto" boundmass="0"', None),
    ],
)
def test_settings_of_mujoco_in_a_urdf_are_told(tmp_path, monkeypatch, setting, code):
    mujoco = pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)  # MuJoCo logs there that a setting is deprecated
    block = f'<mujoco><compiler {setting} fusestatic="false"/></mujoco></robot>'
    shape = "<collision><geometry><box size='.1 .1 .1'/></geometry></collision>"
    text = f"""<robot name="r"><link name="base"/><link name="tool0">{shape}</link>
  <joint name="a" type="continuous"><parent link="base"/><child link="tool0"/></joint>
{block}"""
    exported = put(tmp_path, text, "urdf", "tool0")
    codes = [w.code for w in exported.warnings]
    assert codes == ["link-frame-assumed"] + ([code] if code else [])
    model = mujoco.MjModel.from_xml_string(exported.text)
    as_written = model.body_mass[-1] == pytest.approx(0.932) and np.allclose(
        np.sort(model.body_inertia[-1]), np.linalg.eigvalsh(TENSOR), rtol=1e-6
    )
    assert as_written == (code is None)


def test_the_root_link_of_a_urdf_is_told(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    alone = '<robot name="r"><link name="a"/>{}</robot>'
    above = """<link name="world"/><joint name="j" type="floating">
  <parent link="world"/><child link="a"/></joint>"""
    for more, mass in (("", 0.0), (above, 0.932)):
        exported = put(tmp_path, alone.format(more), "urdf", "a")
        codes = {w.code for w in exported.warnings}
        assert ("root-inertial-dropped" in codes) == (mass == 0.0)
        model = mujoco.MjModel.from_xml_string(exported.text)
        assert sum(model.body_mass) == pytest.approx(mass)


@pytest.mark.parametrize(
    ("target", "content"),
    [
        (
            "urdf",
            '<robot><xacro:macro name="m"><inertial/></xacro:macro><link name="a"><xacro:m/></link></robot>',
        ),
        ("urdf", '<robot><xacro:if value="1"><link name="a"/></xacro:if></robot>'),
        ("sdf", '<sdf><model name="m"><link name="a"/><xacro:m/></model></sdf>'),
    ],
)
def test_xacro_is_refused(tmp_path, target, content):
    """A macro may hold an inertial; a file that has the namespace alone (`URDF`) is
    none."""
    content = content.replace(">", ' xmlns:xacro="x">', 1)
    with pytest.raises(InputError) as caught:
        put(tmp_path, content, target, "a")
    assert f"file.xml: is xacro, not {target.upper()}; expand it first" in str(
        caught.value
    )
    assert f"> robot.{target}" in str(caught.value)


def test_sdf_links_of_one_name_by_their_scopes(tmp_path):
    text = """<sdf version="1.9"><world name="w">
  <model name="a"><link name="link"/><model name="b"><link name="link"/><link name="c"/></model></model>
  <model name="d"><link name="link"/></model></world></sdf>"""
    with pytest.raises(
        InputError,
        match="3 <link> are named 'link'; choose one of: a::link, a::b::link, c, d::link",
    ):
        put(tmp_path, text, "sdf", "link")
    for name, before in (
        ("a::link", 0),
        ("a::b::link", 1),
        ("a::b::c", 2),
        ("c", 2),
        ("d::link", 3),
    ):
        exported = put(tmp_path, text, "sdf", name).text
        assert exported[: exported.index("<inertial")].count("<link") == before + 1
    with pytest.raises(InputError, match="no <link> is named 'b::link'"):
        put(tmp_path, text, "sdf", "b::link")


def test_long_names_of_nested_scopes_are_refused(tmp_path):
    """The names of 3,000 links with those of their scopes took 8 GB."""
    models = "".join(f'<model name="{99 * "m"}"><link name="a"/>' for _ in range(11))
    text = f"<sdf>{models}{11 * '</model>'}</sdf>"
    with pytest.raises(InputError, match="names of more than 1,000 characters"):
        put(tmp_path, text, "sdf", "b")


def test_sdf_link_in_flange_axes(tmp_path):
    pose = np.eye(4)
    pose[2, 3] = 1.0
    exported = put(tmp_path, SDF, "sdf", "hand", sensor_pose_in_flange=pose)
    assert outline(exported.text, "link", "hand") == outline(SDF, "link", "hand")
    found = (
        ElementTree.fromstring(exported.text).findtext("world/model/link/inertial/pose")
        or ""
    ).split()
    np.testing.assert_allclose(
        [float(v) for v in found], (0.01, -0.02, 1.05, 0, 0, 0), atol=1e-15
    )
    assert exported.frame == "flange"
    assert "flange frame" in exported.warnings[0]


def test_byte_order_mark_and_long_attributes(tmp_path):
    long = f'\ufeff<?xml version="1.0"?>\n<robot><link name="tool0" note="{"a>" * 10**6}"/></robot>\n'
    text = put(tmp_path, long, "urdf", "tool0").text
    assert text.startswith("\ufeff<?xml")
    assert text.count("<inertial>") == 1
    ElementTree.fromstring(text.encode())


def test_unknown_link_names_the_nearest_and_the_valid(tmp_path):
    with pytest.raises(
        InputError,
        match=r"no <link> is named 'griper'.*'gripper'.*base, tool0, gripper",
    ):
        put(tmp_path, URDF, "urdf", "griper")
    with pytest.raises(InputError, match=r"which <link>.*choose one of: base, tool0"):
        put(tmp_path, URDF, "urdf", None)
    with pytest.raises(InputError, match=r"2 <link> are named 'tool0'; give each a"):
        put(tmp_path, URDF.replace('name="base"', 'name="tool0"'), "urdf", "tool0")
    with pytest.raises(InputError, match="two inertials"):
        put(
            tmp_path,
            '<robot><link name="a"><inertial/><inertial/></link></robot>',
            "urdf",
            "a",
        )


BOMB = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;">]>\n<robot name="&b;"><link name="tool0"/></robot>'
EXTERNAL = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]>\n<robot><link name="tool0">&x;</link></robot>'


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (BOMB, "document type"),
        (EXTERNAL, "document type"),
        ('<!DOCTYPE robot SYSTEM "http://example.org/r.dtd"><robot/>', "document type"),
        ('<robot><link name="tool0"></robot>', "not well-formed"),
        ('<robot><link name="tool0">&b;</link></robot>', "not well-formed"),
        ("", "not well-formed"),
        ("<sdf/>", "is not URDF: its root is <sdf>"),
        ('<robot><link name="\xff"/></robot>'.encode("latin-1"), "not UTF-8"),
        ('<robot><link name="a"/></robot>'.encode("utf-16"), "not UTF-8"),
        (b"<robot>" + b" " * MAX_XML + b"</robot>", "larger than"),
        ("<robot/>", "no <link> is named 'tool0'; the file has no <link>"),
    ],
)
def test_hostile_and_broken_files(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        put(tmp_path, content, "urdf", "tool0")
    assert "file.xml" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("own", ["", '<worldbody><body name="table"/></worldbody>'])
def test_a_scene_that_includes_others_says_where_to_look(tmp_path, own):
    scene = f'<mujoco><include file="arm.xml"/>{own}</mujoco>'
    with pytest.raises(InputError, match=r"or give the file .* includes arm\.xml"):
        put(tmp_path, scene, "mjcf", "hand")


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        export(ESTIMATE, "urdf", into=tmp_path / "none.urdf", link="a")
