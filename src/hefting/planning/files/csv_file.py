"""CSV: the columns ``time,q1..qn`` of the canonical log."""

from hefting.planning.files import MotionFile
from hefting.planning.result import Plan


def _content(plan: Plan) -> bytes:
    motion = plan.motion
    header = ["time", *(f"q{i + 1}" for i in range(len(plan.joints)))]
    rows = (
        f"{time:.9g}," + ",".join(f"{value:.9f}" for value in q)
        for time, q in zip(motion.time, motion.position, strict=True)
    )
    return "\n".join([",".join(header), *rows, ""]).encode()


FORMAT = MotionFile(".csv", "time and joint positions, in s and rad", _content)
"""Joint positions at 100 Hz, in the order of `Plan.joints`."""
