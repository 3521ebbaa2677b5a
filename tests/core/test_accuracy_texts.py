"""Numbers with units; the accuracy that is asked for, in texts."""

import itertools

import numpy as np
import pytest

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.quantity import UNITS, quantity


def one_line(error: InputError) -> bool:
    return "\n" not in str(error) and "Error" not in str(error)


# quantity


WRITTEN = [
    ("length", "m", "2 m", 2.0),
    ("length", "cm", "1.5cm", 0.015),
    ("length", "mm", " 2mm ", 0.002),
    ("length", "um", ".5um", 5e-7),
    ("angle", "rad", "1e-2rad", 0.01),
    ("angle", "deg", "90deg", np.pi / 2.0),
    ("angle", "°", "3 °", np.pi / 60.0),
    ("share", "%", "20%", 0.2),
    ("share", "", "0.2", 0.2),
    ("percentage", "%", "20 %", 0.2),
    ("force", "N", "0.3 N", 0.3),
    ("force", "mN", "20mN", 0.02),
    ("torque", "Nm", "0.01Nm", 0.01),
    ("torque", "N m", "2 N m", 2.0),
    ("torque", "mNm", "5 mNm", 0.005),
    ("mass", "kg", "0.5kg", 0.5),
    ("mass", "g", "512 g", 0.512),
    ("mass", "lb", "1lb", 0.45359237),
    ("mass", "oz", "16oz", 0.45359237),
]


@pytest.mark.parametrize(("kind", "unit", "text", "value"), WRITTEN)
def test_every_unit(kind, unit, text, value):
    assert quantity(text, kind) == pytest.approx(value, rel=1e-15)
    for number in ("0", "7", "7.", "0.125", ".125", "1e3", "2.5e-3", "1e+2", "007"):
        scale = value / quantity(text.replace(unit, "") if unit else text, "share")
        assert quantity(number + unit, kind) == pytest.approx(
            float(number) * scale, rel=1e-15
        ), number


def test_no_unit_is_left_out_above():
    assert {(kind, unit) for kind, units in UNITS.items() for unit in units} == {
        row[:2] for row in WRITTEN
    }


HOSTILE = (
    *(
        "",
        " ",
        "-1mm",
        "+1mm",
        "--1mm",
        "nan",
        "nanmm",
        "inf",
        "infmm",
        "1e999mm",
        "1e-999mm",
        "1_0mm",
        "0x1mm",
    ),
    *(
        "1,5mm",
        "1.2.3mm",
        ".mm",
        "e3mm",
        "1e mm",
        "1/2mm",
        "mm1",
        "1mm1",
        "1mm;rm",
        "1m m",
        "1MM",
        "1mmm",
        "²mm",
    ),
    *(
        "1\0mm",
        "1mm\0",
        "%",
        "1%%",
        "1st",
        "1 in",
        "5mm,5deg",
        "(1)",
        "1" * 61 + "mm",
        "1" * 200_000,
        "m" * 200_000,
    ),
)


@pytest.mark.parametrize("kind", UNITS)
def test_nothing_else_is_a_quantity(kind):
    foreign = sorted(
        {unit for units in UNITS.values() for unit in units} - set(UNITS[kind])
    )
    for text in (*HOSTILE, *(f"1{unit}" for unit in foreign)):
        with pytest.raises(
            InputError, match=f"is not a {kind}; a number and a unit: "
        ) as caught:
            quantity(text, kind)
        assert one_line(caught.value)


def test_random_texts_are_numbers_or_refused():
    """What is taken is what a number followed by its unit means."""
    rng, taken = np.random.default_rng(1), 0
    for _ in range(20_000):
        text = "".join(rng.choice(list("0123456789..ee+-mmcu%° "), rng.integers(1, 8)))
        try:
            value = quantity(text, "length")
        except InputError:
            continue
        taken += 1
        unit = next(
            unit for unit in ("cm", "mm", "um", "m") if text.strip().endswith(unit)
        )
        assert value == pytest.approx(
            float(text.strip().removesuffix(unit)) * UNITS["length"][unit], rel=1e-15
        ), text
        assert 0.0 <= value < np.inf
    assert taken > 20


# in texts


