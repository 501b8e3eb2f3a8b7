"""A person that the fast instance tracks, and the report of all of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.people import Poses
from followspot.tracking import TRACKED
from followspot_persons.body.view import HEADING
from followspot_persons.fast_instance.pose_history import PoseHistory
from followspot_persons.particles.track import Track


@dataclass(frozen=True, eq=False)
class TrackedPerson:
    """A tracked person.

    agreed, boxed: ns, times of the last picture that agreed with the track, and of the last box of the
    detector; state: as in `Poses`.
    """

    number: int
    track: Track
    agreed: int
    boxed: int
    state: int = TRACKED
    history: PoseHistory = PoseHistory()


def nearest_first(people: Mapping[int, TrackedPerson], known: Collection[int], camera: Camera) -> list[int]:
    """Tracked and known persons by number, the nearest first, because the nearer ones hide others."""
    eye = camera.center[:2]
    distance = {n: float(np.hypot(*(p.track.pose[:2] - eye))) for n, p in people.items() if n in known}
    return sorted(distance, key=lambda n: distance[n])


def poses_of(camera: Camera, people: Mapping[int, TrackedPerson]) -> Poses:
    """The poses of tracked persons, by number, in the pictures of a camera."""
    tracked = [people[number] for number in sorted(people)]
    pose = np.array([p.track.pose for p in tracked]).reshape(-1, 6)
    return Poses(
        camera=camera.name,
        person=np.array([p.number for p in tracked], np.int32),
        state=np.array([p.state for p in tracked], np.uint8),
        xy=pose[:, :2].copy(),
        height=pose[:, 2].copy(),
        heading=pose[:, HEADING].copy(),
        pan=pose[:, 4].copy(),
        tilt=pose[:, 5].copy(),
        sigma=np.array([p.track.present_sigma(camera.center) for p in tracked]).reshape(-1, 6),
        confidence=np.array([min(1.0, p.track.likelihood) for p in tracked]),
    )
