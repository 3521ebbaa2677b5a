"""An estimator of the user's own making in place of a method's name: what it must fit."""

from typing import Any

from hefting.core.errors import InputError
from hefting.estimators import Estimator
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape


def shape_of(
    estimator: Estimator, shape: Shape | None, hyperparameters: dict[str, Any]
) -> Shape | None:
    """The estimator's own shape, if it is one of an object; `InputError` where another
    shape, or hyperparameters, are given beside it."""
    own = getattr(estimator, "shape", None)
    for name in (*hyperparameters, *(["shape"] if shape not in (None, own) else [])):
        what = f"`{name}` is given beside an estimator that is complete"
        fix = f"give it to {type(estimator).__name__}, or give the method's name"
        raise InputError(what, fix=fix)
    return own if isinstance(own, Shape) and own.known != "reach" else None


def require_its_bias(estimator: Estimator, found: Ingested) -> None:
    """`InputError` for an estimator without bias where the wrench has one."""
    if found.bias == "estimate" and getattr(estimator, "bias", "estimate") == "none":
        name = type(estimator).__name__
        what = f"the wrench has a bias, which the {name} that is given does not find"
        fix = f"make it {name}(..., bias='estimate'), or give `bias`='none'"
        raise InputError(what, found.log, fix)
