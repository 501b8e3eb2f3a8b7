"""People and balls of a scene as one camera sees them at one time.

It is a function of the camera and the scene alone. Several cameras must not be computed together: the
windows of all balls would be as large as the largest ball of any camera needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import project
from followspot_sim.rendering.ball_image import Stamps, stamps
from followspot_sim.rendering.camera_rays import CameraRays
from followspot_sim.rendering.occlusion import hide
from followspot_sim.rendering.people_image import Outlines, outlines
from followspot_sim.world import Scene


@dataclass(frozen=True, eq=False)
class ProjectedScene:
    """Outlines of people, and images of balls with what people hide of them."""

    people: Outlines
    balls: Stamps


def projected_scene(view: CameraRays, scene: Scene, radii: Array) -> ProjectedScene:
    """The scene as a camera sees it. radii: (T,) of the balls, m."""
    balls = len(scene.balls)
    points = np.concatenate([scene.balls, scene.limbs.reshape(-1, 3)])
    pixel = project(view.camera, points)
    people = outlines(view.camera, pixel[balls:].reshape(-1, 2, 2), scene.limbs, scene.radius)
    seen = stamps(view, pixel[:balls], scene.balls, radii)
    limbs = np.flatnonzero(people.shown)
    places = np.column_stack([scene.balls, radii])[seen.ball]
    hide(seen, view, places, scene.limbs[limbs], scene.radius[limbs])
    return ProjectedScene(people, seen)
