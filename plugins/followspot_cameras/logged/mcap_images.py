"""Stage `cameras.mcap`: pictures in an MCAP file of another program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Message, Schema
from mcap.summary import Summary

from followspot.errors import InputError
from followspot.files import open_regular
from followspot_cameras.logged.foxglove_images import ENCODINGS, SCHEMAS, stored_image
from followspot_cameras.logged.logged_images import LoggedImages, LogParams, Pictures
from followspot_cameras.logged.stored_image import StoredImage
from followspot_cameras.logged.topics import chosen_topic

LARGEST_CHUNK = 2_000_000_000
"""Bytes of a chunk when it is unpacked."""
WHOLE = "write it again with `mcap recover`"


class McapImages(LoggedImages):
    """Play foxglove.RawImage or foxglove.CompressedImage of an MCAP file, each at its time stamp."""

    class Params(LogParams):
        """The file, the topic, and the part to play."""

    params: Params

    @classmethod
    @contextmanager
    def opened(cls, params: LogParams) -> Iterator[Pictures]:
        """The pictures of an open file. Raises InputError if it is none, or has no summary or topic."""
        try:
            file = open_regular(params.path, None)
        except OSError as error:
            raise InputError.of(f"{params.path} cannot be read: {error.strerror}") from None
        with file:
            try:
                reader = make_reader(file)
                summary = reader.get_summary()
            except Exception as error:  # the reader trusts the lengths in the file
                raise _damaged(params.path, error) from None
            if summary is None or summary.statistics is None:
                raise InputError.of(f"{params.path} has no summary, so it was not closed", WHOLE)
            topic = _topic(params, summary)
            counts = summary.statistics.channel_message_counts
            count = sum(counts.get(n, 0) for n, channel in summary.channels.items() if channel.topic == topic)
            yield Pictures(_images(params.path, reader, topic), count)


def _topic(params: LogParams, summary: Summary) -> str:
    """The topic with pictures. Raises InputError."""
    if any(chunk.uncompressed_size > LARGEST_CHUNK for chunk in summary.chunk_indexes):
        raise InputError.of(f"{params.path} has a chunk of more than {LARGEST_CHUNK} bytes", WHOLE)
    types = {}
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        types[channel.topic] = schema.name if schema is not None else ""
    topic = chosen_topic(params.path, types, SCHEMAS, params.topic)
    encodings = {c.message_encoding for c in summary.channels.values() if c.topic == topic}
    if not encodings <= set(ENCODINGS):
        text = f"topic: {topic} has messages encoded as {', '.join(sorted(encodings))}"
        raise InputError.of(text, f"known are {', '.join(ENCODINGS)}; cameras.ros_bag reads cdr")
    return topic


def _images(path: Path, reader: McapReader, topic: str) -> Iterator[StoredImage | None]:
    """The pictures of a topic. Raises InputError where the file is damaged."""
    for schema, channel, message in _messages(path, reader, topic):
        try:
            name = schema.name if schema is not None else ""
            yield stored_image(name, channel.message_encoding, message.data, message.log_time)
        except ValueError:
            yield None


def _messages(path: Path, reader: McapReader, topic: str) -> Iterator[tuple[Schema | None, Channel, Message]]:
    """The messages of a topic. Raises InputError where the file is damaged."""
    try:
        yield from reader.iter_messages(topics=[topic])
    except Exception as error:  # of the reader, or of the package that unpacks a chunk
        raise _damaged(path, error) from None


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError.of(f"{path} is no whole MCAP file: {type(error).__name__} {error}", WHOLE)
