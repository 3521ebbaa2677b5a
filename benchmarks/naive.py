"""What a lab would write in an afternoon: pandas, SciPy's Savitzky-Golay, Pinocchio's
regressor, least squares.

`python benchmarks/naive.py LOG.csv --gravity 0,0,-9.81`. It uses nothing of Hefting. It
takes the wrench's sign, the clocks and every sample as they come, and says nothing of
how sure it is.
"""

import argparse

import numpy as np
import pandas as pd
import pinocchio as pin
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

WINDOW, DEGREE = 0.2, 3
"""Length [s] and degree of the polynomial of Savitzky-Golay."""


def main() -> None:
    """Read a log, and print mass, COM and inertia about it."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("log", help="CSV: time, px..pz, qx..qw, fx..fz, tx..tz")
    parser.add_argument("--gravity", default="0,0,-9.81", help="in world axes [m/s²]")
    arguments = parser.parse_args()
    gravity = np.array([float(number) for number in arguments.gravity.split(",")])

    log = pd.read_csv(arguments.log)
    phi, bias = identified(log, gravity)
    body = pin.Inertia.FromDynamicParameters(phi)
    with np.printoptions(precision=5, suppress=True):
        print(f"mass    {body.mass:.4f} kg")
        print(f"COM     {body.lever} m")
        print(f"inertia {body.inertia.tolist()} kg m², about the COM")
        print(f"bias    {bias} N, N m")


def identified(log: pd.DataFrame, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ten parameters in Pinocchio's order, and six of the bias."""
    a, w, alpha, to_sensor = motion(log)
    w, alpha = to_sensor.apply(w), to_sensor.apply(alpha)
    force = to_sensor.apply(a - gravity)  # specific, of the sensor's origin
    wrench = log[["fx", "fy", "fz", "tx", "ty", "tz"]].to_numpy()

    rows = []
    for k in range(len(log)):
        # at rest in its own origin: what is differentiated is the classical
        # acceleration, not the spatial one
        regressor = pin.bodyRegressor(
            pin.Motion(np.zeros(3), w[k]), pin.Motion(force[k], alpha[k])
        )
        rows.append(np.hstack([regressor, np.eye(6)]))
    solution, *_ = np.linalg.lstsq(np.vstack(rows), wrench.ravel(), rcond=None)
    return solution[:10], solution[10:]


def motion(log: pd.DataFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray, Rotation]:
    """Linear acceleration, angular velocity and acceleration in world axes, and the
    turn from world to sensor axes."""
    step = np.median(np.diff(log["time"]))
    window = 2 * round(0.5 * WINDOW / step) + 1

    def smooth(values: np.ndarray, derivative: int) -> np.ndarray:
        return savgol_filter(
            values, window, DEGREE, deriv=derivative, delta=step, axis=0
        )

    position = log[["px", "py", "pz"]].to_numpy()
    q = log[["qx", "qy", "qz", "qw"]].to_numpy()
    q = (
        q
        * np.cumprod(
            np.append(1.0, np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0))
        )[:, None]
    )
    angular = [
        2.0 * times_conjugate(smooth(q, derivative), smooth(q, 0))
        for derivative in (1, 2)
    ]
    to_sensor = Rotation.from_quat(smooth(q, 0)).inv()
    return smooth(position, 2), angular[0], angular[1], to_sensor


def times_conjugate(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Vector part (K, 3) of the quaternions p times q conjugated."""
    u, v = p[:, :3], q[:, :3]
    return q[:, 3:] * u - p[:, 3:] * v - np.cross(u, v)


if __name__ == "__main__":
    main()
