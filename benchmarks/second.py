"""Identify a recording twice in one process and print what the second took: `second.py
LOG SHAPE UNIT POSE GRAVITY`.

Processor time [s]. Pose and unit of the shape as the command takes them; ``-`` for
none. The shape is loaded anew, which is not timed.
"""

import sys
import time

from hefting import identify, load_shape, parse_pose

log, spec, unit, pose, gravity = sys.argv[1:6]
for _ in range(2):
    shape = load_shape(
        spec, None if unit == "-" else unit, None if pose == "-" else parse_pose(pose)
    )
    began = time.process_time()
    identify(log, shape, gravity=[float(number) for number in gravity.split(",")])
    took = time.process_time() - began
print(took)
