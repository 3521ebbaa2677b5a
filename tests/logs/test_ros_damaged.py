"""Bags that end early, are damaged or made to harm: read as far as they go, or one
clear line. About 5 s."""

import shutil
import sqlite3
import struct
import time
import tracemalloc

import numpy as np
import pytest
from backports import zstd

from bags import mcap, mcap_message, mcap_topic, serialised, text, write
from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.logs.ros import read_bag
from hefting.logs.ros_bag import is_bag

N = 5000
RNG = np.random.default_rng(6)
FORCE = RNG.normal(size=(N, 6))
FORMS = (
    "ros1.bag",
    "ros1-bz2.bag",
    "ros1-lz4.bag",
    "bare.mcap",
    "bare-storage.mcap",
    "bare.db3",
    "db3-file",
)
"""MCAP bags and ROS 1 bags of two chunks, the others of one file."""
PLAIN = {"ros1.bag": 0, "bare.mcap": 0, "bare.db3": 3 * 4096}
"""Forms without compression, and how many bytes before a cut may be lost: a database is
read by whole pages."""


def entries(ros1: bool, n: int = N):
    kinds = {"/w": "geometry_msgs/WrenchStamped", "/p": "geometry_msgs/PoseStamped"}
    for k in range(n):
        stamp = {"stamp": 10**18 + k * 10**6}
        wrench = {
            **stamp,
            "frame": "sensor",
            "wrench.force": FORCE[k, :3],
            "wrench.torque": FORCE[k, 3:],
        }
        pose = {
            **stamp,
            "frame": "world",
            "pose.orientation": (0, 0, 0, 1),
            "pose.position": FORCE[k, :3],
        }
        for topic, fields in (("/w", wrench), ("/p", pose)):
            kind = kinds[topic]
            yield (
                topic,
                kind,
                stamp["stamp"],
                serialised(kind.replace("/", "/msg/"), fields, ros1),
            )


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """Bytes of a bag of each form, long and short, and where to put them."""
    made = {}
    for n in (N, 60):
        content = {ros1: list(entries(ros1, n)) for ros1 in (True, False)}
        for form in FORMS:
            path = write(
                tmp_path_factory.mktemp("bag"), form, content[form.startswith("ros1")]
            )
            made[form, n] = next(path.glob("*.zstd")) if path.is_dir() else path
    return made


def place(folder, original, data: bytes):
    """A bag with other bytes; a folder when the original is in one."""
    if original.suffix == ".zstd":
        shutil.copytree(original.parent, folder / "bag", dirs_exist_ok=True)
        (folder / "bag" / original.name).write_bytes(data)
        return folder / "bag"
    (folder / original.name).write_bytes(data)
    return folder / original.name


@pytest.mark.parametrize("form", FORMS)
def test_a_truncated_bag_is_read_as_far_as_it_goes(tmp_path, bags, form):
    data = bags[form, N].read_bytes()
    read, refused = [], []
    for share in (0.31, 0.62, 0.9, 0.98):
        cut = int(share * len(data))
        path = place(tmp_path, bags[form, N], data[:cut])
        try:
            got = read_bag(path)
        except InputError as error:
            refused.append((form in PLAIN, "truncated" in str(error)))
            read.append(0)
            continue
        count = len(got["wrench"])
        assert (got["wrench"].values == FORCE[:count]).all()
        assert (got["wrench"].time == np.arange(count) / 1e3).all()
        upto = f"read up to {got.duration:.2f} s" + (
            " of 5.00 s" if form == "db3-file" else ""
        )
        if count < N:
            assert "truncated" in got.warnings[0]
            assert upto in got.warnings[0]
        read.append(count)
        if form in PLAIN:  # each message that lies before the cut, and no other
            ends = ends_of(data, N)
            assert (
                sum(end <= cut - PLAIN[form] for end in ends)
                <= count
                <= sum(end <= cut for end in ends)
            )
    assert read == sorted(read)
    assert read[-1] > N / 2
    assert set(refused) <= {(False, True)}, (
        "part of a chunk without compression can always be read"
    )


