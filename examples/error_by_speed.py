"""
The paper's main figure
=======================

How far off is the inertia when a robot moves slowly, as it must beside people? This example runs a part of the
experiments of `Nadeau et al. 2022 <https://arxiv.org/abs/2203.00830>`__ (Figure 5) with the code of
``hefting reproduce``: one of eight objects, at all speeds and noise levels, by the paper's methods.

Run it with ``pip install 'hefting[sim,plot]'`` and ``python examples/error_by_speed.py``.
"""

# %%
# The experiments
# ---------------
# A UR5 turns the paper's modular object in MuJoCo; noise is added to the exact wrench and accelerations. All methods
# get the same samples, at most ten seconds of them.

from hefting.plots import save_figure
from hefting.reproduction.experiment import METHODS, SPEEDS
from hefting.reproduction.noise import report, run

jobs = [{"object": "hammer", "speed": speed, "seed": 1} for speed in SPEEDS]
made = report([(job, run(job)) for job in jobs])

# %%
# The table
# ---------
# Errors of the inertia about the sensor's origin [%].

table = made.tables[0]
print(f"{'noise':9s} rad/s" + "".join(f"{name:>9s}" for name in METHODS))
for row in table.rows:
    cells = dict(zip(table.columns, row, strict=True))
    errors = (f"{cells[f'{name}: inertia %']:9.1f}" for name in METHODS)
    print(f"{cells['noise']:9s} {cells['rad/s']:5.2f}" + "".join(errors))

# %%
# The figure
# ----------
# From left to right more noise; in each, faster to the right. The dashed line is the signal-to-noise ratio, the dotted
# one the reduced speed of ISO 10218-1. Least squares (OLS) and total least squares (RTLS) do not use the shape.
# ``hefting reproduce`` runs all eight objects and every other experiment of the paper.

figure = made.figures["error-by-speed"]
save_figure(figure, "error_by_speed")
figure  # shown in a notebook
