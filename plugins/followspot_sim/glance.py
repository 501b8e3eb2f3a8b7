"""What all cameras of a process see of people and balls at one moment, computed at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from followspot import Array, Camera, Room
from followspot.geometry import project
from followspot_sim.ball_image import Stamps, hide, in_front, stamps
from followspot_sim.eyes import Eyes, eyes_of
from followspot_sim.people_image import Outlines, outlines
from followspot_sim.recent import Recent
from followspot_sim.world import Setting, world_of


@dataclass(frozen=True, eq=False)
class Glance:
    """People and balls as each of the cameras sees them; one entry a camera."""

    people: list[Outlines]
    balls: list[Stamps]


@lru_cache(maxsize=4)
def onlookers_of(choice: Setting, room: Room) -> Onlookers:
    """The cameras of a room that this process simulates."""
    return Onlookers(choice)


class Onlookers:
    """Cameras that look at the same performance. What one sees does not depend on who else looks."""

    def __init__(self, choice: Setting) -> None:
        self._world = world_of(choice)
        self._radii = np.array(choice.radii)
        self._cameras: list[tuple[Camera, Array]] = []
        self._eyes: Eyes | None = None
        self.glance = Recent(self._look)

    def join(self, camera: Camera, rays: Array) -> int:
        """Take a camera in, with the rays of its pixels (H, W, 3); returns its number in every glance.

        Cameras join before the first glance of those that work at the same time.
        """
        for number, (known, _) in enumerate(self._cameras):
            if known is camera:
                return number
        self._cameras.append((camera, rays.astype(np.float32)))
        self._eyes, self.glance = None, Recent(self._look)
        return len(self._cameras) - 1

    def _look(self, frame: int) -> Glance:
        if self._eyes is None:
            self._eyes = eyes_of(self._cameras)
        scene, eyes = self._world.scene(frame), self._eyes
        balls = len(scene.balls)
        points = np.concatenate([scene.balls, scene.limbs.reshape(-1, 3)])
        pixel: Array = np.stack([project(camera, points) for camera in eyes.cameras])
        ends = pixel[:, balls:].reshape(len(pixel), -1, 2, 2)
        people = outlines(eyes, ends, scene.limbs, scene.radius)
        seen = stamps(eyes, pixel[:, :balls], scene.balls, self._radii)
        center, radii = eyes.center[seen.camera], self._radii[seen.ball]
        before = in_front(center, scene.balls[seen.ball], radii, scene.limbs, scene.radius)
        shown = np.stack([each.shown for each in people])
        hide(seen, before & shown[seen.camera], [each.polygon for each in people])
        return Glance(people, [seen.of(camera) for camera in range(len(pixel))])
