"""Initiation of tracks of people from detections that several cameras agree on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from followspot import Array
from followspot_persons.associate.assignment.contraction import LEAST_GAIN, clusters
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.colors.torso_colors import log_ratios
from followspot_persons.associate.colors.track_colors import initial_colors
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.existence import missed_detection, visible_shares
from followspot_persons.associate.multi_view.views import Views
from followspot_persons.associate.tracks.tracks import LifeCycles, Tracks

SAME_PLACE, SAME_LEVEL = 0.3, 1.0
"""Distances across and in height within which a new body is one that is tracked already, m: the middle of a
part of a body lies above or below that of the whole."""
FEW, FALSE_WEIGHT = 2, 0.5
"""Number of detections of a picture that agree with none, up to which those of a new body count fully, and
what of the logarithm of more is taken from the log-odds of each: the more, the more agree by chance."""


def with_initiated(
    tracks: Tracks[S],
    model: BodyModel[S],
    views: Views,
    unassigned: Sequence[Detections],
    detection: float,
) -> Tracks[S]:
    """The tracks, and new ones of unassigned detections that two cameras or more agree on.

    unassigned: of each camera of the set, also of those without any, which therefore missed a new body; a
    camera that sent nothing tells nothing. detection: probability that a body in full view is detected.
    """
    parts = [one for one in unassigned if len(one.measured)]
    if len(parts) < 2:
        return tracks
    camera = np.concatenate([np.full(len(one.measured), one.camera) for one in parts])
    measured = np.concatenate([one.measured for one in parts])
    colors = np.concatenate([one.colors for one in parts])
    color_ratios = log_ratios(colors[:, None], colors[None])
    by_chance = np.log(max(len(camera) / len(parts) / FEW, 1.0))
    found = clusters(model.pair_ratios(views, camera, measured) + color_ratios, LEAST_GAIN + by_chance)
    chance = _chance(found, camera, len(views.each))
    for rows in found:
        body, rows = _body_of_cluster(model, views, camera, measured, rows)
        if body is None or _is_tracked(tracks, model, body):
            continue
        others = {one.camera for one in unassigned} - set(camera[rows].tolist())
        gain = model.initial_gain(body, views, camera[rows], measured[rows])
        odds = model.odds_limits.initial + float((gain - chance[camera[rows]]).sum())
        odds += _missed(tracks, model, views, body, sorted(others), detection)
        initial = initial_colors(len(views.each), camera[rows], colors[rows])
        life = LifeCycles(np.zeros(1, int), np.array([odds]), np.array([tracks.time]), initial)
        tracks = replace(tracks, bodies=tracks.bodies.joined(body), life=tracks.life.joined(life))
    return tracks


def _chance(found: Sequence[Array], camera: Array, cameras: int) -> Array:
    """What is taken from the log-odds of each camera's detections, (C,), for those that are in no cluster."""
    alone = np.delete(camera, np.concatenate(found)) if found else camera
    return FALSE_WEIGHT * np.log(np.maximum(np.bincount(alone, minlength=cameras) / FEW, 1))


def _body_of_cluster(
    model: BodyModel[S], views: Views, camera: Array, measured: Array, rows: Array
) -> tuple[S | None, Array]:
    """The body of a cluster, and its rows without those that contradict it; None if two are not left."""
    while len(rows) >= 2:
        body = model.initiated(views, camera[rows], measured[rows])
        if body is None:
            return None, rows
        ratio = np.array(
            [model.log_ratios(body, views.each[camera[r]], measured[r][None])[0, 0] for r in rows]
        )
        if (ratio > 0).all():
            return body, rows
        rows = np.delete(rows, ratio.argmin())
    return None, rows


def _is_tracked(tracks: Tracks[S], model: BodyModel[S], body: S) -> bool:
    """Whether a body is at the place of one that is tracked."""
    if not len(tracks.bodies):
        return False
    across, along, up = (model.middle(tracks.bodies) - model.middle(body)[0]).T
    return bool(((np.hypot(across, along) < SAME_PLACE) & (np.abs(up) < SAME_LEVEL)).any())


def _missed(
    tracks: Tracks[S], model: BodyModel[S], views: Views, body: S, cameras: Sequence[int], detection: float
) -> float:
    """Change of the log-odds of a new body that these cameras of the set did not detect."""
    change = 0.0
    for number in cameras:
        view = views.each[number]
        box, depth = model.bounding_boxes(tracks.bodies.joined(body), view)
        visible = visible_shares(box, depth, np.append(tracks.life.number > 0, False), view)
        change += missed_detection(visible, detection)[-1]
    return change
