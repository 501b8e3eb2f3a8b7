"""Blobs of glowing balls in a picture, for the plain tracker that benchmarks compare with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot.room import Camera, Room

SIMILARITY = 0.8
SMALLEST, LARGEST = 0.3, 1.5
EDGES = {"color": 0.7, "infrared": 0.45}
COLORFUL = (0, 80, 70), (255, 255, 255)
BOX = np.ones((9, 9), np.uint8)
BEFORE = 5
"""Pixels around a blob that its outline takes into account."""
NO_VOTES = np.empty((2, 0)), np.empty(0)


class Rect(NamedTuple):
    """A part of a picture, px."""

    left: int
    top: int
    right: int
    bottom: int


class View:
    """A camera with what is computed once."""

    def __init__(self, room: Room, camera: Camera, number: int) -> None:
        self.camera, self.number = camera, number
        self.color = camera.kind == "color"
        targets = room.targets.values()
        area = np.array([target.area[camera.name] for target in targets])
        self.least, self.most = SMALLEST * area[:, 0], LARGEST * area[:, 1]
        self.reached = np.ceil(EDGES[camera.kind] * np.arange(256)).clip(1).astype(np.uint8)
        """The level that belongs to a ball, for each level of the brightest pixel around."""
        if self.color:
            self.templates = np.array([target.hue_histogram[camera.name] for target in targets])
            self.members = np.where(np.repeat(self.templates >= 0.02, 16, axis=1), 255, 0).astype(np.uint8)
        else:
            self.gray = np.array([target.gray[camera.name] for target in targets], int)

    def prepared(self, picture: Array) -> Array:
        """HSV of a colour picture, grey level of an infrared one."""
        if self.color:
            return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL))
        return picture if picture.ndim == 2 else np.ascontiguousarray(picture[..., 0])

    def level(self, target: int, pixels: Array) -> Array:
        """Brightness of the pixels that may show the target, 0 elsewhere."""
        if not self.color:
            low, high = map(int, self.gray[target])
            return np.asarray(cv2.bitwise_and(pixels, cv2.inRange(pixels, low, high)))
        hue, _, value = cv2.split(pixels)
        shown = cv2.bitwise_and(cv2.LUT(hue, self.members[target]), cv2.inRange(pixels, *COLORFUL))
        return np.asarray(cv2.bitwise_and(value, shown))

    def regions(self, pixels: Array) -> Iterator[tuple[Rect, Array]]:
        """Bright parts of a whole picture, and which targets (T,) each may show."""
        if self.color:
            shown = cv2.inRange(pixels, *COLORFUL)
        else:
            shown = cv2.inRange(pixels, int(self.gray[:, 0].min()), int(self.gray[:, 1].max()))
        _, labels, stats, _ = cv2.connectedComponentsWithStats(shown, connectivity=8)
        height, width = shown.shape
        for label in 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= self.least.min()):
            left, top, wide, high, pixel_count = stats[label]
            there = labels[top : top + high, left : left + wide] == label
            part = pixels[top : top + high, left : left + wide][there]
            wanted = pixel_count >= self.least
            if self.color:
                counts = np.bincount(part[:, 0] >> 4, minlength=16)
                wanted = (self.templates >= 0.02) @ counts >= self.least
            around = Rect(
                max(left - BEFORE, 0),
                max(top - BEFORE, 0),
                min(left + wide + BEFORE, width),
                min(top + high + BEFORE, height),
            )
            yield around, wanted


class Blob(NamedTuple):
    """A blob of a target: its centre of mass, px, and where edges (V,) say that its centre is, (2, V) px."""

    view: int
    target: int
    mass: tuple[float, float]
    votes: Array
    slopes: Array


def blobs(
    view: View, target: int, pixels: Array, corner: tuple[int, int], radius: float | None
) -> Iterator[Blob]:
    """Blobs of a target in a part of a picture. corner: of the part; radius: of the outline if known, px."""
    level = view.level(target, pixels)
    mask = cv2.compare(level, cv2.LUT(cv2.dilate(level, BOX), view.reached), cv2.CMP_GE)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    for label in range(1, count):
        left, top, wide, high, area = map(int, stats[label])
        if not view.least[target] <= area <= view.most[target]:
            continue
        inside = labels[top : top + high, left : left + wide] == label
        if view.color:
            hue = pixels[top : top + high, left : left + wide, 0][inside]
            histogram = np.bincount(hue >> 4, minlength=16) / area
            if np.sqrt(histogram * view.templates[target]).sum() < SIMILARITY:
                continue
        x, y = max(left - BEFORE, 0), max(top - BEFORE, 0)
        around = level[y : top + high + BEFORE, x : left + wide + BEFORE]
        blob = np.zeros(around.shape, np.uint8)
        blob[top - y : top - y + high, left - x : left - x + wide] = inside
        moments = cv2.moments(around * blob)
        x, y = corner[0] + x, corner[1] + y
        mass = moments["m10"] / moments["m00"] + x, moments["m01"] / moments["m00"] + y
        given = NO_VOTES if radius is None else votes(view, around, blob, radius, (x, y))
        yield Blob(view.number, target, mass, *given)


def votes(
    view: View, level: Array, blob: Array, radius: float, corner: tuple[int, int]
) -> tuple[Array, Array]:
    """Centres (2, V), px, of discs of this radius with their edge at each edge pixel; the slopes there."""
    edge = EDGES[view.camera.kind] * cv2.minMaxLoc(level, blob)[1]
    smooth = cv2.GaussianBlur(level.astype(np.float32), (3, 3), 0.8)
    across, down = cv2.Scharr(smooth, -1, 1, 0, scale=1 / 32), cv2.Scharr(smooth, -1, 0, 1, scale=1 / 32)
    slope = cv2.magnitude(across, down) + 1e-6
    inside = (smooth - edge) / slope
    border = cv2.dilate(blob, BOX[:3, :3]).view(bool)
    voter = border & (slope > 0.08 * edge / EDGES[view.camera.kind]) & (np.abs(inside) < 1.2)
    y, x = np.nonzero(voter)
    slope = slope[voter]
    step = (radius - (0 if view.color else 0.5) - inside[voter]) / slope
    return np.array([x + corner[0] + step * across[voter], y + corner[1] + step * down[voter]]), slope


def centers(seen: Sequence[Blob]) -> Array:
    """The centre that most edges of each blob vote for, without votes its centre of mass, (N, 2) px."""
    start = np.array([blob.mass for blob in seen])
    owner = np.repeat(np.arange(len(seen)), [blob.slopes.size for blob in seen])
    x, y = np.concatenate([blob.votes for blob in seen], axis=1)
    slope = np.concatenate([blob.slopes for blob in seen])
    voted = np.bincount(owner, minlength=len(seen)) > 0
    center = start.copy()
    for spread in (2.0, 1.4, 1.0, 0.8):
        off2 = np.square(x - center[owner, 0]) + np.square(y - center[owner, 1])
        weight = slope / np.square(1 + off2 / spread**2)
        sums = np.array([np.bincount(owner, weight * part, len(seen)) for part in (x, y, np.ones_like(x))])
        center[voted] = (sums[:2, voted] / sums[2, voted]).T
    return center
