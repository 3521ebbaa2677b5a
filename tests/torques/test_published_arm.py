"""Without an empty run: the URDF's arm, and what its errors do."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hefting.identification import by_torques
from hefting.identification.by_torques import ByTorques
from hefting.identification.torque_checks import cause_of_no_load, link_errors, of_arm
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS, TorqueRobot
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.suspects import Suspects
from torque_runs import BODY, dynamics, fitted, runs


@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_intervals_allow_for_the_links_of_the_published_arm(
    name, tmp_path, monkeypatch
):
    """Of six robots whose links differ from the URDF's by some 10 % in mass; 0.1 kg,
    whatever the arm, had held the mass of one and of four. Joints in another order or of
    another sign are not looked for, which changes no interval."""
    monkeypatch.setattr(by_torques, "of_rivals", lambda *_: [])
    massive, held = TORQUE_ARMS[name], 0
    (tmp_path / "arm.urdf").write_text(massive.urdf)
    for seed in range(6):
        joints = wide_smooth(15.0, 50.0, seed, massive.arm)
        log = TorqueRobot(massive, seed=seed).record(joints, BODY, 60.0, seed=seed)
        found = ByTorques.of([log], tmp_path / "arm.urdf", "flange").estimate()
        assert found.intervals is not None
        low, high = found.intervals["mass"]
        held += low <= BODY.mass <= high
    assert held >= 5


def test_what_links_do_is_what_their_change_does():
    """By least squares anew, of an arm whose links differ; to a half, as
    joints weigh by all of their noise there, and by its slow part here."""
    own = dynamics("panda")
    case = LoadedRuns(own, runs("panda").loaded)
    std = link_errors(own)
    told = Suspects(case, case.fit()).by_links(std)
    (run,) = case.loaded
    W = own.regressor(run.position, run.velocity, run.acceleration)
    for i in np.argsort(-np.abs(told[:, 0]))[:3]:
        torque = run.torque + 0.1 * std[i] * W[..., i]
        changed = replace(run, torque=torque)
        fits = [LoadedRuns(own, (each,)).fit().common[:4] for each in (run, changed)]
        np.testing.assert_allclose(
            fits[1] - fits[0],
            0.1 * told[i, :4],
            atol=0.5 * np.abs(0.1 * told[i, :4]).max(),
        )


def test_a_urdf_without_inertias_does_with_an_empty_run_only(tmp_path):
    """Friction by load had been that of no arm: the mass was 10 % wrong. Without an empty
    run 4.6 kg in place of 0.35 were *usable with care*."""
    text = re.sub("<inertial>.*?</inertial>", "", TORQUE_ARMS["panda"].urdf)
    (tmp_path / "arm.urdf").write_text(text)
    bare = JointDynamics.from_urdf(tmp_path / "arm.urdf", "flange")
    case = replace(runs("panda"), dynamics=bare)
    off = case.fit().common[-10:-6] - fitted("panda").common[-10:-6]
    # what a prior of another size may change
    std = np.sqrt(fitted("panda").covariance.diagonal()[:4])
    assert (np.abs(off) < 0.2 * std).all()
    alone = replace(case, empty=())
    (said,) = of_arm(alone, alone.fit(), [])
    assert said.severity == "error"
    assert said.startswith("the URDF has no inertias")
    assert "record an empty run" in cause_of_no_load(alone.fit())
