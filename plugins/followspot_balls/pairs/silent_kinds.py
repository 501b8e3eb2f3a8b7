"""A warning if no camera of a kind sends blobs, although the room has cameras of this kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from followspot import Camera, Mistake, Room

_WEIGHED = ("color", "infrared")
"""The kinds of cameras that weigh the places of lost targets."""


def check_kinds(room: Room, cameras: Sequence[Camera]) -> Iterator[Mistake]:
    """The warning, for `Stage.check_room`. cameras: those that send blobs.

    All cameras of the room weigh the position of a lost target. A camera that sends nothing counts as one
    that sees no ball, so no target is found. Rooms with depth cameras weigh no positions, and a camera alone
    finds nothing in any case.
    """
    kinds = {camera.kind for camera in cameras}
    silent = [c.name for c in room.cameras.values() if c.kind in _WEIGHED and c.kind not in kinds]
    if len(cameras) < 2 or not silent or any(c.kind == "depth" for c in room.cameras.values()):
        return
    text = f"{', '.join(silent)} of the room send no blobs, and count as cameras that see no ball"
    taking_part = ",".join(camera.name for camera in cameras)
    yield Mistake(None, text, f"leave them out of the room: --cameras {taking_part}")
