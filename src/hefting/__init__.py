"""Hefting tells what a robot is holding: mass, centre of mass and inertia tensor of a manipulated object."""

from importlib import import_module

__version__ = "0.1.0"

_HOME = {
    "InertialParameters": "core.inertia",
    "Consistency": "core.inertia",
    "Recording": "core.recording",
    "Stream": "core.recording",
    "read_log": "logs",
    "write_log": "logs",
    "Robot": "robots",
    "with_poses": "robots",
    "condition": "ingest",
    "Measurements": "core.measurements",
    "Noise": "core.measurements",
    "NOISE_LEVELS": "core.measurements",
    "MotionNoise": "core.measurements",
    "measure": "motion",
    "smooth": "motion",
    "PoseFilter": "motion",
    "Moments": "core.moments",
    "Shape": "shapes",
    "load_shape": "shapes",
    "parse_pose": "shapes",
    "Bayes": "estimators",
    "PMD": "estimators",
    "OLS": "estimators",
    "GEO": "estimators",
    "LMI": "estimators",
    "HPS": "estimators",
    "RTLS": "estimators",
    "Estimate": "core.estimate",
    "Certificate": "core.estimate",
    "errors_between": "core.metrics",
    "identify": "identification",
    "calibrate": "identification",
    "Identification": "identification",
    "predict": "prediction",
    "Prediction": "prediction",
    "HeftingError": "core.errors",
    "InputError": "core.errors",
}


__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]


_RENAMED = {"PointMasses": "Shape"}
"""Former public names, and what they are now."""


def __getattr__(name: str):
    if name in _RENAMED:
        import warnings

        warnings.warn(f"hefting.{name} is hefting.{_RENAMED[name]} now", DeprecationWarning, stacklevel=2)
        name = _RENAMED[name]
    if name not in _HOME:
        raise AttributeError(f"module 'hefting' has no attribute '{name}'")
    value = getattr(import_module(f"hefting.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*_HOME, "__version__"])
