"""Play every source of a room in a process of its own, and all together in one; tell where they differ.

usage: sources_together.py ROOM.yaml FRAMES COARSER

COARSER: how many times as wide and high pixels are as those of the room's cameras.

Prints one line of JSON: {"sources": [...], "differ": {"SOURCE": FRAME}}, with the first frame whose message
has other bytes together than alone. Each process is a fork of this one before any source was built, so
nothing that a class or a module keeps can reach it from another source.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Context, Message, Room, Stage, room_file
from followspot.graph.camera_kind import source_for
from followspot.plugins.registry import load_stage
from followspot_sim.actor.visibility import coarser


def build(room: Room, name: str, frames: int) -> Stage:
    """The source of a camera, or "truth" for that of the room."""
    camera = room.cameras.get(name)
    source = camera.source if camera else room.truth
    assert source is not None
    context = Context(name, room) if camera is None else Context.serving(camera, room, name=name)
    uses = source_for(source.uses, context.member, room)
    stage = load_stage(uses)(context, **{**source.params, "frames": frames})
    stage.setup()
    return stage


def digest(given: object) -> str:
    """Of every bit that a message carries, and of its time and number; of those of all ports in order."""
    return _digest(given) if isinstance(given, Message) else " ".join(map(_digest, vars(given).values()))


def _digest(message: Message) -> str:
    found = hashlib.sha256(repr((message.header.seq, message.header.time)).encode())
    for name, value in sorted(vars(message).items()):
        if isinstance(value, np.ndarray):
            found.update(repr((name, value.shape, value.dtype.str)).encode() + value.tobytes())
        elif name != "header":
            found.update(repr((name, value)).encode())
    return found.hexdigest()


def alone(room: Room, names: list[str], frames: int) -> dict[str, list[str]]:
    """Digests of one source."""
    return {names[0]: [digest(message) for message in build(room, names[0], frames).process()]}


def in_turn(room: Room, names: list[str], frames: int) -> dict[str, list[str]]:
    """Digests of sources that are all set up and then pulled in turn, the last one first."""
    streams: dict[str, Iterator[object]] = {n: build(room, n, frames).process() for n in names}
    found: dict[str, list[str]] = {name: [] for name in names}
    for _ in range(frames):
        for name in reversed(names):
            found[name].append(digest(next(streams[name])))
    return found


def in_threads(room: Room, names: list[str], frames: int) -> dict[str, list[str]]:
    """Digests of sources that are set up and run in threads of their own."""
    found: dict[str, list[str]] = {}
    threads = [
        threading.Thread(target=lambda name=name: found.update(alone(room, [name], frames))) for name in names
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


Way = Callable[[Room, list[str], int], dict[str, list[str]]]


def apart(way: Way, room: Room, names: list[str], frames: int) -> dict[str, list[str]]:
    """What it returns in a process of its own."""
    inlet, outlet = os.pipe()
    if os.fork() == 0:
        os.close(inlet)
        with os.fdopen(outlet, "w") as pipe:
            json.dump(way(room, names, frames), pipe)
        os._exit(0)
    os.close(outlet)
    with os.fdopen(inlet) as pipe:
        text = pipe.read()
    os.wait()
    return dict(json.loads(text))


def main() -> None:
    """Play, compare, print."""
    room, frames, times = room_file.load(Path(sys.argv[1])), int(sys.argv[2]), int(sys.argv[3])
    room = replace(room, cameras={name: coarser(camera, times) for name, camera in room.cameras.items()})
    names = [*room.cameras, *(["truth"] if room.truth else [])]
    for name in names:
        source = room.cameras[name].source if name in room.cameras else room.truth
        assert source is not None
        load_stage(source.uses)  # its modules are imported before the processes part
    expected: dict[str, list[str]] = {}
    for name in names:
        expected |= apart(alone, room, [name], frames)
    differ: dict[str, int] = {}
    for way in (in_turn, in_threads):
        found = apart(way, room, names, frames)
        for name in names:
            assert len(expected[name]) == len(found[name]) == frames
            wrong = [k for k in range(frames) if found[name][k] != expected[name][k]]
            if wrong:
                differ.setdefault(name, wrong[0])
    print(json.dumps({"sources": names, "differ": differ}))


if __name__ == "__main__":
    main()
