"""The part of a recording that is used: two mistakes at once are looked for in the whole
where they may account for its changes."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.changing import case

from given_cases import correct, mistake, undone_of
from hefting.ingest import chosen_part, condition
from hefting.ingest.ingest import ingest
from hefting.ingest.rivals import bias, two_mistakes, units


@pytest.fixture
def searches(monkeypatch):
    """Of each search for mistakes whether two at once were looked for, and when [s] the
    recording that they were looked for in ends."""
    made, doubt_of = [], chosen_part.doubt_of

    def search(case, *, with_tool, pairs=True):
        made.append((pairs, case.recording["wrench"].time[-1]))
        return doubt_of(case, with_tool=with_tool, pairs=pairs)

    monkeypatch.setattr(chosen_part, "doubt_of", search)
    return made


def test_two_mistakes_are_not_looked_for_beside_a_change_that_leaves_a_right_part(
    searches,
):
    """Of an object that is put down the whole is understood as wrongly as with two
    mistakes, and the part as right."""
    found = ingest(case("put-down", 1).recording)
    assert found.changes is not None
    (whole, end), (part, end_of_part) = searches
    assert not whole
    assert part
    assert end_of_part < end


@pytest.mark.parametrize(
    ("made", "searched"),
    [
        ((("turned about x", "180°"), ("unit of force", "kgf")), [False, True]),
        (
            (("unit of position", "in"), ("bias none", "1 N")),
            [False, False, True, True],
        ),
    ],
    ids=["one explains the whole", "the part is wrong"],
)
def test_two_mistakes_that_look_like_changes_are_found_in_the_whole(
    made, searched, searches, monkeypatch
):
    """In place of one that explains all of it, and of a part that is wrong; among a few
    that are undone."""
    among = undone_of(units.force_undone, units.position_undone, bias.undone)
    monkeypatch.setattr(two_mistakes, "UNDONE", among)
    given, rng = correct(2), np.random.default_rng(1)
    for name in made:
        given = mistake(*name).make(given, rng)
    found = ingest(given.recording, bias=given.options.get("bias", "auto"))
    assert found.changes is None
    assert found.doubt is not None
    assert found.doubt.second is not None
    assert [pairs for pairs, _ in searches] == searched


@pytest.mark.parametrize(("knots", "judged"), [(1, 2), (2, 2), (5, 5), (30, 8)])
def test_mistakes_are_judged_beside_the_drift_that_is_removed(knots, judged):
    """Half of a payload in slow motion had been *good* beside a drift that bends."""
    recording = correct(1).recording
    found = condition(recording)
    time = np.linspace(0.0, 10.0, knots)
    drift = replace(found.bias, knots=time, values=np.zeros((knots, 6)))
    found = replace(found, bias=drift)
    case = chosen_part._case(recording, found, may_be_biased=True, sensor_errors=0.005)
    assert case is not None
    assert case.bias_functions.shape[1] == judged
