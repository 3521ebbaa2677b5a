"""
A sensor that is mounted at an angle
====================================

The logged poses are those of the flange, and the sensor is mounted on it turned by 30°: a common mistake, which no
driver reports. This example finds and corrects it.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/turned_sensor.py``.
"""

# %%
# The log of a turned sensor
# --------------------------
# The wrench is in the axes of the sensor, the poses are those of the flange.

import numpy as np
from scipy.spatial.transform import Rotation

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.scene import wrench_curves
from hefting.simulation import UR5, HeldObject, hammer, simulate, sinusoids
from hefting.simulation.demo import POSE

body = HeldObject.of(hammer(), POSE).parameters
motion = UR5.motion(sinusoids(duration=10.0, rate=100.0))
of_sensor = simulate(motion, body, noise=hefting.NOISE_LEVELS["moderate"], seed=7)

sensor_in_flange = Rotation.from_euler("z", 30.0, degrees=True)
sensor = Rotation.from_quat(of_sensor["orientation"].values.copy())
log = {
    "time": of_sensor["wrench"].time,
    "position": of_sensor["position"].values,
    "orientation": (sensor * sensor_in_flange.inv()).as_quat(),
    "wrench": of_sensor["wrench"].values,
}

# %%
# What is found
# -------------
# The verdict is *do not use*; the reasons name the mistake, and the option that corrects it. Common mistakes are fitted
# to the same samples, and one is named if it explains them better than the log as given.

wrong = hefting.identify(log)
print("verdict:", wrong.verdict)
for reason in wrong.verdict.reasons:
    print(f"- [{reason.code}] {reason}")

# %%
# The correction
# --------------
# ``sensor_turned`` says how the sensor is turned in the frame that is logged.

mended = hefting.identify(log, sensor_turned="z:30")
print(mended)

# %%
# The figure shows the centre of mass, and the part of the torque that the object does not explain. With an unknown
# truth the latter shows which answer is right: after the correction it is noise. Gaps are samples that were taken for
# contacts and left out: no object explains them in the axes of the flange.

names, colours = ("as logged", "mended"), (VERMILION, BLUE)
with drawing(2.5, width=7.0) as figure:
    where, rest = figure.subplots(1, 2, width_ratios=(1, 2))
    for found, name, colour in zip((wrong, mended), names, colours, strict=True):
        x, y, _ = 1e3 * found.center_of_mass
        where.plot(x, y, "o", color=colour, label=name)
        curves = wrench_curves(found.measurements, found.estimate)
        torque = np.linalg.norm(curves.residual[:, 3:], axis=1)
        rest.plot(found.measurements.time, torque, ".", color=colour, markersize=1.5)
    x, y, _ = 1e3 * body.center_of_mass
    where.plot(x, y, "+", color=INK, markersize=12, label="truth")
    where.set(xlabel="COM x [mm]", ylabel="COM y [mm]")
    where.set_aspect("equal", adjustable="datalim")
    where.margins(0.3)
    rest.set(xlabel="time [s]", ylabel="unexplained torque [N m]", ylim=(0.0, None))
    figure.legend(loc="outside upper center", ncols=3)
save_figure(figure, "turned_sensor")
figure  # shown in a notebook
