"""What goes into a recording comes out again, bit for bit, and other programs can read it."""

from __future__ import annotations

import json
from base64 import b64decode
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import DataEnd
from mcap.stream_reader import StreamReader

from followspot import Context
from followspot.errors import FollowspotError
from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, identical, stamped
from followspot.people import Poses, PoseTruth
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.room import Camera, LensModel, Room
from followspot.rotation import matrix
from followspot.testing import tiny_room
from followspot.tracking import Blobs, Frame, Positions, Tracks, Truth
from followspot.wire import differenced, pack, unpack
from followspot_recording.contract import ContractError, contract_of, message_type, type_name
from followspot_recording.decoding import decoded as decoded_port
from followspot_recording.foxglove import cameras_of, view_of
from followspot_recording.recorder import Chunking, Recorder, Schema
from followspot_recording.recording import Recording
from followspot_recording.replays import REPLAYS
from followspot_recording.sink import RecordingSink

ROOM = tiny_room()
SPACING = 16_666_667


def frame(number: int) -> Frame:
    pixels = np.random.default_rng(number).integers(0, 256, (20, 24, 3), "u1")
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number * SPACING, 99))


def tracks(number: int) -> Tracks:
    xyz = np.array([[0.1 * number, 0.0, 1.0], [np.nan, 0.0, 0.0]])
    told = Tracks(np.array([0, 1], "i4"), np.array([1, 2], "u1"), xyz, xyz, np.full((2, 3), 0.01))
    return stamped(seal(told), Header("camera/cam0", number, number * SPACING, 7))


def record(path: Path, count: int = 40, **params: object) -> Path:
    """Two ports, `count` messages each, through the sinks."""
    about = {"metadata": {"graph": "toy"}, "attachments": {"graph/toy.yaml": "graph: toy\n"}}
    first = RecordingSink(Context("a", ROOM), path=path, port="camera/cam0.out", **about, **params)
    second = RecordingSink(Context("b", ROOM), path=path, port="track.tracks", **params)
    for sink in (first, second):
        sink.setup()
    for number in range(count):
        first.process(frame(number))
        second.process(tracks(number))
    first.close()
    second.close()
    return path


def decoded(recording: Recording, port: str, kind: type[Message], **part: int) -> list[Message]:
    found = [unpack(bytes(message.data), kind) for message in recording.messages(port, **part)]
    return [message for message in found if isinstance(message, Message)]


@pytest.mark.parametrize("compression", ["lz4", "zstd", "none"])
def test_messages_come_out_bit_for_bit(tmp_path: Path, compression: str) -> None:
    with Recording(record(tmp_path / "a.mcap", compression=compression, chunk_size=0.01)) as recording:
        assert recording.problem == ""
        assert set(recording.ports) == {"camera/cam0.out", "track.tracks"}
        frames = decoded(recording, "camera/cam0.out", Frame)
        found = decoded(recording, "track.tracks", Tracks)
    assert len(frames) == len(found) == 40
    assert all(identical(frame(n), message) for n, message in enumerate(frames))
    assert all(identical(tracks(n), message) for n, message in enumerate(found))


def test_a_malformed_picture_names_its_message(tmp_path: Path) -> None:
    """It says that its rows are coded, and its head speaks of more bytes than came."""
    whole = differenced(pack(frame(5)))
    recorder = Recorder(tmp_path / "a.mcap", Chunking(1 << 20, 1.0, "none"))
    schema = Schema(type_name(Frame), "followspot", contract_of(Frame))
    for number, data in enumerate([whole, whole[:-64]]):
        recorder.add("/followspot/camera/cam0/out", "followspot", schema, number, number, data)
    recorder.close()
    with Recording(recorder.path) as recording:
        found = decoded_port(recording, "camera/cam0.out", Frame)
        assert identical(next(found), frame(5))
        with pytest.raises(FollowspotError, match=r"message 1 of camera/cam0.out is none: "):
            next(found)


