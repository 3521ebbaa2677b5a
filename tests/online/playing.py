"""Recordings played through the live pipeline as fast as it goes."""

from benchmarks.online_streams import parts

from hefting.online import LiveIdentifier


def play(recording, edit=lambda samples, step: [samples], period=0.2, **options):
    """The identifier after a recording, and what it said at each step; `edit` makes
    other samples of each."""
    live = LiveIdentifier(in_process=False, **options)
    said = []
    for step, together in enumerate(parts(recording, period)):
        for samples in together:
            for each in edit(samples, step):
                live.add(each)
        now = live.step()
        if now is not None:
            said.append(now)
    return live, said
