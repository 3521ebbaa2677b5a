"""Bodies added to real recordings: that they are added right, and a quick run of the
benchmark."""

from functools import cache

import numpy as np
import pytest
from benchmarks.injected import SOURCES, WINDOWS, Host, cases, hosts
from benchmarks.injected_runs import METHODS, identified
from benchmarks.injection import line

from hefting.core.inertia import InertialParameters
from hefting.ingest.ingest import ingest
from recordings import DATA, needs_recordings

pytestmark = needs_recordings
BODY = InertialParameters.from_com(0.8, (0.01, -0.02, 0.06), 1e-3 * np.eye(3))


@cache
def ready() -> tuple[Host, ...]:
    """One recording of each set, the last of them in halves."""
    return tuple(hosts(DATA, SOURCES[::2]))


@pytest.mark.usefixtures("nothing_looked_for")
def test_a_body_that_is_added_is_found_by_least_squares():
    """What least squares finds with it is more by the body than without: the same
    samples, noise and bias. Clock offset and outliers are found anew, which moves the
    mass by some parts in a thousand."""
    for host in ready()[:3]:
        alone, both = (
            ingest(log, gravity=host.gravity).fit
            for log in (host.recording, host.with_body(BODY))
        )
        assert both.vector[0] - alone.vector[0] == pytest.approx(0.8, rel=0.01), (
            host.set
        )
        moment = (both.vector[1:4] - alone.vector[1:4]) / 0.8
        np.testing.assert_allclose(moment, BODY.center_of_mass, atol=2e-3)


def test_cases_are_wholes_and_parts_of_each_set():
    found = list(cases(list(ready()), 1, 1))
    assert {case.host.set for case in found} == {"panda", "kuka", "axia"}
    assert {case.window for case in found} == {None, *WINDOWS}
    for case in found:
        if case.window is not None:
            assert case.recording.duration <= case.window
        assert 0.1 <= case.body.parameters.mass <= 2.0


def test_intervals_of_one_body(capsys):
    """Parts of 6 s by both methods: of ten numbers each, four fifths at least are held,
    and a row of the table says so."""
    found = [case for case in cases(list(ready()), 1, 3) if case.window == 6.0]
    runs = [run for case in found for run in identified(case)]
    assert {run.method for run in runs} == set(METHODS)
    held = [run.held for run in runs if run.held is not None]
    assert np.mean(held) > 0.8
    row = line("all", runs)
    assert row["number"] == len(runs)
    assert f"{row['held']:.1f}" in capsys.readouterr().out


@pytest.mark.usefixtures("same_recordings")
def test_what_is_exact_makes_intervals_narrower():
    """Each error that is allowed for widens the interval of the mass."""
    found = [case for case in cases(list(ready()), 1, 3) if case.window is None]
    for case in found:
        usual = identified(case)
        for exact in (("sensor",), ("tool",)):
            for own, run in zip(usual, identified(case, exact), strict=True):
                assert run.half_width < own.half_width, (case.host.set, exact)
