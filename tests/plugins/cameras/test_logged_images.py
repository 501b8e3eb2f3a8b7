"""Pictures in MCAP files and ROS bags of other programs."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from tests.plugins.cameras.recordings import SIZE, context, numbers, picture

from followspot import InputError, Room
from followspot_cameras.logged.logged_images import LoggedImages
from followspot_cameras.logged.mcap_images import McapImages
from followspot_cameras.logged.ros_bag import RosBag
from followspot_cameras.logged.stored_image import StoredImage

WIDTH, HEIGHT = SIZE
STAMPS = [1_700_000_000_000_000_007, 1_700_000_000_100_000_000, 1_700_000_001_000_000_000]
SCHEMA = "foxglove.CompressedImage"
FRAMES = [(stamp, number) for number, stamp in enumerate(STAMPS)]


def png(number: int) -> bytes:
    return cv2.imencode(".png", picture(number))[1].tobytes()


def raw(number: int) -> bytes:
    return picture(number).tobytes()


def message(schema: str, encoding: str, stamp: int, number: int) -> bytes:
    """A picture in one of Foxglove's schemas."""
    sec, nsec = divmod(stamp, 10**9)
    compressed = schema == "foxglove.CompressedImage"
    data = png(number) if compressed else raw(number)
    size = {"width": WIDTH, "height": HEIGHT, "step": WIDTH * 3, "encoding": "bgr8"}
    if encoding == "json":
        about: dict[str, Any] = {"format": "png"} if compressed else size
        text = base64.b64encode(data).decode()
        return json.dumps(
            {"timestamp": {"sec": sec, "nsec": nsec}, "data": text, "frame_id": "a", **about}
        ).encode()
    built = CompressedImage(format="png", data=data) if compressed else RawImage(**size, data=data)
    built.frame_id = "a"
    built.timestamp.seconds, built.timestamp.nanos = sec, nsec
    return bytes(built.SerializeToString())


def mcap(
    path: Path, schema: str, encoding: str, messages: Sequence[bytes], topics: Sequence[str] = ("/a",)
) -> Path:
    """An MCAP file that has the messages in the first topic, and the first of them in all others."""
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        kind = writer.register_schema(schema, "jsonschema", b"{}")
        channels = [writer.register_channel(topic, encoding, kind) for topic in topics]
        for number, data in enumerate(messages):
            for channel in channels if number == 0 else channels[:1]:
                writer.add_message(channel, 7 + number, data, 7 + number)
        writer.finish()
    return path


def play(
    stage: type[LoggedImages], path: Path, **params: object
) -> tuple[list[tuple[int, int, int]], list[str]]:
    """Time, number and shown number of each frame, and the warnings."""
    warnings: list[str] = []
    source = stage(context(warn=warnings.append), path=path, **params)
    source.setup()
    frames = list(source.process())
    assert source.length() >= len(frames)
    return [(f.header.time, f.header.seq, numbers(f.pixels)) for f in frames], warnings


def check(stage: type[LoggedImages], path: Path, **params: object) -> list[str]:
    found = stage.check_files(stage.Params(path=path, **params), Room(), context().member)
    return [str(mistake) for mistake in found]


def ros2(path: Path, storage: StoragePlugin, *, compressed: bool, stamps: Sequence[int] = STAMPS) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = "sensor_msgs/msg/CompressedImage" if compressed else "sensor_msgs/msg/Image"
    with Writer2(path, version=9, storage_plugin=storage) as writer:
        connection = writer.add_connection("/cam/image", kind, typestore=store)
        for number, stamp in enumerate(stamps):
            writer.write(
                connection, 5 + number, store.serialize_cdr(image(store, stamp, number, compressed), kind)
            )
    return path


