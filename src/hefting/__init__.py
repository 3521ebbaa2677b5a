"""Hefting tells what a robot is holding: mass, centre of mass and inertia tensor of a
manipulated object."""

from importlib import import_module

__version__ = "0.2.0"

_HOME = {
    "InertialParameters": "core.inertia",
    "Consistency": "core.inertia",
    "Recording": "core.recording",
    "Stream": "core.recording",
    "as_recording": "logs.given",
    "read_log": "logs",
    "write_log": "logs",
    "with_sensor_pose": "logs.orientations",
    "Robot": "robots",
    "with_poses": "robots",
    "condition": "ingest",
    "Measurements": "core.measurements",
    "Noise": "core.measurements",
    "NOISE_LEVELS": "core.measurements",
    "MotionNoise": "core.measurements",
    "measure": "motion",
    "smooth": "motion",
    "PoseFilter": "motion.kalman",
    "Moments": "core.moments",
    "Shape": "shapes",
    "load_shape": "shapes",
    "parse_pose": "shapes",
    "Estimate": "core.estimate",
    "Certificate": "core.estimate",
    "errors_between": "core.accuracy",
    "Gravity": "core.gravity",
    "SensorAccuracy": "core.sensor_accuracy",
    "MassReading": "core.quantity",
    "identify": "identification",
    "calibrate": "identification",
    "Identification": "identification",
    "Comparison": "identification",
    "compare": "identification.agreement",
    "in_frame": "identification.frames",
    "Live": "identification.live",
    "LiveState": "identification.live",
    "live": "sources.live",
    "LiveIdentifier": "online.identifier",
    "EndOfSource": "online.samples",
    "SourceLostError": "online.samples",
    "LiveEstimate": "online.live_estimate",
    "plan": "planning",
    "Plan": "planning",
    "inspect": "inspection",
    "Inspection": "inspection",
    "predict": "prediction",
    "Prediction": "prediction",
    "batch": "batches",
    "HeftingError": "core.errors",
    "InputError": "core.errors",
    "NeedError": "core.errors",
    "NotIdentifiableError": "core.errors",
    "MissingDependencyError": "core.errors",
}
"""Where each public name is; the estimators are in `hefting.estimators.METHODS`."""

_RENAMED = {"PointMasses": "Shape"}
"""Former public names, and what they are now."""


def __getattr__(name: str):
    if name in _RENAMED:
        import warnings

        warnings.warn(
            f"hefting.{name} is hefting.{_RENAMED[name]} now",
            DeprecationWarning,
            stacklevel=2,
        )
        name = _RENAMED[name]
    if name == "__all__":
        return [*_HOME, *_methods()]
    if name in _HOME:
        value = getattr(import_module(f"hefting.{_HOME[name]}"), name)
    # submodules and what Python looks for begin otherwise
    elif name[:1].isupper() and name in _methods():
        value = _methods()[name]
    else:
        raise AttributeError(f"module 'hefting' has no attribute '{name}'")
    globals()[name] = value
    return value


def _methods() -> dict[str, type]:
    """The estimators by name; the first call imports NumPy."""
    return import_module("hefting.estimators").METHODS


def __dir__() -> list[str]:
    return sorted([*_HOME, *_methods(), "__version__"])
