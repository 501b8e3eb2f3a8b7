"""Stage `cameras.ros_bag`: pictures in a bag of ROS 1 or ROS 2, without ROS."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.typesys import Stores, get_typestore

from followspot.errors import InputError
from followspot.frame_times import SECOND
from followspot_cameras.logged.logged_images import LoggedImages, LogParams, Pictures
from followspot_cameras.logged.stored_image import StoredImage
from followspot_cameras.logged.topics import chosen_topic

RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


class RosBag(LoggedImages):
    """Play sensor_msgs/Image or sensor_msgs/CompressedImage of a bag, each at the stamp of its header."""

    class Params(LogParams):
        """The bag (.bag, a folder of ROS 2, .db3 or .mcap), the topic, and the part to play."""

    params: Params

    @classmethod
    @contextmanager
    def opened(cls, params: LogParams) -> Iterator[Pictures]:
        """The pictures of an open bag. Raises InputError if it is none, or has no such topic."""
        reader = _reader(params)
        try:
            types = {connection.topic: connection.msgtype for connection in reader.connections}
            topic = chosen_topic(params.path, types, (RAW, COMPRESSED), params.topic)
            connections = [one for one in reader.connections if one.topic == topic]
            yield Pictures(_images(params, reader, connections), sum(one.msgcount for one in connections))
        finally:
            reader.close()


def _reader(params: LogParams) -> AnyReader:
    """The open bag. Raises InputError."""
    try:
        reader = AnyReader([params.path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except Exception as error:  # databases, texts and definitions of types may be anything
        raise _damaged(params, error) from None
    return reader


def _images(
    params: LogParams, reader: AnyReader, connections: list[Connection]
) -> Iterator[StoredImage | None]:
    """The pictures of a topic. Raises InputError where the bag is damaged."""
    messages = reader.messages(connections)
    while True:
        try:
            connection, logged, data = next(messages)
        except StopIteration:
            return
        except Exception as error:
            raise _damaged(params, error) from None
        try:
            image = _image(reader.deserialize(data, connection.msgtype), connection.msgtype, logged)
        except Exception:  # a message that is not of its type
            image = None
        yield image


def _image(message: Any, kind: str, logged: int) -> StoredImage:
    """The picture of a message; its time is the stamp of its header, or `logged`, ns, if that is 0."""
    stamp = message.header.stamp
    time = int(stamp.sec) * SECOND + int(stamp.nanosec) or logged
    data = np.asarray(message.data, "u1")
    if kind == COMPRESSED:
        return StoredImage(time, data)
    return StoredImage(
        time, data, message.encoding, message.width, message.height, message.step, bool(message.is_bigendian)
    )


def _damaged(params: LogParams, error: Exception) -> InputError:
    text = f"{params.path} cannot be read as a ROS bag: {type(error).__name__} {error}"
    return InputError.of(text, "give a file .bag, .db3 or .mcap, or the folder that `ros2 bag record` made")
