"""Hefting tells what a robot is holding: mass, centre of mass and inertia tensor of a manipulated object."""

from importlib import import_module

__version__ = "0.1.0"

_HOME = {
    "InertialParameters": "inertia",
    "Consistency": "inertia",
    "Recording": "recording",
    "Stream": "recording",
    "read_log": "logs",
    "write_log": "logs",
    "Robot": "kinematics",
    "with_poses": "kinematics",
    "condition": "ingest",
    "Measurements": "measurements",
    "Noise": "measurements",
    "NOISE_LEVELS": "measurements",
    "MotionNoise": "measurements",
    "measure": "motion",
    "smooth": "motion",
    "PoseFilter": "motion",
    "Moments": "moments",
    "PointMasses": "shapes",
    "load_shape": "shapes",
    "parse_pose": "shapes",
    "Bayes": "estimators",
    "PMD": "estimators",
    "OLS": "estimators",
    "GEO": "estimators",
    "LMI": "estimators",
    "HPS": "estimators",
    "RTLS": "estimators",
    "Estimate": "estimate",
    "Certificate": "estimate",
    "errors_between": "metrics",
    "identify": "identification",
    "calibrate": "identification",
    "Identification": "identification",
    "predict": "prediction",
    "Prediction": "prediction",
    "HeftingError": "errors",
    "InputError": "errors",
}


__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'hefting' has no attribute '{name}'")
    value = getattr(import_module(f"hefting.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*_HOME, "__version__"])
