"""How messages are put into chunks, and which chunks are compressed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

from followspot_recording.recorder import Chunking, Recorder, Schema

SCHEMA = Schema("any", "followspot", "")


def chunks_of(path: Path, messages: list[bytes], size: int) -> list[Chunk]:
    recorder = Recorder(path, Chunking(size, 60.0, "zstd"))
    for number, data in enumerate(messages):
        recorder.add("/a", "followspot", SCHEMA, number, number, data)
    recorder.close()
    with path.open("rb") as file:
        return [
            record for record in StreamReader(file, emit_chunks=True).records if isinstance(record, Chunk)
        ]


def test_a_chunk_has_a_hundred_messages_at_most(tmp_path: Path) -> None:
    chunks = chunks_of(tmp_path / "a.mcap", [b"."] * 201, 1 << 20)
    assert [(chunk.message_start_time, chunk.message_end_time) for chunk in chunks] == [
        (0, 99),
        (100, 199),
        (200, 200),
    ]


def test_after_a_chunk_of_noise_some_are_stored_without_compression(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).bytes(4096)
    chunks = chunks_of(tmp_path / "a.mcap", [noise, *[bytes(4096)] * 20], 4096)
    assert [chunk.compression for chunk in chunks] == ["zstd", *[""] * 15, *["zstd"] * 5]
