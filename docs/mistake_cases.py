"""What fails.md shows: each mistake that is looked for, as it is made, and its words."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """A mistake as the page shows it."""

    title: str
    code: str
    """of the message"""
    made: tuple[str, str]
    """name and strength in `benchmarks.mistaken`"""
    what: str
    """what it is, and how it comes about"""
    seed: int = 1


CASES = {
    "Frames": (
        Case(
            "The sensor is mounted at an angle",
            "axes-turned",
            ("turned about z", "30°"),
            "The logged pose is that of the flange, and the sensor is turned in it: "
            "screw holes allow any multiple of some angle.",
        ),
        Case(
            "The sensor is elsewhere than the logged frame",
            "lever-arm",
            ("flange behind sensor", "150 mm"),
            "The pose of the flange is logged, and the sensor is ahead of it; or the "
            "torque is given about a TCP.",
        ),
        Case(
            "The wrench is in base axes",
            "wrench-in-base-axes",
            ("wrench in base axes", ""),
            "Some controllers turn the wrench into the axes of the robot's base.",
        ),
        Case(
            "The base is tilted",
            "base-tilted",
            ("base tilted", "15°"),
            "The robot stands on a slope or hangs on a wall, and gravity is not along "
            "-z of its base.",
        ),
        Case(
            "Gravity points the other way",
            "gravity-reversed",
            ("gravity", "upwards"),
            "The robot hangs from the ceiling, z points down in the log, or, as here, "
            "`--gravity` has the wrong sign.",
        ),
    ),
    "Poses": (
        Case(
            "Quaternions with w first",
            "quaternion-order",
            ("quaternion order", "w first"),
            "MuJoCo, Eigen's constructor and many others write w, x, y, z.",
            seed=2,
        ),
        Case(
            "Angles of another form",
            "orientation-form",
            ("form of angles", "roll, pitch, yaw"),
            "Columns RX, RY, RZ are a rotation vector from UR, and angles about axes from "
            "most others; Doosan's a, b, c turn about z, y, z, KUKA's about z, y, x.",
        ),
        Case(
            "The inverse pose",
            "pose-inverse",
            ("inverse pose", "orientation"),
            "The pose of the world in the sensor frame was logged, not that of the sensor "
            "in the world.",
        ),
        Case(
            "Positions in another unit",
            "position-unit",
            ("unit of position", "in"),
            "Millimetres, centimetres or inches are read as metres: accelerations are then "
            "too large by the same factor.",
        ),
        Case(
            "Positions in other axes",
            "position-axes",
            ("axes of position", "swapped"),
            "Columns that are swapped or have the wrong sign, or positions of a tracker in "
            "a world of its own.",
        ),
        Case(
            "Time in another unit",
            "time-unit",
            ("time", "half as fast"),
            "Milliseconds are read as seconds, or the rate is not that of the samples: "
            "accelerations are wrong by the square, and the inertia is wrong even if mass "
            "and COM are right.",
        ),
        Case(
            "Poses that stand still while the robot moves",
            "poses-frozen",
            ("frozen poses", "1 s"),
            "The driver repeats its last pose. These poses are left out and counted.",
        ),
        Case(
            "Poses that jump",
            "pose-glitches",
            ("position glitches", "0.1 m"),
            "No acceleration of a robot explains these single poses. They are left out.",
        ),
        Case(
            "Poses before the driver has started",
            "poses-held-at-ends",
            ("starts with the identity", "100"),
            "The log starts with the identity, or repeats the last pose at its end. These "
            "poses are left out.",
        ),
        Case(
            "A clock that runs fast",
            "clock-rate",
            ("pose clock fast", "1.0%"),
            "Poses and wrench were stamped by different clocks. A constant offset is "
            "found and corrected; a different rate is not.",
        ),
    ),
    "The wrench": (
        Case(
            "A biased log, and --bias none",
            "bias-wrong",
            ("bias none", "5 N"),
            "The sensor was not zeroed, or was zeroed with another load.",
        ),
        Case(
            "An axis with the wrong sign",
            "axis-flipped",
            ("axis flipped", "fx"),
            "One channel has the wrong sign, axes are left-handed, or columns are swapped.",
        ),
        Case(
            "Force and torque in different axes",
            "axes-turned-apart",
            ("torque turned alone", "45°"),
            "Only one of them was turned into the axes of the flange or the tool.",
        ),
        Case(
            "Force and torque in different units",
            "force-unit",
            ("unit of force", "lbf"),
            "Pounds or kilograms of force together with N m, or N together with N mm.",
        ),
        Case(
            "The controller subtracts a payload",
            "wrench-compensated",
            ("compensated wrench", "60% of the payload"),
            "A configured payload is subtracted from the wrench before it is logged.",
        ),
        Case(
            "A low-pass filter",
            "wrench-filtered",
            ("low-passed", "0.7 Hz"),
            "The sensor's own filter is slower than the motion.",
            3,
        ),
        Case(
            "Steps larger than the noise",
            "wrench-quantised",
            ("quantised", "2 N"),
            "Digits are missing, from an analogue input or a printout.",
        ),
        Case(
            "The end of the sensor's range",
            "saturated",
            ("saturated", "60%"),
            "A channel shows its largest value instead of the load.",
        ),
    ),
    "The sensor": (
        Case(
            "Channels with different gains",
            "gain-uneven",
            ("gain of one axis", "10%"),
            "The calibration matrix is that of another sensor, or the sensor has aged. A "
            "gain error that all channels share leaves no residual: a scale shows it (`--mass`).",
        ),
        Case(
            "Channels that respond to one another",
            "cross-talk",
            ("cross-talk", "3%"),
            "A wrong calibration matrix, or bolts that strain the sensor.",
        ),
        Case(
            "One channel that is wrong by itself",
            "channel-wrong",
            ("channel times", "fx, 0.5"),
            "It is in another unit, its gauge is loose or dead, or it is wired to another "
            "channel.",
        ),
        Case(
            "Play or hysteresis",
            "hysteresis",
            ("play", "3%"),
            "The sensor or an adapter is loose.",
        ),
        Case(
            "A gain that changes with the load",
            "gain-by-load",
            ("gain by load", "0.6% per N"),
            "The load is near the end of the sensor's range, or it was calibrated at "
            "another load.",
            seed=3,
        ),
        Case(
            "A mount that gives way",
            "mount-elastic",
            ("soft mount", "4° per N m"),
            "The load turns the sensor, or the whole hand: a plastic adapter, a quick "
            "changer that is not locked.",
        ),
        Case(
            "A sensor that warms up, in a short recording",
            "drift-in-short",
            ("warming up", "6 s"),
            "The bias drifts. In recordings of 8 s and longer a drift is found and removed; "
            "in shorter ones it cannot be separated from the object.",
        ),
    ),
    "The object": (
        Case(
            "A cable pulls",
            "cable-force",
            ("cable", "5 N/m"),
            "The pull of a cable or a hose depends on where the sensor is; weight depends "
            "only on how it is turned.",
        ),
        Case(
            "The arm vibrates",
            "vibration",
            ("vibration", "12 Hz"),
            "A compliant arm, gripper or sensor vibrates faster than the motion. That is no "
            "mistake: it counts as noise.",
        ),
        Case(
            "Something swings",
            "sloshing",
            ("sloshing", "30%"),
            "A liquid or a loose part moves in the object.",
        ),
        Case(
            "Another object during the recording",
            "change-point",
            ("swapped", "1.5"),
            "It was picked up, put down, swapped, or slipped in the gripper. The longest "
            "stretch of one free body is used, with those that only contacts divide from "
            "it.",
        ),
        Case(
            "An object that changes gradually",
            "object-changing",
            ("leaks", "40%"),
            "It leaks, is filled, or creeps in the gripper. There is no single body: the "
            "answer is between those of the start and the end.",
        ),
        Case(
            "A soft grip",
            "grip-elastic",
            ("soft grip", "20 mm"),
            "A suction cup or soft fingers give way, so that the object moves as it is turned.",
        ),
        Case(
            "It touched something",
            "change-touched",
            ("in contact", "55%"),
            "A short contact is left out; after a long one too little remains.",
            seed=4,
        ),
        Case(
            "None of these",
            "unexplained",
            ("a hand on the object", "1 N"),
            "The residual is larger than noise, and no known mistake explains it: here a "
            "hand stays on the object. The answer is doubtful, or not to be used.",
        ),
    ),
}
"""What the page shows, by what is mistaken."""

HEAD = """# When it fails