@pytest.mark.parametrize("form", PLAIN)
def test_a_cut_anywhere_gives_the_messages_before_it(tmp_path, bags, form):
    """At every seventh byte of a few records, headers included."""
    data = bags[form, 60].read_bytes()
    ends = ends_of(data, 60)
    told = []
    cuts = (
        range(ends[30], ends[33], 7)
        if form != "bare.db3"
        else range(len(data) // 4, len(data) - 1, 997)
    )
    for cut in cuts:
        path = place(tmp_path, bags[form, 60], data[:cut])
        try:
            count = len(read_bag(path)["wrench"])
        except InputError as error:
            told.append((form, "truncated" in str(error)))
            continue
        assert (
            sum(end <= cut - PLAIN[form] for end in ends)
            <= count
            <= sum(end <= cut for end in ends)
        )
    assert set(told) <= {("bare.db3", True)}, (
        "the first pages of a database hold its tables"
    )


def ends_of(data: bytes, n: int) -> list[int]:
    """Where the bytes of each wrench end in a bag without compression."""
    ends = [0]
    for k in range(n):
        # within a page order is backward
        found = data.find(FORCE[k, 5].tobytes(), max(ends[-1] - 4096, 0))
        ends.append(found + 8 if found >= 0 else data.index(FORCE[k, 5].tobytes()) + 8)
    return ends[1:]


def test_a_bag_that_was_not_closed_and_one_without_its_metadata(tmp_path, bags):
    data = bytearray(bags["ros1.bag", 60].read_bytes())
    at = data.index(b"index_pos=") + 10
    (index,) = struct.unpack_from("<Q", data, at)
    data[at : at + 8] = b"\0" * 8
    got = read_bag(place(tmp_path, bags["ros1.bag", 60], bytes(data[:index])))
    assert len(got["wrench"]) == 60
    assert got.warnings == ("ros1.bag is truncated: read up to 0.06 s",)
    folder = place(tmp_path, bags["db3-file", 60], bags["db3-file", 60].read_bytes())
    (folder / "metadata.yaml").unlink()
    assert is_bag(folder)
    assert read_bag(folder).warnings == ("metadata.yaml is missing: read up to 0.06 s",)


def test_split_bags_are_one_recording_and_a_missing_part_is_told(tmp_path):
    part = list(entries(False, 60))
    paths = [
        write(tmp_path, form, part[i : i + 40])
        for i, form in ((0, "bare.mcap"), (40, "bare-storage.mcap"))
    ]
    folder = tmp_path / "split"
    folder.mkdir()
    names = ["split_10.mcap", "split_9.mcap", "split_11.mcap"]
    shutil.copy(paths[0], folder / names[1])
    shutil.copy(paths[1], folder / names[0])
    (folder / "split_8.mcap").write_bytes(b"not listed, so not read")
    listed = "".join(f"    - split/{name}\n" for name in (names[1], names[0]))
    metadata = f"rosbag2_bagfile_information:\n  relative_file_paths:\n{listed}  duration:\n    nanoseconds: 79000000\n"
    (folder / "metadata.yaml").write_text(metadata)
    got = read_bag(folder)
    assert (got["wrench"].values == FORCE[:40]).all()
    assert not got.warnings
    (folder / "metadata.yaml").write_text(
        metadata.replace("  duration", f"    - {names[2]}\n  duration")
    )
    assert read_bag(folder).warnings == (
        "split_11.mcap is missing: read up to 0.04 s of 0.08 s",
    )


def test_no_flip_and_no_cut_gives_anything_but_a_recording_or_one_line(tmp_path, bags):
    rng = np.random.default_rng(12)
    outcomes = {Recording: 0, InputError: 0}
    begin = time.process_time()
    for form in FORMS:
        read_bag(bags[form, 60])
    whole, longest = time.process_time() - begin, 0.0
    for trial in range(140):
        form = FORMS[trial % len(FORMS)]
        data = bytearray(bags[form, 60].read_bytes())
        for at in rng.integers(0, len(data), rng.integers(0, 12)):
            data[at] = rng.integers(256)
        # flips where they matter: most of a small bag is its header
        if rng.random() < 0.3 or form.startswith("ros1"):
            begin = max(bytes(data).find(b"op="), 0)
            data[begin + rng.integers(0, min(400, len(data) - begin))] = rng.integers(
                256
            )
        if rng.random() < 0.4:
            del data[rng.integers(1, len(data)) :]
        path = place(tmp_path, bags[form, 60], bytes(data))
        begin = time.process_time()
        try:
            outcomes[type(read_bag(path))] += 1
        except InputError:
            outcomes[InputError] += 1
        longest = max(longest, time.process_time() - begin)
    # what all undamaged bags took together: damage makes no search
    assert longest < 100 * whole
    assert min(outcomes.values()) > 10


def chunk(kind: str, size: int, stored: bytes, checksum: int = 0) -> tuple[int, bytes]:
    return 6, struct.pack("<QQQI", 0, 0, size, checksum) + text(kind) + struct.pack(
        "<Q", len(stored)
    ) + stored


def records(*more):
    wrench = serialised("geometry_msgs/msg/WrenchStamped", {"frame": "a"})
    return mcap(
        [
            *mcap_topic(1, "/w", "geometry_msgs/msg/WrenchStamped"),
            mcap_message(1, 5, wrench),
            *more,
        ]
    )


def bombs():
    """Two chunks, each of one message of zeros."""
    size = 250 << 20
    stored = zstd.compress(struct.pack("<BQ", 5, size) + bytes(size))
    return records(*[chunk("zstd", size + 9, stored)] * 2)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (
            records(chunk("zstd", 1 << 40, b"")),
            "a chunk has 1099512 MB, more than 256 MiB",
        ),
        (records(chunk("brotli", 9, b"")), "compressed as 'brotli', which is not read"),
        (bombs, "more than 200 times its size"),
        (
            b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, 2**63),
            "is truncated: nothing can be read",
        ),
        (b"not an MCAP file at all", "is not an MCAP file"),
        (b"", "the file is empty"),
        (mcap([]), "holds no wrench, only no topics"),
        (records(mcap_message(1, 2**64 - 1, b"")), "times before 1970 or after 2262"),
    ],
    ids=["huge", "kind", "bomb", "length", "other", "empty", "nothing", "time"],
)
def test_files_made_to_harm_are_refused_in_little_memory(tmp_path, content, match):
    path = tmp_path / "x.mcap"
    path.write_bytes(content() if callable(content) else content)
    tracemalloc.start()
    with pytest.raises(InputError, match=match):
        read_bag(path)
    assert tracemalloc.get_traced_memory()[1] < 600e6
    tracemalloc.stop()