def ros1(path: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer1(path) as writer:
        connection = writer.add_connection("/cam/image", "sensor_msgs/msg/Image", typestore=store)
        for number, stamp in enumerate(STAMPS):
            data = store.serialize_ros1(image(store, stamp, number, False), "sensor_msgs/msg/Image")
            writer.write(connection, 5 + number, data)
    return path


def image(store: Any, stamp: int, number: int, compressed: bool) -> Any:
    types = store.types
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    header = types["std_msgs/msg/Header"]
    head = header(time, "a") if "seq" not in header.__dataclass_fields__ else header(0, time, "a")
    if compressed:
        data = np.frombuffer(png(number), "u1")
        return types["sensor_msgs/msg/CompressedImage"](head, "png", data)
    data = np.frombuffer(raw(number), "u1")
    return types["sensor_msgs/msg/Image"](head, HEIGHT, WIDTH, "bgr8", 0, 3 * WIDTH, data)


@pytest.mark.parametrize("schema", ["foxglove.RawImage", "foxglove.CompressedImage"])
@pytest.mark.parametrize("encoding", ["protobuf", "json"])
def test_mcap_pictures_come_at_their_time_stamps(tmp_path: Path, schema: str, encoding: str) -> None:
    path = mcap(
        tmp_path / "a.mcap", schema, encoding, [message(schema, encoding, *frame) for frame in FRAMES]
    )
    assert check(McapImages, path) == []
    assert play(McapImages, path) == ([(stamp, number, number) for stamp, number in FRAMES], [])
    later, _ = play(McapImages, path, start_frame=1, frames=1, start_time=-1_700_000_000.0)
    assert later == [(100_000_000, 1, 1)]


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_ros_2_pictures_come_at_the_stamps_of_their_headers(
    tmp_path: Path, storage: StoragePlugin, compressed: bool
) -> None:
    path = ros2(tmp_path / "bag", storage, compressed=compressed)
    assert check(RosBag, path, topic="/cam/image") == []
    assert play(RosBag, path) == ([(stamp, number, number) for stamp, number in FRAMES], [])


def test_ros_1_pictures_come_at_the_stamps_of_their_headers(tmp_path: Path) -> None:
    assert play(RosBag, ros1(tmp_path / "a.bag")) == (
        [(stamp, number, number) for stamp, number in FRAMES],
        [],
    )


def test_pictures_that_are_no_later_leave_a_gap_and_are_counted(tmp_path: Path) -> None:
    path = ros2(tmp_path / "bag", StoragePlugin.MCAP, compressed=True, stamps=[10, 0, 20, 20, 15, 30])
    frames, warnings = play(RosBag, path)
    assert frames == [(10, 0, 0), (20, 2, 2), (30, 5, 5)], "a stamp of 0 stands for the time of the log, 6 ns"
    assert warnings == ["bag: 3 pictures are left out: they are no later than one before"]


def test_damaged_pictures_leave_a_gap_and_are_counted(tmp_path: Path) -> None:
    good = [message("foxglove.RawImage", "json", *frame) for frame in FRAMES]
    short = json.dumps(json.loads(good[1]) | {"step": 10**9}).encode()
    path = mcap(tmp_path / "a.mcap", "foxglove.RawImage", "json", [good[0], b"[", b"{}", short, good[2]])
    frames, warnings = play(McapImages, path)
    assert [frame[1:] for frame in frames] == [(0, 0), (4, 2)]
    assert warnings == ["a.mcap: 3 pictures cannot be read"]


def test_the_topic_must_be_named_if_there_are_two(tmp_path: Path) -> None:
    schema = "foxglove.CompressedImage"
    data = [message(schema, "json", *FRAMES[0])]
    two = mcap(tmp_path / "two.mcap", schema, "json", data, ["/left", "/right"])
    with pytest.raises(InputError, match=r"has 2 topics with pictures(.|\n)*say which: /left, /right"):
        check(McapImages, two)
    with pytest.raises(InputError, match=r'has no topic "/rihgt"(.|\n)*did you mean "/right"'):
        check(McapImages, two, topic="/rihgt")
    assert play(McapImages, two, topic="/right")[0] == [(STAMPS[0], 0, 0)]
    log = mcap(tmp_path / "log.mcap", "foxglove.Log", "json", [b"{}"])
    with pytest.raises(InputError, match=r"has 0 topics with pictures(.|\n)*topics: /a"):
        check(McapImages, log)
    with pytest.raises(InputError, match=r"topic: /a in .* has messages of type foxglove.Log"):
        check(McapImages, log, topic="/a")


def test_hostile_files_are_refused_with_a_remedy(tmp_path: Path) -> None:
    schema = "foxglove.CompressedImage"
    whole = mcap(
        tmp_path / "a.mcap", schema, "json", [message(schema, "json", *f) for f in FRAMES]
    ).read_bytes()
    for path, data in (("cut.mcap", whole[:-40]), ("none.mcap", b"no log"), ("empty.mcap", b"")):
        (tmp_path / path).write_bytes(data)
        with pytest.raises(InputError, match=r"(is no whole MCAP file|was not closed)(.|\n)*mcap recover"):
            check(McapImages, tmp_path / path)
    for path in ("none.mcap", "none.bag", "none.db3"):
        (tmp_path / path).write_bytes(b"no log")
        with pytest.raises(InputError, match=r"cannot be read as a ROS bag(.|\n)*give a file"):
            check(RosBag, tmp_path / path)


def test_a_chunk_that_cannot_be_unpacked_is_refused_with_a_remedy(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    mcap(path, SCHEMA, "json", [message(SCHEMA, "json", *frame) for frame in FRAMES])
    begins_zstd = bytes.fromhex("28b52ffd")
    whole = path.read_bytes()
    assert begins_zstd in whole
    path.write_bytes(whole.replace(begins_zstd, b"none"))
    for act in (check, play):
        with pytest.raises(InputError, match=r"is no whole MCAP file(.|\n)*mcap recover"):
            act(McapImages, path)


def test_pictures_of_another_size_are_refused_before_they_are_converted(tmp_path: Path) -> None:
    huge = json.dumps(
        json.loads(message("foxglove.RawImage", "json", *FRAMES[0])) | {"height": 2**31}
    ).encode()
    path = mcap(tmp_path / "a.mcap", "foxglove.RawImage", "json", [huge])
    with pytest.raises(InputError, match="has pictures of 64x2147483648 px"):
        play(McapImages, path)


PIXELS = np.array([[[10, 20, 30], [10, 20, 30]]], "u1").repeat(2, axis=0)
RGB = StoredImage(0, PIXELS[..., ::-1].ravel(), "rgb8", 2, 2, 6)


@pytest.mark.parametrize(
    ("image", "expected"),
    [
        (RGB, PIXELS),
        (replace(RGB, data=np.insert(PIXELS[..., ::-1].ravel(), 6, [0, 0]), step=8), PIXELS),
        (
            replace(RGB, encoding="rgba8", data=np.insert(PIXELS[..., ::-1], 3, 255, axis=2).ravel(), step=8),
            PIXELS,
        ),
        (StoredImage(0, np.array([1, 200, 2, 100], "u1"), "mono16", 2, 1, 4), [[200, 100]]),
        (StoredImage(0, np.array([1, 200, 2, 100], "u1"), "mono16", 2, 1, 4, True), [[1, 2]]),
        (StoredImage(0, np.full(8, 128, "u1"), "yuv422", 2, 2, 4), np.full((2, 2, 3), 130)),
        (StoredImage(0, np.full(16, 77, "u1"), "bayer_rggb8", 4, 4, 4), np.full((4, 4, 3), 77)),
        (replace(RGB, step=5), None),
        (replace(RGB, data=RGB.data[:-1]), None),
        (StoredImage(0, np.zeros(6, "u1"), "yuyv", 3, 1, 6), None),
        (StoredImage(0, np.zeros(6, "u1")), None),
    ],
)
def test_encodings_become_grey_or_bgr(image: StoredImage, expected: Any) -> None:
    found = image.decoded(lambda width, height: None)
    if expected is None:
        assert found is None
    else:
        assert found is not None
        assert found.reshape(np.shape(expected)).tolist() == np.asarray(expected).tolist()


def test_unknown_encoding_is_refused() -> None:
    with pytest.raises(InputError, match=r'encoding "16UC1"(.|\n)*known encodings: mono8'):
        replace(RGB, encoding="16UC1").decoded(lambda width, height: None)


WITHOUT = """
import sys
sys.modules["rosbags"] = sys.modules["mcap"] = None
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import examined
for name in ("cameras.ros_bag", "cameras.mcap"):
    found = examined(catalogue()[name])
    print(found.state, "-", found.problem)
"""


def test_without_the_packages_the_stages_are_not_installed() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "not installed - pip install 'followspot[ros]'",
        "not installed - pip install 'followspot[recording]'",
    ]
