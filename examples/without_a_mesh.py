"""
Without a mesh
==============

A mesh is not needed. Any knowledge of the shape, even a box around it, narrows the interval of the inertia; that of the
mass hardly changes.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/without_a_mesh.py``.
"""

# %%
# One recording, three states of knowledge
# ----------------------------------------
# The box is given by two opposite corners, in the axes of the sensor. A box or a mesh says where mass may be, and not
# how it is distributed.

import numpy as np

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, ORANGE, SKY, drawing
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)
body = held.parameters
motion = UR5.motion(sinusoids(duration=10.0, rate=100.0, angular_speed=1.0))
log = simulate(motion, body, noise=hefting.NOISE_LEVELS["moderate"], seed=4)

points = held.points().positions
low, high = points.min(axis=0) - 0.01, points.max(axis=0) + 0.01
box = hefting.Shape.from_box(*np.column_stack((low, high)).ravel())
mesh = held.points()  # `hefting.load_shape` reads one from a file
found = {
    "nothing": hefting.identify(log),
    "a box": hefting.identify(log, box),
    "the mesh": hefting.identify(log, mesh),
}

# %%
# How wide the intervals are
# --------------------------
# Half the width of the 95 % intervals, the largest of the three axes of the centre of mass and of the moments of
# inertia.


print("known        mass      COM       inertia")
for name, each in found.items():
    half = each.estimate.half_widths
    com, inertia = half["center_of_mass"].max(), np.diag(half["inertia_at_com"]).max()
    print(
        f"{name:10s} ±{1e3 * half['mass']:5.2f} g  ±{1e3 * com:5.2f} mm  ±{1e3 * inertia:5.3f} g m²"
    )

# %%
# The figure shows the three moments of inertia with their intervals, and the true ones as lines.

colours = (SKY, ORANGE, BLUE)
true = 1e3 * np.diag(body.inertia_at_com)
with drawing(2.5, width=6.0) as figure:
    axes = figure.subplots()
    for k, ((name, each), colour) in enumerate(
        zip(found.items(), colours, strict=True)
    ):
        at = np.arange(3) + 0.2 * (k - 1)
        lows, highs = 1e3 * np.diagonal(each.interval("inertia"), axis1=1, axis2=2)
        middle = 1e3 * np.diag(each.inertia)
        reach = (middle - lows, highs - middle)
        axes.errorbar(at, middle, reach, fmt="o", color=colour, capsize=3, label=name)
    axes.hlines(
        true,
        np.arange(3) - 0.4,
        np.arange(3) + 0.4,
        color=INK,
        linewidth=0.8,
        label="truth",
    )
    axes.set_xticks(range(3), ("xx", "yy", "zz"))
    axes.set(ylabel="inertia about the COM [g m²]")
    figure.legend(loc="outside upper center", ncols=4, title="known of the shape")
save_figure(figure, "without_a_mesh")
figure  # shown in a notebook
