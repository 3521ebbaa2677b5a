"""Cases of answers as they are told, written and read again."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hammers import shape
from hefting.core.accuracy import Accuracy
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import fields_of
from hefting.core.inertia import PARAMETERS_OF
from hefting.core.quantity import MassReading
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
from reference.held import biased, box, dynamic, few, slow

READ_AGAIN = {"covariance", "intervals", "vector", "point_masses", "provenance"}
"""Parts of an estimate's JSON that are told as they are read again."""


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
    "provenance": lambda: [
        {**method.provenance, "sampling": method.sampling}
        for method in (
            *(OLS("estimate"), RTLS(), LMI(box()), PMD(shape(), c1=3.0)),
            *(
                GEO(shape()),
                GEO(shape(), gamma=3.0),
                GEO(shape(), distance="euclidean"),
            ),
            *(
                Bayes(shape(), mass="1.00kg"),
                Bayes(box("bounds"), sensor_accuracy="1%"),
            ),
            OLS(model="blended", c1=7.0, mass=(0.6, 0.01)),
        )
    ],
}
"""By name."""
