"""hefting view: see object, wrench and arm along a recording, in a browser."""

import argparse
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import render
from hefting.cli.identify import add_hyperparameters, add_reading
from hefting.cli.options import (
    add_mass,
    add_recording,
    add_shape,
    add_shape_details,
    add_tool,
    check_output,
    read_recording,
)
from hefting.cli.outputs import open_page
from hefting.cli.parser import wrote
from hefting.cli.progress import progress
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.request.settings import (
    hyperparameters_of,
    refuse_given,
    require_shape,
    shape_of,
)

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.recording import Recording
    from hefting.viewer import Playback, Session, Settings
    from hefting.viewer.viewer import Viewer

HERE = "127.0.0.1"
"""Address that only this machine reaches."""
EXAMPLES = (
    "hefting view log.csv --shape mug.stl --object-pose 0,0,0.1,0,0,0,1",
    "hefting view log.bag --urdf robot.urdf --sensor-frame tool0",
    "hefting view log.csv --box 0.1,0.2,0.3 --save player.html",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting view``."""
    from hefting.estimators import default_method

    add_shape(parser)
    add_tool(parser)
    parser.add_argument(
        "--method",
        metavar="NAME",
        help=f"at first; see hefting methods; default {default_method(True)}",
    )
    add_mass(parser)
    parser.add_argument(
        "--estimate", metavar="FILE", help="show this estimate as well (JSON)"
    )
    parser.add_argument(
        "--truth",
        metavar="FILE",
        help="show true parameters, or another estimate, as a ghost (JSON)",
    )
    parser.add_argument(
        "--save",
        metavar="FILE.html",
        help="write one page that plays the recording without a server, and end",
    )
    place = parser.add_argument_group("where the viewer is")
    place.add_argument(
        "--host",
        metavar="ADDRESS",
        help=f"listen there; default {HERE}, which only this machine reaches. "
        "Whoever reaches another address can see and control the viewer",
    )
    place.add_argument("--port", type=int, metavar="N", help="default any that is free")
    place.add_argument(
        "--no-browser", action="store_true", help="do not open a browser"
    )
    add_shape_details(parser.add_argument_group("more on the object's shape"))
    add_reading(add_recording(parser, what="recording to see"))
    add_hyperparameters(parser.add_argument_group("methods"))
    parser.set_defaults(until=None)


def run(arguments: argparse.Namespace) -> None:
    """Show the viewer until Ctrl-C, or write the player."""
    from hefting.robots import Arm
    from hefting.viewer.server import address_of, serving
    from hefting.viewer.viewer import Viewer

    a = arguments
    require_shape(a)
    _check_output(a)
    with serving(a.host or HERE, a.port or 0) as server:
        with progress("identifying"):
            session, playback, recording, settings = _session(a)
            arm = None
            if a.urdf:
                arm = Arm.from_urdf(a.urdf, a.sensor_frame, recording)
            viewer = Viewer(server, session, playback, arm, settings, render)
        try:
            if a.save:
                _save(viewer, a.save, a.log)
            else:
                _serve(address_of(server), browser=not a.no_browser)
        finally:
            viewer.close()


def _session(a: argparse.Namespace) -> "tuple[Session, Playback, Recording, Settings]":
    """The session with its recording, before and after ingest, and first settings."""
    from hefting.identification.truth import load_truth
    from hefting.ingest.ingest import ingest
    from hefting.request.settings import reading_of
    from hefting.viewer import Playback, Session

    truth = load_truth(a.truth).parameters if a.truth else None
    given = _given(a.estimate)
    recording = read_recording(a)
    shape = shape_of(a)
    hyperparameters = hyperparameters_of(a)
    found = ingest(recording, **reading_of(a))
    session = Session(found, shape, hyperparameters, given, truth)
    settings = _settings(a.method, session, hyperparameters)
    return session, Playback(recording, found), recording, settings


def _given(path: str | None) -> "dict[str, Estimate]":
    """An estimate in a file, by a name that no method has."""
    from hefting.core.estimate import Estimate

    return {f"as in {Path(path).name}": Estimate.load(path)} if path else {}


def _settings(
    method: str | None, session: "Session", hyperparameters: dict[str, Any]
) -> "Settings":
    """The method to begin with, and the hyperparameters that have controls."""
    from hefting.estimators import spelled
    from hefting.viewer import Settings

    if method is None:
        return Settings(session.default.method, hyperparameters)
    settings = Settings(spelled(method), hyperparameters)
    session.estimator(settings)  # raises what it lacks
    return settings


def _check_output(a: argparse.Namespace) -> None:
    """`InputError` for a player that cannot or must not be written."""
    if not a.save:
        return
    if Path(a.save).suffix.lower() not in (".html", ".htm"):
        raise InputError("a player is a .html file", a.save, "as in player.html")
    check_output(a.save, a)
    refuse_given(a, ("host", "port"), "a player has no server", "leave it out")


def _save(viewer: "Viewer", path: str, log: str) -> None:
    from hefting.viewer.player import player_of

    with progress("writing the player"):
        page = player_of(viewer, f"{Path(log).name} - Hefting")
    write_atomically(path, page)
    wrote(path)


def _serve(address: str, browser: bool) -> None:
    print(f"viewer at {address} (Ctrl-C ends it)", flush=True)
    if browser:
        open_page(address)
    sys.stdout.flush()
    while True:  # on Windows an endless wait ignores Ctrl-C
        threading.Event().wait(1.0)
