"""Viewer: object, wrench and arm along a recording, identified up to any instant of it.

    session = Session(found, shape)
    answer = session.answer(2.5, Settings("PMD", {"c1": 10.0}))

Session and playback are plain data. What draws them needs viser.
"""

from hefting.viewer.session import Answer, Frame, Playback, Session, Settings

__all__ = ["Answer", "Frame", "Playback", "Session", "Settings"]
