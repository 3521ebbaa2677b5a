"""What the viewer draws and says, as its server holds it: the library's own scene and
numbers, following the controls."""

import socket
from dataclasses import replace
from html import escape
from unittest.mock import Mock
from urllib.request import urlopen

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.messages import warning
from hefting.identification import identify
from hefting.robots import Arm
from hefting.scene import Scene, headline_of, scene_of, surface_of
from hefting.shapes import Shape
from hefting.viewer import Settings
from hefting.viewer.drawing import (
    MOST_REACH,
    ObjectDrawing,
    axes_length,
    letter,
    size_of,
)
from hefting.viewer.motion import arrow
from hefting.viewer.panel import answer_html, legend_html
from hefting.viewer.server import Follower, address_of, serving
from hefting.viewer.viewer import Viewer
from urdfs import LINKS
from viewing import HOSTILE, POSE, held, recorded, shape, viewed, write_arm

pytest.importorskip("viser")
SINGLE = 1e-6
"""[m] Vertices are sent in single precision: 6e-8 of a metre."""


@pytest.fixture(scope="module")
def server():
    with serving() as server:
        yield server


@pytest.fixture(scope="module")
def viewer(server, tmp_path_factory):
    """On the arm, with the truth."""
    truth = held().parameters.moved(POSE)
    session, playback, recording = viewed(truth=truth)
    urdf = write_arm(tmp_path_factory.mktemp("arm"))
    viewer = Viewer(server, session, playback, Arm.from_urdf(urdf, "tool0", recording))
    viewer.truth = truth
    yield viewer
    viewer.close()


def node(viewer, name):
    return viewer.drawing._nodes[name]


def wanted(viewer, **values):
    """Set controls, and wait for what they want."""
    for name, value in values.items():
        getattr(viewer.controls, name).value = value
    viewer.follow()
    assert viewer.settle()


def ellipsoid_of(mesh, ellipsoid):
    """Distance of vertices from the surface of an ellipsoid, in half-axes."""
    inside = np.linalg.solve(ellipsoid.half_axes, (mesh - ellipsoid.center).T)
    return np.linalg.norm(inside, axis=0) - 1.0


@pytest.mark.parametrize(
    ("method", "time"), [("Bayes", 4.99), ("PMD", 1.3), ("OLS", 2.6), ("GEO", 4.99)]
)
def test_object_and_numbers_are_those_of_the_estimate_up_to_the_instant(
    viewer, method, time
):
    wanted(viewer, method=method, time=time)
    instant = viewer.playback.found.measurements.time[0] + time
    expected = viewer.session.estimate(instant, viewer.controls.settings)
    shown = viewer.answer.estimate
    np.testing.assert_array_equal(shown.parameters.vector, expected.parameters.vector)
    for number in headline_of(expected).numbers:
        assert escape(number) in viewer.text.content
    assert f"verdict: {expected.verdict}" in viewer.text.content
    (body,) = scene_of({"estimate": expected}).bodies
    center = node(viewer, "estimate/com")
    np.testing.assert_allclose(center.position, body.center, rtol=0.0, atol=1e-12)
    for part, ellipsoid in (("region", body.region), ("inertia", body.ellipsoid)):
        size = viewer.drawing.size
        small = ellipsoid is not None
        small = small and (
            part == "inertia" or ellipsoid.reach.max() <= MOST_REACH * size
        )
        if small:
            mesh = node(viewer, f"estimate/{part}")
            assert mesh.visible
            off = ellipsoid_of(mesh.vertices, ellipsoid)
            thinnest = np.linalg.norm(ellipsoid.half_axes, axis=0).min()
            np.testing.assert_allclose(off, 0.0, atol=SINGLE / thinnest)
        elif f"estimate/{part}" in viewer.drawing._nodes:
            assert not node(viewer, f"estimate/{part}").visible
    if shown.point_masses is not None:
        assert len(node(viewer, "masses").colors) == len(shown.point_masses)


def test_the_legend_names_the_ellipsoid_only_where_it_is_drawn(viewer):
    """Not for that of the truth, which has a line of its own."""
    answer = viewer.session.answer(1.0, Settings("Bayes"))
    for without in (False, True):
        body = replace(answer.scene.bodies[-1], ellipsoid=None)
        bodies = (*answer.scene.bodies[:-1], body) if without else answer.scene.bodies
        shown = replace(answer, scene=replace(answer.scene, bodies=bodies))
        assert ("of equal inertia" in legend_html(shown, 0.1, np.ones(2))) != without


