"""A damaged recording is read as far as it is good, and says where that is."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer
from tests.full_disk import full_disk

from followspot import Context
from followspot.errors import FollowspotError
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.tracking import Positions
from followspot_recording.recording import Recording
from followspot_recording.records import HEAD, MAGIC
from followspot_recording.sink import RecordingSink

COUNT = 60
PORT = "fuse.out"
ABOUT: Mapping[str, Any] = {"compression": "lz4", "metadata": {"graph": "toy"}}


def record(path: Path) -> Path:
    sink = RecordingSink(Context("a"), path=path, port=PORT, chunk_size=0.001, **ABOUT)
    sink.setup()
    fill(sink, COUNT)
    sink.close()
    return path


def fill(sink: RecordingSink, count: int) -> None:
    for number in range(count):
        sink.process(stamped(seal(Positions.empty()), Header("camera", number, number * 1000)))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return record(tmp_path_factory.mktemp("whole") / "a.mcap").read_bytes()


def read(path: Path, data: bytes) -> tuple[list[int], str]:
    """Numbers of the messages that are read, and what is said of the rest."""
    path.write_bytes(data)
    with Recording(path) as recording:
        return [message.seq for message in recording.messages(PORT)], recording.problem


def test_a_port_that_came_late_has_the_type_that_an_earlier_chunk_tells(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    early, late = (
        RecordingSink(Context("a"), path=path, port=port, chunk_size=0.001) for port in (PORT, "late.out")
    )
    for sink in (early, late):
        sink.setup()
    fill(early, COUNT)
    fill(late, COUNT)
    late.close()
    early.close()
    path.write_bytes(path.read_bytes()[:-1000])
    with Recording(path) as recording:
        assert recording.problem
        assert (
            recording.ports["late.out"].schema
            == recording.ports[PORT].schema
            == "followspot.tracking.Positions"
        )


def test_a_whole_recording_has_no_problem(whole: bytes, tmp_path: Path) -> None:
    assert read(tmp_path / "a.mcap", whole) == (list(range(COUNT)), "")


@pytest.mark.parametrize(
    "left_out",
    [
        {"index_types": IndexType.NONE},
        {"index_types": IndexType.CHUNK},  # the chunks without the messages in each
        {"index_types": IndexType.MESSAGE, "use_statistics": False},
        {"repeat_channels": False},
        {"use_statistics": False},
    ],
)
def test_all_messages_of_a_file_with_a_partial_index_are_read(
    whole: bytes, tmp_path: Path, left_out: Mapping[str, Any]
) -> None:
    """Other programs that write MCAP files may leave parts of the index out."""
    found, _ = read(tmp_path / "b.mcap", written_again(whole, tmp_path / "a.mcap", **left_out))
    assert found == list(range(COUNT))


def written_again(whole: bytes, path: Path, **options: Any) -> bytes:
    """The channels and messages of a recording as the mcap package writes them."""
    schemas, channels = dict[int, int](), dict[int, int]()
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1000, **options)
        writer.start()
        for schema, channel, message in make_reader(BytesIO(whole)).iter_messages():
            if schema is not None and schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                told = channel.topic, channel.message_encoding, schemas.get(channel.schema_id, 0)
                channels[channel.id] = writer.register_channel(*told)
            times = message.log_time, message.data, message.publish_time, message.sequence
            writer.add_message(channels[channel.id], *times)
        writer.finish()  # type: ignore[no-untyped-call]
    return path.read_bytes()


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_a_recording_that_was_cut_off_is_read_to_its_last_chunk(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    path = tmp_path_factory.mktemp("cut") / "a.mcap"
    size = int(share * len(whole))
    if size < 8:
        with pytest.raises(FollowspotError, match="does not begin like an MCAP file"):
            read(path, whole[:size])
        return
    found, problem = read(path, whole[:size])
    assert found == list(range(len(found)))
    assert "read up to there" in problem or "its index is damaged" in problem


@settings(max_examples=120, deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_never_makes_a_wrong_message(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, share: float, bit: int
) -> None:
    data = bytearray(whole)
    data[int(share * len(data))] ^= 1 << bit
    path = tmp_path_factory.mktemp("flip") / "a.mcap"
    if not data.startswith(MAGIC):
        with pytest.raises(FollowspotError, match="does not begin like an MCAP file"):
            read(path, bytes(data))
        return
    found, problem = read(path, bytes(data))
    assert found == list(range(len(found)))
    assert len(found) == COUNT or problem


@settings(max_examples=120, deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_an_examination_tells_every_flipped_bit(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, share: float, bit: int
) -> None:
    data = bytearray(whole)
    data[int(share * len(data))] ^= 1 << bit
    path = tmp_path_factory.mktemp("flip") / "a.mcap"
    if data.startswith(MAGIC):
        assert examined(path, bytes(data))


def test_an_examination_tells_a_flipped_bit_in_the_facts_about_a_run(whole: bytes, tmp_path: Path) -> None:
    assert not examined(tmp_path / "whole.mcap", whole)
    damaged = whole.replace(b"toy", b"tox", 1)
    assert "facts about the run" in examined(tmp_path / "a.mcap", damaged)


def examined(path: Path, data: bytes) -> str:
    """What an examination of all bytes says."""
    path.write_bytes(data)
    with Recording(path) as recording:
        recording.examine()
        return recording.problem


def test_a_flipped_bit_in_a_chunk_ends_the_recording_there(whole: bytes, tmp_path: Path) -> None:
    data = bytearray(whole)
    data[data.index(b"lz4", len(data) // 4) + 60] ^= 1  # in the content of a chunk
    found, problem = read(tmp_path / "a.mcap", bytes(data))
    assert 0 < len(found) < COUNT
    assert "at byte" in problem
    assert f"of {len(data)}; read up to there" in problem


@pytest.mark.parametrize("times", [0, 2])
def test_a_recording_without_one_of_its_chunks_or_with_one_twice_is_not_whole(
    whole: bytes, tmp_path: Path, times: int
) -> None:
    """times: how often the chunk is there."""
    start, end = last_chunk(whole)
    found, problem = read(tmp_path / "a.mcap", whole[:start] + times * whole[start:end] + whole[end:])
    assert found != list(range(COUNT))
    assert "not those that it tells of" in problem


def last_chunk(data: bytes) -> tuple[int, int]:
    """Where the last chunk of a recording begins and ends."""
    found, offset = (0, 0), len(MAGIC)
    while offset + HEAD.size < len(data):
        opcode, length = HEAD.unpack_from(data, offset)
        end = offset + HEAD.size + length
        found = (offset, end) if opcode == Opcode.CHUNK else found
        offset = end
    return found


def test_a_file_without_chunks_is_told_with_a_remedy(tmp_path: Path) -> None:
    file = BytesIO()
    writer = Writer(file, use_chunking=False)
    writer.start()
    channel = writer.register_channel(PORT, "", writer.register_schema("a", "", b""))
    writer.add_message(channel, 0, b"", 0)
    writer.finish()
    numbers, problem = read(tmp_path / "a.mcap", file.getvalue())
    assert not numbers
    assert "messages outside of chunks (mcap compress FILE -o NEW.mcap" in problem


@pytest.mark.parametrize("data", [b"", b"hello, world"])
def test_another_file_is_refused(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(FollowspotError, match="no recording"):
        read(tmp_path / "a.mcap", data)


@pytest.mark.parametrize("data", [MAGIC, MAGIC + b"\xff" * 200, MAGIC * 30])
def test_a_file_without_a_good_record_has_no_messages(tmp_path: Path, data: bytes) -> None:
    found, problem = read(tmp_path / "a.mcap", data)
    assert found == []
    assert "at byte 8 of" in problem


def test_a_chunk_that_claims_to_be_huge_is_refused(whole: bytes, tmp_path: Path) -> None:
    data = bytearray(whole)
    at = data.index(b"lz4") - 4 - 4 - 8  # before the compression's name: its length, the checksum, the size
    data[at : at + 8] = (1 << 60).to_bytes(8, "little")
    found, problem = read(tmp_path / "a.mcap", bytes(data))
    assert found == []
    assert "allowed" in problem


@full_disk(20_000)
def test_a_full_disk_ends_the_recording_with_one_warning_and_not_the_show(tmp_path: Path) -> None:
    said: list[str] = []
    path = tmp_path / "a.mcap"
    sink = RecordingSink(
        Context("a", warn=said.append),
        path=path,
        port=PORT,
        chunk_size=0.001,
        compression="none",
        essential=False,
    )
    sink.setup()
    fill(sink, 200)
    sink.close()
    (warning,) = said
    assert f"{path} is cut short: File too large" in warning
    with Recording(path) as recording:
        found = [message.seq for message in recording.messages(PORT)]
        assert "read up to there" in recording.problem
    assert found == list(range(len(found)))
    assert len(found) > 10


@full_disk(20_000)
def test_a_full_disk_ends_a_run_that_is_for_the_recording(tmp_path: Path) -> None:
    sink = RecordingSink(
        Context("a"), path=tmp_path / "a.mcap", port=PORT, chunk_size=0.001, compression="none"
    )
    sink.setup()
    with pytest.raises(FollowspotError, match="ulimit -f unlimited"):
        fill(sink, 200)
    sink.close()


def removed_recording(tmp_path: Path, chunk_mib: float) -> RecordingSink:
    """A sink whose file was removed after it was opened."""
    sink = RecordingSink(Context("a"), path=tmp_path / "a.mcap", port=PORT, chunk_size=chunk_mib)
    sink.setup()
    (tmp_path / "a.mcap").unlink()
    return sink


REMOVED = r"a\.mcap was removed while it was recorded"


def test_a_recording_that_is_removed_ends_a_run_that_is_for_it(tmp_path: Path) -> None:
    sink = removed_recording(tmp_path, chunk_mib=0.001)
    with pytest.raises(FollowspotError, match=REMOVED):
        fill(sink, 200)
    sink.close()


def test_a_recording_that_is_removed_is_missed_at_the_end_at_the_latest(tmp_path: Path) -> None:
    sink = removed_recording(tmp_path, chunk_mib=4.0)
    fill(sink, 1)
    with pytest.raises(FollowspotError, match=REMOVED):
        sink.close()


def test_a_recording_that_is_removed_is_one_warning_in_a_show(tmp_path: Path) -> None:
    said: list[str] = []
    sink = RecordingSink(Context("a", warn=said.append), path=tmp_path / "a.mcap", port=PORT, essential=False)
    sink.setup()
    (tmp_path / "a.mcap").unlink()
    fill(sink, 200)
    sink.close()
    assert said == [
        f"the recording ends here, the run goes on: {tmp_path}/a.mcap was removed while it was recorded"
    ]
