"""Mistakes with the bias, and with units."""

from benchmarks.mistaken.catalogue import Add, named
from benchmarks.mistaken_poses import position_axes, positions
from benchmarks.mistaken_wrenches import anothers_bias, unbiased_options, units


def add_values(add: Add) -> None:
    """A wrong bias, and other units of positions, forces and torques."""
    add(
        "bias none",
        named("bias-wrong"),
        {f"{b:g} N": unbiased_options(b) for b in (1.0, 5.0, 20.0)},
    )
    add(
        "another run's bias",
        named("bias-wrong"),
        {f"{b:g} N": anothers_bias(b) for b in (1.0, 3.0, 8.0)},
    )
    add(
        "unit of position",
        named("position-unit"),
        {
            "mm": positions(1e3),
            "cm": positions(1e2),
            "in": positions(1 / 0.0254),
        },
    )
    add(
        "axes of position",
        named("position-axes"),
        {
            "swapped": position_axes((0, 1, 0), (1, 0, 0), (0, 0, 1)),
            "mirrored": position_axes((1, 0, 0), (0, -1, 0), (0, 0, 1)),
            "y up": position_axes((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        },
    )
    wrong_unit = named(
        "force-unit",
        "torque-unit",
        "wrong-unit",
        "com-outside-shape",
        "com-implausible",
    )
    add(
        "unit of force",
        wrong_unit,
        {
            "kgf": units(1 / 9.80665, 1.0),
            "lbf": units(1 / 4.4482, 1.0),
            "g": units(101.97, 1.0),
        },
    )
    add(
        "unit of torque",
        wrong_unit,
        {
            "N mm": units(1.0, 1e3),
            "N cm": units(1.0, 100.0),
            "lbf in": units(1.0, 8.85),
        },
    )
