"""hefting simulate: write the log of a simulated robot that wields an object, and the
truth beside it."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.options import POSE, add_number
from hefting.cli.parser import wrote
from hefting.cli.progress import progress
from hefting.cli.simulated_files import check_outputs, read_back, truth_of, write_beside
from hefting.core.errors import InputError, printable
from hefting.core.quantity import numbers
from hefting.request.settings import pose_of

if TYPE_CHECKING:
    from hefting.simulation import Faults
    from hefting.simulation.objects import HeldObject
    from hefting.simulation.scenario import Scenario, Simulated

EXAMPLES = (
    "hefting simulate log.csv --mesh hammer.stl",
    "hefting simulate held.mcap --object tee --arm xarm7 --motion random",
    "hefting simulate held.csv --torques --arm panda",
    "hefting simulate bad.csv --bias 20 --offset 0.03 --spikes 0.02 --seed 3",
)

LASTS = 10.0
"""[s] Default duration of a recording."""
LEVER = 0.05
"""[m] Torque over force of a bias or a drift that is given by its force only."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting simulate``."""
    from hefting.logs.registry import formats

    suffixes = sorted(
        (suffix for each in formats() for suffix in each.written),
        key=lambda suffix: not suffix,
    )
    written = ", ".join(suffix or "or no suffix for a folder" for suffix in suffixes)
    parser.add_argument("output", metavar="OUTPUT", help=f"log: {written}")
    scene = parser.add_argument_group("what is simulated (in MuJoCo)")
    scene.add_argument(
        "--object",
        metavar="NAME|MESH[,MESH...]",
        default="hammer",
        help="the paper's hammer, barbell, tee, uniform, corners, rod, half-n-half or empty; joiners-hammer; or "
        "watertight meshes in one frame; default %(default)s",
    )
    scene.add_argument("--density", metavar="D[,D...]", help="of each mesh [kg/m³]")
    scene.add_argument(
        "--unit", metavar="m|cm|mm|in", help="length unit of the meshes; default m"
    )
    scene.add_argument(
        "--object-pose",
        metavar="POSE",
        help=f"the object's frame in the sensor frame: {POSE}",
    )
    arms = "ur5|xarm7|FILE.urdf"
    scene.add_argument("--arm", metavar=arms, default="ur5", help="default ur5")
    scene.add_argument(
        "--sensor-frame", metavar="NAME", help="of a URDF: link that carries the sensor"
    )
    scene.add_argument(
        "--motion",
        metavar="sinusoids|random|stop-and-go",
        default="sinusoids",
        help="default sinusoids",
    )
    add_number(scene, "--speed", "RAD/S", "mean angular speed; default 1")
    add_number(
        scene, "--speed-limit", "M/S", "slower, so that the sensor never exceeds this"
    )
    add_number(scene, "--duration", "S", "default 10; with --torques 30")
    scene.add_argument(
        "--torques",
        action="store_true",
        help="joint torques in place of a wrench, of ur5e, panda or xarm7: an empty run "
        "and a URDF beside the log",
    )
    add_number(scene, "--tilt", "DEG", "of the robot's base", default=0.0)
    scene.add_argument(
        "--seed", type=int, default=0, help="of all that is random; default %(default)s"
    )
    log = parser.add_argument_group("what the log holds")
    add_number(log, "--rate", "HZ", "of the wrench; default 100", default=100.0)
    add_number(log, "--pose-rate", "HZ", "default that of the wrench; 0: no poses")
    add_number(log, "--joint-rate", "HZ", "joint angles; default none", default=0.0)
    add_number(
        log, "--imu-rate", "HZ", "gyroscope, accelerometer; default none", default=0.0
    )
    fault = parser.add_argument_group("what is wrong with it")
    fault.add_argument(
        "--noise",
        metavar="none|low|moderate|high|ft300",
        default="ft300",
        help="default %(default)s",
    )
    add_number(fault, "--noise-correlation", "R", "from sample to sample", default=0.0)
    fault.add_argument(
        "--bias",
        metavar="N|FX,FY,FZ,TX,TY,TZ",
        help="of the wrench; or the size of its force, in a random direction",
    )
    fault.add_argument(
        "--drift", metavar="N|FX,FY,FZ,TX,TY,TZ", help="of the bias over the recording"
    )
    fault.add_argument(
        "--drift-kind",
        metavar="linear|exponential",
        default="linear",
        help="default %(default)s",
    )
    add_number(fault, "--offset", "S", "how late the wrench is stamped", default=0.0)
    add_number(
        fault, "--spikes", "SHARE", "of wrench samples that are wrong", default=0.0
    )
    add_number(fault, "--dropped", "SHARE", "of messages that are lost", default=0.0)
    add_number(
        fault, "--contacts", "SHARE", "of the time that it touches things", default=0.0
    )
    fault.add_argument(
        "--saturation", metavar="N,NM", help="largest force and torque shown"
    )
    add_number(
        fault, "--pose-glitches", "SHARE", "of poses that are wrong", default=0.0
    )
    add_number(
        fault,
        "--pose-stalls",
        "SHARE",
        "of the time that the pose is repeated",
        default=0.0,
    )
    add_number(
        fault,
        "--pose-startup",
        "S",
        "time at the start with the identity as pose",
        default=0.0,
    )
    fault.add_argument(
        "--on-sensor",
        action="store_true",
        help="the sensor shows the wrench exerted on itself",
    )
    results = parser.add_argument_group("results beside the log")
    results.add_argument(
        "--truth", metavar="FILE.json", help="written, default OUTPUT.truth.json"
    )
    results.add_argument(
        "--mesh",
        metavar="FILE",
        help="write the object's shape [m]: .stl, .ply, .obj, .off or .glb",
    )


