"""The empty room as a camera sees it, and how far away its furniture is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_sim.actor.furniture import Box, furniture_of
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.texture import TEXTURES, Spots, ceiling, floor, wall
from followspot_sim.rendering.screen import rays_of

PARALLEL = 1e-9
"""A direction is never quite along a wall."""


@dataclass(frozen=True, eq=False)
class Backdrop:
    """The empty room: picture (H, W, 3) uint8; away: (H, W) float32, level distance of furniture, m.

    Without furniture, `away` is infinite.
    """

    picture: Array
    away: Array


def lamp_of(params: ActorParams) -> Array:
    """Position of the lamp, (3,) m."""
    return np.array([0.0, 0.0, params.room_size[2] - 0.05])


def backdrop(params: ActorParams, camera: Camera) -> Backdrop:
    """Cast one ray for each pixel. Takes about a second."""
    ray = rays_of(camera).reshape(-1, 3)
    boxes = furniture_of(params)
    place, color, normal = _shell(params, camera.center, ray)
    distance = np.linalg.norm(place - camera.center, axis=1)
    away = np.full(len(ray), np.inf, np.float32)
    for box in boxes:
        far, face = _meet(box, camera.center, ray)
        hit = far < distance
        if not hit.any():
            continue
        point = camera.center + ray[hit] * far[hit, None]
        place[hit], distance[hit] = point, far[hit]
        color[hit], normal[hit] = _on_box(box, point, face[hit])
        away[hit] = np.hypot(*(point - camera.center)[:, :2].T)
    light = color * _light(params, boxes, place, normal)[:, None]
    width, height = camera.size
    picture = np.clip(light, 0, 255).astype(np.uint8).reshape(height, width, 3)
    return Backdrop(picture, away.reshape(height, width))


def _shell(params: ActorParams, centre: Array, ray: Array) -> tuple[Array, Array, Array]:
    """Intersections of rays with walls, floor and ceiling: (N, 3) m, colour (N, 3), inward normal (N, 3)."""
    half = np.array([params.room_size[0] / 2, params.room_size[1] / 2, params.room_size[2]])
    low, high = np.array([-half[0], -half[1], 0.0]), half
    ray = np.where(np.abs(ray) < PARALLEL, PARALLEL, ray)
    reach = ((np.where(ray > 0, high, low) - centre) / ray).T.copy()  # numpy reduces three columns slowly
    axis = reach.argmin(axis=0)
    place = centre + ray * reach.min(axis=0)[:, None]
    positive = np.take_along_axis(ray, axis[:, None], axis=1)[:, 0] > 0
    normal = np.zeros_like(ray)
    normal[np.arange(len(ray)), axis] = np.where(positive, -1.0, 1.0)
    color = np.empty_like(ray)
    surface = 2 * axis + positive
    for number in np.unique(surface).tolist():
        hit = surface == number
        across = place[hit] - low
        u, v = (across[:, 1 - number // 2], across[:, 2]) if number < 4 else (across[:, 0], across[:, 1])
        spots = Spots(np.zeros(hit.sum(), int), u, v, 2 * half[0], 2 * half[1])
        texture = wall if number < 4 else (floor, ceiling)[number - 4]
        color[hit] = texture(spots, np.random.default_rng([params.seed, number, 3]))
    return place, color, normal


def _meet(box: Box, centre: Array, ray: Array) -> tuple[Array, Array]:
    """Distance at which rays enter a box, (N,) m, infinite if they miss, and through which of its axes."""
    axes, half = box.axes(), np.array(box.size) / 2
    start, local = (centre - box.middle()) @ axes.T, ray @ axes.T
    near, far = np.full(len(ray), -np.inf), np.full(len(ray), np.inf)
    axis = np.zeros(len(ray), np.intp)
    for number, along in enumerate(np.ascontiguousarray(local.T)):  # numpy reduces three columns slowly
        along[np.abs(along) < PARALLEL] = PARALLEL
        side = np.copysign(half[number], along)
        enter = (-side - start[number]) / along
        axis[enter > near] = number
        np.maximum(near, enter, out=near)
        np.minimum(far, (side - start[number]) / along, out=far)
    return np.where((near > 0) & (near < far), near, np.inf), axis


def _on_box(box: Box, point: Array, axis: Array) -> tuple[Array, Array]:
    """Colour and outward normal of points on a box; axis: of the side that each point is on."""
    local = (point - box.middle()) @ box.axes().T
    half = np.array(box.size) / 2
    sign = np.sign(np.take_along_axis(local, axis[:, None], axis=1))
    normal = sign * box.axes()[axis]
    front = (axis == 0) & (sign[:, 0] > 0)
    face = np.where(axis == 2, 2, np.where(front, 0, 1))
    u = np.where(axis == 1, local[:, 0] + half[0], local[:, 1] + half[1])
    v = np.where(axis == 2, local[:, 0] + half[0], local[:, 2] + half[2])
    spots = Spots(face, u, v, box.size[1], box.size[2])
    return TEXTURES[box.kind](spots, np.random.default_rng(box.seed)), normal


def _light(params: ActorParams, boxes: tuple[Box, ...], place: Array, normal: Array) -> Array:
    """Light of the lamp and of the room, darker in corners and around furniture on the floor, (N,)."""
    to_lamp = lamp_of(params) - place
    distance = np.linalg.norm(to_lamp, axis=1)
    slant = np.maximum((normal * to_lamp).sum(axis=1) / distance, 0.0)
    light = 0.62 + 0.45 * slant * np.minimum(2.4 / distance, 1.5)
    half = np.array(params.room_size)[:2] / 2
    from_wall = np.sort(np.column_stack([half - np.abs(place[:, :2]), place[:, 2]]), axis=1)[:, 1]
    light *= 1 - 0.22 * np.exp(-from_wall / 0.25)
    for box in boxes:
        if box.z > 0:
            continue
        across = np.abs((place - box.middle()) @ box.axes().T)[:, :2] - np.array(box.size[:2]) / 2
        out = np.hypot(*np.maximum(across, 0.0).T)
        light *= np.where(place[:, 2] < 0.01, 1 - 0.35 * np.exp(-out / 0.2), 1.0)
    return np.asarray(light)