def test_a_part_of_a_recording_is_found_by_capture_time(tmp_path: Path) -> None:
    with Recording(record(tmp_path / "a.mcap", chunk_size=0.001)) as recording:
        part = decoded(recording, "track.tracks", Tracks, start=10 * SPACING, stop=12 * SPACING)
        assert (recording.begin, recording.end) == (0, 39 * SPACING)
    assert [message.header.seq for message in part] == [10, 11, 12]


def test_the_reader_of_the_mcap_package_opens_it(tmp_path: Path) -> None:
    with record(tmp_path / "a.mcap", chunk_size=0.01).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
        attachments = {a.name: a.data for a in reader.iter_attachments()}
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    assert summary is not None
    assert summary.statistics is not None
    assert len(summary.chunk_indexes) > 1
    assert summary.statistics.message_count == len(messages) == 161 + 2 * len(ROOM.cameras)
    # twice two ports, a line of log, and of each camera its place and its lens
    topics = {channel.topic for channel in summary.channels.values()}
    exact = {"/followspot/camera/cam0/out", "/followspot/track/tracks"}
    cameras = {f"/cameras/{name}/{what}" for name in ROOM.cameras for what in ("transform", "calibration")}
    assert topics >= exact | cameras
    assert topics - set(exact) - cameras == {"/camera/cam0", "/track/tracks", "/log"}
    assert attachments == {"graph/toy.yaml": b"graph: toy\n"}
    assert metadata["followspot"] == {"graph": "toy"}


def test_the_mcap_package_finds_the_checksum_of_all_data_right_also_of_a_file_that_went_on(
    tmp_path: Path,
) -> None:
    recorder = Recorder(tmp_path / "a.mcap", Chunking(1, 1.0, "none"))
    for number in range(3):
        recorder.note(f"mark {number}", {"text": "now"})
        recorder.add("/log", "json", Schema("log", "jsonschema", "{}"), number, number, b"{}")
        recorder.complete()
    recorder.close()
    with recorder.path.open("rb") as file:
        assert len(list(NonSeekingReader(file, validate_crcs=True).iter_messages())) == 3
    with recorder.path.open("rb") as file:
        (end,) = (one for one in StreamReader(file).records if isinstance(one, DataEnd))
    assert end.data_section_crc


@pytest.mark.parametrize("pictures", ["jpeg", "png", "raw"])
def test_what_viewers_are_shown_fits_its_foxglove_schema(tmp_path: Path, pictures: str) -> None:
    with record(tmp_path / "a.mcap", 3, picture_format=pictures).open("rb") as file:
        views = [m for m in make_reader(file).iter_messages() if m[1].message_encoding == "json"]
    names = set()
    for schema, _, message in views:
        assert schema is not None
        names.add(schema.name)
        told = json.loads(schema.data)
        jsonschema.Draft202012Validator.check_schema(told)
        jsonschema.validate(json.loads(message.data), told)
    image = "foxglove.RawImage" if pictures == "raw" else "foxglove.CompressedImage"
    room = {"foxglove.CameraCalibration", "foxglove.FrameTransform"}
    assert names == {image, "foxglove.SceneUpdate", "foxglove.Log", *room}


def told_of(camera: Camera) -> dict[str, dict[str, Any]]:
    """What viewers are told of a camera, by schema."""
    views = cameras_of(Room(cameras={camera.name: camera}), 1_500_000_000)
    return {schema.name: json.loads(data) for _, schema, data in views}


