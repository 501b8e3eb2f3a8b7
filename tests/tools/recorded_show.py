"""A short recording of the ready graph, and what tests make of it: replays, and copies that are another."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from mcap.reader import make_reader
from mcap.writer import Writer

from followspot.cli.main import main

GRAPHS = Path(__file__).parents[2] / "graphs"
GLOWBALLS = str(GRAPHS / "glowballs.yaml")
FRAMES = 6


def recorded(folder: Path) -> Path:
    """A recording of all ports of the ready graph, in a folder; its outputs beside it."""
    run = ["run", GLOWBALLS, "--frames", str(FRAMES), "--out", str(folder / "out"), "--quiet", "--json"]
    assert main([*run, "--record", str(folder / "show.mcap")]) == 0
    return folder / "show.mcap"


def replay(show: Path, out: Path, *options: str) -> int:
    return main(["replay", str(show), "--out", str(out), "--quiet", "--json", *options])


def altered(
    show: Path,
    path: Path,
    ends: Mapping[str, int] = MappingProxyType({}),
    chunk_size: int = 1 << 20,
    **changes: object,
) -> Path:
    """The recording with another embedded plan, made by the writer of the mcap package.

    ends: how many messages of these topics it has; all of the others. chunk_size: B, at which a chunk ends.
    """
    with show.open("rb") as old, path.open("wb") as new:
        reader = make_reader(old)
        writer = Writer(new, chunk_size=chunk_size)
        writer.start()
        for attachment in reader.iter_attachments():
            data = json.loads(attachment.data) if attachment.name == "plan.json" else {}
            if data:
                writer.add_attachment(0, 0, "plan.json", "", json.dumps(data | changes).encode())
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if message.sequence >= ends.get(channel.topic, FRAMES):
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                topic = channel.topic, channel.message_encoding
                channels[channel.id] = writer.register_channel(*topic, schemas[schema.id])
            data_of = message.data
            writer.add_message(channels[channel.id], message.log_time, data_of, 0, message.sequence)
        writer.finish()
    return path


def cut_short(show: Path, path: Path, topic: str, count: int) -> Path:
    """The recording without its end, of which so many messages of a topic can be read.

    Each message has a chunk of its own, so that this does not depend on how many the recorder put into one.
    """
    altered(show, path, chunk_size=1)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    (channel,) = (channel.id for channel in summary.channels.values() if channel.topic == topic)
    chunks = [c.chunk_start_offset for c in summary.chunk_indexes if channel in c.message_index_offsets]
    path.write_bytes(path.read_bytes()[: sorted(chunks)[count] + 100])
    return path


def chunks_of(path: Path) -> list[int]:
    """Where the chunks of a recording begin, bytes."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [chunk.chunk_start_offset for chunk in summary.chunk_indexes]
