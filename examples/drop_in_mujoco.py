"""
Into a simulator: dropped, and thrown
=====================================

The inertia matters when nothing holds the object. A hammer is identified, exported to MuJoCo and let go, beside the
true one and one of uniform density with the same shape and mass.

Run it with ``pip install 'hefting[sim,plot]'`` and ``python examples/drop_in_mujoco.py``.
"""

# %%
# Identify and export
# -------------------
# Export writes as many digits as the intervals justify.

import mujoco
import numpy as np

import hefting
from hefting.export import export
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)
true, shape = held.parameters, held.points()
motion = UR5.motion(sinusoids(duration=20.0, rate=100.0, angular_speed=1.2))
log = simulate(motion, true, noise=hefting.NOISE_LEVELS["moderate"], seed=2)
found = hefting.identify(log, shape)
text = export(found.estimate, "mjcf", name="hammer").text
print(text)

# %%
# The others
# ----------
# The true body, and the one that a scale and a drawing alone would give.

even = hefting.InertialParameters(true.mass * shape.homogeneous.vector)
models = {
    "true": export(hefting.Estimate("truth", true, samples=0), "mjcf").text,
    "identified": text,
    "even density": export(hefting.Estimate("drawing", even, samples=0), "mjcf").text,
}

# %%
# Let go
# ------
# All are let go by the same gripper, so that the grasped points move alike at first. A point of the head is followed.

HEAD = np.array([0.0, 0.20, 0.06])  # [m] in the frame of the sensor, and of the body


def path_of(model: str, velocity: list[float], spin: list[float]) -> np.ndarray:
    """(K, 3) [m] of the head for 0.8 s; velocity [m/s] and spin [rad/s] at first."""
    simulator = mujoco.MjModel.from_xml_string(model)
    simulator.opt.timestep = 0.001
    simulator.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(simulator)
    data.qvel[:] = (*velocity, *spin)
    points = []
    for _ in range(800):
        mujoco.mj_step(simulator, data)
        points.append(data.xpos[1] + data.xmat[1].reshape(3, 3) @ HEAD)
    return np.array(points)


throws = {
    "dropped": ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    "thrown": ([1.5, 0.0, 3.0], [0.0, 2.0, 12.0]),
}
paths = {
    how: {name: path_of(model, *start) for name, model in models.items()}
    for how, start in throws.items()
}
for how, each in paths.items():
    for name in ("identified", "even density"):
        off = np.linalg.norm(each[name] - each["true"], axis=1)
        print(f"{how}, {name}: {1e3 * off.max():.1f} mm off at most")

# %%
# Dropped at rest, all bodies fall alike. Thrown with a spin they do not. The figure shows the path of the head, and its
# distance from that of the true hammer.

colours = {"true": INK, "identified": BLUE, "even density": VERMILION}
with drawing(2.9, width=6.5) as figure:
    side, off = figure.subplots(1, 2)
    for name, path in paths["thrown"].items():
        line = (
            {"linewidth": 2.5, "alpha": 0.3} if name == "true" else {"linewidth": 0.9}
        )
        side.plot(path[:, 0], path[:, 2], color=colours[name], label=name, **line)
        if name != "true":
            distance = np.linalg.norm(path - paths["thrown"]["true"], axis=1)
            off.plot(1e-3 * np.arange(1, 801), 1e3 * distance, color=colours[name])
    side.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
    off.set(
        xlabel="time [s]", ylabel="head off by [mm]", yscale="log", ylim=(0.1, None)
    )
    figure.legend(loc="outside upper center", ncols=3)
save_figure(figure, "drop_in_mujoco")
figure  # shown in a notebook
