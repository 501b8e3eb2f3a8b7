"""The view of one camera of people and balls at one time.

A glance is a function of the camera and the scene alone. Several cameras must not be computed together: the
windows of all balls would be as large as the largest ball of any camera needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import project
from followspot_sim.ball_image import Stamps, stamps
from followspot_sim.eye import Eye
from followspot_sim.occlusion import hide
from followspot_sim.people_image import Outlines, outlines
from followspot_sim.world import Scene


@dataclass(frozen=True, eq=False)
class Glance:
    """People and balls as the camera sees them."""

    people: Outlines
    balls: Stamps


def glance(eye: Eye, scene: Scene, radii: Array) -> Glance:
    """Look at a scene; radii: (T,) of the balls, m."""
    balls = len(scene.balls)
    points = np.concatenate([scene.balls, scene.limbs.reshape(-1, 3)])
    pixel = project(eye.camera, points)
    people = outlines(eye.camera, pixel[balls:].reshape(-1, 2, 2), scene.limbs, scene.radius)
    seen = stamps(eye, pixel[:balls], scene.balls, radii)
    limbs = np.flatnonzero(people.shown)
    places = np.column_stack([scene.balls, radii])[seen.ball]
    hide(seen, eye, places, scene.limbs[limbs], scene.radius[limbs])
    return Glance(people, seen)
