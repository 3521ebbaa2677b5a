"""
Your own NumPy arrays
=====================

Three arrays are enough: when, where the sensor was, and what it felt. This example makes them with a
simulated UR5 that wields a hammer for ten seconds; with a robot they come from your driver or your log.

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
# Nothing else is said: whom the wrench acts on, its bias and its noise are found from the arrays. Behind each number
# stands half the width of its 95 % interval.

found = hefting.identify(
    time=time, position=position, orientation=orientation, wrench=wrench
)
print(found)

# %%
# Compare with the truth
# ----------------------
# A simulation knows what is to be found. An interval of 95 % holds the true number in 19 of 20 cases.

low, high = found.interval("mass")
print(f"true mass {held.parameters.mass:.4f} kg, interval {low:.4f} to {high:.4f} kg")
print(f"the verdict: {found.verdict}, by {found.estimate.method}")

# %%
# The figure shows, on the left, the centre of mass with its 95 % region and the ellipsoid of even density that has the
# inertia found, beside the true ones. On the right is the wrench as measured and as the object explains it; what
# remains should look like noise.

figure = plot_identification(found.measurements, found.estimate, truth=held.parameters)
save_figure(figure, "own_arrays")
figure  # shown in a notebook
