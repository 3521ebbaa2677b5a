"""
Static poses: mass and centre of mass alone
===========================================

An arm that stops in a few poses, without time or velocities, is enough for a controller's payload. The inertia, which
static poses cannot show, stays open, and is not invented.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/static_poses.py``.
"""

# %%
# Twelve poses
# ------------
# Orientations and wrenches, nothing else: without times each row is a pose at rest.

import numpy as np
from scipy.spatial.transform import Rotation

import hefting
from hefting.export import export
from hefting.plots import plot_wrench, save_figure
from hefting.simulation import HeldObject, hammer
from hefting.simulation.demo import POSE

body = HeldObject.of(hammer(), POSE).parameters
rng = np.random.default_rng(5)
turns = Rotation.random(12, random_state=rng)
force = turns.inv().apply([0.0, 0.0, 9.80665 * body.mass])  # what bears the weight
torque = np.cross(body.center_of_mass, force)
bias = [2.0, -1.0, 3.0, 0.1, 0.02, -0.05]
noise = [0.02, 0.02, 0.02, 0.001, 0.001, 0.001]
wrench = np.hstack((force, torque)) + rng.normal(bias, noise, (12, 6))

found = hefting.identify(orientation=turns, wrench=wrench, bias="estimate")
print(found)

# %%
# What is open
# ------------
# The inertia is marked as open: its values come from the prior for objects near the sensor, not from the recording. An
# export for a controller gets mass and centre of mass; an export that needs an inertia is refused, unless you say what
# to put there.

undetermined = found.estimate.undetermined
print("inertia open:", undetermined.inertia_at_com.all())
print("what stands for it:", undetermined.filled_from)
print(export(found.estimate, "ur").text)
try:
    export(found.estimate, "mjcf")
except hefting.InputError as error:
    print(error)

# %%
# The figure shows the wrench pose by pose: measured as dashes, predicted as dots.

figure = plot_wrench(found.measurements, found.estimate)
save_figure(figure, "static_poses")
figure  # shown in a notebook
