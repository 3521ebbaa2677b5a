"""
Without a force-torque sensor
=============================

The torques of the joints show what the flange holds, if the arm is known well enough. An empty run of the same arm says
more about it than what its maker publishes.

Run it with ``pip install 'hefting[sim,robot,plot]'`` and ``python examples/joint_torques.py``.
"""

# %%
# An empty and a loaded run
# -------------------------
# A simulated UR5e whose links differ from its URDF as those of real arms do, with friction in every joint. The
# empty run has another motion.

from pathlib import Path

import numpy as np

from hefting.identification.by_torques import ByTorques
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.simulation import HeldObject, hammer
from hefting.simulation.demo import POSE
from hefting.simulation.torque_scenario import TorqueScenario

held = HeldObject.of(hammer(), POSE)
runs = TorqueScenario(held, duration=15.0, rate=50.0, seed=3).run()
Path("arm.urdf").write_text(runs.urdf)  # stands for that of your robot

# %%
# With and without the empty run
# ------------------------------
# The verdict says how much a published arm is worth.

shape = held.points()
found = {}
for name, empty in (("published arm", []), ("with an empty run", [runs.empty])):
    torques = ByTorques.of([runs.loaded], "arm.urdf", "flange", empty=empty)
    found[name] = torques.estimate(shape)
    print(f"{name}: {found[name].mass:.3f} kg, verdict {found[name].verdict}")
    for message in found[name].warnings:
        print("-", message)
print(f"true: {held.parameters.mass:.3f} kg")

# %%
# The figure shows the errors of mass and centre of mass, with 95 % intervals.

true = held.parameters
with drawing(2.1, width=6.0) as figure:
    mass, com = figure.subplots(1, 2, width_ratios=(1, 3))
    for k, (name, each) in enumerate(found.items()):
        half, colour = each.half_widths, (VERMILION, BLUE)[k]
        bars = {"fmt": "o", "color": colour, "capsize": 3, "markersize": 4}
        mass.errorbar(k, 1e3 * (each.mass - true.mass), 1e3 * half["mass"], **bars)
        off = 1e3 * (each.center_of_mass - true.center_of_mass)
        at = np.arange(3) + 0.2 * (k - 0.5)
        com.errorbar(at, off, 1e3 * half["center_of_mass"], label=name, **bars)
    for axes in (mass, com):
        axes.axhline(0.0, color=INK, linewidth=0.6)
    mass.set(ylabel="mass off by [g]", xlim=(-0.7, 1.7), xticks=[])
    com.set_xticks(range(3), ("x", "y", "z"))
    com.set(ylabel="COM off by [mm]")
    figure.legend(loc="outside upper center", ncols=2)
save_figure(figure, "joint_torques")
figure  # shown in a notebook