@pytest.mark.parametrize(
    ("text", "limits"),
    [
        ("mass=1%,com=2mm,inertia=20%", (0.01, 0.002, 0.2)),
        (" inertia = 20% , mass = 1e0 % ", (0.01, None, 0.2)),
        ("com=1cm", (None, 0.01, None)),
    ],
)
def test_an_accuracy_in_words(text, limits):
    found = Accuracy.parse(text)
    for value, limit in zip(
        (found.mass, found.center_of_mass, found.inertia), limits, strict=True
    ):
        assert value == (None if limit is None else pytest.approx(limit, rel=1e-15))


def test_what_is_written_is_read():
    """Three digits are shown: the same to half of the last, and to the letter the
    second time."""
    rng = np.random.default_rng(2)
    for given in itertools.product((False, True), repeat=3):
        for _ in range(40 * any(given)):
            limits = [10.0 ** rng.uniform(-9, 4) if each else None for each in given]
            asked = Accuracy(*limits)
            again = Accuracy.parse(str(asked))
            for one, two in zip(
                limits, (again.mass, again.center_of_mass, again.inertia), strict=True
            ):
                assert two == (None if one is None else pytest.approx(one, rel=5.1e-3))
            assert str(again) == str(asked)
    assert str(Accuracy(0.01, 0.002, 0.2)) == "mass=1%,com=2mm,inertia=20%"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "'' is no accuracy; as in mass=1%"),
        ("mass", "'mass' is no accuracy; as in"),
        ("mas=1%", "did you mean 'mass'?"),
        ("Mass=1%", "did you mean 'mass'?"),
        ("mass=1%,", "'' is no accuracy"),
        ("mass=1%,mass=2%", "mass is given twice in 'mass=1%,mass=2%'"),
        ("mass=", "mass: '' is not a percentage"),
        ("mass=1mm", "mass: '1mm' is not a percentage"),
        ("inertia=-1%", "inertia: '-1%' is not a percentage"),
        ("mass=nan", "mass: 'nan' is not a percentage"),
        ("mass==1%", "mass: '=1%' is not a percentage"),
        ("com=2%", "com: '2%' is not a length; a number and a unit: m, cm, mm, um"),
        ("mass=1", "mass: '1' is not a percentage; a number and a unit: %"),
        ("com=2", "com: '2' is not a length"),
        ("mass=1%\ncom=2mm", "mass: '1% com=2mm' is not a percentage"),
        ("mass=0%", "one or more positive limits; as in mass=1%"),
        ("mass=1e-99%,com=0um", "one or more positive limits"),
    ],
)
def test_what_is_no_accuracy_is_told_in_one_line(text, said):
    with pytest.raises(InputError) as caught:
        Accuracy.parse(text)
    assert said in str(caught.value)
    assert one_line(caught.value)


@pytest.mark.parametrize(
    "limits", [(), (0.0,), (0.01, -1.0), (np.nan, 0.01, 0.01), (None, None, 0.0)]
)
def test_limits_are_positive(limits):
    with pytest.raises(InputError, match="one or more positive limits"):
        Accuracy(*limits)


def test_what_suffices_and_what_is_missing():
    asked = Accuracy(mass=0.01, center_of_mass=0.002)
    cases = {
        (0.01, 0.002, 5.0): "",  # as good as asked; the inertia does not matter
        (0.001, 0.001, None): "",
        (0.02, 0.001, 0.1): "the mass is known to 2%, not 1%",
        (0.001, 0.0031, 0.1): "the COM is known to 3.1mm, not 2mm",
        (
            0.02,
            0.003,
            0.1,
        ): "the mass is known to 2%, not 1% and the COM is known to 3mm, not 2mm",
        (np.inf, 0.001, 0.1): "the mass is open, not known to 1%",
        (0.001, None, 0.1): "the COM is open, not known to 2mm",
    }
    for limits, missing in cases.items():
        claimed = Accuracy(*limits)
        assert asked.shortfall(claimed) == missing
        assert asked.met_by(claimed) is (missing == "")
    assert Accuracy(mass=np.inf, inertia=0.1).met_by(Accuracy(np.inf, 0.1, 0.1))
    assert (
        Accuracy(inertia=0.2).shortfall(Accuracy(inertia=0.3))
        == "the inertia is known to 30%, not 20%"
    )
    assert str(Accuracy(np.inf, 0.001, np.inf)) == "mass=open,com=1mm,inertia=open"