def test_controls_of_a_method_reach_its_estimate(viewer):
    end = float(viewer.controls.time.max)
    wanted(viewer, method="PMD", time=end)
    assert viewer.controls.numbers["c1"].value == 1.0  # of smoothed poses
    assert viewer.controls.numbers["regularization"].value == 0.1
    viewer.controls.numbers["c1"].value = 40.0
    viewer.controls.numbers["regularization"].value = 0.5
    wanted(viewer)
    whole = identify(recorded(), shape(), method="PMD", c1=40.0, regularization=0.5)
    shown = viewer.answer.estimate
    scale = np.abs(whole.estimate.parameters.vector).max()
    np.testing.assert_allclose(
        shown.parameters.vector,
        whole.estimate.parameters.vector,
        rtol=0.0,
        atol=1e-9 * scale,
    )
    wanted(viewer, method="Bayes", pose_known=True, pose_mm=20.0, pose_degrees=30.0)
    assert viewer.controls.settings == Settings(
        "Bayes", {"pose_std": (0.02, np.radians(30.0))}
    )
    unsure = viewer.answer.estimate.half_widths["mass"]
    wanted(viewer, pose_known=False)
    assert viewer.answer.estimate.half_widths["mass"] < unsure


def test_controls_are_there_for_methods_that_have_them(viewer):
    seen = {}
    for method in ("Bayes", "PMD", "OLS"):
        wanted(viewer, method=method)
        controls = viewer.controls
        seen[method] = (
            controls.pose_known.visible,
            controls.numbers["c1"].visible,
            controls.numbers["regularization"].visible,
        )
    assert seen == {
        "Bayes": (True, False, False),
        "PMD": (False, True, True),
        "OLS": (False, False, False),
    }


def test_sensor_arm_and_arrows_move_with_the_recording(viewer):
    wanted(viewer, method="OLS", time=2.0)
    index = viewer.playback.nearest(2.0)
    frame, playback = viewer.playback[index], viewer.playback
    np.testing.assert_array_equal(viewer.sensor.position, frame.position)
    np.testing.assert_array_equal(viewer.sensor.wxyz[1:], frame.orientation[:3])
    tool = next(i for i, k in enumerate(viewer.arm.arm.links) if k.name == "tool0")
    # joint angles and poses of the sensor are recorded at the same times; the poses
    # have noise of 0.1 mm
    at = viewer.arm.frames[tool].position
    np.testing.assert_allclose(at, frame.position, atol=1e-3)
    estimate = viewer.answer.estimate
    wrenches = {
        "measured": frame.measured - playback.bias(estimate),
        "predicted": playback.predicted(estimate, frame.sample),
    }
    for name, arrows in viewer.arrows.nodes.items():
        part, kind = name.split(", ")
        i = ("force", "torque").index(part)
        tail, tip = arrows.points[0]
        expected = viewer.arrows.scales[i] * wrenches[kind][3 * i : 3 * i + 3]
        np.testing.assert_allclose(tip - tail, expected, atol=SINGLE)
        assert arrows.visible


def test_what_is_open_or_not_ticked_is_not_drawn(viewer):
    wanted(viewer, method="OLS", time=4.99)
    assert node(viewer, "estimate/inertia").visible
    viewer.boxes["inertia"].value = False
    assert not node(viewer, "estimate/inertia").visible
    assert not node(viewer, "truth/truth/inertia").visible
    viewer.boxes["inertia"].value = True
    assert node(viewer, "truth/truth/inertia").visible
    wanted(viewer, time=0.0)  # one sample tells nothing of the inertia
    assert not node(viewer, "estimate/inertia").visible
    viewer.boxes["wrench"].value = False
    assert not any(arrows.visible for arrows in viewer.arrows.nodes.values())
    viewer.boxes["wrench"].value = True


def test_the_truth_is_a_ghost(viewer):
    ellipsoid = scene_of(known={"truth": viewer.truth}).bodies[0].ellipsoid
    ghost = node(viewer, "truth/truth/inertia")
    np.testing.assert_allclose(ellipsoid_of(ghost.vertices, ellipsoid), 0.0, atol=1e-4)
    assert ghost.opacity < 0.5


def test_links_have_their_mesh_or_a_line(viewer, tmp_path):
    arm = viewer.arm
    meshes = [link.name for link in arm.arm.links if link.geometries]
    assert meshes == ["forearm"]
    bare = [arm.arm.links[i].name for i in arm._bare]
    # no line along the forearm, from its joint to that of the first wrist
    assert bare == [n for n in LINKS if n not in ("base", "wrist_1")]
    index = viewer.playback.nearest(float(viewer.controls.time.value))
    ends = arm.position[index][arm._bare]
    viewer.show_frame(index)
    np.testing.assert_allclose(arm.lines.points[:, 1], ends, atol=SINGLE)


def test_playing_moves_on_and_pauses(viewer):
    wanted(viewer, method="OLS", time=0.5)
    viewer.toggle()
    assert viewer.controls.play.label == "Pause"
    assert viewer._closed.wait(0.5) is False
    viewer.toggle()
    now = viewer.controls.time.value
    assert 0.5 < now < 4.0
    assert viewer._closed.wait(0.2) is False
    assert viewer.controls.time.value <= now + 0.2  # a tick may have been on its way