<!-- written by docs/mistake_pictures.py -->

Every answer begins with a verdict. If noise does not explain a recording, Hefting tries the mistakes of this page,
and names the one that explains it, with what to do. It does not correct them by itself. So:

1. Read the first reason below the verdict. If it names an option, run the command again with it. If it names a column
   map, write one with `hefting map log.csv > map.toml`, change the line in question (as in
   `orientation = { columns = [...], form = "wxyz" }`), and run the command again with `--map map.toml`.
2. If two mistakes are named, correct both. After a correction another mistake may show: repeat.
3. If the reason asks for a change of the recording (payload, cable, mount), change it and record again.
4. If no mistake is named (`unexplained`), look at the residuals (`--report found.html`): where in time, and in which
   channel? Compare with the pictures below, and check the [rules for logs](howto/log.md).

[Mistakes, and the verdict](mistakes.md) says how the search works, and how often each mistake is found.

The pictures are from simulated recordings of ten seconds. Left: the force on the object as recorded (wide and pale)
and as predicted for the body that was found (thin); x is blue, y orange, z green. Middle and right: the residuals of
force and torque. Parts in grey were left out.
"""
TAIL = """
## What no wrench can show

Some mistakes look exactly like another body: a gain error that all channels of the sensor share, a gripper that was
not given as `--tool`, or, in slow motion, a torque about another point. [What cannot be
seen](mistakes.md#what-cannot-be-seen) lists them; a kitchen scale ([`--mass`](howto/tare.md#a-scale)) finds most.

## Errors

A log that cannot be read, or determines nothing, is one line: what is wrong, where, and what to do. The exit status
is then 2, and 3 for an answer that is not to be used. [Messages](messages.md) lists everything that can be said of an
answer.
"""
