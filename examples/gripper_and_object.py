"""
A gripper, and what it holds
============================

A sensor between arm and gripper measures gripper and object together. The empty gripper is identified once and then
subtracted; its uncertainty is part of the object's intervals.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/gripper_and_object.py``.
"""

# %%
# Two recordings
# --------------
# One of the gripper alone, one of the gripper with a hammer, in the same sensor frame. The sensor is not zeroed: its
# bias is in both.

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, GREEN, INK, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, hammer, random_smooth, simulate
from hefting.simulation.demo import POSE
from hefting.simulation.objects import Assembly, Part

body = HeldObject.of(hammer(), POSE).parameters
fingers = (Part("box", (0.02, 0.02, 0.06), 2700.0, (x, 0, 0.09)) for x in (-0.04, 0.04))
palm = Part("box", (0.12, 0.06, 0.06), 2000.0, (0.0, 0.0, 0.03))
gripper = Assembly("gripper", (palm, *fingers)).parameters


def recorded(held: hefting.InertialParameters, seed: int) -> hefting.Recording:
    """What the robot logs while it moves what the sensor holds."""
    motion = UR5.motion(random_smooth(12.0, 100.0, angular_speed=1.2, seed=seed))
    noise = hefting.NOISE_LEVELS["moderate"]
    return simulate(motion, held, noise=noise, bias=(3, -1, 5, 0.1, 0, 0), seed=seed)


empty, full = recorded(gripper, seed=1), recorded(gripper + body, seed=2)

# %%
# Calibrate the empty gripper
# ---------------------------

tool = hefting.calibrate(empty)
low, high = tool.interval("mass")
print(f"gripper: {low:.4f} to {high:.4f} kg (true: {gripper.mass:.4f} kg)")

# %%
# Weigh the hammer
# ----------------
# Without the calibration the answer is that of everything at the sensor; with it, of the object alone.

both = hefting.identify(full)
alone = hefting.identify(full, tool=tool)
print(alone)

# %%
# A kitchen scale
# ---------------
# Each sensor has a gain error, which no recording shows. A scale's reading of the object corrects it; here it also
# makes the interval of the mass narrower.

weighed = hefting.identify(full, tool=tool, mass="0.670kg±1g")
for name, found in (("alone", alone), ("with scale", weighed)):
    low, high = found.interval("mass")
    print(
        f"{name}: {1e3 * found.mass:.1f} g, 95 % interval {1e3 * (high - low):.1f} g wide"
    )

# %%
# The figure shows the error of each mass, with its interval.

bars = {
    "gripper": (tool, gripper.mass, GREEN),
    "gripper and hammer": (both, gripper.mass + body.mass, VERMILION),
    "hammer": (alone, body.mass, BLUE),
    "hammer, with a scale": (weighed, body.mass, BLUE),
}
with drawing(1.9, width=5.0) as figure:
    axes = figure.subplots()
    for row, (found, true, colour) in enumerate(bars.values()):
        low, high = (1e3 * (end - true) for end in found.interval("mass"))
        axes.plot((low, high), (row, row), color=colour, linewidth=3.0, alpha=0.5)
        axes.plot(1e3 * (found.mass - true), row, "o", color=colour)
        axes.annotate(
            f"{found.mass:.3f} kg", (high, row), (6, -2), textcoords="offset points"
        )
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.set_yticks(range(len(bars)), list(bars))
    axes.set(xlabel="mass found less true mass [g]", ylim=(3.6, -0.6))
    axes.margins(x=0.2)
save_figure(figure, "gripper_and_object")
figure  # shown in a notebook
