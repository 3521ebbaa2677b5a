"""
Methods side by side
====================

All methods get the same corrected samples; one is recommended, with the reason.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/all_methods.py``.
"""

# %%
# One log, six methods
# --------------------
# In slow motion the inertia hardly shows in the wrench, so it matters what a method knows about the shape. ``"all"``
# instead of the names runs all that can be used, including variants.

import numpy as np

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, SKY, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

METHODS = ("Bayes", "PMD", "GEO", "LMI", "OLS", "RTLS")

held = HeldObject.of(hammer(), POSE)
true = held.parameters
motion = UR5.motion(sinusoids(duration=10.0, rate=100.0, angular_speed=0.6))
log = simulate(motion, true, noise=hefting.NOISE_LEVELS["moderate"], seed=9)
compared = hefting.identify(log, held.points(), method=METHODS)
print("recommended:", compared.recommended, "-", compared.reason)

# %%
# How far off each is
# -------------------
# Not every answer is a body that can exist: unconstrained least squares may find negative moments of inertia.


def inertia_error(estimate: hefting.Estimate) -> float:
    """Of the tensor about the COM, as a share of the true one."""
    difference = estimate.inertia - true.inertia_at_com
    return float(np.linalg.norm(difference) / np.linalg.norm(true.inertia_at_com))


print("method          mass      COM    inertia  can exist")
for name, each in compared.results.items():
    mass = 100.0 * abs(each.mass / true.mass - 1.0)
    com = 1e3 * np.linalg.norm(each.center_of_mass - true.center_of_mass)
    inertia = 100.0 * inertia_error(each)
    print(
        f"{name:12s} {mass:6.2f} % {com:5.2f} mm {inertia:6.1f} %  {each.physically_consistent}"
    )

# %%
# The figure shows the same errors of the inertia.

errors = {name: 100.0 * inertia_error(each) for name, each in compared.results.items()}
with drawing(1.9, width=5.0) as figure:
    axes = figure.subplots()
    for row, (name, error) in enumerate(errors.items()):
        recommended = name == compared.recommended
        exists = compared.results[name].physically_consistent
        colour = BLUE if exists else SKY
        axes.barh(row, error, color=VERMILION if recommended else colour, height=0.6)
        said = f"{error:.0f} %" + (", recommended" if recommended else "")
        said += "" if exists else ", not a possible body"
        axes.annotate(said, (error, row), (4, -2), textcoords="offset points")
    axes.set_yticks(range(len(errors)), list(errors))
    axes.invert_yaxis()
    axes.margins(x=0.3)
    axes.set(xlabel="error of the inertia about the COM [%]")
save_figure(figure, "all_methods")
figure  # shown in a notebook
