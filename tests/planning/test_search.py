"""What is said where no place to start from is free."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from problems import problem

import hefting
from folding_arm import folding_arm
from hefting.core.errors import InputError
from hefting.planning.search import EFFORTS, Searcher
from hefting.planning.space import HalfSpace
from plans import search_briefly


class Crowded(SimpleNamespace):
    """A space in which everything touches: half of all places this, the others that."""

    contacts = True
    half_spaces = (HalfSpace.parse("z>=0.1"),)

    def clearance(self, q):
        return np.full(len(q), -0.01)

    def nearest(self, q):
        return -0.01, self.this if q[0] > 0.0 or q[1] > 0.0 else self.that


@pytest.mark.parametrize(
    ("this", "fix"),
    [
        ("link 'a' and link 'b'", "`srdf`, if these cannot touch"),
        ("link 'a' and the object", "the object's own `shape`, or its box"),
        ("link 'a' and z>=0.1", "relax `keep`"),
        ("the object and z>=0.1", "relax `keep`"),
    ],
)
def test_what_is_near_most_often_is_named_with_what_helps(this, fix):
    space = Crowded(this=this, that="link 'c' and link 'd'")
    own = problem()
    joints = tuple(map(str, range(len(own.start))))
    searcher = Searcher(joints, space, EFFORTS["quick"], np.random.default_rng(1))
    with pytest.raises(InputError) as error:
        searcher.free_starts(own, 1)
    assert f"it is {this}; give `start`, or {fix}" in str(error.value)


class Cell(Crowded):
    """A space in which one of 2,000 places is clear."""

    asked = 0

    def clearance(self, q):
        self.asked += len(q)
        clear = np.arange(self.asked - len(q), self.asked) == 1999
        return np.where(clear, 0.05, -0.01)


def test_a_narrow_cell_has_a_place_to_start_from():
    own, space = problem(), Cell()
    joints = tuple(map(str, range(len(own.start))))
    searcher = Searcher(joints, space, EFFORTS["quick"], np.random.default_rng(1))
    assert searcher.free_starts(own, 12).shape == (1, len(own.start))
    assert space.asked == 2000


def test_joints_that_stay_beyond_half_a_turn_have_a_place_to_start_from():
    """It had been at half a turn, where no motion keeps their range."""
    own, ends = problem(), np.array((3.5, 5.4))
    limits = replace(
        own.constraints.limits, position=np.tile(ends, (len(own.start), 1))
    )
    own = replace(own, constraints=replace(own.constraints, limits=limits))
    joints = tuple(map(str, range(len(own.start))))
    searcher = Searcher(joints, Cell(), EFFORTS["quick"], np.random.default_rng(1))
    (start,) = searcher.free_starts(own, 1)
    assert ((ends[0] < start) & (start < ends[1])).all()


def test_regions_without_a_way_between_are_named(tmp_path, monkeypatch):
    search_briefly(monkeypatch)
    keep = ["z>=0.5", "z<=0.45"]
    with pytest.raises(InputError, match=r"and z[<>]=0\.\d+; .*relax `keep`"):
        hefting.plan(folding_arm(tmp_path), "tool", keep=keep, effort="quick")