def run(arguments: argparse.Namespace) -> None:
    """Simulate, write, and print a description and the command that reads it."""
    from hefting.logs import write_log
    from hefting.simulation.scenario import mujoco_version

    a = arguments
    if a.torques:
        _simulate_torques(a)
        return
    a.duration = LASTS if a.duration is None else a.duration
    output = Path(a.output)
    truth = truth_of(a)
    check_outputs(a, truth)
    mujoco_version()  # fails at once where it is missing
    scenario = _scenario(a)
    with progress("simulating", stages={"simulating": 1.0}):
        made = scenario.run()
        lost = write_log(made.recording, output)
        write_beside(a, scenario.held, made.facts, truth)
    print(*map(printable, _description(scenario, made)), sep="\n")
    if lost:
        print(
            f"warning: not written, as the format cannot hold it: {', '.join(lost).replace('_', ' ')}"
        )
    wrote(*(path for path in (output, truth, a.mesh) if path))
    print(printable(read_back(a, scenario, made, truth)))


def _simulate_torques(a: argparse.Namespace) -> None:
    """Simulate two runs with joint torques in place of a wrench."""
    from hefting.cli.simulated_files import beside, check_options, simulate_torques
    from hefting.simulation.scenario import mujoco_version

    fresh = argparse.ArgumentParser()
    add_arguments(fresh)
    check_options(a, fresh._actions)
    truth = truth_of(a)
    check_outputs(a, truth, *beside(Path(a.output)))
    mujoco_version()  # fails at once where it is missing
    simulate_torques(a, _held(a), truth)


def _held(a: argparse.Namespace) -> "HeldObject":
    from hefting.simulation.scenario import named_object

    densities = numbers(a.density, None, "--density") if a.density else ()
    return named_object(a.object, densities, a.unit, pose_of(a.object_pose))


def _scenario(a: argparse.Namespace) -> "Scenario":
    import numpy as np

    from hefting.simulation import Rates, tilted_gravity
    from hefting.simulation.scenario import Scenario, named_arm

    if a.seed < 0:
        raise InputError(f"'{a.seed}' is negative", where="--seed")
    heading = float(np.random.default_rng([a.seed, 1]).uniform(-np.pi, np.pi))
    if not abs(a.tilt) <= 180.0:
        raise InputError(
            f"'{a.tilt}' is not an angle from -180 to 180 degrees", where="--tilt"
        )
    return Scenario(
        held=_held(a),
        arm=named_arm(a.arm, a.sensor_frame),
        motion=a.motion,
        angular_speed=a.speed,
        speed_limit=a.speed_limit,
        duration=a.duration,
        rates=Rates(
            a.rate,
            a.rate if a.pose_rate is None else a.pose_rate,
            a.joint_rate,
            a.imu_rate,
        ),
        gravity=tilted_gravity(np.radians(a.tilt), heading),
        faults=_faults(a),
        seed=a.seed,
    )


def _faults(a: argparse.Namespace) -> "Faults":
    from hefting.core.errors import nearest
    from hefting.simulation import WRENCH_NOISE, Faults

    if a.noise not in WRENCH_NOISE:
        fix = f"use {', '.join(WRENCH_NOISE)}"
        raise InputError(
            f"'{a.noise}' is no noise level{nearest(a.noise, WRENCH_NOISE)}",
            "--noise",
            fix,
        )
    return Faults(
        wrench_noise=WRENCH_NOISE[a.noise],
        noise_correlation=a.noise_correlation,
        bias=_six(a.bias, "--bias", [a.seed, 2]),
        drift=_six(a.drift, "--drift", [a.seed, 3]),
        drift_kind=a.drift_kind,
        wrench_delay=a.offset,
        spikes=a.spikes,
        dropped=a.dropped,
        contacts=a.contacts,
        saturation=tuple(numbers(a.saturation, 2, "--saturation"))
        if a.saturation
        else None,  # type: ignore[arg-type]
        on_sensor=a.on_sensor,
        pose_glitches=a.pose_glitches,
        pose_stalls=a.pose_stalls,
        pose_startup=a.pose_startup,
    )


def _six(text: str | None, option: str, seed: list[int]) -> tuple:
    """Six numbers; for one, a force of that size in a random direction, with a torque."""
    from hefting.simulation.scenario import random_six

    if not text:
        return (0.0,) * 6
    if "," in text:
        return tuple(numbers(text, 6, option))
    (force,) = numbers(text, 1, option)
    return tuple(random_six(force, LEVER * force, seed).tolist())


def _description(scenario: "Scenario", made: "Simulated") -> list[str]:
    about, body = made.facts["simulation"], scenario.held.parameters
    lines = [
        f"{scenario.held.name}, {body.mass:.4g} kg, on the arm {about['arm']}; wrench from {about['engine']}",
        f"{about['motion']} for {about['duration']:g} s: mean {about['mean_angular_speed']:.3g} rad/s, "
        f"{about['mean_linear_speed']:.3g} m/s at the sensor, seed {about['seed']}",
    ]
    rates = made.recording.rates()
    lines += [
        f"  {name.replace('_', ' '):<16}{rates[name]:>8.4g} Hz"
        for name in made.recording.streams
    ]
    return lines + [f"warning: {render(line)}" for line in made.warnings]
