"""What the fast instance knows of one person, and reports of all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from followspot.people import Poses
from followspot.tracking import TRACKED
from followspot_persons.body.view import HEADING
from followspot_persons.fast_instance.trail import Trail
from followspot_persons.particles.track import Track


@dataclass(frozen=True, eq=False)
class Followed:
    """A tracked person.

    good, boxed: ns, times of the last picture that agreed, and of the last box of the detector; state: as in
    `Poses`.
    """

    number: int
    track: Track
    good: int
    boxed: int
    state: int = TRACKED
    trail: Trail = Trail()


def poses_of(camera: str, followed: Mapping[int, Followed]) -> Poses:
    """The poses of tracked persons, by number, in the pictures of a camera."""
    people = [followed[number] for number in sorted(followed)]
    pose = np.array([p.track.pose for p in people]).reshape(-1, 6)
    return Poses(
        camera=camera,
        person=np.array([p.number for p in people], np.int32),
        state=np.array([p.state for p in people], np.uint8),
        xy=pose[:, :2].copy(),
        height=pose[:, 2].copy(),
        heading=pose[:, HEADING].copy(),
        pan=pose[:, 4].copy(),
        tilt=pose[:, 5].copy(),
        sigma=np.array([p.track.sigma for p in people]).reshape(-1, 6),
        confidence=np.array([min(1.0, p.track.likelihood) for p in people]),
    )
