"""Cases of what is refused, and of what is just not."""

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from hammers import shape
from hefting.core.accuracy import Accuracy, errors_between
from hefting.core.errors import InputError
from hefting.core.estimate_json import fields_of
from hefting.core.gravity import Gravity
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.quantity import MassReading, quantity
from hefting.core.recording import Recording, Stream
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.undetermined import Undetermined
from hefting.estimators import (
    GEO,
    LMI,
    OLS,
    PMD,
    RTLS,
    Bayes,
)
from hefting.ingest.ingest import ingest
from hefting.ingest.joint import ingest_all
from hefting.ingest.plausibility import require_object
from hefting.ingest.sign_and_bias import tare
from hefting.shapes import Shape
from reference.held import dynamic, few, slow
from reference.recorded import (
    FAULTS,
    accelerated,
    changed,
    only,
    recorded,
    short,
    static_poses,
)

Refused = Callable[[], Any]


def raised(refused: Refused) -> dict[str, Any]:
    """What is said of what cannot be."""
    try:
        found = refused()
    except (InputError, ValueError, TypeError, KeyError) as error:
        text = str(error).replace(str(Path.cwd()), "")
        words = re.findall(r"[a-z]+", text)
        return {
            "kind": type(error).__name__,
            "about": "-".join(words[:5])[:30],
            "text": text,
        }
    return {"kind": "accepted", "found": found}


def stream(**changes: Any) -> Stream:
    """A wrench of five samples, with changes."""
    given = {"time": np.arange(5) * 0.1, "values": np.ones((5, 6))} | changes
    return Stream(**given)


def recording(**changes: Any) -> Recording:
    """With orientations."""
    q = np.tile((0.0, 0.0, 0.0, 1.0), (5, 1)) * changes.pop("size", 1.0)
    return Recording({"wrench": stream(**changes), "orientation": stream(values=q)})


def ones(**changes: Any) -> Any:
    """Three samples, with changes."""
    names = (
        *("gravity", "linear_acceleration", "angular_velocity"),
        *("angular_acceleration", "force", "torque"),
    )
    given: Any = {name: np.ones((3, 3)) for name in names}
    return cast(Any, Measurements)(**(given | {"time": np.arange(3.0)} | changes))


def undetermined(**changes: Any) -> Undetermined:
    """What is open, read from JSON with changes."""
    data = Undetermined.of_parameters(("mcx", "Jyz"), "prior").to_dict()
    return Undetermined.from_dict(data | changes)


def read_again(**changes: Any) -> Any:
    """An estimate, read from JSON with changes."""
    data = json.loads(json.dumps(OLS().fit(dynamic()).to_dict()))
    return fields_of(data | changes)


def body(mass: float) -> InertialParameters:
    """Of any mass."""
    return InertialParameters.from_com(mass, (0.0, 0.0, 0.1), 0.01 * np.eye(3))


def held(scale: float, **reading: Any) -> None:
    """Whether an object is held at all, with a wrench so many times as large."""
    found = changed(recorded(), "wrench", lambda _, w: scale * w)
    require_object(
        ingest(found, **reading), Shape.from_box(-0.1, 0.1, -0.1, 0.1, 0, 0.2)
    )