def test_damaged_chunks_and_messages_are_told(tmp_path):
    poses = serialised(
        "geometry_msgs/msg/PoseStamped", {"pose.orientation": (0, 0, 0, 1)}
    )
    good = [
        *mcap_topic(2, "/p", "geometry_msgs/msg/PoseStamped"),
        mcap_message(2, 5, poses),
    ]
    path = tmp_path / "x.mcap"
    path.write_bytes(records(*good, chunk("", 3, b"abc", checksum=1)))
    assert "is damaged at byte" in read_bag(path).warnings[0]
    path.write_bytes(
        records(
            *good, mcap_message(1, 6, b"\0\1\0\0short"), mcap_message(1, 6, b"\0\7")
        )
    )
    assert (
        "2 of 3 messages of /w do not fit their definition: left out"
        in read_bag(path).warnings
    )
    path.write_bytes(
        mcap(
            [
                *mcap_topic(1, "/w", "geometry_msgs/msg/WrenchStamped"),
                mcap_message(1, 6, b""),
            ]
        )
    )
    with pytest.raises(
        InputError,
        match="1 of 1 messages of /w do not fit their definition: left out, and holds no",
    ):
        read_bag(path)


@pytest.mark.parametrize(
    ("statement", "match"),
    [
        (
            "CREATE VIEW messages AS WITH RECURSIVE r(i) AS (VALUES(1) UNION ALL SELECT i + 1 FROM r) "
            "SELECT 1 topic_id, i timestamp, zeroblob(9) data FROM r",
            "without the tables of a ROS 2 bag",
        ),
        (
            "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)",
            "holds virtual tables",
        ),
        (
            "CREATE TABLE messages(topic_id, timestamp, data GENERATED ALWAYS AS (zeroblob(9000)));"
            "INSERT INTO messages VALUES(1, 1), (1, 2), (1, 3), (1, 4)",
            "truncated or damaged|is damaged",
        ),
    ],
    ids=["endless", "virtual", "large"],
)
def test_databases_made_to_harm_are_refused(tmp_path, statement, match):
    path = tmp_path / "x.db3"
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE topics(id, name, type, serialization_format);"
            "INSERT INTO topics VALUES(1, '/w', 'geometry_msgs/msg/WrenchStamped', 'cdr');"
            + statement
        )
    database.close()
    with pytest.raises(InputError, match=match):
        read_bag(path)


