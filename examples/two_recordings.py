"""
Two recordings of one object, and one that contradicts
======================================================

Recordings of several days are identified together: each has its own wrench bias, clock and sign, and all share the
object. One that shows another object is named.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/two_recordings.py``.
"""

# %%
# Three days
# ----------
# On Wednesday a magnet of 60 g sticks to the hammer's head.

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, hammer, random_smooth, simulate
from hefting.simulation.demo import POSE

body = HeldObject.of(hammer(), POSE).parameters
magnet = hefting.InertialParameters.from_com(
    0.06, (0.0, 0.2, 0.085), [[4e-6, 0, 0], [0, 4e-6, 0], [0, 0, 4e-6]]
)


def recorded(day: int, held: hefting.InertialParameters) -> hefting.Recording:
    """Six seconds, with the bias of that day."""
    motion = UR5.motion(random_smooth(6.0, 100.0, angular_speed=0.8, seed=day))
    noise = hefting.NOISE_LEVELS["moderate"]
    return simulate(motion, held, noise=noise, bias=(day, -2, 3, 0, 0.1, 0), seed=day)


monday, tuesday = recorded(1, body), recorded(2, body)
wednesday = recorded(3, body + magnet)

# %%
# Two days together
# -----------------
# The intervals of both together are narrower than those of either.

alone = {"Monday": hefting.identify(monday), "Tuesday": hefting.identify(tuesday)}
together = hefting.identify([monday, tuesday])
for name, found in (*alone.items(), ("both", together)):
    low, high = found.interval("mass")
    print(f"{name}: {found.mass:.4f} kg, interval {1e3 * (high - low):.1f} g wide")
print("bias of each [N]:", together.estimate.bias[:, :3].round(1).tolist())

# %%
# A day that contradicts
# ----------------------
# No object explains all three days. The verdict names the recording to look at.

contradicting = hefting.identify([monday, tuesday, wednesday])
print("verdict:", contradicting.verdict)
for reason in contradicting.verdict.reasons:
    print(f"- [{reason.code}] {reason}")

# %%
# The figure shows the mass of each day and of days together, with 95 % intervals.

rows = {
    **alone,
    "Wednesday": hefting.identify(wednesday),
    "Monday and Tuesday": together,
    "all three": contradicting,
}
with drawing(2.1, width=5.0) as figure:
    axes = figure.subplots()
    for row, found in enumerate(rows.values()):
        low, high = 1e3 * found.interval("mass")
        colour = BLUE if found.verdict.usable else VERMILION
        axes.plot((low, high), (row, row), color=colour, linewidth=3.0, alpha=0.5)
        axes.plot(1e3 * found.mass, row, "o", color=colour)
        axes.annotate(
            f"{found.verdict}", (high, row), (6, -2), textcoords="offset points"
        )
    axes.axvline(
        1e3 * body.mass, color=INK, linewidth=0.6, label="true mass of the hammer"
    )
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set(xlabel="mass [g]", ylim=(4.6, -0.6))
    axes.margins(x=0.3)
    figure.legend(loc="outside upper center")
save_figure(figure, "two_recordings")
figure  # shown in a notebook
