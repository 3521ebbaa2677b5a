"""Fold single samples into PMD and estimate after each: `python streamed.py SAMPLES`
prints the median [s].

Processor time, as in `benchmarks.streaming`: `Measurements`, update, and an estimate
from the one before.
"""

import sys
import time
from dataclasses import fields
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks.problem import shape, wielded
from hefting import PMD, Measurements

KNOWN = 150
samples = int(sys.argv[1])
z = wielded(KNOWN + samples)
motion = (z.gravity, z.linear_acceleration, z.angular_velocity, z.angular_acceleration)
arrays = (z.time, *motion, z.force, z.torque)
# earlier code, with which this is compared, has no intervals
known = {field.name for field in fields(PMD)}
pmd = PMD(shape(56), **({"intervals": False} if "intervals" in known else {}))
state = pmd.update(pmd.start(), z[:KNOWN])
estimate = pmd.estimate(state)
took = []
for k in range(KNOWN, KNOWN + samples):
    began = time.process_time()
    state = pmd.update(state, Measurements(*(array[k : k + 1] for array in arrays)))
    estimate = pmd.estimate(state, start=estimate)
    took.append(time.process_time() - began)
print(float(np.median(took)))