def test_a_box_is_drawn_by_its_edges_without_diagonals():
    api, sides = Mock(), (0.1, 0.2, 0.4)
    box = Shape.from_box(0.0, sides[0], 0.0, sides[1], 0.0, sides[2])
    ObjectDrawing(api, Scene(surface=surface_of(box)))
    (edges,) = (
        call.args[1]
        for call in api.add_line_segments.call_args_list
        if call.args[0].endswith("/shape")
    )
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    np.testing.assert_allclose(np.sort(lengths), np.repeat(sides, 4))
    assert not api.add_mesh_simple.called


def test_each_reason_for_doubt_is_told_apart_from_the_next(viewer):
    doubts = (warning("unexplained", "one"), warning("saturated", "another"))
    estimate = replace(viewer.answer.estimate, warnings=doubts)
    page = answer_html(replace(viewer.answer, estimate=estimate), "all", False)
    assert ">- one<" in page
    assert ">- another<" in page


def test_text_of_files_is_escaped(viewer):
    session = viewed(given={HOSTILE: viewer.answer.estimate})[0]
    answer = session.answer(1.0, Settings(HOSTILE))
    page = answer_html(answer, HOSTILE, False, lambda text: text + HOSTILE)
    assert escape(HOSTILE) in page
    assert "<img" not in page


def test_it_listens_on_this_machine_alone_and_lets_go_of_the_port():
    with serving() as server:
        port = server.get_port()
        assert address_of(server) == f"http://127.0.0.1:{port}"
        # read to its end, as the server must not be stopped while it accepts
        with urlopen(address_of(server), timeout=60.0) as page:
            assert page.read()
        # another address of this machine, that 0.0.0.0 would listen at as well
        with pytest.raises(OSError, match=r".*"):
            socket.create_connection(("127.0.0.2", port), timeout=5.0)
    with socket.create_server(("127.0.0.1", port)):
        pass


def test_a_port_in_use_and_a_host_elsewhere_are_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with (
            pytest.raises(InputError, match=f"cannot listen at 127.0.0.1, port {port}"),
            serving(port=port),
        ):
            pass
    for host, wrong in (("192.0.2.1", 0), ("x" * 300, 0), ("127.0.0.1", 70_000)):
        with pytest.raises(InputError), serving(host, wrong):
            pass


def test_no_page_can_ask_for_a_tunnel(server):
    from viser import _messages

    handlers = server._websock_server._incoming_handlers
    assert _messages.GuiUpdateMessage in handlers  # the check itself
    assert _messages.ShareUrlRequest not in handlers


def test_a_follower_ends_with_what_was_wanted_last():
    seen, failed = [], []

    def work(what):
        if what == 13:
            raise ValueError("unlucky")
        seen.append(what)

    follower = Follower(work, failed.append)
    for k in (13, *range(100, 200)):
        follower.want(k)
    assert follower.settle()
    assert seen[-1] == 199
    follower.want(13)
    assert follower.settle()
    assert [str(error) for error in failed][-1] == "unlucky"
    follower.close()


@pytest.mark.parametrize("size", [0.05, 0.13, 1.0, 7.0])
def test_axes_have_a_round_length_that_suits_the_scene(size):
    length = axes_length(size)
    assert 0.2 * size <= length <= 0.5 * size
    digits = f"{length:.0e}"
    assert digits[0] in "125"
    assert float(digits) == pytest.approx(length)  # no more than one digit
    assert np.abs(letter("y", length)[..., 1].min() - length) < 0.2 * length


def test_an_arrow_is_beside_its_vector():
    vector = np.array((0.0, 0.0, -3.0))
    tail, tip = arrow(vector, 0.1, 0.02)
    np.testing.assert_allclose(tip - tail, 0.1 * vector, atol=1e-15)
    assert np.linalg.norm(tail) == pytest.approx(0.02)
    assert abs(tail @ vector) < 1e-15


def test_an_empty_scene_has_a_size():
    assert size_of(scene_of()) == 0.05


@pytest.mark.parametrize(
    ("origin", "welcome"),
    [
        (None, True),
        ("http://127.0.0.1:{port}", True),
        ("http://localhost:{port}", True),
        ("https://elsewhere.example", False),
        ("http://127.0.0.1.elsewhere.example", False),
    ],
)
def test_pages_of_other_sites_do_not_reach_it(origin, welcome):
    from websockets.exceptions import ConnectionClosed, InvalidStatus
    from websockets.sync.client import connect

    with serving() as server:
        port = server.get_port()
        address = f"ws://127.0.0.1:{port}"
        said = origin and origin.format(port=port)
        if welcome:
            # let in, and sent away as it does not say viser's version; waited for, as
            # the server must not end before
            with (
                connect(address, origin=said, open_timeout=60) as connection,
                pytest.raises(ConnectionClosed),
            ):
                connection.recv(timeout=60)
        else:
            with pytest.raises(InvalidStatus, match="403"):
                connect(address, origin=said, open_timeout=60)
