"""`Live`: raw samples as they come give what the same samples give at once, in whatever
pieces and order of streams."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.identification.waiting import LONGEST_WAIT
from hefting.simulation import UR5, hammer, random_smooth, simulate

SHAPE = hefting.Shape.from_mesh(hammer().mesh())
MASS = hammer().parameters.mass


def samples(seed=1, duration=6.0, rate=100.0):
    """Time, position, orientation and wrench as a robot gives them."""
    motion = UR5.motion(random_smooth(duration, rate, 1.0, seed))
    recording = simulate(
        motion, hammer().parameters, noise=hefting.Noise(0.1, 0.005), seed=seed
    )
    names = ("position", "orientation", "wrench")
    return recording["wrench"].time, *(recording[name].values for name in names)


TIME, POSITION, ORIENTATION, WRENCH = samples()


def fed(live, piece, wrench_first=False, ahead=0):
    """The state after all samples, `piece` at a time, each stream in a call of its
    own; poses come `ahead` pieces before their wrenches."""
    state = live.start()
    count = -(-len(TIME) // piece)
    for k in range(count + ahead):
        poses = slice(k * piece, (k + 1) * piece)
        late = slice(max(k - ahead, 0) * piece, max(k - ahead + 1, 0) * piece)
        wrench = {"wrench_time": TIME[late], "wrench": WRENCH[late]}
        pose = {
            "time": TIME[poses],
            "position": POSITION[poses],
            "orientation": ORIENTATION[poses],
        }
        for given in (wrench, pose) if wrench_first else (pose, wrench):
            state = live.update(state, **given)
    return state


@pytest.fixture(scope="module")
def live():
    return hefting.Live(SHAPE)


@pytest.fixture(scope="module")
def whole(live):
    """All samples in one call."""
    state = live.update(
        live.start(),
        time=TIME,
        position=POSITION,
        orientation=ORIENTATION,
        wrench=WRENCH,
    )
    return live.estimate(state)


def test_it_finds_the_object(whole):
    low, high = whole.interval("mass")
    assert low < MASS < high
    assert 0.5 * (high - low) < 0.03 * MASS


@pytest.mark.parametrize(
    "how",
    [
        {"piece": 7},
        {"piece": 50, "wrench_first": True},
        {"piece": 10, "ahead": 4},
    ],
)
def test_pieces_and_the_order_of_streams_do_not_matter(live, whole, how):
    """But for the second of poses on which the filter is tuned, which ends with a
    piece."""
    tuned = hefting.PoseFilter.tuned(TIME[:100], POSITION[:100], ORIENTATION[:100])
    fixed = hefting.Live(SHAPE, poses=tuned)
    reference = fixed.estimate(fed(fixed, len(TIME)))
    found = fixed.estimate(fed(fixed, **how))
    assert found.samples == reference.samples
    # sums in another order, and the passes of an iteration that stops at 2 %
    np.testing.assert_allclose(
        found.parameters.vector, reference.parameters.vector, rtol=1e-6, atol=1e-9
    )
    own = live.estimate(fed(live, **how))
    low, high = whole.interval("mass")
    assert low < own.mass < high


def test_single_samples_in_every_form_of_a_pose():
    tuned = hefting.PoseFilter.tuned(TIME[:100], POSITION[:100], ORIENTATION[:100])
    live = hefting.Live(SHAPE, poses=tuned)
    states = [live.start() for _ in range(4)]
    for k in range(150):
        turned = Rotation.from_quat(ORIENTATION[k])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turned.as_matrix(), POSITION[k]
        forms = (
            {"position": POSITION[k], "orientation": ORIENTATION[k]},
            {"position": POSITION[k], "orientation": turned},
            {"pose": pose},
            {"pose": np.concatenate((POSITION[k], ORIENTATION[k]))},
        )
        states = [
            live.update(state, time=TIME[k], wrench=WRENCH[k], **form)
            for state, form in zip(states, forms, strict=True)
        ]
    first, *others = (live.estimate(state).parameters.vector for state in states)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-6, atol=1e-9)


def test_the_sensors_sign(live, whole):
    other = hefting.Live(SHAPE, sign="on-sensor")
    poses = {"time": TIME, "position": POSITION, "orientation": ORIENTATION}
    state = other.update(other.start(), wrench=-WRENCH, **poses)
    assert other.estimate(state).mass == pytest.approx(whole.mass, rel=1e-9)


def test_an_estimate_once_there_is_enough_and_when_it_is_sure():
    live = hefting.Live(SHAPE, until="mass=3%")
    state, found = live.start(), None
    assert live.estimate(state) is None
    for k in range(0, len(TIME), 10):
        new = slice(k, k + 10)
        state = live.update(
            state,
            time=TIME[new],
            position=POSITION[new],
            orientation=ORIENTATION[new],
            wrench=WRENCH[new],
        )
        found = live.estimate(state, start=found)
        if found is not None and found.sufficient:
            break
    assert 0 < k < len(TIME) - 10
    assert abs(found.mass - MASS) < 0.03 * MASS


def test_a_rest_before_the_motion_is_not_what_the_filter_is_tuned_on(live):
    """Poses at rest have no noise here, from which no bandwidth can be told."""
    rest = 300
    state = live.update(
        live.start(),
        time=TIME[0] + 0.01 * np.arange(-rest, 0),
        position=np.tile(POSITION[0], (rest, 1)),
        orientation=np.tile(ORIENTATION[0], (rest, 1)),
        wrench=np.tile(WRENCH[0], (rest, 1)),
    )
    assert state.pose_filter is None
    assert live.estimate(state) is None
    assert len(state.poses.time) <= 101  # those of the last second
    state = live.update(
        state, time=TIME, position=POSITION, orientation=ORIENTATION, wrench=WRENCH
    )
    low, high = live.estimate(state).interval("mass")
    assert low < MASS < high


def test_instants_in_a_gap_of_the_wrench_are_left_out(live):
    gap = (TIME > 2.0) & (TIME < 3.5)
    poses = {"time": TIME, "position": POSITION, "orientation": ORIENTATION}
    state = live.update(
        live.start(), wrench_time=TIME[~gap], wrench=WRENCH[~gap], **poses
    )
    complete = live.update(live.start(), wrench=WRENCH, **poses)
    lost = complete.samples.samples - state.samples.samples
    assert lost == gap.sum()


def test_memory_does_not_grow_where_a_stream_has_stopped(live):
    state = live.start()
    for k in range(200):
        at = k + 0.01 * np.arange(100)
        state = live.update(state, wrench_time=at, wrench=np.ones((100, 6)))
    assert len(state.pairing.time) <= 100 * (LONGEST_WAIT + 1)
    tuned = hefting.Live(SHAPE, poses=hefting.PoseFilter())
    state = tuned.start()
    for k in range(100):
        at = k + 0.01 * np.arange(100)
        turned = np.tile([0.0, 0.0, 0.0, 1.0], (100, 1))
        state = tuned.update(state, time=at, orientation=turned)
    assert sum(len(m.time) for m in state.pairing.motions) <= 100 * (LONGEST_WAIT + 1)


def test_the_state_that_is_passed_in_does_not_change(live):
    first = live.update(
        live.start(), time=TIME[:300], pose=np.hstack((POSITION, ORIENTATION))[:300]
    )
    before = len(first.pairing.time), first.samples.samples
    live.update(first, wrench_time=TIME, wrench=WRENCH)
    assert (len(first.pairing.time), first.samples.samples) == before


def test_samples_that_are_nan_throughout_add_nothing():
    """A driver's dropouts; a pose may lack its position alone, as of a lost marker."""
    lost = np.isin(np.arange(len(TIME)), (0, 7, 8, 60))
    poses = {"time": TIME, "position": POSITION, "orientation": ORIENTATION}
    kept = {name: values[~lost] for name, values in poses.items()}
    gone = poses | {"position": np.where(lost[:, None], np.nan, POSITION)}
    at = {"wrench_time": TIME, "wrench": np.where(lost[:, None], np.nan, WRENCH)}
    live = hefting.Live(SHAPE)
    one = live.update(live.start(), **gone, **at)
    rest = {"wrench_time": TIME[~lost], "wrench": WRENCH[~lost]}
    other = live.update(live.start(), **kept, **rest)
    assert one.samples.samples == other.samples.samples > 0
    assert live.estimate(one).mass == live.estimate(other).mass
    # a single one
    nan = {"pose": np.full((4, 4), np.nan), "wrench": np.full(6, np.nan)}
    after = live.update(one, time=TIME[-1] + 1.0, **nan)
    assert (after.samples, after.pairing.time[-1]) == (one.samples, TIME[-1])


