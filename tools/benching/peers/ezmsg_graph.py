"""The tracker as an ezmsg graph: a unit for each camera in a process of its own, and one for the fusion."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncGenerator
from typing import Any

import ezmsg.core as ez

from benching.peers.parts import Camera, Fusion, Order, read_order


class CameraSettings(ez.Settings):
    order: Order
    camera: str


class CameraUnit(ez.Unit):
    SETTINGS = CameraSettings
    FORECAST = ez.InputStream(Any)
    BLOBS = ez.OutputStream(Any)

    async def initialize(self) -> None:
        self.part = Camera(self.SETTINGS.order, self.SETTINGS.camera)
        self.number = 0

    @ez.subscriber(FORECAST)
    @ez.publisher(BLOBS)
    async def detect(self, forecast: Any) -> AsyncGenerator[Any, Any]:
        if self.number == 0:
            self.part.clock.ready(self.SETTINGS.camera)
            self.part.clock.wait()
        await asyncio.sleep(self.part.clock.seconds_until(self.number))
        blobs = self.part.blobs(self.number, forecast)
        self.number += 1
        yield self.BLOBS, blobs


class FusionSettings(ez.Settings):
    order: Order


class FusionUnit(ez.Unit):
    SETTINGS = FusionSettings
    BLOBS = ez.InputStream(Any)
    FORECAST = ez.OutputStream(Any)

    async def initialize(self) -> None:
        self.part = Fusion(self.SETTINGS.order)
        self.waiting: dict[str, Any] = {}

    @ez.publisher(FORECAST)
    async def begin(self) -> AsyncGenerator[Any, Any]:
        yield self.FORECAST, None

    @ez.subscriber(BLOBS)
    @ez.publisher(FORECAST)
    async def fuse(self, blobs: Any) -> AsyncGenerator[Any, Any]:
        self.waiting[blobs.camera] = blobs
        if len(self.waiting) == len(self.part.cameras):
            forecast = self.part.fuse([self.waiting.pop(camera) for camera in self.part.cameras])
            if blobs.header.seq + 1 == self.SETTINGS.order.frames:
                self.part.report()
                raise ez.NormalTermination
            yield self.FORECAST, forecast


def run(order: Order) -> None:
    """Run the graph."""
    fusion = FusionUnit(FusionSettings(order))
    cameras = {name: CameraUnit(CameraSettings(order, name)) for name in order.plan().room.cameras}
    links = [(camera.BLOBS, fusion.BLOBS) for camera in cameras.values()]
    links += [(fusion.FORECAST, camera.FORECAST) for camera in cameras.values()]
    components = {"FUSION": fusion, **cameras}
    ez.run(components, connections=links, process_components=tuple(components.values()))


if __name__ == "__main__":
    run(read_order(sys.argv[1]))
