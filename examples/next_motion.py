"""
What to move next
=================

After a few seconds of motion the inertia is very uncertain. The next motion is planned to reduce that, within the
limits of the robot, and played in simulation: is it as good as forecast?

Run it with ``pip install 'hefting[plot]'`` and ``python examples/next_motion.py``.
"""

# %%
# After a first motion
# --------------------
# A slow one of four seconds, like one made by hand.

from pathlib import Path

import numpy as np

import hefting
from hefting.plots import plot_plan, save_figure
from hefting.simulation import HeldObject, hammer, random_smooth, simulate
from hefting.simulation.demo import POSE
from hefting.simulation.torque_scenario import TORQUE_ARMS

robot = TORQUE_ARMS["ur5e"]
Path("arm.urdf").write_text(robot.urdf)  # stands for that of your robot
held = HeldObject.of(hammer(), POSE)
noise = hefting.NOISE_LEVELS["moderate"]


def played(joints) -> hefting.Recording:
    """What the robot logs along a motion of its joints."""
    return simulate(robot.arm.motion(joints), held.parameters, noise=noise, seed=1)


by_hand = played(
    random_smooth(4.0, 100.0, 0.3, seed=2, arm=robot.arm, speed_limit=0.25)
)
first = hefting.identify(by_hand, held.points())


def widths(mass, com, inertia) -> str:
    """Half the widths of 95 % intervals, the largest of the axes."""
    largest = float(np.max(np.diagonal(inertia)))
    return (
        f"±{1e3 * mass:.1f} g, ±{1e3 * np.max(com):.2f} mm, ±{1e3 * largest:.2f} g m²"
    )


print("now:     ", widths(*first.estimate.half_widths.values()))

# %%
# The plan
# --------
# Four seconds more, from rest to rest, with every corner of the object below 0.25 m/s. Limits that a URDF does not have
# are assumed, and listed.

plan = hefting.plan(
    "arm.urdf",
    "flange",
    estimate=first.estimate,
    shape=held.points(),
    duration=4.0,
    effort="quick",
)
end = plan.forecast
print("forecast:", widths(end.mass[-1], end.center_of_mass[-1], end.inertia[-1]))
for each in (*plan.binding, *plan.notes):
    print("-", each)

# %%
# Is the forecast right?
# ----------------------
# The first recording with the planned motion, played in simulation, and with a second motion by hand.

planned = hefting.identify([by_hand, played(plan.motion)], held.points())
again = played(random_smooth(4.0, 100.0, 0.3, seed=3, arm=robot.arm, speed_limit=0.25))
twice = hefting.identify([by_hand, again], held.points())
true = held.parameters.inertia_at_com
for name, found in (("by hand twice", twice), ("by hand, planned", planned)):
    error = np.linalg.norm(found.inertia - true) / np.linalg.norm(true)
    print(f"{name}: {widths(*found.estimate.half_widths.values())}")
    print(f"    inertia off by {100 * error:.1f} %")

# %%
# The figure shows the planned joints with their limits, the speed of the fastest corner, and the half-widths that are
# expected before and after it.

figure = plot_plan(plan)
save_figure(figure, "next_motion")
figure  # shown in a notebook
