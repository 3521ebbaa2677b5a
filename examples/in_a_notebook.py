"""
What a notebook shows
=====================

At the end of a cell, results are shown as HTML: the verdict with its reasons, each number with its interval and unit,
and a picture. Here is what each kind of result looks like.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/in_a_notebook.py``, which writes the same as one page,
``in_a_notebook.html``; or take the notebook below.
"""

# %%
# An estimate
# -----------

from pathlib import Path

import hefting
from hefting.identification.agreement import Agreement
from hefting.plots import plot_shape, save_figure
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)
motion = UR5.motion(sinusoids(duration=10.0, rate=100.0, angular_speed=1.0))
log = simulate(motion, held.parameters, noise=hefting.NOISE_LEVELS["moderate"], seed=1)
shape = held.points()
found = hefting.identify(log, shape)
found

# %%
# A shape
# -------

shape

# %%
# Several methods
# ---------------
# What each found from the same samples, and which to trust.

compared = hefting.identify(log, shape, method=["Bayes", "PMD", "OLS"])
compared

# %%
# Two estimates against each other
# --------------------------------

first, second = (hefting.identify(log.slice(start, 5.0), shape) for start in (0.0, 5.0))
agreement = Agreement.of({"first half": first.estimate, "second half": second.estimate})
agreement

# %%
# The same anywhere else
# ----------------------
# What is shown is one block of HTML without scripts.

parts = (found, shape, compared, agreement)
page = "<!doctype html><meta charset='utf-8'>" + "".join(
    part._repr_html_() for part in parts
)
Path("in_a_notebook.html").write_text(page, encoding="utf-8")
print(f"{len(page) / 1e3:.0f} kB")

figure = plot_shape(shape, {"found": found.estimate})
save_figure(figure, "in_a_notebook")
