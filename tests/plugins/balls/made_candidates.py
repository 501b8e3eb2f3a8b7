"""Blobs of positions in the cameras of a room, and the candidates that they make, for association tests."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from tests.plugins.balls.scene import blobs_of, make_room

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Blobs, Candidates, Forecast
from followspot_balls.associate import Associate
from followspot_balls.association.view_association import ViewAssociation
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs

Place = tuple[float, float, float]
ROOM = make_room()
BALL: Place = (0.1, 0.2, 1.2)
PATCH: Place = (0.4, 0.35, 1.4)
COLOR, INFRARED = ("cam0", "cam2"), ("cam1", "cam3")
EVERYWHERE = (*COLOR, *INFRARED)


def views(
    shown: Mapping[Place, tuple[str, ...]], targets: list[list[bool]] | None = None, room: Room = ROOM
) -> tuple[Blobs, ...]:
    """Blobs of places in those cameras that show them. Infrared blobs may be anyone's."""
    made = []
    for name, camera in room.cameras.items():
        rows = [row for row, cameras in enumerate(shown.values()) if name in cameras]
        owners = [[True, False]] * len(shown) if targets is None else targets
        mine = [[True, True] if camera.kind == "infrared" else owners[row] for row in rows]
        made.append(blobs_of(camera, [list(shown)[row] for row in rows], mine))
    return tuple(made)


def associated(to: ViewAssociation, blobs: tuple[Blobs, ...], forecast: Forecast | None) -> Candidates:
    return to.process(candidates_of(blobs, forecast), forecast).candidates


def candidates_of(blobs: tuple[Blobs, ...], forecast: Forecast | None = None) -> Candidates:
    verify, triangulate = VerifyPairs(Context(room=ROOM)), Triangulate(Context(room=ROOM))
    verify.setup()
    triangulate.setup()
    return seal(triangulate.process(seal(verify.process(blobs)), forecast))


def red(found: Candidates) -> Array:
    """Places of candidates of the first target."""
    return np.asarray(found.xyz[found.targets[:, 0]])


def stage(**params: float) -> Associate:
    """The stage, set up in the room."""
    made = Associate(Context(room=ROOM), **params)
    made.setup()
    return made
