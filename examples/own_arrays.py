"""
Your own NumPy arrays
=====================

Three arrays and their times are enough: positions and orientations of the sensor, and the wrench. This example makes
them with a simulated UR5 that turns a hammer for ten seconds; with a robot they come from your driver or your log.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/own_arrays.py``.
"""

# %%
# Arrays
# ------
# Poses are those of the sensor frame in the world; quaternions are x, y, z, w. The wrench is force, then torque,
# in the axes of the sensor about its origin.

import hefting
from hefting.plots import plot_identification, save_figure
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)  # POSE: of the hammer in the sensor frame
motion = UR5.motion(sinusoids(duration=10.0, rate=100.0, angular_speed=1.0))
log = simulate(motion, held.parameters, noise=hefting.NOISE_LEVELS["moderate"], seed=1)

time = log["wrench"].time  # (K,) s
position = log["position"].values  # (K, 3) m
orientation = log["orientation"].values  # (K, 4)
wrench = log["wrench"].values  # (K, 6) N, N m
print(time.shape, position.shape, orientation.shape, wrench.shape)

# %%
# Identify
# --------
# Nothing else is needed: the sign of the wrench, its bias and its noise are found from the arrays. ± is half the width
# of the 95 % interval.

found = hefting.identify(
    time=time, position=position, orientation=orientation, wrench=wrench
)
print(found)

# %%
# Compare with the truth
# ----------------------
# In a simulation the truth is known. A 95 % interval holds the true number in 19 of 20 cases.

low, high = found.interval("mass")
print(f"true mass {held.parameters.mass:.4f} kg, interval {low:.4f} to {high:.4f} kg")
print(f"the verdict: {found.verdict}, by {found.estimate.method}")

# %%
# The figure shows, on the left, the centre of mass with its 95 % region and the ellipsoid of uniform density with the
# inertia found, beside the true ones. On the right are the measured and the predicted wrench; the residual should look
# like noise.

figure = plot_identification(found.measurements, found.estimate, truth=held.parameters)
save_figure(figure, "own_arrays")
figure  # shown in a notebook
