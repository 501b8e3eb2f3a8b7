"""Takes pictures of cameras in a process of its own: python gev_client.py JSON.

JSON: {"backend": ..., "interface": ..., "count": pictures of each, "cameras": {name: address}, "sync": that
of the room, or null}. Prints JSON: for each camera its frames, [[number, capture time in ns], ...], what it
lost, and what it said.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from typing import Any

from tests.plugins.cameras.recordings import context

from followspot import Context, Room
from followspot.room import Sync
from followspot_cameras.genicam.stage import Genicam

SIZE = (64, 48)


def taken(name: str, asked: dict[str, Any]) -> dict[str, Any]:
    """The pictures of one camera."""
    said: list[str] = []
    lost: Counter[str] = Counter()
    camera = replace(context("infrared", SIZE).room.cameras["cam3"], name=name)
    room = Room(cameras={name: camera}, sync=Sync(**asked["sync"]) if asked["sync"] else None)
    found = Context.serving(camera, room, name=f"camera/{name}", warn=said.append)
    found = replace(found, lost=lambda kind, number: lost.update({kind: number}))
    where = {key: asked[key] for key in ("backend", "interface")}
    stage = Genicam(found, camera=asked["cameras"][name], read_timeout=20.0, **where)
    frames = [(frame.header.seq, frame.header.time) for frame in islice(stage.process(), asked["count"])]
    stage.close()
    return {"frames": frames, "lost": dict(+lost), "said": said}


def main(asked: dict[str, Any]) -> None:
    with ThreadPoolExecutor() as pool:
        found = pool.map(lambda name: taken(name, asked), asked["cameras"])
        print(json.dumps(dict(zip(asked["cameras"], found, strict=True))))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
