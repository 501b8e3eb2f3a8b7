"""Fit the sections of the outline to crops: maximise the agreement of their edges with the silhouette."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot import Array
from followspot_persons.body.shape import ShapeModel, shape_of, turn
from followspot_persons.gradients import emphasis, packed_edges, padded, spread
from followspot_persons.likelihood.edges import edge_likelihood
from followspot_shape import start
from followspot_shape.crops import Crops

HALF, REACH = 12.0, 4
"""Reach of `persons.gradients`: grey levels, px. It is shorter here because the poses are known."""
SIGMA = 0.35
"""Standard deviation of the orientation, rad."""
STEPS = (0.016, 0.008, 0.004, 0.002)
"""Steps of lengths, in body heights; one round over all numbers with each."""
DEGREES_PER_LENGTH = 1000.0
"""The rise is searched with this many degrees for a step of one body height."""


def fitted_document(crops: Crops) -> dict[str, Any]:
    """The content of the file of the shape model that fits best to the crops, from anthropometric numbers."""
    sections = start_document()["outline"]
    edges = _edges(crops)
    for step in STEPS:
        for section in sections:
            for key in _free(section):
                _ascend(section, key, step, sections, crops, edges)
    return _document(sections)


def start_document() -> dict[str, Any]:
    """The content of the file of the anthropometric model."""
    keys = ("name", "part", "up", "width", "depth", "forward", "rise")
    return _document([dict(zip(keys, section, strict=True)) for section in start.SECTIONS])


def fitness(document: dict[str, Any], crops: Crops, edges: tuple[Array, Array] | None = None) -> float:
    """Mean edge likelihood of a model over the crops, 0 to 1; edges: of the crops, if known."""
    return float(_likelihood(shape_of(document), crops, edges or _edges(crops)).mean())


def _document(sections: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "neck": start.NECK,
        "outline": sections,
        "surface": start.surface(sections),
    }


def _free(section: dict[str, Any]) -> tuple[str, ...]:
    """The fitted numbers. Heights stay fixed; otherwise sections would meet at the strongest contrast."""
    return ("width", "depth", "forward", "rise") if section["width"] else ("forward",)


def _ascend(
    section: dict[str, Any],
    key: str,
    step: float,
    sections: list[dict[str, Any]],
    crops: Crops,
    edges: tuple[Array, Array],
) -> None:
    """Move one number uphill while it helps, three steps at most."""
    size = step * (DEGREES_PER_LENGTH if key == "rise" else 1)
    best = fitness(_document(sections), crops, edges)
    for direction in (size, -size):
        for _ in range(3):
            before = section[key]
            section[key] = round(before + direction, 4)
            if section[key] < 0.01 and key in ("width", "depth"):
                section[key] = before
                break
            value = fitness(_document(sections), crops, edges)
            if value <= best:
                section[key] = before
                break
            best = value


def _likelihood(shape: ShapeModel, crops: Crops, edges: tuple[Array, Array]) -> Array:
    magnitude, orientation = edges
    turned = turn(shape, crops.torso, crops.head, crops.tilt)
    rows, columns = feature_pixels(shape, crops, turned.edge, magnitude.shape[1:])
    number = np.arange(len(rows))[:, None]
    return edge_likelihood(
        magnitude[number, rows, columns], orientation[number, rows, columns], shape.outline.normal, SIGMA
    )


def feature_pixels(
    shape: ShapeModel, crops: Crops, features: Array, size: tuple[int, ...]
) -> tuple[Array, Array]:
    """Rows and columns of features, (N, features, 2) in body heights, in the crops; kept within them."""
    scale = (crops.bottom - crops.top)[:, None] / (1 - start.BOTTOM)
    columns = crops.axis[:, None] + features[..., 0] * scale
    rows = crops.top[:, None] + (1 - features[..., 1]) * scale
    return (
        np.clip(np.rint(rows), 0, size[0] - 1).astype(int),
        np.clip(np.rint(columns), 0, size[1] - 1).astype(int),
    )


def _edges(crops: Crops) -> tuple[Array, Array]:
    """Magnitude and orientation of all crops, (N, H, W) u1 each."""
    table = emphasis(HALF)
    packed = [spread(packed_edges(padded(_grey(pixels), 0), table), REACH) for pixels in crops.pixels]
    stack = np.array(packed)
    return (stack >> 8).astype(np.uint8), (stack & 255).astype(np.uint8)


def _grey(pixels: Array) -> Array:
    import cv2

    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY))
