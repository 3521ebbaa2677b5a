"""Rival explanations of a recording: mistakes, fitted side by side and compared.

Each mistake is one file, whose `explain(case)` returns the mistake as it fits best, with
the sentence that names it, and one line below.
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
    elastic_grip,
    elastic_mount,
    force_unit,
    gain_by_load,
    hysteresis,
    lever_arm,
    object_changing,
    one_channel,
    orientation_form,
    pose_inverse,
    position_axes,
    position_unit,
    short_drift,
    sloshing,
    time_unit,
    turned_and_tilted,
    wrench_compensated,
    wrench_filtered,
)

EXPLANATIONS = (
    bias_wrong.explain,
    position_axes.explain,
    orientation_form.explain,
    wrench_filtered.explain,
    clock_rate.explain,
    hysteresis.explain,
    gain_by_load.explain,
    cable.explain,
    sloshing.explain,
    object_changing.explain,
    elastic_grip.explain,
    elastic_mount.explain,
    short_drift.explain,
)
"""Mistakes that are always searched for."""
LINEAR_EXPLANATIONS = (
    axes_turned.explain,
    axis_flipped.explain,
    force_unit.explain,
    time_unit.explain,
    lever_arm.explain,
    base_tilted.explain,
    wrench_compensated.explain,
    calibration_matrix.explain,
    turned_and_tilted.explain,
    one_channel.explain,
)
"""Mistakes that explain no more than free channels do (`explained_by_motion`). They are
searched for only where free channels explain enough."""
LARGE_EXPLANATIONS = (
    base_axes.explain,
    position_unit.explain,
    orientation_form.explain_order,
    orientation_form.explain_composed,
    turned_and_tilted.explain_axes,
    pose_inverse.explain,
)
"""Mistakes that are searched for only where much is unexplained, as they leave it."""
OF_FEW_POSES = (
    axes_turned.explain,
    axis_flipped.explain,
    force_unit.explain,
    one_channel.explain,
    base_tilted.explain,
    base_axes.explain,
    bias_wrong.explain,
    orientation_form.explain,
    orientation_form.explain_order,
    orientation_form.explain_composed,
    pose_inverse.explain,
)
"""Mistakes of few unknowns, the only ones searched for in a few static poses."""
BESIDE_ANOTHER = (
    axes_turned.explain,
    lever_arm.explain,
    base_tilted.explain,
    wrench_compensated.explain,
    one_channel.explain,
    position_axes.explain,
)
"""Mistakes that are searched for beside a first one, which is undone."""
UNDONE = (
    (axis_flipped.undone, axis_flipped.explain),
    (force_unit.undone, force_unit.explain),
    (time_unit.undone, time_unit.explain),
    (position_unit.undone, position_unit.explain),
    (base_axes.undone, base_axes.explain),
    (bias_wrong.undone, bias_wrong.explain),
    (wrench_compensated.undone, None),
    (base_tilted.undone, None),
    (orientation_form.undone, None),
    (pose_inverse.undone, None),
)
"""First mistakes of a pair, which have no unknowns: how each is undone, and the search by
which it is the second mistake beside those that follow in this list."""
