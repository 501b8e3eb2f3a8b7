"""Takes pictures of cameras in a process of its own: python gev_client.py JSON.

JSON: {"backend": ..., "interface": ..., "count": pictures of each, "cameras": {name: address}, "sync": that
of the room, or null; "features" and "read_timeout" of the stage may follow}. Prints a line once all cameras
send pictures; then JSON: for each camera its frames, [[number, capture time in ns], ...], their stamps by
the camera, ns, what it lost, and what it said, [[ns since 1970, text], ...].
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from threading import Semaphore
from typing import Any

from tests.plugins.cameras.recordings import context

from followspot import Context, Room
from followspot.room import Sync
from followspot_cameras.genicam.camera import Picture, VisionCamera
from followspot_cameras.genicam.stage import Genicam

SIZE = (64, 48)


class Stamped(Genicam):
    """Keeps the camera's own time stamp of each picture."""

    def _is_whole(self, picture: Picture, camera: VisionCamera) -> bool:
        whole = super()._is_whole(picture, camera)
        self.stamps[self._numbers.number] = picture.camera_time
        return whole


def taken(name: str, asked: dict[str, Any], begun: Semaphore) -> dict[str, Any]:
    """The pictures of one camera."""
    said: list[tuple[int, str]] = []
    lost: Counter[str] = Counter()
    camera = replace(context("infrared", SIZE).room.cameras["cam3"], name=name)
    room = Room(cameras={name: camera}, sync=Sync(**asked["sync"]) if asked["sync"] else None)
    found = Context.serving(camera, room, name=f"camera/{name}")
    found = replace(found, warn=lambda text: said.append((time.time_ns(), text)))
    found = replace(found, lost=lambda kind, number: lost.update({kind: number}))
    params = {"backend", "interface", "features", "read_timeout"} & asked.keys()
    where = {"read_timeout": 20.0, **{name: asked[name] for name in params}}
    stage = Stamped(found, camera=asked["cameras"][name], **where)
    stage.stamps = {}
    pictures = stage.process()
    frames = [next(pictures)]
    if not begun.acquire(blocking=False):
        print("taking", flush=True)
    frames += islice(pictures, asked["count"] - 1)
    stage.close()
    stamps = [stage.stamps[frame.header.seq] for frame in frames]
    told = [(frame.header.seq, frame.header.time) for frame in frames]
    return {"frames": told, "stamps": stamps, "lost": dict(+lost), "said": said}


def main(asked: dict[str, Any]) -> None:
    begun = Semaphore(len(asked["cameras"]) - 1)
    with ThreadPoolExecutor(len(asked["cameras"])) as pool:
        found = pool.map(lambda name: taken(name, asked, begun), asked["cameras"])
        print(json.dumps(dict(zip(asked["cameras"], found, strict=True))))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
