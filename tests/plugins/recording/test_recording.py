"""What goes into a recording comes out again, bit for bit, and other programs can read it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import DataEnd
from mcap.stream_reader import StreamReader
from tests.plugins.recording.recorded_messages import ROOM, SPACING, frame, record, tracks

from followspot import Context
from followspot.errors import FollowspotError
from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, identical, stamped
from followspot.people import Poses, PoseTruth
from followspot.tracking import Blobs, Frame, Tracks, Truth
from followspot.wire import differenced, pack, unpack
from followspot_recording.contract import ContractError, contract_of, message_type, type_name
from followspot_recording.decoding import decoded as decoded_port
from followspot_recording.recorder import Chunking, Recorder, Schema
from followspot_recording.recording import Recording
from followspot_recording.replays import REPLAYS
from followspot_recording.sink import RecordingSink


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
