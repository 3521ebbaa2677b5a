"""Rival explanations of a recording: mistakes, fitted side by side and compared.

Each file holds one mistake or some of one kind: an `explain(case)` returns the mistake as
it fits best, with the sentence that names it, and has one line below.
"""

from hefting.ingest.rivals import (
    axes_turned,
    axis_flipped,
    base_axes,
    base_tilted,
    bias_wrong,
    cable,
    calibration_matrix,
    clock_rate,
    elastic,
    gain_by_load,
    object_changing,
    placement,
    pose_forms,
    short_drift,
    sloshing,
    units,
    wrench_compensated,
    wrench_filtered,
)

EXPLANATIONS = (
    bias_wrong.explain,
    pose_forms.explain_position_axes,
    pose_forms.explain,
    wrench_filtered.explain,
    clock_rate.explain,
    gain_by_load.explain_hysteresis,
    gain_by_load.explain,
    cable.explain,
    sloshing.explain,
    object_changing.explain,
    elastic.explain_grip,
    elastic.explain_mount,
    short_drift.explain,
)
"""Mistakes that are always searched for."""
LINEAR_EXPLANATIONS = (
    axes_turned.explain,
    axis_flipped.explain,
    units.explain_force,
    units.explain_time,
    placement.explain_lever,
    base_tilted.explain,
    wrench_compensated.explain,
    calibration_matrix.explain,
    axes_turned.explain_with_tilt,
    calibration_matrix.explain_channel,
)
"""Mistakes that explain no more than free channels do (`explained_by_motion`). They are
searched for only where free channels explain enough."""
LARGE_EXPLANATIONS = (
    base_axes.explain,
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
    calibration_matrix.explain_channel,
    base_tilted.explain,
    base_axes.explain,
    bias_wrong.explain,
    pose_forms.explain,
    pose_forms.explain_order,
    pose_forms.explain_composed,
    pose_forms.explain_inverse,
)
"""Mistakes of few unknowns, the only ones searched for in a few static poses."""
BESIDE_ANOTHER = (
    axes_turned.explain,
    placement.explain_lever,
    base_tilted.explain,
    wrench_compensated.explain,
    calibration_matrix.explain_channel,
    pose_forms.explain_position_axes,
)
"""Mistakes that are searched for beside a first one, which is undone."""
UNDONE = (
    (axis_flipped.undone, axis_flipped.explain),
    (units.force_undone, units.explain_force),
    (units.time_undone, units.explain_time),
    (units.position_undone, units.explain_position),
    (base_axes.undone, base_axes.explain),
    (bias_wrong.undone, bias_wrong.explain),
    (wrench_compensated.undone, None),
    (base_tilted.undone, None),
    (pose_forms.undone, None),
    (pose_forms.inverse_undone, None),
)
"""First mistakes of a pair, which have no unknowns: how each is undone, and the search by
which it is the second mistake beside those that follow in this list."""
