"""Names of `hefting/__init__.py` for type checkers, which do not follow its lazy imports."""

from hefting.batches import batch as batch
from hefting.core.accuracy import errors_between as errors_between
from hefting.core.errors import HeftingError as HeftingError
from hefting.core.errors import InputError as InputError
from hefting.core.errors import MissingDependencyError as MissingDependencyError
from hefting.core.errors import NeedError as NeedError
from hefting.core.errors import NotIdentifiableError as NotIdentifiableError
from hefting.core.estimate import Certificate as Certificate
from hefting.core.estimate import Estimate as Estimate
from hefting.core.gravity import Gravity as Gravity
from hefting.core.inertia import Consistency as Consistency
from hefting.core.inertia import InertialParameters as InertialParameters
from hefting.core.measurements import NOISE_LEVELS as NOISE_LEVELS
from hefting.core.measurements import Measurements as Measurements
from hefting.core.measurements import MotionNoise as MotionNoise
from hefting.core.measurements import Noise as Noise
from hefting.core.moments import Moments as Moments
from hefting.core.quantity import MassReading as MassReading
from hefting.core.recording import Recording as Recording
from hefting.core.recording import Stream as Stream
from hefting.core.sensor_accuracy import SensorAccuracy as SensorAccuracy
from hefting.estimators.methods import *  # noqa: F403
from hefting.identification import Comparison as Comparison
from hefting.identification import Identification as Identification
from hefting.identification import calibrate as calibrate
from hefting.identification import identify as identify
from hefting.identification.agreement import compare as compare
from hefting.identification.frames import in_frame as in_frame
from hefting.identification.live import Live as Live
from hefting.identification.live import LiveState as LiveState
from hefting.ingest import condition as condition
from hefting.inspection import Inspection as Inspection
from hefting.inspection import inspect as inspect
from hefting.logs import read_log as read_log
from hefting.logs import write_log as write_log
from hefting.logs.given import as_recording as as_recording
from hefting.logs.orientations import with_sensor_pose as with_sensor_pose
from hefting.motion import measure as measure
from hefting.motion import smooth as smooth
from hefting.motion.kalman import PoseFilter as PoseFilter
from hefting.online.identifier import LiveIdentifier as LiveIdentifier
from hefting.online.live_estimate import LiveEstimate as LiveEstimate
from hefting.online.samples import EndOfSource as EndOfSource
from hefting.online.samples import SourceLostError as SourceLostError
from hefting.planning import Plan as Plan
from hefting.planning import plan as plan
from hefting.prediction import Prediction as Prediction
from hefting.prediction import predict as predict
from hefting.robots import Robot as Robot
from hefting.robots import with_poses as with_poses
from hefting.shapes import Shape as Shape
from hefting.shapes import load_shape as load_shape
from hefting.shapes import parse_pose as parse_pose
from hefting.sources.live import live as live

__version__: str
