"""Rival explanations of a recording: mistakes, fitted side by side and compared.

Each mistake is one file, whose `explain(case)` returns the mistake as it fits best, with
the sentence that names it, and one line in `EXPLANATIONS`.
"""

from hefting.ingest.rivals import (
    axes_turned,
    axis_flipped,
    base_axes,
    base_tilted,
    bias_wrong,
    clock_rate,
    cross_talk,
    force_unit,
    gain_uneven,
    hysteresis,
    lever_arm,
    pose_inverse,
    position_unit,
    quaternion_order,
    wrench_compensated,
    wrench_filtered,
)

EXPLANATIONS = (
    (bias_wrong.explain, False),
    (axes_turned.explain, False),
    (axis_flipped.explain, False),
    (force_unit.explain, False),
    (lever_arm.explain, False),
    (base_tilted.explain, False),
    (wrench_compensated.explain, False),
    (wrench_filtered.explain, False),
    (clock_rate.explain, False),
    (gain_uneven.explain, False),
    (cross_talk.explain, False),
    (hysteresis.explain, False),
    (base_axes.explain, True),
    (position_unit.explain, True),
    (quaternion_order.explain, True),
    (pose_inverse.explain, True),
)
"""Every mistake that is looked for, and whether it is one of poses or axes that leaves
much unexplained: these are tried only then."""
