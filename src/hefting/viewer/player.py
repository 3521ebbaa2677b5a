"""Players: a recording or a planned motion as one page that plays without a server. Needs
viser."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array
from hefting.logs.given import as_recording
from hefting.planning.result import Plan, speed_text
from hefting.robots import Arm, Robot
from hefting.viewer.drawing import COM, EDGES, GREY, rgb
from hefting.viewer.motion import ArmDrawing
from hefting.viewer.panel import answer_html, legend_html
from hefting.viewer.server import serving
from hefting.viewer.viewer import FROM, Viewer

if TYPE_CHECKING:
    from viser import ViserServer

POSES_A_SECOND = 2.0
"""[1/s] Pace of a recording of static poses."""
PAUSE = 1.0
"""[s] Pause at the end."""
STYLE = """<style>
#hefting{position:fixed;right:0.6em;top:0.6em;z-index:5;max-width:min(24em,92vw);
max-height:45vh;overflow:auto;font:13px/1.35 system-ui,sans-serif;border-radius:6px;
background:rgba(255,255,255,0.88);color:#222;box-shadow:0 1px 4px rgba(0,0,0,0.25)}
#hefting summary{padding:0.4em 0.8em;cursor:pointer;font-weight:700}
@media (prefers-color-scheme:dark){#hefting{background:rgba(30,32,36,0.9);color:#ddd}}
@media (max-width:600px){#hefting{font-size:11px;max-height:34vh}}
.mantine-Select-wrapper{width:4.5em!important}
</style>"""
FOLDED = "<script>if(innerWidth<=600)hefting.open=false</script>"
"""Closes the box on a phone, where it would hide the object."""
SCHEME = "window.__VISER_EMBED_CONFIG__={darkMode:matchMedia('(prefers-color-scheme: dark)').matches};"
"""Makes the page follow the reader's colour scheme."""
RATE = 20.0
"""[Hz] Rate of the frames."""
THIN, THICK = 0.004, 0.008
"""[m] Thickness of the lines of the path and of the box."""


def player_of(viewer: Viewer, title: str) -> str:
    """A page that plays the whole recording with the answer that the viewer now shows.

    It is complete and makes no requests. `title` is escaped.
    """
    playback = viewer.playback
    viewer.show_frame(0)
    recorded = viewer.server.get_scene_serializer()
    steps = playback.times[1:] - playback.times[:-1]
    pace = POSES_A_SECOND if playback.static else 1.0
    for index, step in enumerate(steps, start=1):
        recorded.insert_sleep(float(step) / pace)
        viewer.show_frame(index)
    recorded.insert_sleep(PAUSE)
    viewer.show_frame(0)  # the recorded first frame shares memory with the shown one
    return dressed(recorded.as_html(), title, _answer(viewer))


def _answer(viewer: Viewer) -> str:
    playback, answer = viewer.playback, viewer.answer
    used = f"all of {float(playback.times[-1]):.2f} s"
    if playback.static:
        used = f"all of {len(playback)} poses"
    legend = legend_html(answer, viewer.drawing.size, playback.largest)
    text = answer_html(answer, used, playback.static, viewer.say)
    return f"{text}<details><summary>what is drawn</summary>{legend}</details>"


def dressed(page: str, title: str, inside: str) -> str:
    """viser's page with a title, which is escaped, and a box with HTML `inside`."""
    box = (
        f'<details id="hefting" open><summary>{escape(title)}</summary>'
        f"{inside}</details>"
    )
    page = page.replace("<title>Viser</title>", f"<title>{escape(title)}</title>", 1)
    page = page.replace("window.__VISER_EMBED_CONFIG__={darkMode:false};", SCHEME, 1)
    head, body = page.rsplit("</head>", 1)
    before, after = body.rsplit("</body>", 1)
    return f"{head}{STYLE}</head>{before}{box}{FOLDED}</body>{after}"


def plan_player(plan: Plan) -> str:
    """A page that plays the plan's arm, read from `Plan.source`, along the motion, with
    the box of the object and the path of the tip.

    Raises `InputError` if the robot cannot be read, `MissingDependencyError` without
    viser.
    """
    count = max(round(plan.duration * RATE), 1)
    motion = plan.at(np.linspace(0.0, plan.duration, count + 1))
    columns = {f"q{i + 1}": q for i, q in enumerate(motion.position.T)}
    recording = as_recording({"time": motion.time} | columns, wrench_needed=False)
    arm = Arm.from_urdf(plan.source, plan.tip, recording)
    place, turn = Robot.from_urdf(plan.source, plan.tip).poses(motion.position)
    with serving() as server:
        links = ArmDrawing(server.scene, arm, motion.position)
        tip = _draw(server, plan, place)
        _aim(server, np.vstack((place, links.position.reshape(-1, 3))))

        def show(k: int) -> None:
            links.show(k)
            tip.position, tip.wxyz = place[k], turn[k, [3, 0, 1, 2]]

        show(0)
        recorded = server.get_scene_serializer()
        for k in range(1, len(motion.time)):
            recorded.insert_sleep(plan.duration / count)
            show(k)
        recorded.insert_sleep(PAUSE)
        show(0)
        page = recorded.as_html()
    title = f"{Path(plan.source).name}: planned motion - Hefting"
    return dressed(page, title, _text(plan))


def _draw(server: "ViserServer", plan: Plan, place: Array) -> Any:
    api = server.scene
    path = np.stack((place[:-1], place[1:]), axis=1).astype(np.float32)
    api.add_line_segments("/path", path, rgb(GREY), thickness=THIN)
    tip = api.add_frame("/tip", axes_length=0.06, axes_radius=0.002)
    if len(box := plan.corners[-8:]) == 8:
        edges = np.asarray(box, dtype=np.float32)[list(EDGES)]
        api.add_line_segments("/tip/box", edges, rgb(COM), thickness=THICK)
    return tip


def _aim(server: "ViserServer", points: Array) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    middle, reach = 0.5 * (low + high), float(np.linalg.norm(high - low))
    server.scene.set_up_direction("+z")
    camera = server.initial_camera
    camera.look_at = middle
    camera.position = middle + 1.3 * reach * FROM / np.linalg.norm(FROM)


def _text(plan: Plan) -> str:
    after = str(plan.forecast.accuracy[-1]).replace(",", ", ")
    lines = [
        f"{plan.duration:.4g} s; the corners of the orange box keep "
        f"{speed_text(plan.limits.corner_speed)}",
        f"expected after it, ± 95 %: {after}",
    ]
    return "".join(f"<p style='margin:0.4em 0.8em'>{escape(x)}</p>" for x in lines)
