"""A target in one picture, by a click or a rectangle: the pixels that show it, and a template of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from followspot import Camera, Target
from followspot.errors import InputError
from followspot.messages import Array
from followspot_balls.detection.hue import BINS, bhattacharyya, hue_bin, normalised
from followspot_balls.templates.from_clip import VIVID

ALIKE_HUE = 14
"""Largest difference in hue of neighbouring pixels of a clicked target, of 256."""
LARGEST_SHARE = 0.1
"""Share of the picture above which a clicked colour has run over into the background."""
LEAST_SATURATED, LEAST_BRIGHT = 0.7, 0.33
"""Smallest saturation and brightness of a clicked target's pixels, over those of the clicked one."""
CONVEX = 0.8
"""Smallest share of its convex hull that a clicked target fills; chosen by eye on photographs of balls in
hands, where what had run over into the hand filled 0.75 at most."""
PALER, STRONG = 0.8, 140
"""Share of a target's saturation that a detector may ask for, and from which value on it is worth it."""
LEAST_COLORED = 0.3
"""Share of a target's pixels that must show a hue."""
NEARER = 4.0
"""How much larger or smaller than here the target may be seen, in area: at half or twice the distance."""
MOST_ALIKE = 0.8
"""Similarity of two templates above which the detector, at its default, takes one ball for the other."""


class Pick(NamedTuple):
    """A target to learn. box: click x, y, or rectangle x, y, width, height, px; empty to look first."""

    name: str
    box: tuple[int, ...]
    frame: int | None


@dataclass(frozen=True)
class Template:
    """What a picked target looks like. histogram: (16,) normalised; pixels: how many show it; saturation:
    least of nine tenths of these, 0 to 255; center: of these, x and y, px.
    """

    histogram: Array
    pixels: int
    saturation: float
    center: tuple[float, float]

    @property
    def minimum_saturation(self) -> int | None:
        """What keeps paler things of its hue away, such as skin and wood; None for a ball as pale."""
        wanted = int(PALER * self.saturation)
        return wanted if wanted >= STRONG else None

    @property
    def area(self) -> tuple[float, float]:
        """Smallest and largest area, px."""
        return round(self.pixels / NEARER, 1), round(self.pixels * NEARER, 1)


def template_of(picture: Array, pick: Pick) -> Template:
    """The template of a picked target; picture: (H, W, 3) u8, blue first. Raises InputError."""
    _check_inside(picture, pick)
    hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL)
    inside = _clicked(hsv, pick) if len(pick.box) == 2 else _ellipse(picture.shape[:2], pick.box)
    vivid = inside & (hsv[..., 1] >= VIVID)
    if vivid.sum() < LEAST_COLORED * inside.sum():
        text = f"{pick.name} has hardly any colour at {_place(pick)}: {vivid.sum()} of {inside.sum()} px"
        raise InputError.of(text, "pick a coloured ball, where no light bleaches it")
    counts = np.bincount(hue_bin(hsv[vivid][:, 0]), minlength=BINS).astype(float)
    saturation = float(np.percentile(hsv[vivid][:, 1], 10))
    rows, columns = np.nonzero(vivid)
    center = float(columns.mean()), float(rows.mean())
    return Template(np.round(normalised(counts), 6), int(vivid.sum()), saturation, center)


def with_template(target: Target, camera: Camera, template: Template, radius: float | None) -> Target:
    """The target with this template for a camera, and this radius (m; None: its own).

    What other cameras know of it stays.
    """
    return replace(
        target,
        radius=target.radius if radius is None else radius,
        hue_histogram={**target.hue_histogram, camera.name: template.histogram},
        area={**target.area, camera.name: template.area},
    )


def likeness(
    targets: Mapping[str, Target], picked: Iterable[str], camera: str
) -> list[tuple[str, str, float]]:
    """Each pair of a picked target and another that this camera knows, with their templates' similarity.

    From `MOST_ALIKE` on, the detector confuses them.
    """
    known = {name: t.hue_histogram[camera] for name, t in targets.items() if camera in t.hue_histogram}
    mine = [name for name in picked if name in known]
    pairs = [(a, b) for a in mine for b in known if a != b and (b not in mine or a < b)]
    return [(a, b, round(float(bhattacharyya(known[a], known[b])), 2)) for a, b in pairs]


def _check_inside(picture: Array, pick: Pick) -> None:
    height, width = picture.shape[:2]
    x, y, *size = pick.box
    right, below = (x + size[0], y + size[1]) if size else (x + 1, y + 1)
    if not (0 <= x < right <= width and 0 <= y < below <= height):
        raise InputError.of(f"{_place(pick)} is not in the picture of {width} x {height} px", "look again")


def _clicked(hsv: Array, pick: Pick) -> Array:
    """The pixels (H, W) around a click that have its hue. Raises InputError if they are too many."""
    x, y = pick.box
    around = hsv[max(0, y - 1) : y + 2, max(0, x - 1) : x + 2].reshape(-1, 3)
    hue, saturation, value = np.median(around[around[:, 1].argsort()[-5:]], axis=0)
    apart = np.abs((hsv[..., 0].astype(int) - int(hue) + 128) % 256 - 128)
    alike = (apart <= ALIKE_HUE) & (hsv[..., 1] >= LEAST_SATURATED * saturation)
    alike &= hsv[..., 2] >= LEAST_BRIGHT * value
    _, labels = cv2.connectedComponents(alike.astype(np.uint8))
    inside = (labels == labels[y, x]) & alike
    if not inside.any():
        raise InputError.of(f"there is no colour of its own at {_place(pick)}", "click on the ball's middle")
    if inside.sum() > LARGEST_SHARE * inside.size or _filled(inside) < CONVEX:
        text = f"the colour at {_place(pick)} runs over into what is beside the ball: {inside.sum()} px"
        raise InputError.of(text, f"give its rectangle: {pick.name}=X,Y,WIDTH,HEIGHT")
    return np.asarray(inside)


def _filled(inside: Array) -> float:
    """The share of its convex hull that a region fills, holes such as highlights included: 1 for a ball."""
    outlines, _ = cv2.findContours(inside.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=cv2.contourArea)
    return cv2.contourArea(outline) / max(cv2.contourArea(cv2.convexHull(outline)), 1.0)


def _ellipse(size: tuple[int, int], box: tuple[int, ...]) -> Array:
    """The pixels (H, W) of the ellipse in a rectangle."""
    x, y, width, height = box
    v, u = np.mgrid[: size[0], : size[1]]
    across = (u + 0.5 - x - width / 2) / (width / 2)
    along = (v + 0.5 - y - height / 2) / (height / 2)
    return np.asarray(across**2 + along**2 <= 1.0)


def _place(pick: Pick) -> str:
    return ",".join(map(str, pick.box))
