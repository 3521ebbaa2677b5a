"""Conditioning without a search for changes of the object, and recordings for it."""

from functools import partial

from disturbances import body, disturbed, with_wrench
from hefting.ingest import condition as condition_and_look_for_changes
from hefting.simulation import UR5, simulate, stop_and_go

condition = partial(condition_and_look_for_changes, changes=False)
"""Looking for changes of the object alters nothing else: see `test_changes.py`."""


def exact_recording(late_by=0.0):
    motion = UR5.motion(stop_and_go(10.0, 100.0, seed=2))
    recording = simulate(motion, body(1.5), pose_noise=(0.0, 0.0), exact=True)
    return with_wrench(recording, motion.time + late_by, recording["wrench"].values)


CLEAN = disturbed("clean", 1.5, 0).recording