BAD = np.array((1.0, np.nan, 1.0, 1.0, 1.0))
JUMP = np.array((0.0, 0.1, 0.1, 0.3, 0.4))
REFUSED: dict[str, Refused] = {
    **{
        f"accuracy {text}": partial(Accuracy.parse, text)
        for text in ("mass", "mas=1%", "mass=1%,mass=2%", "com=2%", "mass=-1%", "")
    },
    **{
        f"sensor {text}": partial(SensorAccuracy.parse, text)
        for text in ("1% 2%", "nobody", "101%", "1kg", "-2N", "3N 4N")
    },
    **{
        f"sensor {limits}": partial(SensorAccuracy, *limits)
        for limits in ((0.5, -1.0), (0.1, 0.1, np.inf), (0.1, 0.1, 0.1, 0.0), ("a",))
    },
    **{
        f"mass {text}": partial(cast(Any, MassReading.of), text)
        for text in ("heavy", "0g", "1kg±2kg", "1kg±0g", "1±2±3", "2000t", (1.0,), 3)
    },
    **{
        f"quantity {text}": partial(quantity, text, "length")
        for text in ("2kg", "x", "3 parsecs", "inf m", "1e400m")
    },
    "vector": partial(InertialParameters, np.ones(9)),
    "no truth": lambda: errors_between(body(1.0), body(0.0), (1.0, 1.0, 1.0)),
    "no sides": lambda: errors_between(body(1.0), body(1.0), (1.0, 0.0, 1.0)),
    "flat": lambda: errors_between(body(1.0), body(1.0), (1.0, 0.5, 1.0)),
    "no body": lambda: errors_between(body(-1.0), body(1.0), (1.0, 0.5, 1.0)),
    "latitude": partial(Gravity.at, 91.0),
    "altitude": partial(Gravity.at, 45.0, 9001.0),
    "gravity": partial(Gravity.of, (0.0, 0.0)),
    "no gravity": partial(Gravity.of, (0.0, 0.0, 0.0)),
    "given gravity": partial(Gravity.of, (0.0, 0.0, -9.7)),
    **{
        f"undetermined {number}": partial(undetermined, **changes)
        for number, changes in enumerate(
            (
                {"mass": 1},
                {"center_of_mass": [True, True]},
                {"inertia_at_com": [[True] * 3] * 2},
                {"center_of_mass": [1, 0, 0]},
                {"filled_from": 3},
                {"filled_from": "a long name " * 99},
            )
        )
    },
    **{
        f"estimate {number}": partial(read_again, **changes)
        for number, changes in enumerate(
            (
                {"vector": [1.0] * 9},
                {"vector": [np.nan] * 10},
                {"vector": [1e-30] * 10, "mass": None, "center_of_mass": None},
                {"vector": [1e30] * 10},
                {"covariance": [[1.0] * 10] * 9},
                {"covariance": [[1e60] * 10] * 10},
                {"sufficient": 1},
                {"intervals": {"mass": [0.0, 1.0]}},
                {"bias": [1.0] * 5},
                {"bias": [[1.0] * 6] * 2},
                {"messages": [{"code": "a", "text": "b", "severity": "worse"}]},
                {"messages": [{"code": "a", "text": "b", "severity": "note"}]},
                {"certificate": {"objective": 1.0, "bound": 0.5, "iterations": 3}},
                {"accuracy": {"mass": 0.1, "center_of_mass": None, "inertia": 0.2}},
                {"accuracy": {"mass": -0.1, "center_of_mass": None, "inertia": 0.2}},
                {"consistency": {"margins": {"hull": 0.3}}},
                {"consistency": {"margins": {"hull": "far"}}},
                {"provenance": {"notes": ["b", 3]}},
                {"provenance": {"notes": "b"}},
                {"samples": "many"},
            )
        )
    },
    "biases": lambda: ingest_all([recorded(), recorded()], bias=np.zeros((3, 6))),
    "same log": lambda: ingest_all([str(Path("a.csv"))] * 2),
    "no logs": lambda: ingest_all([]),
    "stream": partial(stream, values=np.ones((4, 6))),
    "columns": partial(recording, values=np.ones((5, 5))),
    "not finite": partial(recording, values=np.ones((5, 6)) * BAD[:, None]),
    "repeated": partial(recording, time=JUMP),
    "unsorted": partial(recording, time=np.array((0.0, 0.2, 0.1, 0.3, 0.4))),
    "too near": partial(recording, time=np.array((0.0, 0.2, 0.2 + 1e-10, 0.3, 0.4))),
    "too large": partial(recording, values=np.full((5, 6), 1e12)),
    "quaternions": partial(recording, size=1.02),
    "nearly unit": lambda: recording(size=1.009)["orientation"].values,
    "missing": lambda: recording()["position"],
    "rates": lambda: (recording().rates(), recording().start, recording().duration),
    "measured shape": partial(ones, force=np.ones((4, 3))),
    "measured": partial(ones, torque=np.ones((3, 3)) * BAD[:3, None]),
    "measured weights": partial(ones, weights=np.array((1.0, -1.0, 1.0))),
    "tare": partial(tare, recorded(), 99.0, 100.0),
    "until": partial(cast(Any, Bayes), shape(), until=3.0),
    "pose std": partial(Bayes, shape(), pose_std=(0.1, -0.1)),
    "three pose stds": partial(cast(Any, Bayes), shape(), pose_std=np.ones(3)),
    "shape std": partial(Bayes, shape(), shape_std=1.1),
    "carried": partial(Bayes, shape(), carried=np.ones(9)),
    "systematic": partial(Bayes, shape(), systematic=-np.eye(10)),
    "no covariance": partial(Bayes, shape(), systematic=np.ones((3, 3))),
    "noise": partial(OLS, noise=np.ones((5, 5))),
    "model": partial(cast(Any, OLS), model="another"),
    "c1": partial(PMD, shape(), c1=-1.0),
    "regularization": partial(PMD, shape(), regularization=-1.0),
    "gamma": partial(GEO, shape(), gamma=-1.0),
    "bias": partial(cast(Any, LMI), bias="some"),
    "no samples": lambda: OLS().estimate(OLS().start()),
    "few": lambda: RTLS("estimate").fit(few()[:2]).undetermined,
    "one pose": lambda: OLS("estimate").fit(slow()[:1]).undetermined,
    "held": partial(held, 1.0),
    "upside down": partial(held, -1.0, wrench="on-object"),
    "in pounds": partial(held, 4.45),
    "in newton millimetres": partial(held, 3000.0),
    "nothing": partial(held, 1e-6),
    "zero": partial(held, 0.0),
    "wrong bias": partial(held, 1.0, bias=(0.0, 0.0)),
    "no such sign": partial(held, 1.0, wrench="on"),
    "no such bias": partial(held, 1.0, bias="perhaps"),
    "at rest": lambda: require_object(
        ingest(only(recorded(short), "orientation", "wrench").slice(0.0, 0.02))
    ),
    "gravity of few": lambda: require_object(
        ingest(static_poses(3), gravity="estimate")
    ),
    "long": lambda: require_object(
        ingest(recorded()), Shape.from_box(-6.0, 6.0, -0.1, 0.1, 0.0, 0.2)
    ),
    "dense": lambda: require_object(
        ingest(recorded()), Shape.from_box(-0.01, 0.01, -0.01, 0.01, 0.1, 0.11)
    ),
    "far": lambda: require_object(
        ingest(changed(recorded(), "wrench", lambda _, w: w * np.repeat((1, 300), 3)))
    ),
    "accelerations": lambda: ingest(accelerated(), bias=FAULTS.bias).fit.vector,
}
"""What is refused, and what is just not."""

CASES: dict[str, Callable[[], Any]] = {
    name: partial(raised, case) for name, case in REFUSED.items()
}
"""By name."""
