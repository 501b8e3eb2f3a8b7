"""Balls of known size as the four cameras of a small room see them, and the candidates of their pairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tests.plugins.balls.scene import RADIUS, forecast_at, make_room

from followspot.context import Context
from followspot.geometry import back_projection, triangulate_pairs
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Candidates, Forecast
from followspot_balls.bundle_fusion import Bundle

ROOM = make_room()
P = np.array([c.projection for c in ROOM.cameras.values()])
CENTERS = np.array([c.center for c in ROOM.cameras.values()])
FOCAL = 150.0
COLOR = np.array([c.kind == "color" for c in ROOM.cameras.values()])
HIGH = (0.1, -0.2, 1.5)
TARGETS = 2
Labels = Sequence[Sequence[Sequence[bool]]]


def undistorted(place: Array) -> Array:
    """Where a point appears in every camera, (4, 2) px."""
    x = P @ np.append(place, 1.0)
    return np.asarray(x[:, :2] / x[:, 2:])


def whole(place: Array) -> Array:
    """Sizes of a whole ball's blobs there, (4,) px."""
    distance = np.linalg.norm(np.asarray(place) - CENTERS, axis=1)
    return np.asarray(np.pi * np.square(FOCAL * RADIUS / distance))


def candidates(xy: list[Array], area: list[Array], targets: Labels, room: Room = ROOM) -> Candidates:
    """All pairs over cameras of blobs: for each camera (n, 2) px, (n,) px and n lists of what it may be."""
    back = np.array([back_projection(c) for c in room.cameras.values()])
    centers = np.array([c.center for c in room.cameras.values()])
    rows = [(c, i) for c, points in enumerate(xy) for i in range(len(points))]
    pairs = [(a, b) for n, a in enumerate(rows) for b in rows[n + 1 :] if a[0] < b[0]]
    view = np.array([[a[0], b[0]] for a, b in pairs], np.int32).reshape(-1, 2)
    blob = np.array([[a[1], b[1]] for a, b in pairs], np.int32).reshape(-1, 2)
    place = np.array([[xy[c][i] for c, i in pair] for pair in pairs]).reshape(-1, 2, 2)
    rays = (back[view, :, :2] @ place[..., None])[..., 0] + back[view, :, 2]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    both = [np.array(targets[a[0]][a[1]]) & np.array(targets[b[0]][b[1]]) for a, b in pairs]
    of = np.array(both, bool).reshape(-1, TARGETS)
    xyz = triangulate_pairs(centers[view], rays)
    real = of.any(axis=1) & ~np.isnan(xyz[:, 0])
    color = COLOR[view]
    return seal(
        Candidates(
            cameras=tuple(room.cameras),
            xyz=xyz[real],
            view=view[real],
            blob=blob[real],
            xy=place[real],
            area=np.array([[area[c][i] for c, i in pair] for pair in pairs]).reshape(-1, 2)[real],
            epipolar=np.zeros(int(real.sum())),
            labelled=np.asarray(color.any(axis=1))[real],
            confirmed=(color[:, 0] ^ color[:, 1])[real],
            evident=(color[:, 0] ^ color[:, 1])[real],
            targets=of[real],
            clutter=np.ones((int(real.sum()), 2)),
        )
    )


def one_ball(xy: Array, place: Array, views: tuple[int, ...] = (0, 1, 2, 3)) -> Candidates:
    """Candidates of one blob in each of some views, that may be the first target."""
    size = whole(place)
    return candidates(
        [xy[[c]] if c in views else np.zeros((0, 2)) for c in range(4)],
        [size[[c]] if c in views else np.zeros(0) for c in range(4)],
        [[[True, False]] if c in views else [] for c in range(4)],
    )


def bundle(room: Room = ROOM, **params: float) -> Bundle:
    stage = Bundle(Context(room=room), **params)
    stage.setup()
    return stage


def near(place: tuple[float, float, float] = HIGH, sigma: float = 0.02) -> Forecast:
    """The first target expected a centimetre from there, the second far away."""
    return forecast_at([(place[0] + 0.01, place[1], place[2]), (1.5, 1.5, 1.0)], sigma)
