"""Each transport for real, between two processes on this machine: nothing is lost, what
is malformed is counted, and a source that dies is found again."""

import math
import os

import numpy as np
import pytest
from benchmarks.fast_dds import is_installed
from benchmarks.interruptions import run as interrupt
from benchmarks.peers import (
    ORIENTATION,
    POSE,
    RATIO,
    WRENCH,
    count,
    position_of,
    wrench_of,
)
from benchmarks.transports import ADDRESSES, run
from forked_peers import forked_peers

from hefting.sources import UNREADABLE

SECONDS = 0.25
MALFORMED = 40
PEERS = {"ws": "foxglove", "zenoh": "zenoh"}
CLIENTS = {"ws": "websockets", "dds": "cyclonedds", "fastdds": "cyclonedds"}
DDS = ("dds", "fastdds")


def needs(name: str) -> None:
    """Skip where the library of either end is missing."""
    for module in (PEERS.get(name), CLIENTS.get(name)):
        if module is not None:
            pytest.importorskip(module, reason=f"{name}:// needs {module}")
    if name == "fastdds" and not is_installed():
        pytest.skip("Fast DDS is not installed")


@pytest.fixture(scope="module", autouse=True)
def _peers():
    """Peers that start soon, where processes can be forked."""
    if not hasattr(os, "fork"):
        yield
        return
    with forked_peers() as start, pytest.MonkeyPatch.context() as patch:
        for module in ("transports", "interruptions"):
            patch.setattr(f"benchmarks.{module}.start_peer", start)
        yield


@pytest.mark.parametrize("name", ADDRESSES)
def test_nothing_is_lost(name):
    needs(name)
    received, skipped = run(name, SECONDS, MALFORMED)
    wrenches, poses = count(SECONDS)
    assert received.missing(SECONDS) == (0, 0)
    assert len(received.stamps["wrench"]) == wrenches  # none twice either
    values = np.concatenate(received.values["wrench"])
    assert np.array_equal(values, [wrench_of(k) for k in range(wrenches)])
    assert (np.diff(received.stamps["wrench"]) > 0).all()
    if name == "rtde":  # a pose in each package
        poses = wrenches
    ratio = wrenches // poses
    position = np.concatenate(received.values["position"])
    sent = [position_of(k * ratio // RATIO * RATIO) for k in range(poses)]
    assert np.array_equal(position, sent)
    orientation = np.concatenate(received.values["orientation"])
    assert np.array_equal(orientation, np.tile(ORIENTATION, (poses, 1)))
    # DDS hands out only what has the topic's type
    bad = 0 if name in DDS else math.ceil(wrenches / MALFORMED)
    assert sum(skipped.values()) == bad
    if name not in (*DDS, "tcp"):
        assert list(skipped) == [UNREADABLE]


@pytest.mark.parametrize("name", ADDRESSES)
def test_a_source_that_dies_is_found_again(name):
    needs(name)
    found, pump = interrupt(name, 2, life=0.1)
    assert pump.state == "ended"
    assert pump.error is None
    assert min(found.wrenches) > 0
    # DDS has no connection that could be lost
    lost = 0 if name in DDS else 1
    back = found.said["source-back"]
    if name == "zenoh":
        assert back <= lost  # a router that is back within a second is never missed
    else:
        assert back == lost
    # the end of the second life may be noticed as well
    assert back <= found.said["source-lost"] <= back + lost


@pytest.mark.parametrize("kind", [WRENCH, POSE, "tf2_msgs/msg/TFMessage"])
def test_dds_types_have_the_names_that_ros_gives_them(kind):
    # publishers of ROS tell nothing else of a type, so that no other name is matched
    pytest.importorskip("cyclonedds")
    from hefting.sources.dds import type_for

    package, name = kind.split("/msg/")
    named = f"{package}::msg::dds_::{name}_"
    assert type_for(kind).__idl_typename__ == named
    assert type_for(kind).__idl__.idl_transformed_typename == named
