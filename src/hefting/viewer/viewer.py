"""Viewer: scene, controls and answer in a browser, which follow each other. Needs
viser."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array
from hefting.robots import Arm
from hefting.viewer import Answer, Playback, Session, Settings
from hefting.viewer.drawing import GREY, ObjectDrawing, rgb
from hefting.viewer.motion import ArmDrawing, WrenchArrows, WrenchPlots
from hefting.viewer.panel import Controls, answer_html, legend_html
from hefting.viewer.server import Follower

if TYPE_CHECKING:
    from viser import ViserServer

FIELD_OF_VIEW = np.radians(45.0)
FROM = np.array((1.0, -1.3, 0.6))
"""Initial direction to the camera: to the right, the front, and above."""
ABOVE_PANEL = 0.17
"""Distance by which the camera looks below the object in a narrow window, whose lower
part holds the panel, over the camera's distance."""
TICK = 0.05
"""[s] Interval of frames while playing."""
SHOWN = ("shape", "masses", "region", "inertia", "truth", "wrench")
"""Parts that can be hidden."""


class Viewer:
    """The page of a session, with the arm at the recorded joint positions and initial
    `settings`, by default those of the session. `say` turns names of arguments in
    backquotes into the reader's."""

    def __init__(
        self,
        server: "ViserServer",
        session: Session,
        playback: Playback,
        arm: Arm | None = None,
        settings: Settings | None = None,
        say: Callable[[str], str] = str,
    ):
        self.server, self.session, self.playback = server, session, playback
        self._lock = threading.RLock()
        settings = session.default if settings is None else settings
        self.say = say
        first = session.answer(float(playback.instants[-1]), settings)
        self.answer: Answer = first
        """The answer that is shown."""
        gravity = session.found.conditioned.gravity
        server.scene.set_up_direction(-gravity / np.linalg.norm(gravity))
        self.drawing = ObjectDrawing(server.scene, first.scene)
        self.arrows = WrenchArrows(server.scene, playback, self.drawing.size)
        joints = playback.at("joint_positions")
        self.arm: ArmDrawing | None = None
        if arm is not None and joints is not None:
            self.arm = ArmDrawing(server.scene, arm, joints)
        self._draw_path()
        self._aim()
        self._make_panel(settings, first)
        self._playing = threading.Event()
        self._closed = threading.Event()
        self._follower: Follower[tuple[float, Settings]] = Follower(
            lambda wanted: self.show(*wanted), self._fail
        )
        self._player = threading.Thread(target=self._play, daemon=True)
        self._player.start()
        self.show(float(playback.times[-1]), settings)

    def _make_panel(self, settings: Settings, first: Answer) -> None:
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label("Hefting")
        self.text = gui.add_html("")
        self.controls = Controls(
            self.server, self.session, self.playback, settings, self.follow
        )
        self.controls.play.on_click(lambda _: self.toggle())
        with gui.add_folder("Wrench on the object", expand_by_default=True):
            self.plots = WrenchPlots(gui, self.playback)
        with gui.add_folder("Shown", expand_by_default=True):
            self.legend = gui.add_html(self._legend(first))
            self.boxes = {name: gui.add_checkbox(name, True) for name in SHOWN}
            dark = gui.add_checkbox("dark", False)
        for box in self.boxes.values():
            box.on_update(lambda _: self._hide())
        dark.on_update(
            lambda _: gui.configure_theme(
                show_logo=False, show_share_button=False, dark_mode=bool(dark.value)
            )
        )

    def follow(self) -> None:
        """Show the instant and settings of the controls, soon and in another thread."""
        self._follower.want((self.controls.chosen_time, self.controls.settings))

    def settle(self) -> bool:
        """Wait until the instant and settings of the controls are shown; whether so."""
        return self._follower.settle()

    def show(self, time: float, settings: Settings) -> None:
        """Show the answer up to a time, one like those of `Playback.times`, and the
        nearest frame."""
        answer = self.session.answer(self.playback.instant(time), settings)
        index = self.playback.nearest(time)
        with self._lock, self.server.atomic():
            self.answer = answer
            self.show_frame(index)
            self.drawing.show(answer.scene)
            self.text.content = answer_html(
                answer, self._used(time), self.playback.static, self.say
            )
            self.plots.show(index, answer.estimate)
            self.legend.content = self._legend(answer)

    def show_frame(self, index: int) -> None:
        """Move sensor, arm and arrows to a frame of the playback."""
        frame = self.playback[index]
        self.sensor.position = frame.position
        self.sensor.wxyz = frame.orientation[[3, 0, 1, 2]]
        self.arrows.show(frame, self.answer.estimate)
        if self.arm is not None:
            self.arm.show(index)

    def toggle(self) -> None:
        """Play, or pause."""
        if self._playing.is_set():
            self._playing.clear()
            self.controls.play.label = "Play"
        else:
            self._playing.set()
            self.controls.play.label = "Pause"

    def close(self) -> None:
        """End the threads."""
        self._closed.set()
        self._playing.set()
        self._follower.close()
        self._player.join(timeout=5.0)

    @property
    def sensor(self) -> Any:
        """The node of the sensor's frame."""
        return self.drawing.sensor

    def _fail(self, error: Exception) -> None:
        refused = Answer(None, self.session.scene(None), str(error))
        with self._lock:
            self.text.content = answer_html(refused, "", False, self.say)

    def _play(self) -> None:
        times = self.playback.times
        pace = 2.0 if self.playback.static else 1.0  # poses a second
        while not self._closed.is_set():
            self._playing.wait()
            began = time.monotonic()
            if self._closed.wait(TICK):
                return
            slider = self.controls.time
            last = float(times[-1])
            passed = pace * (time.monotonic() - began)
            now = float(slider.value) + passed
            slider.value = float(times[0]) if now > last else now

    def _legend(self, answer: Answer) -> str:
        return legend_html(answer, self.drawing.size, self.playback.largest)

    def _used(self, time: float) -> str:
        if self.playback.static:
            return f"poses up to {time:g}"
        return f"first {time:.2f} of {float(self.playback.times[-1]):.2f} s"

    def _hide(self) -> None:
        with self._lock:
            hidden = {name for name, box in self.boxes.items() if not box.value}
            self.arrows.hidden = "wrench" in hidden
            self.drawing.hide(hidden)
            index = self.playback.nearest(self.controls.chosen_time)
            self.arrows.show(self.playback[index], self.answer.estimate)

    def _draw_path(self) -> None:
        path = self.playback.poses[0]
        if len(path) > 1 and np.ptp(path, axis=0).max() > 0.0:
            self.server.scene.add_line_segments(
                "/path",
                np.stack((path[:-1], path[1:]), axis=1),
                rgb(GREY),
                thickness=1.5,
                thickness_units="screen",
            )

    def _aim(self) -> None:
        low, high = self._extent()
        middle, radius = 0.5 * (low + high), 0.55 * float(np.max(high - low))
        up = -self.session.found.conditioned.gravity
        up = up / np.linalg.norm(up)
        aside = np.cross(up, (0.0, 1.0, 0.0) if abs(up[1]) < 0.9 else (0.0, 0.0, 1.0))
        aside = -aside / np.linalg.norm(aside)
        front = np.cross(up, aside)
        toward = FROM @ np.array((aside, front, up))
        distance = radius / np.sin(0.5 * FIELD_OF_VIEW)
        toward = distance * toward / np.linalg.norm(toward)
        camera = self.server.initial_camera
        camera.fov = float(FIELD_OF_VIEW)
        camera.look_at = middle
        camera.position = middle + toward
        camera.near = 1e-3 * distance

        @self.server.on_client_connect
        def _(client: Any) -> None:
            narrow = min(float(client.camera.aspect), 1.0)
            if narrow < 1.0:  # a phone held upright sees less to the sides
                lower = middle - ABOVE_PANEL * np.linalg.norm(toward) / narrow * up
                with client.atomic():
                    client.camera.position = lower + toward / narrow
                    client.camera.look_at = lower  # the position had moved it

    def _extent(self) -> tuple[Array, Array]:
        """Lowest and highest corner (3,) [m] of the path with the object, and the arm."""
        path, size = self.playback.poses[0], self.drawing.size
        low, high = path.min(axis=0) - 0.7 * size, path.max(axis=0) + 0.7 * size
        if self.arm is not None:
            points = self.arm.position.reshape(-1, 3)
            low = np.minimum(low, points.min(axis=0))
            high = np.maximum(high, points.max(axis=0))
        return low, high
