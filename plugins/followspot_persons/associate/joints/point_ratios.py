"""Log-likelihood ratios that found points are the joints of bodies, whose sides may have been exchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array
from followspot_persons.associate.joints import sides as side_odds
from followspot_persons.associate.joints.sides import Sides
from followspot_persons.associate.joints.tracks import JointTracks, PredictedPoints
from followspot_persons.associate.multi_view.point_errors import INDEPENDENT, WRONG
from followspot_persons.associate.multi_view.views import View

TELLING, ALONE = 5.0, 0.5
"""Log-likelihood ratio of sides that a point gives at most if the same joint of the other side was found, and
if not: then a joint at a wrong place looks like an exchange.
"""


def log_ratios(tracks: JointTracks, points: PredictedPoints, view: View, xy: Array, sides: Sides) -> Array:
    """Log-likelihood ratios that detections are these bodies, (M, N), against points anywhere in the picture.

    points: of the bodies; xy: (N, J, 2) px, NaN for joints that were not found. Each part of a detection
    counts by the labels that are likelier.
    """
    each = PredictedPoints(*(part[:, None] for part in vars(points).values()))
    ratio, other = (_of_points(each, view, one[None]) for one in (xy, xy[:, sides.mirror]))
    prior = tracks.exchanged[:, None, view.number, :, 0]
    exchanged = _of_sides(ratio, other, sides) + prior > 0
    ratio = np.where(exchanged @ sides.part.T > 0, other, ratio)
    found = np.isfinite(ratio)
    count = found.sum(axis=2)
    mean = np.where(found, ratio, 0.0).sum(axis=2) / np.maximum(count, 1)
    return np.asarray(mean * np.minimum(count, INDEPENDENT))


def labelled(
    tracks: JointTracks, points: PredictedPoints, view: View, xy: Array, sides: Sides
) -> tuple[JointTracks, Array]:
    """The bodies after the labels of one camera, and their points (M, J, 2) px by the likelier labels.

    xy: (M, J, 2) px of the detection of each body, NaN for joints that were not found.
    """
    other = xy[:, sides.mirror]
    ratio = _of_sides(_of_points(points, view, xy), _of_points(points, view, other), sides)
    exchanged = tracks.exchanged.copy()
    exchanged[:, view.number], reversal = side_odds.observed(
        exchanged[:, view.number], tracks.reversal, ratio
    )
    joints = (exchanged[:, view.number, :, 0] > 0) @ sides.part.T > 0
    return replace(tracks, exchanged=exchanged, reversal=reversal), np.where(joints[..., None], other, xy)


def _of_points(points: PredictedPoints, view: View, xy: Array) -> Array:
    """Log-likelihood ratio that each point is its joint, (..., J), NaN if it was not found.

    A share `WRONG` of the points may be anywhere. xy: (..., J, 2) px.
    """
    S = points.spread + points.error
    determinant = S[..., 0, 0] * S[..., 1, 1] - S[..., 0, 1] ** 2
    a, b, c = (-part / (2 * determinant) for part in (S[..., 1, 1], -2 * S[..., 0, 1], S[..., 0, 0]))
    scale = (1 - WRONG) * float(view.size.prod()) / (2 * np.pi * np.sqrt(determinant))
    offset = xy - points.there
    x, y = offset[..., 0], offset[..., 1]
    return np.asarray(np.log(scale * np.exp((a * x + b * y) * x + c * y * y) + WRONG))


def _of_sides(ratio: Array, other: Array, sides: Sides) -> Array:
    """Log-likelihood ratio that the labels of each part are exchanged, (..., G).

    ratio, other: (..., J) of the points as labelled, and by the labels of the other side.
    """
    named, turned = np.isfinite(ratio), np.isfinite(other)
    change = np.where(turned, other, 0.0) - np.where(named, ratio, 0.0)
    most = np.where(named & turned, TELLING, ALONE)
    change = np.minimum(np.maximum(change, -most), most)
    all_of_part = INDEPENDENT * TELLING
    return np.asarray(np.clip(change @ sides.part, -all_of_part, all_of_part))
