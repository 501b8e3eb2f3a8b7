"""Learn how the colours of people's features relate, from crops of several people."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot import Array
from followspot_persons.body.shape import ShapeModel, turn
from followspot_persons.color.hsi import hsi, plane
from followspot_shape.crops import Crops
from followspot_shape.fit import feature_pixels

FACTORS = 5
"""Factors of the covariance between features."""
SHRINKAGE = 0.15
"""Share of a feature's variance that is its own whatever the few people say: others wear something else."""


def relations_document(shape: ShapeModel, crops: Crops) -> dict[str, Any]:
    """The content of the file of the relations: per feature the mean, the factors and its own variances."""
    people = np.concatenate([person_colors(shape, crops)] * 2)
    half = len(people) // 2
    people[half:] = people[half:][:, mirrored(shape)]
    mean = people.mean(axis=0)
    rest = people - mean
    chroma, own_chroma = _factors(np.concatenate([rest[..., 0], rest[..., 1]]))
    intensity, own_intensity = _factors(rest[..., 2])
    return {
        "features": [
            {
                "name": name,
                "mean": _rounded(mean[i]),
                "chroma": _rounded(chroma[i]),
                "intensity": _rounded(intensity[i]),
                "own": [round(float(own_chroma[i]), 6), round(float(own_intensity[i]), 6)],
            }
            for i, name in enumerate(shape.names)
        ]
    }


def person_colors(shape: ShapeModel, crops: Crops) -> Array:
    """Mean colour of each feature of each person over the crops that show it: (people, F, 3)."""
    turned = turn(shape, crops.torso, crops.head, crops.tilt)
    rows, columns = feature_pixels(shape, crops, turned.surface, crops.pixels.shape[1:3])
    colors = plane(hsi(crops.pixels[np.arange(len(rows))[:, None], rows, columns]))
    weight = np.where(turned.visibility > 0.3, turned.visibility, 0)[..., None]
    people = []
    for body in np.unique(crops.body):
        own = crops.body == body
        people.append((weight[own] * colors[own]).sum(axis=0) / weight[own].sum(axis=0))
    return np.array(people)


def mirrored(shape: ShapeModel) -> Array:
    """For each surface feature the one on the other side of the body, (F,)."""
    position, other = shape.surface.position, shape.surface.position * [1, -1, 1]
    distance = np.linalg.norm(position[:, None] - other[None], axis=2)
    distance[shape.surface.head[:, None] != shape.surface.head] = np.inf
    return np.asarray(distance.argmin(axis=1))


def _factors(samples: Array) -> tuple[Array, Array]:
    """Loadings (F, factors) and own variances (F,) of samples (N, F) without their mean."""
    covariance = samples.T @ samples / len(samples)
    values, vectors = np.linalg.eigh(covariance)
    loadings = vectors[:, -FACTORS:] * np.sqrt(np.maximum(values[-FACTORS:], 0) * (1 - SHRINKAGE))
    own = np.diag(covariance) - (loadings**2).sum(axis=1)
    return loadings, np.maximum(own, 1e-4)


def _rounded(values: Array) -> list[float]:
    return [round(float(v), 4) for v in values]
