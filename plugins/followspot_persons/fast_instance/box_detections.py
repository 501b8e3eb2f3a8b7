"""Assignment of the boxes of a detector to tracked persons, and their propagation to the present."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from followspot import Camera
from followspot.people import Boxes
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import view
from followspot_persons.box_geometry import box_distance
from followspot_persons.fast_instance.pose_history import propagated_detection
from followspot_persons.fast_instance.slow_pose import SlowPose
from followspot_persons.fast_instance.tracked_person import TrackedPerson
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.nearest_neighbours import matched
from followspot_persons.panorama import turn_of
from followspot_persons.particles.track import coasted

MAXIMUM_DISTANCE = 0.6
"""Largest distance of a box from its person, in heights of the box."""


def person_detections(
    boxes: Boxes,
    people: Mapping[int, TrackedPerson],
    slow_poses: Mapping[int, SlowPose],
    camera: Camera,
    shape: ShapeModel,
    now: int,
    seconds: float,
) -> dict[int, Detection]:
    """The detections of people, moved to the present picture; people without a detection are left out.

    A person is expected at the position of the track at the time of the boxes, or at the position that the
    slow instance has seen in the same picture.
    now: time of this picture, ns; seconds: since the previous one.
    """
    time, numbers = boxes.header.time, list(people)
    pose = np.array([coasted(people[n].track, seconds).pose for n in numbers])
    then = pose.copy()
    if time < now:
        past = [people[n].history.at(time) for n in numbers]
        then = np.array([pose[i] if p is None else p for i, p in enumerate(past)])
    slow = [slow_poses[n] for n in numbers]
    expected = np.array([s.pose if s.time == time else then[i] for i, s in enumerate(slow)])
    distance = box_distance(view(camera, shape, expected).box, boxes.box, turn_of(camera))
    found = {}
    for i, box in matched(distance, MAXIMUM_DISTANCE):
        detection = Detection.row(boxes, box)
        found[numbers[i]] = propagated_detection(detection, camera, shape, then[i], pose[i])
    return found
