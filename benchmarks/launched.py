"""Run a command and print what it took as JSON: `python -I -S launched.py OUTPUT
COMMAND ...`.

A process of its own, as small as can be: on Linux a child's peak of memory is no less
than its parent's.
"""

import json
import os
import subprocess
import sys
import time

with open(sys.argv[1], "wb") as output:
    began = time.perf_counter()
    child = subprocess.Popen(
        sys.argv[2:], stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT
    )
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - began
code = child.returncode = os.waitstatus_to_exitcode(status)
peak = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
print(
    json.dumps(
        {
            "code": code,
            "wall": wall,
            "cpu": usage.ru_utime + usage.ru_stime,
            "peak": peak,
        }
    )
)
