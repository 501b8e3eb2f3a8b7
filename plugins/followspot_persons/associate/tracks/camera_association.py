"""Association of one camera's detections with tracks, in rounds: the most certain first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_persons.associate.assignment.association_probabilities import association_probabilities
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.colors.track_colors import color_log_ratios, updated_colors
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.existence import log_visibility, missed_detection, visible_shares
from followspot_persons.associate.multi_view.views import View
from followspot_persons.associate.tracks.tracks import Tracks

Choice = Callable[[Array], tuple[Array, Array]]
"""Rows and columns, (K,) each, of the pairs that belong together, by their log-likelihood ratios, (M, N)."""

EXPLAINED = 4.0
"""Log-likelihood ratio from which a detection is a second one of a person with a number."""


@dataclass(frozen=True, eq=False)
class Association:
    """What is associated so far of M tracks and N detections of one camera.

    found: (M,) bool, tracks with a detection; ratio: (M,) log-likelihood ratios of these; probability: (M,)
    that they are the tracks', 0 without one; used: (N,) bool, detections of tracks; explained: (N,) bool,
    detections that fit a person with a number well; visible: (M,) share of each body that the camera sees.
    """

    detections: Detections
    found: Array
    ratio: Array
    probability: Array
    used: Array
    explained: Array
    visible: Array

    @classmethod
    def none(cls, detections: Detections, bodies: int) -> Association:
        """Before the first round."""
        none, nothing = np.zeros(len(detections.measured), bool), np.zeros(bodies)
        return cls(detections, np.zeros(bodies, bool), nothing, nothing, none, none, nothing)

    @property
    def unassigned(self) -> Detections:
        """The detections that belong to no track and fit no person with a number well."""
        one, free = self.detections, ~(self.used | self.explained)
        return replace(one, measured=one.measured[free], colors=one.colors[free])

    def gain(self, detection: float, most: float) -> Array:
        """Change of the log-odds of the tracks with a detection, (M,), `most` at most.

        Ratios are against one false detection anywhere in the picture. Those of `unassigned` are taken for
        false: the more there are, the more of them fit a body by chance. None counts less than a missed one.
        """
        false = max(len(self.unassigned.measured), 1)
        least = missed_detection(self.visible, detection)
        return np.asarray(self.probability * np.clip(self.ratio - np.log(false), least, most))

    def loss(self, detection: float) -> Array:
        """Change of the log-odds of the tracks without a detection, (M,).

        detection: probability that a body in full view is detected.
        """
        return np.where(self.found, 0.0, missed_detection(self.visible, detection))


def clear(ratio: Array, lead: float) -> tuple[Array, Array]:
    """The pairs whose log-likelihood ratios lead by this much over all others of their rows and columns, and
    over 0.
    """
    worth = np.maximum(ratio, 0.0)
    rows, columns = np.nonzero(worth - np.maximum(_rivals(worth), _rivals(worth.T).T) >= lead)
    return rows, columns


def _rivals(worth: Array) -> Array:
    """The largest of the other entries of each entry's row, 0 without others. worth: (M, N), from 0."""
    ordered = np.sort(np.pad(worth, ((0, 0), (2, 0))), axis=1)
    return np.where(worth == ordered[:, -1:], ordered[:, -2:-1], ordered[:, -1:])


def associated(
    tracks: Tracks[S],
    model: BodyModel[S],
    view: View,
    before: Association,
    choose: Choice,
) -> tuple[Tracks[S], Association]:
    """The tracks at the time of exposure, and what is associated, after a round of one camera.

    choose: which of the pairs that are left belong together.
    """
    if not len(tracks.bodies):
        return tracks, before
    box, depth = model.bounding_boxes(tracks.bodies, view)
    visible = visible_shares(box, depth, tracks.life.number > 0, view)
    one, life = before.detections, tracks.life
    if not len(one.measured):
        return tracks, replace(before, visible=visible)
    ratio = model.log_ratios(tracks.bodies, view, one.measured)
    color_ratio = color_log_ratios(life.colors, one.camera, one.colors)
    score = np.where(ratio > 0, ratio + color_ratio, ratio) + log_visibility(visible)[:, None]
    score[before.found] = score[:, before.used] = -np.inf
    rows, columns = choose(score)
    probability = association_probabilities(score, 1 / (1 + np.exp(-life.odds)))[rows, columns]
    found, used = before.found.copy(), before.used.copy()
    found[rows], used[columns] = True, True
    ratios, probabilities = before.ratio.copy(), before.probability.copy()
    ratios[rows], probabilities[rows] = ratio[rows, columns], probability
    explained = np.asarray((ratio[life.number > 0] > EXPLAINED).any(axis=0))
    seen = life.seen.copy()
    seen[rows] = one.time
    colors = updated_colors(life.colors, rows, one.camera, one.colors[columns], visible[rows])
    bodies = model.updated(tracks.bodies, rows, view, one.measured[columns], probability)
    tracks = replace(tracks, bodies=bodies, life=replace(life, seen=seen, colors=colors))
    return tracks, Association(one, found, ratios, probabilities, used, explained, visible)
