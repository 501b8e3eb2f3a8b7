"""The colour-difference model: predicts the colours of a person's unseen sides from the seen ones.

The paper planned it (section 3.3) and did not build it. Colours of the features of many people are a
Gaussian: features that differ little from each other in most people (front and back of a shirt) are strongly
correlated, others (face and hair) hardly. Conditioned on the features seen of one person, it predicts the
others, each with its uncertainty; without this, a tracker prefers headings that show the known side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.errors import InputError, Mistake
from followspot.yaml.node import plain
from followspot.yaml.reader import read
from followspot_persons.color.hsi import from_plane, plane
from followspot_persons.color.model import FIRST_VARIANCE, ColorModel

SHIPPED = Path(__file__).with_name("color_relations.yaml")
OBSERVATION = 0.0004
"""Smallest variance of a mean colour, however many observations there are: light varies over the room."""
WIDEST_HUE = 1 / 12
"""Variance of an unknown hue."""


@dataclass(frozen=True, eq=False)
class ColorRelations:
    """The Gaussian of people's colours, in the plane of `hsi.plane`.

    mean: (F, 3); chroma, intensity: (F, F), covariance between features of each of the first two
    coordinates, and of the third.
    """

    mean: Array
    chroma: Array
    intensity: Array


def read_relations(path: Path = SHIPPED, names: Sequence[str] = ()) -> ColorRelations:
    """The relations in a file: per feature mean, factors and own variances. Raises InputError.

    names: of the shape's features, which the file must have in the same order; without names, any.
    """
    try:
        rows = plain(read(path))["features"]
        if names and [row["name"] for row in rows] != list(names):
            raise ValueError(f"its {len(rows)} features are not the {len(names)} of the shape, by name")
        mean, chroma, intensity, own = (
            np.array([row[key] for row in rows], float) for key in ("mean", "chroma", "intensity", "own")
        )
        if mean.shape != (len(rows), 3) or own.shape != (len(rows), 2) or not (own > 0).all():
            raise ValueError("each feature has a mean of 3 numbers and two own variances above 0")
        if not all(np.isfinite(a).all() for a in (mean, chroma, intensity, own)):
            raise ValueError("a number is not finite")
    except (ValueError, TypeError, KeyError) as error:
        remedy = 'make a file with "followspot shape colors"'
        raise InputError([Mistake(None, f"{path}: no relations of colours: {error}", remedy)]) from None
    return ColorRelations(
        mean, chroma @ chroma.T + np.diag(own[:, 0]), intensity @ intensity.T + np.diag(own[:, 1])
    )


def completed(model: ColorModel, relations: ColorRelations) -> ColorModel:
    """The model of every feature: slightly corrected observations, and predictions of unseen features.

    The variance of a feature is that of its pixels plus that of its mean. Evidence stays as it was.
    """
    seen = model.evidence > 0
    spread = model.variance[seen].mean(axis=0) if seen.any() else FIRST_VARIANCE
    pixel = np.where(seen[:, None], model.variance, spread)
    observed = plane(model.mean)
    mean, variance = np.empty((len(seen), 3)), np.empty((len(seen), 2))
    for k, covariance in enumerate((relations.chroma, relations.intensity)):
        columns = slice(0, 2) if k == 0 else slice(2, 3)
        prior = relations.mean[:, columns]
        noise = OBSERVATION + (0.01 if k == 0 else 0.02) / np.maximum(model.evidence[seen], 1e-3)
        gain = np.linalg.solve(covariance[np.ix_(seen, seen)] + np.diag(noise), covariance[seen]).T
        mean[:, columns] = prior + gain @ (observed[seen][:, columns] - prior[seen])
        variance[:, k] = np.diag(covariance) - np.einsum("ij,ji->i", gain, covariance[seen])
    colors = from_plane(mean)
    return ColorModel(colors, pixel + _hsi_variance(colors, variance), model.evidence)


def at_large(relations: ColorRelations) -> ColorModel:
    """The generic model: the colours of people in general, from the relations of colours."""
    colors = from_plane(relations.mean)
    spread = np.column_stack([np.diag(relations.chroma), np.diag(relations.intensity)])
    return ColorModel(colors, FIRST_VARIANCE + _hsi_variance(colors, spread), np.zeros(len(colors)))


def _hsi_variance(colors: Array, variance: Array) -> Array:
    """Variances in the plane as those of hue, saturation and intensity, to first order. (F, 3)."""
    chroma, intensity = np.maximum(variance, 0).T
    hue = chroma / (np.maximum(colors[:, 1], 1e-3) * 2 * np.pi) ** 2
    return np.column_stack([np.minimum(hue, WIDEST_HUE), chroma, intensity])
