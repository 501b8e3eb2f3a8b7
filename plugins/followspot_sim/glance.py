"""What all cameras of a process see of people and balls at one moment, computed at once."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import cache, lru_cache, partial

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
        self._lock = threading.Lock()
        self.glance = self._glances()

    def join(self, camera: Camera, rays: Array) -> int:
        """Take a camera in, with the rays of its pixels (H, W, 3); returns its number in every later glance.

        Cameras may join in several threads, also while others look.
        """
        with self._lock:
            for number, (known, _) in enumerate(self._cameras):
                if known is camera:
                    return number
            self._cameras.append((camera, rays.astype(np.float32)))
            self.glance = self._glances()
            return len(self._cameras) - 1

    def _glances(self) -> Recent[Glance]:
        """Those of the cameras that have joined by now, whoever joins later."""
        eyes = cache(partial(eyes_of, tuple(self._cameras)))
        return Recent(lambda frame: self._look(eyes(), frame))

    def _look(self, eyes: Eyes, frame: int) -> Glance:
        scene = self._world.scene(frame)
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