def test_what_is_not_a_bag_is_one_clear_line(tmp_path):
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V1.2\n")
    (tmp_path / "y.bag").write_bytes(b"PK")
    (tmp_path / "z.db3").write_bytes(b"PK")
    (tmp_path / "empty").mkdir()
    assert not is_bag(tmp_path / "empty")
    for name, match in (
        ("x.bag", "another version than 2.0"),
        ("y.bag", "is not a ROS 1 bag"),
        ("z.db3", "is not an SQLite file"),
        ("w.mcap", "does not exist"),
        ("empty", r"the folder holds no \.db3"),
    ):
        with pytest.raises(InputError, match=match):
            read_bag(tmp_path / name)


def test_a_message_of_very_many_joints_costs_no_more_a_joint(tmp_path):
    """A search for each name among all would take ten times as long a joint for ten
    times as many."""
    topics = [
        *mcap_topic(1, "/w", "geometry_msgs/msg/WrenchStamped"),
        *mcap_topic(2, "/j", "sensor_msgs/msg/JointState"),
    ]
    wrench = mcap_message(
        1, 9, serialised("geometry_msgs/msg/WrenchStamped", {"stamp": 9})
    )
    costs = []
    for count in (4_000, 40_000):
        names = [f"j{i}" for i in range(count)]
        fields = {"stamp": 9, "name": names, "position": np.ones(count)}
        joints = mcap_message(2, 9, serialised("sensor_msgs/msg/JointState", fields))
        path = tmp_path / f"bag{count}.mcap"
        path.write_bytes(mcap([*topics, wrench, joints]))
        read_bag(path)  # imports
        begin = time.process_time()
        assert read_bag(path).joint_names[-1] == names[-1]
        costs.append(time.process_time() - begin)
    assert costs[1] < 30 * costs[0]  # 10 where it is linear, 100 with a search


def test_topics_without_messages_are_told(tmp_path):
    wrench = mcap_topic(1, "/w", "geometry_msgs/msg/WrenchStamped")
    pose = mcap_topic(2, "/p", "geometry_msgs/PoseStamped")
    message = mcap_message(
        2, 9, serialised("geometry_msgs/msg/PoseStamped", {"stamp": 9})
    )
    (tmp_path / "bag.mcap").write_bytes(mcap([*wrench, *pose, message]))
    with pytest.raises(
        InputError, match="topic /w has no messages, and holds no wrench, only /p"
    ):
        read_bag(tmp_path / "bag.mcap")


def test_files_of_a_folder_with_raised_digits(tmp_path):
    """Which are digits, but no number."""
    for name in ("1²2.mcap", "²1.mcap"):
        (tmp_path / name).touch()
    with pytest.raises(InputError, match="the file is empty"):
        read_bag(tmp_path)
