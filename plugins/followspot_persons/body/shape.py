"""The shape of an upper body: features of its outline and of its surface (Weinrich et al. 2010, section 3.1).

A body is a stack of elliptic cross-sections, lengths in body heights. The outline of an ellipse that is
seen under an angle is known in closed form, so that edge features lie on the silhouette from every side,
where points fixed to the body would wander into it. Head features turn about the neck by pan and tilt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from followspot import Array
from followspot.errors import InputError, Mistake
from followspot.yaml.node import plain
from followspot.yaml.reader import read

SHIPPED = Path(__file__).parents[1] / "shape.yaml"  # plans of older recordings have this path
MAX_FEATURES = 1000
PARTS = ("torso", "head")
LONGEST_OUTWARD = 1.001
"""Of a unit vector whose coordinates are rounded."""


@dataclass(frozen=True, eq=False)
class Outline:
    """E edge features. A section gives one on each side; a section without width, the crown, gives one.

    head: (E,) whether it turns with the head; side: (E,) -1 on the left of the picture, 1 on the right,
    0 in the middle; up, width, depth, forward: (E,) height, semi-axes and displacement of the section from
    the body's axis, in body heights; normal: (E,) rad, of the edge in the picture, as in `Gradients`.
    """

    head: Array
    side: Array
    up: Array
    width: Array
    depth: Array
    forward: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class Surface:
    """F surface features. head: (F,); position: (F, 3) forward, left, up from the foot of the axis, in
    body heights; outward: (F, 2) forward and left of the direction from the axis of its part, at most 1 long.
    """

    head: Array
    position: Array
    outward: Array


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """Outline and surface, and the height of the joint of the neck, in body heights."""

    neck: float
    outline: Outline
    surface: Surface
    names: tuple[str, ...]
    """Of the surface features."""


def read_shape(path: Path = SHIPPED) -> ShapeModel:
    """The model in a file. Raises InputError with the file, the mistake and the remedy."""
    return _shipped() if path == SHIPPED else _read(path)


@cache
def _shipped() -> ShapeModel:
    """The shipped model; to parse it takes tens of milliseconds, and many stages of a process ask for it."""
    return _read(SHIPPED)


def _read(path: Path) -> ShapeModel:
    try:
        return shape_of(plain(read(path)))
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        reason = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        remedy = 'make a file with "followspot shape fit"'
        raise InputError([Mistake(None, f"{path}: no shape model: {reason}", remedy)]) from None


def shape_of(document: dict[str, Any]) -> ShapeModel:
    """The model of a parsed file. Raises ValueError, TypeError or KeyError if it is invalid."""
    sections, features = document["outline"], document["surface"]
    if not 0 < len(sections) <= MAX_FEATURES or not 0 < len(features) <= MAX_FEATURES:
        raise ValueError(f"outline and surface have 1 to {MAX_FEATURES} entries each")
    neck, names = float(document["neck"]), tuple(str(f["name"]) for f in features)
    shape = ShapeModel(neck, _outline(sections), _surface(features), names)
    numbers = [[neck], *(vars(shape.outline).values()), shape.surface.position]
    if not all(np.isfinite(n).all() and np.abs(n).max() < 10 for n in numbers):
        raise ValueError("a number is not finite, or no share of the body's height")
    if not (np.hypot(*shape.surface.outward.T) <= LONGEST_OUTWARD).all():
        raise ValueError("outward of a feature is longer than a unit vector")
    return shape


def _outline(sections: list[dict[str, Any]]) -> Outline:
    """Both sides of each section; the normal of the left one is the mirror image of the right one."""
    sides = [(s, side) for s in sections for side in ((-1, 1) if float(s["width"]) > 0 else (0,))]
    rise = np.radians([float(s["rise"]) for s, _ in sides])
    side = np.array([side for _, side in sides], float)
    columns = {
        key: np.array([float(s[key]) for s, _ in sides]) for key in ("up", "width", "depth", "forward")
    }
    return Outline(
        head=np.array([_is_head(s) for s, _ in sides]),
        side=side,
        normal=np.where(side > 0, -rise, rise) % np.pi,
        **columns,
    )


def _surface(features: list[dict[str, Any]]) -> Surface:
    position = np.array([[float(x) for x in f["position"]] for f in features]).reshape(len(features), 3)
    outward = np.array([[float(x) for x in f["outward"]] for f in features]).reshape(len(features), 2)
    return Surface(np.array([_is_head(f) for f in features]), position, outward)


def _is_head(entry: dict[str, Any]) -> bool:
    if entry["part"] not in PARTS:
        raise ValueError(f'part is "torso" or "head", not "{entry["part"]}"')
    return bool(entry["part"] == "head")


@dataclass(frozen=True, eq=False)
class Turned:
    """Features of P bodies as a camera sees them, in body heights, float32.

    edge, surface: (P, E, 3) and (P, F, 3): from the foot of the axis to the right in the picture, up, and
    towards the camera; visibility: (P, F), from 0 on the far side to 1 for one that faces the camera.
    """

    edge: Array
    surface: Array
    visibility: Array


def turn(shape: ShapeModel, torso: Array, head: Array, tilt: Array) -> Turned:
    """The features for headings relative to the camera (0: towards it, + to the person's left) and tilts.

    torso, head: (P,) rad, heading of chest and face; tilt: (P,) rad. A feature is visible by the cosine of
    the angle between its direction from the axis of its part and the direction to the camera.
    """
    return Turned(_turned_outline(shape, torso, head, tilt), *_turned_surface(shape, torso, head, tilt))


def with_girth(shape: ShapeModel, girth: float | Array) -> ShapeModel:
    """The model with a torso that is wider and deeper by this factor; by (P,) factors, one for each body."""
    o, s = shape.outline, shape.surface
    factor = np.asarray(girth)[..., None]
    sections = np.where(o.head, 1.0, factor)
    across = np.where(s.head, 1.0, factor)
    scale = np.stack([across, across, np.ones_like(across)], axis=-1)
    return replace(
        shape,
        outline=replace(o, width=o.width * sections, depth=o.depth * sections),
        surface=replace(s, position=s.position * scale),
    )


def _turned_outline(shape: ShapeModel, torso: Array, head: Array, tilt: Array) -> Array:
    o = shape.outline
    sine, cosine = _per_feature(o.head, torso, head)
    forward, up = _tilted(shape.neck, o.head, o.forward, o.up, tilt)
    reach = np.sqrt((_single(o.width) * cosine) ** 2 + (_single(o.depth) * sine) ** 2)
    return _points(forward * sine + _single(o.side) * reach, up, forward * cosine)


def _turned_surface(shape: ShapeModel, torso: Array, head: Array, tilt: Array) -> tuple[Array, Array]:
    s = shape.surface
    sine, cosine = _per_feature(s.head, torso, head)
    forward, up = _tilted(shape.neck, s.head, s.position[..., 0], s.position[..., 2], tilt)
    left = _single(s.position[..., 1])
    place = _points(forward * sine + left * cosine, up, forward * cosine - left * sine)
    facing = _single(s.outward[:, 0]) * cosine - _single(s.outward[:, 1]) * sine
    return place, np.maximum(facing, np.float32(0))


def _points(right: Array, up: Array, toward: Array) -> Array:
    """Coordinates (P, features) as points (P, features, 3), each coordinate by itself in memory."""
    return np.moveaxis(np.stack([right, up, toward]), 0, -1)


def _single(values: Array) -> Array:
    return values.astype(np.float32)


def _per_feature(is_head: Array, torso: Array, head: Array) -> tuple[Array, Array]:
    """Sine and cosine of the heading of each feature's part: (P, features) each."""
    angle = _single(np.stack([torso, head], axis=1))
    part = is_head.astype(np.intp)
    return np.sin(angle).take(part, axis=1), np.cos(angle).take(part, axis=1)


def _tilted(neck: float, is_head: Array, forward: Array, up: Array, tilt: Array) -> tuple[Array, Array]:
    """Forward and up of features, (P, features) each, after the head has turned about the neck."""
    angle = _single(tilt)[:, None]
    sine = np.sin(angle) * _single(is_head)
    cosine = np.where(is_head, np.cos(angle), np.float32(1))
    forward, above = _single(forward), _single(up) - np.float32(neck)
    return forward * cosine - above * sine, np.float32(neck) + forward * sine + above * cosine
