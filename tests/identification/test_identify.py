"""Identify: what it settles for a method where nothing is said."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.clean import simulated

from hammers import shape
from hefting.core.accuracy import errors_between
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.identification import identify
from hefting.simulation import UR5, hammer, random_smooth, simulate

BODY = hammer().parameters


def recorded(exact=False):
    motion = UR5.motion(random_smooth(4.0, 100.0, 1.0, 2))
    return simulate(motion, BODY, noise=Noise(0.1, 0.005), seed=2, exact=exact)


def test_the_blended_model_of_smoothed_poses_is_hardly_blended():
    """c1 is 1 where poses are smoothed here, and the paper's 300 where accelerations
    were recorded."""
    log = recorded()
    found = identify(log, shape(), method="PMD").estimate
    assert found.provenance["c1"] == 1.0
    assert identify(log, shape(), method="PMD", c1=5.0).estimate.provenance["c1"] == 5.0
    assert (
        identify(recorded(exact=True), shape(), method="PMD").estimate.provenance["c1"]
        == 300.0
    )
    # with the paper's most samples would count as at rest, which they are not: several
    # times the errors
    paper = identify(log, shape(), method="PMD", c1=300.0).estimate
    own, theirs = (
        errors_between(e.parameters, BODY, shape().extents) for e in (found, paper)
    )
    assert own.center_of_mass < 0.5 * theirs.center_of_mass
    assert own.inertia_at_origin < 0.5 * theirs.inertia_at_origin


@pytest.mark.parametrize("kind", ["smooth", "orientation", "columns", "static"])
def test_what_was_found_can_be_pickled(kind):
    """As a pool of processes hands it back, from each source of motion."""
    log = recorded(exact=kind == "columns")
    left = {k: v for k, v in log.streams.items() if k in ("wrench", "orientation")}
    if kind in ("orientation", "static"):
        log = replace(log, streams=left, static=kind == "static")
    found = identify(log, shape(), method="OLS")
    again = pickle.loads(pickle.dumps(found))
    path, same = found.ingested.conditioned.path, again.ingested.conditioned.path
    assert path.kind == kind
    assert again.mass == found.mass
    time = log["wrench"].time[5:50]
    assert np.array_equal(path.at(time).value, same.at(time).value)
    assert again.estimate.to_dict() == found.estimate.to_dict()


def test_samples_after_the_last_pose_are_no_doubt():
    """As a clock offset leaves them: 0.2 s of 5 s. The rest is as good as it would be."""
    made, *_ = simulated(1, 5.0)

    def with_poses(last):
        streams = {k: s if k == "wrench" else s[:last] for k, s in made.streams.items()}
        return identify(replace(made, streams=streams)).estimate

    late = with_poses(-20)
    assert "outside-poses" in codes(late.provenance["notes"])
    assert late.verdict.level == "good"
    # of 0.8 s other clocks are a likelier cause
    assert "outside-poses" in codes(with_poses(-80).warnings)
