"""`python -m benchmarks.viewer LOG`: how long the viewer takes for an answer.

Processor time of one answer, without drawing it, for each method at twelve
instants of a recording; the longest and the median. An answer is to follow a slider at
once, which takes less than 0.3 s.
"""

import argparse
import os
import time

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

BOX = "box:-0.06,0.06,-0.06,0.06,0,0.2"
INSTANTS = 12


def main() -> None:
    """Print a row a method."""
    import numpy as np

    from hefting.ingest.ingest import ingest
    from hefting.logs import read_log
    from hefting.shapes import as_shape
    from hefting.viewer import Session, Settings

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.viewer", description=main.__doc__
    )
    parser.add_argument("log", metavar="LOG")
    parser.add_argument("--shape", default=BOX)
    arguments = parser.parse_args()
    began = time.process_time()
    found = ingest(read_log(arguments.log))
    print(f"ingest, once: {time.process_time() - began:.2f} s")
    session = Session(found, as_shape(arguments.shape))
    z = found.measurements
    print(f"{'method':12}{'median':>9}{'longest':>9}  ms an answer")
    for method in session.methods:
        took = []
        for instant in np.linspace(z.time[0], z.time[-1], INSTANTS + 1)[1:]:
            began = time.process_time()
            session.answer(float(instant), Settings(method))
            took.append(1e3 * (time.process_time() - began))
        print(f"{method:12}{np.median(took):9.1f}{max(took):9.1f}", flush=True)


if __name__ == "__main__":
    main()
