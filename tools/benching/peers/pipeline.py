"""The tracker as a pipeline of `multiprocessing`: a process for each camera, pipes to the fusion and back."""

from __future__ import annotations

import multiprocessing
import sys
import time
from multiprocessing.connection import Connection

from benching.peers.parts import Camera, Fusion, Order, read_order


def watch(order: Order, camera: str, pipe: Connection) -> None:
    """A camera's process."""
    part = Camera(order, camera)
    part.clock.ready(camera)
    part.clock.wait()
    forecast = None
    for number in range(order.frames):
        time.sleep(part.clock.seconds_until(number))
        pipe.send(part.blobs(number, forecast))
        forecast = pipe.recv()


def run(order: Order) -> None:
    """The fusion's process, which starts the others."""
    context = multiprocessing.get_context("spawn")
    fusion = Fusion(order)
    pipes, cameras = [], []
    for camera in fusion.cameras:
        ours, theirs = context.Pipe()
        cameras.append(context.Process(target=watch, args=(order, camera, theirs)))
        cameras[-1].start()
        pipes.append(ours)
    for _ in range(order.frames):
        forecast = fusion.fuse([pipe.recv() for pipe in pipes])
        for pipe in pipes:
            pipe.send(forecast)
    for process in cameras:
        process.join()
    fusion.report()


if __name__ == "__main__":
    run(read_order(sys.argv[1]))
