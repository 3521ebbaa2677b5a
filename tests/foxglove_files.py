"""Files for Foxglove: a log with what was found from it, and what independent readers find
in a file."""

from types import SimpleNamespace

import numpy as np
import pytest

from hefting.identification import identify
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids

POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
START = 1_000_000_000
"""Time of a recording's first sample in the file [ns]."""


def held():
    """A log of a hammer with bias, what was found from it, and the hammer's shape."""
    tool = hammer()
    log = simulate(
        UR5.motion(sinusoids(5.0, 100.0, 1.5)),
        tool.parameters.moved(POSE),
        bias=(3.0, -2.0, 5.0, 0.1, 0.2, -0.1),
        pose_noise=(1e-4, 3.5e-4),
        seed=3,
    )
    shape = Shape.from_mesh(tool.mesh(), pose=POSE)
    return log, identify(log, shape).estimate, shape


def read(path):
    """Schema names by topic, and (time [ns], message) of each topic in Foxglove's own
    schemas."""
    mcap = pytest.importorskip("mcap.reader")
    mcap_protobuf = pytest.importorskip("mcap_protobuf.decoder")
    with open(path, "rb") as file:
        reader = mcap.make_reader(
            file, decoder_factories=[mcap_protobuf.DecoderFactory()]
        )
        summary = reader.get_summary()
        names = {
            c.topic: summary.schemas[c.schema_id].name
            for c in summary.channels.values()
        }
        own = [topic for topic, name in names.items() if name.startswith("foxglove.")]
        found = {topic: [] for topic in own}
        for _, channel, raw, message in reader.iter_decoded_messages(topics=own):
            found[channel.topic].append((raw.log_time, message))
        whole = summary.statistics
    return SimpleNamespace(names=names, topics=found, statistics=whole)


def numbers(values, names="xyz"):
    return np.array([getattr(values, name) for name in names])