GOOD = {"time": 7.0, "position": [0, 0, 0.0], "orientation": [0, 0, 0, 1.0]}
BAD = {
    "no time": ({"time": None}, "a pose has no time; give `time`"),
    "wrench without time": (
        {"time": None, "position": None, "orientation": None, "wrench": np.ones(6)},
        "a wrench has no time; give `wrench_time`",
    ),
    "position alone": ({"orientation": None}, "there is no orientation; give"),
    "both": ({"pose": np.eye(4)}, "a pose and its parts are both given"),
    "earlier": ({"time": 5.0}, "5 s is not later than"),
    "earlier wrench": (
        {"wrench_time": 5.0, "wrench": np.ones(6)},
        "wrench_time 5 s is not later than 6 s",
    ),
    "norm": ({"orientation": [0, 0, 0, 2.0]}, "norm 2, not 1"),
    "w first": ({"orientation": [1.0, 0, 0]}, "give quaternions"),
    "nan": ({"position": [0, 0, np.nan]}, "position at 7 s is not finite; leave"),
    "no numbers": ({"position": "abc"}, "position is not an array of numbers"),
    "nan time": ({"time": np.nan}, "time is not"),
    "wrench of five": ({"wrench": np.ones(5)}, r"\(1, 5\), not \(1, 6\)"),
    "wrench nan": (
        {"wrench": [0, 0, np.nan, 0, 0, 0]},
        "wrench at 7 s is not finite; leave",
    ),
    "no position any more": ({"position": None}, "at some times and not at others"),
    "several wrenches, one time": ({"wrench": np.ones((2, 6))}, "shape"),
}


