"""Player: a recording as one page that plays without a server. Needs viser."""

from html import escape

from hefting.viewer.text import answer_html, legend_html
from hefting.viewer.viewer import Viewer

POSES_A_SECOND = 2.0
"""Of a recording of static poses."""
PAUSE = 1.0
"""[s] at the end."""
STYLE = """<style>
#hefting{position:fixed;right:0.6em;top:0.6em;z-index:5;max-width:min(24em,92vw);
max-height:45vh;overflow:auto;font:13px/1.35 system-ui,sans-serif;border-radius:6px;
background:rgba(255,255,255,0.88);color:#222;box-shadow:0 1px 4px rgba(0,0,0,0.25)}
#hefting summary{padding:0.4em 0.8em;cursor:pointer;font-weight:700}
@media (prefers-color-scheme:dark){#hefting{background:rgba(30,32,36,0.9);color:#ddd}}
@media (max-width:600px){#hefting{font-size:11px;max-height:34vh}}
</style>"""
SCHEME = (
    "window.__VISER_EMBED_CONFIG__="
    "{darkMode:matchMedia('(prefers-color-scheme: dark)').matches};"
)
"""Lets the page follow the reader's colour scheme."""


def player_of(viewer: Viewer, title: str) -> str:
    """The page: the whole recording, played with the answer that is shown now.

    It holds all it needs, and asks for nothing. `title` is escaped.
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
    viewer.show_frame(0)  # what was recorded first shares memory with what is shown
    return dressed(recorded.as_html(), title, _answer(viewer))


def _answer(viewer: Viewer) -> str:
    """The answer and the legend."""
    playback, answer = viewer.playback, viewer.answer
    used = f"all of {float(playback.times[-1]):.2f} s"
    if playback.static:
        used = f"all of {len(playback)} poses"
    force, torque = (float(x) for x in playback.largest)
    legend = legend_html(answer, viewer.drawing.size, (force, torque))
    text = answer_html(answer, used, playback.static, viewer.say)
    return f"{text}<details><summary>what is drawn</summary>{legend}</details>"


def dressed(page: str, title: str, inside: str) -> str:
    """viser's page with a title, which is escaped, and a box that has HTML inside."""
    box = (
        f'<details id="hefting" open><summary>{escape(title)}</summary>'
        f"{inside}</details>"
    )
    page = page.replace("<title>Viser</title>", f"<title>{escape(title)}</title>", 1)
    page = page.replace("window.__VISER_EMBED_CONFIG__={darkMode:false};", SCHEME, 1)
    head, body = page.rsplit("</head>", 1)
    before, after = body.rsplit("</body>", 1)
    return f"{head}{STYLE}</head>{before}{box}</body>{after}"
