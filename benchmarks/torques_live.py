"""What live folding of joint torques costs beside the regressor of a sample."""

from time import perf_counter

import numpy as np

from benchmarks.torques_simulated import dynamics_of
from hefting.torques.equations import OWN, LiveTorques

SAMPLES = 4000


def costs() -> dict[str, float]:
    """Median, 99th percentile and mean of folding one sample of a Panda with 43 base
    parameters [µs], and the size of the state in the beginning and in the end
    [bytes]."""
    dynamics = dynamics_of("panda")
    n, columns = dynamics.joints, len(OWN) + len(dynamics.base) + 11
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((64, n, columns))
    live, took = LiveTorques.empty(n, len(OWN), len(dynamics.base)), []
    used = np.ones(n, dtype=bool)
    for k in range(SAMPLES):
        begin = perf_counter()
        live.add(rows[k % 64], 0.01 * k, used)
        took.append(perf_counter() - begin)
        if k == SAMPLES // 10:
            early = live.size
    micro = 1e6 * np.array(took)
    return {
        "median [us]": float(np.median(micro)),
        "99th [us]": float(np.quantile(micro, 0.99)),
        "mean [us]": float(micro.mean()),
        "early [bytes]": float(early),
        "late [bytes]": float(live.size),
    }