@pytest.mark.parametrize("tuned", [False, True])
@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_is_refused_in_one_line(case, tuned):
    poses = hefting.PoseFilter() if tuned else None
    live = hefting.Live(SHAPE, poses=poses)
    state = live.update(
        live.start(), wrench=np.ones((2, 6)), **_twice(GOOD, (5.9, 6.0))
    )
    changes, match = BAD[case]
    with pytest.raises(InputError, match=match) as refused:
        live.update(state, **(GOOD | changes))
    assert "\n" not in str(refused.value)


def _twice(sample, times):
    """Two samples at these times."""
    both = {name: [value, value] for name, value in sample.items()}
    return both | {"time": times}


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"sign": "auto"}, "use on-object or on-sensor"),
        ({"gravity": 9.81}, "gravity must be three numbers.*; give `gravity`"),
        ({"tuning": 0.0}, "tuning is 0.0"),
        ({"method": "Bayes"}, "method is not an estimator"),
        ({"method": hefting.OLS(), "until": "mass=1%"}, "give them to the estimator"),
        ({"until": "mass"}, "'mass' is no accuracy"),
        ({"shape": 5}, "is not a shape"),
    ],
)
def test_options_are_checked(options, match):
    with pytest.raises(InputError, match=match):
        hefting.Live(**options)


def test_another_method():
    live = hefting.Live(method=hefting.OLS(bias="estimate"))
    poses = {"time": TIME, "position": POSITION, "orientation": ORIENTATION}
    state = live.update(live.start(), wrench=WRENCH, **poses)
    assert live.estimate(state).mass == pytest.approx(MASS, rel=0.05)
    assert len(repr(live)) < 200
