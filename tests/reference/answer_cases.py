"""Cases of answers as they are told, written and read again, and of what is refused."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np

from hammers import shape
from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import fields_of
from hefting.core.gravity import Gravity
from hefting.core.inertia import InertialParameters
from hefting.core.mass_reading import MassReading
from hefting.core.measurements import Measurements
from hefting.core.metrics import errors_between
from hefting.core.quantity import quantity
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
    describe_methods,
    options,
)
from hefting.estimators.coordinates import PARAMETERS_OF
from hefting.ingest.bias import tare
from hefting.ingest.ingest import ingest
from hefting.ingest.plausibility import require_object
from hefting.shapes import Shape
from reference.held import biased, box, dynamic, few, slow
from reference.recorded import (
    FAULTS,
    accelerated,
    changed,
    only,
    recorded,
    short,
    static_poses,
)

READ_AGAIN = {"covariance", "intervals", "vector", "point_masses", "provenance"}
"""Parts of an estimate's JSON that are told as they are read again."""
Refused = Callable[[], Any]


def told(estimate: Callable[[], Estimate]) -> dict[str, Any]:
    """An estimate as text and as JSON, and what is read again."""
    found = estimate()
    data = found.to_dict()
    again = fields_of(json.loads(json.dumps(data)))
    return {
        "text": str(found),
        "data": {key: value for key, value in data.items() if key not in READ_AGAIN},
        "provenance": {
            key: value
            for key, value in found.provenance.items()
            if isinstance(value, int | float | str)
        },
        "again": {key: value for key, value in again.items() if key != "provenance"},
        "half widths": found.half_widths,
        "verdict": found.verdict,
        "usable": found.verdict.usable,
        "consistency": found.parameters.consistency(),
    }


def open_answer() -> Estimate:
    """Of poses at rest: no inertia, with sentences of warning."""
    found = OLS().fit(slow())
    names = ("Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")
    undetermined = Undetermined.of_parameters(names, "shape")
    return replace(
        found,
        undetermined=undetermined,
        warnings=(*found.warnings, *(f"sentence {i} " * 30 for i in range(9))),
        duration=None,
        accuracy=Accuracy(0.01, 0.002, np.inf),
        sufficient=False,
    )


def words() -> dict[str, Any]:
    """Of parts that are not determined, and of accuracies."""
    asked = Accuracy.parse("mass=1%,com=2mm,inertia=20%")
    some = (("m",), ("mcx",), ("mcy", "Jxz"), ("Jyy",), ("mcx", "mcy", "mcz"))
    claims = (
        Accuracy(0.02, 0.001, 0.5),
        Accuracy(0.01000001, np.inf, 0.19),
        Accuracy(1e-3, 1e-3, np.inf),
        Accuracy(mass=1e-3),
    )
    return {
        "undetermined": [
            (
                found,
                found.position.split(),
                Undetermined.from_dict(found.to_dict()),
                (found.inertia, bool(found)),
            )
            for names in some
            for found in [Undetermined.of_parameters(names, "prior")]
        ],
        "lacking": [asked.shortfall(claim) for claim in claims],
        "asked": str(asked),
        "readings": [str(MassReading.of(text)) for text in ("0.512kg±1g", "1.5 lb")],
        "sensors": [
            str(SensorAccuracy.parse(text)) for text in ("0.5% 0.3N", "1% 2N 30mNm")
        ],
        "methods": describe_methods(),
        "options": len(options()),
        "matrices": PARAMETERS_OF,
    }


def raised(refused: Refused) -> dict[str, Any]:
    """What is said of what cannot be."""
    try:
        found = refused()
    except InputError as error:
        words = re.findall(r"[a-z]+", str(error))
        return {
            "kind": type(error).__name__,
            "about": "-".join(words[:5])[:30],
            "text": str(error),
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


def ones(**changes: Any) -> Measurements:
    """Three samples, with changes."""
    names = (
        *("gravity", "linear_acceleration", "angular_velocity"),
        *("angular_acceleration", "force", "torque"),
    )
    given: dict[str, Any] = {name: np.ones((3, 3)) for name in names}
    return Measurements(**(given | {"time": np.arange(3.0)} | changes))


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
    "OLS": partial(told, lambda: OLS().fit(dynamic())),
    "OLS, biased": partial(told, lambda: OLS("estimate").fit(biased())),
    "few": partial(told, lambda: OLS().fit(few())),
    "GEO": partial(told, lambda: GEO(box(), gamma=7.0).fit(dynamic())),
    "PMD": partial(told, lambda: PMD(shape(), mass="0.67kg±5g").fit(dynamic())),
    "Bayes": partial(
        told,
        lambda: Bayes(shape(), sensor_accuracy="1%", mass=(0.67, 0.01)).fit(dynamic()),
    ),
    "Bayes, bounds": partial(told, lambda: Bayes(box("bounds")).fit(slow())),
    "open": partial(told, open_answer),
    "words": words,
    **{f"refused: {name}": partial(raised, case) for name, case in REFUSED.items()},
}
"""By name."""
