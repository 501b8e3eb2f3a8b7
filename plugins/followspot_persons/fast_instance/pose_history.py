"""Poses of a track in the last pictures, and propagation of results for an earlier picture by them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array, Camera
from followspot.geometry import wrap
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import HEADING, PAN, view
from followspot_persons.hog.likelihood import heading_log_likelihood
from followspot_persons.likelihood.fitness import Detection

LENGTH = 64
"""Pictures that are remembered."""


@dataclass(frozen=True, eq=False)
class PoseHistory:
    """The poses of one person in the last pictures: (time in ns, (6,)), ascending."""

    poses: tuple[tuple[int, Array], ...] = ()

    def extended(self, time: int, pose: Array) -> PoseHistory:
        """The history with one more pose."""
        return PoseHistory((*self.poses[1 - LENGTH :], (time, pose)))

    def at(self, time: int) -> Array | None:
        """The pose in the last picture up to a time; None from before the history began."""
        return next((pose for then, pose in reversed(self.poses) if then <= time), None)


def propagated_contact(contact: Array, age: float) -> Contact | None:
    """The floor contact of a person some time after it was reported; None if the feet were not seen.

    contact: (2,) distance, m, and precision, 1/m^2, 0 for unseen feet; age: s.
    """
    distance, precision = contact.tolist()
    return Contact(distance, precision**-0.5).later(age) if precision > 0 else None


def propagated_pose(pose: Array, then: Array, now: Array) -> Array:
    """A pose of an earlier picture, moved and turned as the person has since: all (6,)."""
    out = pose.copy()
    out[:2] += now[:2] - then[:2]
    out[HEADING] += wrap(now[HEADING] - then[HEADING])
    return out


def propagated_detection(
    detection: Detection, camera: Camera, shape: ShapeModel, then: Array, now: Array
) -> Detection:
    """A detection in an earlier picture, its box moved and its headings turned as the person has since."""
    seen = view(camera, shape, np.stack([then, now]))
    turned = float(wrap(np.diff(seen.bearing.torso))[0])
    nodded = turned + float(wrap(now[PAN] - then[PAN]))
    return replace(
        detection,
        box=detection.box + np.nan_to_num(np.diff(seen.box, axis=0)[0]),
        torso=_rotated(detection.torso, turned),
        head=_rotated(detection.head, nodded),
    )


def _rotated(table: Array, angle: float) -> Array:
    """Log-likelihoods of directions, turned by an angle, rad."""
    directions = np.arange(len(table)) * (2 * np.pi / max(len(table), 1))
    return heading_log_likelihood(table, directions - angle)
