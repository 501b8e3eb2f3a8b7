"""Blobs of points in a room of four cameras, and the pairs that balls.verify_pairs keeps."""

from __future__ import annotations

from tests.plugins.balls.scene import blobs_of, make_room

from followspot.context import Context
from followspot.room import Room
from followspot.tracking import Blobs, Pairs
from followspot_balls.verify_pairs import VerifyPairs

ROOM = make_room()
BALL = (0.1, 0.2, 1.0)


def verify(blobs: dict[str, list[tuple[float, float, float]]], **params: float) -> Pairs:
    """Pairs of exact blobs of red points in the named cameras, an infrared one serving both targets."""
    stage = VerifyPairs(Context(room=ROOM), **params)
    stage.setup()
    return stage.process(tuple(named(ROOM, n, p) for n, p in blobs.items()))


def named(room: Room, name: str, places: list[tuple[float, float, float]]) -> Blobs:
    camera = room.cameras[name]
    return blobs_of(camera, places, [[True, camera.kind == "infrared"]] * len(places))


def views(pairs: Pairs) -> list[list[int]]:
    return pairs.view.tolist()
