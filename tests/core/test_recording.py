"""Recording: streams keep their clocks; what cannot be right is refused with row and
column."""

import pickle

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.recording import (
    COLUMNS,
    JOINT_STREAMS,
    Recording,
    Stream,
    all_finite,
    column_names,
)

WIDTHS = {
    name: 2 if name in JOINT_STREAMS else len(columns)
    for name, columns in COLUMNS.items()
}


def stream(name: str, time, seed: int = 0) -> Stream:
    values = np.random.default_rng(seed).normal(size=(len(time), WIDTHS[name]))
    if name == "orientation":
        values /= np.linalg.norm(values, axis=1)[:, None]
    return Stream(np.asarray(time, dtype=float), values)


def recording(**times) -> Recording:
    return Recording({name: stream(name, time) for name, time in times.items()})


def test_every_stream_of_the_table_is_accepted_in_the_table_s_order():
    names = list(COLUMNS)
    full = Recording({name: stream(name, np.arange(4)) for name in reversed(names)})
    assert list(full.streams) == names
    assert full.has(*names)
    assert column_names("joint_velocities", 3) == ("dq1", "dq2", "dq3")


@pytest.mark.parametrize(
    "name", [name for name in COLUMNS if name not in JOINT_STREAMS]
)
def test_a_wrong_width_is_refused(name):
    with pytest.raises(
        InputError, match=f"{name}.*{WIDTHS[name] + 1} columns, not {WIDTHS[name]}"
    ):
        Recording({name: Stream(np.arange(3.0), np.ones((3, WIDTHS[name] + 1)))})


def test_arrays_are_copied_and_read_only():
    time, values = np.arange(3.0), np.zeros((3, 6))
    wrench = Recording({"wrench": Stream(time, values)})["wrench"]
    time[0] = values[0, 0] = 7.0
    assert wrench.time[0] == wrench.values[0, 0] == 0.0
    for array in (wrench.time, wrench.values, wrench.rows):
        assert not array.flags.writeable


@pytest.mark.parametrize(
    ("time", "values"),
    [
        (np.arange(3), np.ones((2, 6))),
        (np.arange(3), np.ones(3)),
        ([], np.ones((0, 6))),
        (np.ones((2, 1)), np.ones((2, 6))),
    ],
)
def test_shapes_that_disagree_are_refused(time, values):
    with pytest.raises(InputError, match="a stream needs"):
        Stream(np.asarray(time, dtype=float), values)


def test_unknown_and_absent_streams_are_named():
    with pytest.raises(InputError, match=r"'wrenches'.*did you mean 'wrench'"):
        Recording({"wrenches": stream("wrench", [0, 1])})
    with pytest.raises(InputError, match="no samples"):
        Recording({})
    with pytest.raises(InputError, match=r"has no position \(columns px py pz\)"):
        recording(wrench=[0, 1])["position"]


def test_streams_that_are_none_are_refused():
    with pytest.raises(InputError, match=r"dictionary of hefting.Stream.*as_recording"):
        Recording(np.arange(3.0))
    with pytest.raises(InputError, match=r"dictionary of hefting.Stream"):
        Recording({"position": np.zeros((3, 3))})


def test_joint_streams_must_agree():
    with pytest.raises(InputError, match="differ in number"):
        Recording(
            {
                name: Stream(np.zeros(1), np.ones((1, n)))
                for n, name in enumerate(JOINT_STREAMS, 1)
            }
        )


def test_joint_names_are_as_many_as_joint_columns():
    q = {"joint_positions": Stream(np.zeros(1), np.ones((1, 2)))}
    assert Recording(q, joint_names=("one", "two")).joint_names == ("one", "two")
    with pytest.raises(InputError, match="3 joint names for 2 joint columns"):
        Recording(q, joint_names=("one", "two", "three"))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_named_by_row_and_column(bad):
    values = np.zeros((5, 6))
    values[3, 1] = values[4, 0] = bad
    with pytest.raises(InputError, match=f"log, row 14, column fy: the value is {bad}"):
        Recording(
            {"wrench": Stream(np.arange(5.0), values, np.arange(11, 16))}, source="log"
        )
    time = np.arange(5.0)
    time[2] = bad
    with pytest.raises(InputError, match="row 3, column time"):
        Recording({"wrench": Stream(time, np.zeros((5, 6)))})


def test_time_increases_within_a_stream_and_not_across_them():
    recording(wrench=[0, 1, 2], orientation=[0, 0.5, 1])
    with pytest.raises(
        InputError,
        match="row 3, column time: time 1 s repeats that of row 2 in the wrench stream",
    ):
        recording(wrench=[0, 1, 1, 2])
    with pytest.raises(
        InputError, match=r"row 3, column time: time 0\.5 s is before 1 s of row 2"
    ):
        recording(wrench=[0, 1, 0.5, 2])