@pytest.mark.parametrize(
    ("model", "terms", "name"),
    [("pinhole", 5, "plumb_bob"), ("rational", 8, "rational_polynomial"), ("fisheye", 4, "kannala_brandt")],
)
def test_viewers_are_told_where_a_camera_stands_and_its_lens(model: LensModel, terms: int, name: str) -> None:
    known = ROOM.cameras["cam0"]
    rotation, _ = cv2.Rodrigues(np.array([0.3, -1.2, 2.0]))
    place = np.array([0.5, -0.25, 2.0])
    camera = replace(
        known, model=model, distortion=np.full(terms, 0.01), rotation=rotation, translation=place
    )
    told = told_of(camera)
    frame, lens = told["foxglove.FrameTransform"], told["foxglove.CameraCalibration"]
    assert (
        (frame["parent_frame_id"], frame["child_frame_id"]) == ("room", "cam0") == ("room", lens["frame_id"])
    )
    turn = np.array([frame["rotation"][axis] for axis in "wxyz"])
    origin = np.array([frame["translation"][axis] for axis in "xyz"])
    np.testing.assert_allclose(matrix(turn), rotation.T, atol=1e-12)
    np.testing.assert_allclose(rotation @ origin + place, np.zeros(3), atol=1e-12)
    assert (lens["distortion_model"], lens["D"]) == (name, [0.01] * terms)
    assert (lens["width"], lens["height"]) == known.size
    np.testing.assert_array_equal(np.reshape(lens["K"], (3, 3)), known.matrix)
    np.testing.assert_array_equal(np.reshape(lens["P"], (3, 4))[:, :3], known.matrix)


def test_viewers_are_told_the_place_alone_of_a_panorama() -> None:
    assert set(told_of(replace(ROOM.cameras["cam0"], model="cylinder"))) == {"foxglove.FrameTransform"}


def shown(message: Message) -> dict[str, Any]:
    """What viewers are shown of it, held against its schema."""
    view = view_of(stamped(seal(message), Header("x", 0, 1_500_000_000)), ROOM, "none")
    assert view is not None
    schema, data = view
    told: dict[str, Any] = json.loads(data)
    jsonschema.validate(told, json.loads(schema.text))
    return told | {"schema": schema.name}


def test_viewers_are_shown_points_in_pictures_and_in_the_room() -> None:
    pixel = np.array([[10.5, 20.0], [np.nan, 0.0]])
    two = np.zeros(2)
    marks = shown(Blobs("cam0", pixel, pixel, two, two, np.zeros((2, 1), bool)))
    assert marks["schema"] == "foxglove.ImageAnnotations"
    assert [points["points"] for points in marks["points"]] == [[{"x": 10.5, "y": 20.0}]]
    empty = Positions.empty()
    xyz = np.array([[1.0, -2.0, 0.5]])
    whole, yes = np.zeros(1, "i4"), np.ones(1, bool)
    cloud = shown(
        replace(
            empty,
            target=whole,
            xyz=xyz,
            covariance=np.zeros((1, 3, 3)),
            support=whole,
            confirmed=yes,
            evident=yes,
            iterations=whole,
            predicted=yes,
        )
    )
    assert (cloud["schema"], cloud["timestamp"]) == ("foxglove.PointCloud", {"sec": 1, "nsec": 500_000_000})
    assert np.frombuffer(b64decode(cloud["data"]), "<f4").tolist() == xyz[0].tolist()
    assert shown(empty)["data"] == ""


@pytest.mark.parametrize("kind", [Truth, Poses, PoseTruth, Blobs])
def test_an_empty_message_is_recorded_too(tmp_path: Path, kind: type[Message]) -> None:
    path = tmp_path / "a.mcap"
    sink = RecordingSink(Context("a", ROOM), path=path, port="x.out")
    sink.setup()
    sink.process(stamped(seal(kind.empty()), Header("x", 0, 5)))
    sink.close()
    with Recording(path) as recording:
        assert len(decoded(recording, "x.out", kind)) == 1


def test_an_older_recording_is_never_replaced(tmp_path: Path) -> None:
    record(tmp_path / "a.mcap", 1)
    before = (tmp_path / "a.mcap").read_bytes()
    record(tmp_path / "a.mcap", 2)
    assert (tmp_path / "a.mcap").read_bytes() == before
    with Recording(tmp_path / "a-2.mcap") as recording:
        assert len(list(recording.messages("track.tracks"))) == 2


