"""A node of the tracker as a dora graph: the fusion, or the camera that is named."""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import pyarrow as pa
from dora import Node

from benching.peers.parts import Camera, Fusion, Order, read_order
from followspot.messages import M, Message
from followspot.tracking import Blobs, Forecast
from followspot.wire import pack, unpack


def send(node: Any, output: str, message: Message) -> None:
    """As bytes: Arrow has no types of ours."""
    node.send_output(output, pa.array(np.frombuffer(pack(message), np.uint8)))


def received(event: Any, kind: type[M]) -> M:
    """The message of an event. Raises InvalidMessage."""
    found = unpack(event["value"].to_numpy().tobytes(), kind)
    assert isinstance(found, kind)
    return found


def watch(order: Order, camera: str) -> None:
    """A camera's node. It sends first, once all cameras are there: no node has to hear a first message."""
    part, node = Camera(order, camera), Node()
    part.clock.ready(camera)
    part.clock.wait()
    for number in range(order.frames):
        forecast = received(next_input(node), Forecast) if number else None
        time.sleep(part.clock.seconds_until(number))
        send(node, "blobs", part.blobs(number, forecast))


def fuse(order: Order) -> None:
    """The fusion's node."""
    part, node = Fusion(order), Node()
    for _ in range(order.frames):
        waiting: dict[str, Any] = {}
        while len(waiting) < len(part.cameras):
            event = next_input(node)
            waiting[event["id"]] = received(event, Blobs)
        send(node, "forecast", part.fuse([waiting[camera] for camera in part.cameras]))
    part.report()


def next_input(node: Any) -> Any:
    """The next event that brings a message. Raises RuntimeError if the graph ends before."""
    for event in node:
        if event["type"] == "INPUT":
            return event
    raise RuntimeError("no message came any more")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        watch(read_order(sys.argv[1]), sys.argv[2])
    else:
        fuse(read_order(sys.argv[1]))