def test_quaternions_are_normalised_once_and_keep_their_sign():
    rng = np.random.default_rng(3)
    q = rng.normal(size=(500, 4))
    q *= (1 + rng.uniform(-0.009, 0.009, 500))[:, None] / np.linalg.norm(q, axis=1)[
        :, None
    ]
    q[7] = (0.0, 0.6, 0.0, 0.8)  # which is normalised already
    once = Recording({"orientation": Stream(np.arange(500.0), q)})["orientation"]
    # rounding of four squares, a root and a division
    np.testing.assert_allclose(np.linalg.norm(once.values, axis=1), 1.0, atol=5e-16)
    assert (np.sum(once.values * q, axis=1) > 0).all()
    twice = Recording({"orientation": once})["orientation"]
    assert (twice.values == once.values).all()


@pytest.mark.parametrize(
    ("scale", "norm"), [(1.02, "1.02"), (0.98, "0.98"), (0.0, "0"), (1e200, "inf")]
)
def test_a_quaternion_of_another_norm_is_refused_with_its_row(scale, norm):
    orientation = stream("orientation", np.arange(4))
    values = orientation.values.copy()
    values[2] *= scale
    with pytest.raises(
        InputError,
        match=f"row 3, columns qx..qw: the quaternion qx qy qz qw has norm {norm}, not 1",
    ):
        Recording({"orientation": Stream(orientation.time, values)})


def test_duration_and_rates():
    both = recording(
        wrench=10 + np.arange(101) / 100,
        orientation=10.5 + np.arange(11) / 10,
        position=[11],
    )
    assert both.start == 10
    assert both.duration == pytest.approx(1.5, abs=1e-12)  # sums of decimal fractions
    assert both.rates() == pytest.approx(
        {"position": 0, "orientation": 10, "wrench": 100}, rel=1e-9
    )


def test_it_is_shown_in_a_line():
    wrench = Stream(np.arange(11) / 10.0, np.ones((11, 6)))
    recording = Recording({"wrench": wrench}, source="a.csv")
    assert repr(recording) == "<Recording 'a.csv': wrench 11 at 10 Hz>"
    static = Recording({"wrench": wrench}, static=True)
    assert repr(static) == "<Recording 'recording': wrench 11>"


def test_slice_is_half_open_counts_from_the_start_and_keeps_rows():
    both = recording(wrench=10 + np.arange(8.0), orientation=10 + np.arange(4.0))
    part = both.slice(2.0, 3.0)
    assert part["wrench"].time.tolist() == [12, 13, 14]
    assert part["wrench"].rows.tolist() == [3, 4, 5]
    assert part["orientation"].time.tolist() == [12, 13]
    assert (part["wrench"].values == both["wrench"].values[2:5]).all()
    assert not both.slice(4.0).has("orientation")
    assert both.slice()["wrench"].time.tolist() == both["wrench"].time.tolist()
    for start, duration in ((-1, None), (0, 0), (np.nan, None), (0, np.nan), (8, None)):
        with pytest.raises(InputError) as error:
            both.slice(start, duration)
        assert "None" not in str(error.value)


@pytest.mark.parametrize("cut", [0.001, 0.37, 1.0, 2.5])
def test_a_cut_loses_and_repeats_nothing(cut):
    whole = recording(
        wrench=np.cumsum(np.random.default_rng(5).uniform(0.001, 0.02, 400))
    )
    rows = np.concatenate(
        [whole.slice(0, cut)["wrench"].rows, whole.slice(cut)["wrench"].rows]
    )
    assert rows.tolist() == list(range(1, 401))


def test_a_recording_travels_to_another_process():
    sent = recording(wrench=[0, 1], orientation=[0, 1])
    got = pickle.loads(pickle.dumps(sent))
    assert (got["wrench"].values == sent["wrench"].values).all()
    assert got.source == sent.source


def test_finite_values_whose_sum_is_not_are_finite():
    large = np.full((4, 3), 1.5e308)
    assert all_finite(large)
    assert not all_finite(np.array([1.0, np.nan]))
    assert not all_finite(np.array([np.inf, -np.inf]))


def test_joint_angles_without_a_robot_are_told_what_makes_poses_of_them():
    streams = {"joint_positions": Stream(np.arange(3.0), np.zeros((3, 6)))}
    with pytest.raises(InputError, match="give `urdf` and `sensor_frame`"):
        Recording(streams)["orientation"]
