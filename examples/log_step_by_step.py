"""
A log with the usual faults, step by step
=========================================

Logs of real robots have a clock offset, a sensor that was not zeroed, spikes, and a sign that is not documented.
This example writes such a log, then reads, inspects and identifies it and predicts another motion, and shows what each
step finds.

Run it with ``pip install 'hefting[plot]'`` and ``python examples/log_step_by_step.py``.
"""

# %%
# A log
# -----
# The wrench is 25 ms late, is that on the sensor instead of that on the object, and has a bias and some spikes. It is
# written to a CSV file, as from a robot.

import hefting
from hefting.plots import plot_prediction, save_figure
from hefting.simulation import (
    UR5,
    WRENCH_NOISE,
    Faults,
    HeldObject,
    hammer,
    random_smooth,
    record,
    sinusoids,
    wield_analytically,
)
from hefting.simulation.demo import POSE

held = HeldObject.of(hammer(), POSE)
faults = Faults(
    wrench_noise=WRENCH_NOISE["ft300"],
    bias=(4.0, -2.5, 6.0, 0.2, -0.1, 0.05),
    wrench_delay=0.025,
    spikes=0.005,
    on_sensor=True,
)
first = wield_analytically(UR5, sinusoids(12.0, 100.0), held.parameters)
hefting.write_log(record(first, faults, seed=1), "log.csv")

# %%
# Read
# ----
# The streams in the file, as they were logged.

log = hefting.read_log("log.csv")
for name, rate in log.rates().items():
    print(f"{name}: {len(log[name])} samples at {rate:.0f} Hz")

# %%
# Inspect
# -------
# Sign, clock offset and bias of the log, and whether its motion is enough to identify an object.

seen = hefting.inspect(log)
print(f"verdict: {seen.verdict}; the wrench is {seen.sign.name}")
for finding in seen.findings:
    print("-", finding)
print("bias as recorded:", seen.facts.bias.round(2), "N, N m")

# %%
# Identify
# --------
# The same faults are corrected before any method sees a sample.

found = hefting.identify(log)
print(found)
print(f"clock offset {1e3 * found.ingested.conditioned.offset:.1f} ms (true: 25 ms)")

# %%
# Predict
# -------
# The test of an estimate is what it predicts: here the wrench along another motion, which the estimate has not seen.
# The wrench of the object lies in the band with 95 % probability; the measured one includes the sensor's bias.

second = wield_analytically(UR5, random_smooth(6.0, 100.0, seed=5), held.parameters)
another = record(second, faults, seed=4)
prediction = hefting.predict(found.estimate, another)
force, torque = prediction.agreement.varying
print(f"unexplained, less its mean: {force:.3f} N, {torque:.4f} N m rms")

# %%
# The figure shows the prediction with its band over the measured wrench, and the difference.

figure = plot_prediction(prediction)
save_figure(figure, "log_step_by_step")
figure  # shown in a notebook