def test_that_a_recording_goes_to_another_file_is_said_once_for_all_its_ports(tmp_path: Path) -> None:
    record(tmp_path / "a.mcap", 1)
    warnings: list[str] = []
    context = Context("a", out=tmp_path, warn=warnings.append)
    sinks = [RecordingSink(context, path="a.mcap", port=port) for port in ("x.out", "y.out", "z.out")]
    for sink in sinks:
        sink.setup()
    for sink in sinks:
        sink.close()
    assert warnings == [f"{tmp_path / 'a.mcap'} exists; recording to a-2.mcap beside it"]


def test_every_replay_has_its_stage() -> None:
    for name, kind in REPLAYS.items():
        (port,) = ports(load_stage(f"recording.{name}")).outputs
        assert port.type is kind


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("recording.port[balls.kalman.track]", 'balls.kalman has no output "track"'),
        ("recording.port[balls.kallman.tracks]", 'no stage "balls.kallman"'),
        ("recording.port[recording.port[balls.kalman.tracks].out]", "cannot be asked for"),
        ("recording.tracks[balls.kalman.tracks]", "cannot be asked for"),
        ("recording.port[", 'no stage ""'),
    ],
)
def test_a_replay_of_a_port_that_is_none_says_so(name: str, said: str) -> None:
    with pytest.raises(FollowspotError) as told:
        load_stage(name)
    assert said in str(told.value)


def test_a_replay_without_a_type_says_what_to_write(tmp_path: Path) -> None:
    with pytest.raises(FollowspotError, match=r"recording\.port\[STAGE\.PORT\]"):
        load_stage("recording.port")(path=record(tmp_path / "a.mcap", 1)).setup()


def replayed(path: Path, **params: object) -> list[Message]:
    stage = load_stage("recording.tracks")(Context("track", ROOM), path=path, port="track.tracks", **params)
    stage.setup()
    try:
        return [message for message, _ in zip(stage.process(), range(100), strict=False)]
    finally:
        stage.close()


def test_a_replay_keeps_times_and_numbers(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap")
    found = replayed(path, start_time=0.06, stop_time=0.09)
    assert [m.header.seq for m in found] == [4, 5]
    assert [m.header.time for m in found] == [4 * SPACING, 5 * SPACING]
    assert found[0].xyz.tobytes() == tracks(4).xyz.tobytes()


def test_a_replay_in_a_loop_goes_on_in_time(tmp_path: Path) -> None:
    found = replayed(record(tmp_path / "a.mcap", 3), loop=True)
    times = [m.header.time for m in found]
    assert len(found) == 100
    assert times == sorted(set(times))
    assert [m.header.seq for m in found[:7]] == [0, 1, 2, 3, 4, 5, 6]


def test_a_replay_of_another_type_says_what_is_there(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap", 1)
    stage = load_stage("recording.blobs")(Context("color", ROOM), path=path, port="track.tracks")
    stage.setup()
    with pytest.raises(FollowspotError, match=r"holds followspot\.tracking\.Tracks"):
        next(stage.process())
    stage.close()


@pytest.mark.parametrize("kind", REPLAYS.values())
def test_a_contract_describes_its_type(kind: type[Message]) -> None:
    made = message_type(contract_of(kind))
    assert [c[:4] for c in made.columns] == [c[:4] for c in kind.columns]
    assert made.scalars == kind.scalars


@given(st.text() | st.binary().map(str) | st.from_regex(r'\{"type": .*\}'))
def test_a_contract_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ContractError):
        message_type(text)


@pytest.mark.parametrize("name", ["__init__", "header", "class", "a b", "where"])
def test_a_contract_cannot_name_what_a_message_has(name: str) -> None:
    contract = json.loads(contract_of(Tracks))
    contract["scalars"] = {name: "str"}
    with pytest.raises(ContractError, match="impossible names"):
        message_type(json.dumps(contract))
