"""Rival explanations of a recording: mistakes, fitted side by side and compared.

Each file holds one mistake or some of one kind: an `explain(case)` returns the mistake as
it fits best, with the sentence that names it, and has one line below.
"""

from hefting.ingest.rivals import (
    axes_turned,
    axis_flipped,
    base,
    bias,
    cable,
    elastic,
    not_rigid,
    placement,
    pose_forms,
    sensor_calibration,
    timing,
    units,
    wrench_compensated,
)

EXPLANATIONS = (
    bias.explain,
    pose_forms.explain_position_axes,
    pose_forms.explain,
    timing.explain_filter,
    timing.explain_clock_rate,
    sensor_calibration.explain_hysteresis,
    sensor_calibration.explain_by_load,
    cable.explain,
    not_rigid.explain_sloshing,
    not_rigid.explain_change,
    elastic.explain_grip,
    elastic.explain_mount,
    bias.explain_drift,
)
"""Mistakes that are always searched for."""
LINEAR_EXPLANATIONS = (
    axes_turned.explain,
    axis_flipped.explain,
    axis_flipped.explain_turned_apart,
    units.explain_force,
    units.explain_time,
    placement.explain_lever,
    base.explain,
    wrench_compensated.explain,
    sensor_calibration.explain,
    axes_turned.explain_with_tilt,
    sensor_calibration.explain_channel,
)
"""Mistakes that explain no more than free channels do (`explained_by_motion`). They are
searched for only where free channels explain enough."""
LARGE_EXPLANATIONS = (
    base.explain_axes,
    units.explain_position,
    pose_forms.explain_order,
    pose_forms.explain_composed,
    axes_turned.explain_with_axis,
    pose_forms.explain_inverse,
)
"""Mistakes that are searched for only where much is unexplained, as they leave it."""
OF_FEW_POSES = (
    axes_turned.explain,
    axis_flipped.explain,
    units.explain_force,
    sensor_calibration.explain_channel,
    base.explain,
    base.explain_axes,
    bias.explain,
    pose_forms.explain,
    pose_forms.explain_order,
    pose_forms.explain_composed,
    pose_forms.explain_inverse,
)
"""Mistakes of few unknowns, the only ones searched for in a few static poses."""
BESIDE_ANOTHER = (
    axes_turned.explain,
    placement.explain_lever,
    base.explain,
    wrench_compensated.explain,
    sensor_calibration.explain_channel,
    pose_forms.explain_position_axes,
)
"""Mistakes that are searched for beside a first one, which is undone."""
UNDONE = (
    (axis_flipped.undone, axis_flipped.explain),
    (units.force_undone, units.explain_force),
    (units.time_undone, units.explain_time),
    (units.position_undone, units.explain_position),
    (base.axes_undone, base.explain_axes),
    (bias.undone, bias.explain),
    (wrench_compensated.undone, None),
    (base.undone, None),
    (pose_forms.undone, None),
    (pose_forms.inverse_undone, None),
)
"""First mistakes of a pair, which have no unknowns: how each is undone, and the search by
which it is the second mistake beside those that follow in this list."""
