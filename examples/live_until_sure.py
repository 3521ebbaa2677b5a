"""
Live, until it is sure enough
=============================

Samples go in as the robot gives them, and the motion ends when the intervals are narrow enough, not after a fixed time.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/live_until_sure.py``.
"""

# %%
# The accuracy wanted
# -------------------
# ``until`` limits half the widths of the 95 % intervals. ``hefting.Live`` needs the sign; here the log has the wrench
# on the object. ``hefting.LiveIdentifier`` finds the sign too, and clock offset, drift and contacts.

import numpy as np

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, GREEN, INK, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)
motion = UR5.motion(sinusoids(duration=30.0, rate=100.0, angular_speed=1.2))
log = simulate(motion, held.parameters, noise=hefting.NOISE_LEVELS["moderate"], seed=11)
robot = {name: log[name].values for name in ("position", "orientation", "wrench")}
time = log["wrench"].time

live = hefting.Live(held.points(), until="mass=1%,com=1.2mm,inertia=15%")
print(live)

# %%
# Until it is sure
# ----------------
# The state is a value that is passed in and returned. Samples may come one by one; here 25 come at once, with an
# estimate four times a second. The estimate is None until there are enough samples.

state, estimate, history = live.start(), None, []
for k in range(0, len(time), 25):
    new = {name: values[k : k + 25] for name, values in robot.items()}
    state = live.update(state, time=time[k : k + 25], **new)
    estimate = live.estimate(state, start=estimate)
    if estimate is not None:
        history.append((time[k + 24], estimate))
        if estimate.sufficient:
            break

stopped, last = history[-1]
print(f"stopped after {stopped:.1f} of {time[-1]:.0f} s")
print(f"mass {last.mass:.4f} kg, true {held.parameters.mass:.4f} kg")
print(f"half-widths now: {last.accuracy}")

# %%
# The figure shows these half-widths while the robot moves; dashed, the accuracy wanted. The wrench's bias and noise are
# found on the way: until then, the intervals are wide.

asked = live.estimator.until
rows = (
    ("mass", "mass [%]", 1e2, BLUE),
    ("center_of_mass", "COM [mm]", 1e3, VERMILION),
    ("inertia", "inertia [%]", 1e2, GREEN),
)
seconds = [when for when, _ in history]
with drawing(2.2, width=7.0) as figure:
    for axes, (name, label, scale, colour) in zip(
        figure.subplots(1, 3), rows, strict=True
    ):
        widths = [scale * getattr(each.accuracy, name) for _, each in history]
        axes.plot(seconds, np.where(np.isfinite(widths), widths, np.nan), color=colour)
        axes.axhline(
            scale * getattr(asked, name), color=INK, linestyle="--", linewidth=0.8
        )
        axes.set(xlabel="time [s]", ylabel=f"± {label}")
        axes.set_ylim(0.0, 4.0 * scale * getattr(asked, name))
save_figure(figure, "live_until_sure")
figure  # shown in a notebook
