"""Stage `persons.associate`: people in 3D from what networks found in the pictures of several cameras."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from followspot import Array, Camera, Joined, Mistake, Room, Stage
from followspot.errors import FollowspotError
from followspot.frame_times import to_ns
from followspot.people import Boxes, Poses, Skeletons
from followspot.plain_values import from_plain, to_plain
from followspot.points import Points2D
from followspot.tracking import Frame
from followspot.two_views import check_two_views
from followspot_persons.associate.boxes.model import BoxModel
from followspot_persons.associate.boxes.shape_mixture import ShapeMixture
from followspot_persons.associate.colors.torso_colors import BINS, histograms
from followspot_persons.associate.detections import Detections, Measured, boxes_of, joints_of
from followspot_persons.associate.joints.limbs import Lengths, constrained, learnt
from followspot_persons.associate.joints.model import JointModel
from followspot_persons.associate.joints.skeleton_pose import tell_heading
from followspot_persons.associate.joints.tracks import JointTracks
from followspot_persons.associate.multi_view.views import Noise, views_of
from followspot_persons.associate.parameters import AssociateParams
from followspot_persons.associate.picture_size import Reach, picture_size_warning
from followspot_persons.associate.reports import box_poses, joint_poses, skeletons_of
from followspot_persons.associate.tracks.multi_camera_update import Rules, updated
from followspot_persons.associate.tracks.tracks import Tracks, no_tracks, reported_at
from followspot_persons.associate.unassigned_detections import unassigned_warning

FLOOR = np.array([0.0, 0.0, 1.0, 0.0])
"""Of a room whose file has no plane "floor"."""
STEEPEST = 0.5
"""Cosine of the steepest slope of a floor that people stand on."""
MOST_JOINTS = 150
"""Names of joints that are followed, the first that come."""


@dataclass(frozen=True)
class Outputs:
    """People as poses, and their joints."""

    poses: Poses
    skeletons: Skeletons


class Associate(Stage):
    """Find people in the room by joints or boxes of several calibrated cameras, and follow each by a number.

    `points` are joints with the number of their person in the picture, as `vision.keypoints_json` and pose
    networks give them; `boxes` are boxes of whole bodies, as `vision.boxes_csv` gives them with `upper_share`
    1. Connect one of them, with an edge from each camera. Each camera's detections are assigned to the people
    that were expected there at its time of exposure; what is left over becomes a new person if cameras agree.
    With `frames`, the pictures, the colours of torsos count beside the places.
    """

    class Params(AssociateParams):
        """Errors of what was found, and when a person exists."""

    params: Params
    advice = (
        "are two cameras calibrated in one frame of reference, do both see the same people, and are their "
        "scores above minimum_score?"
    )
    reach: Mapping[str, Reach] = MappingProxyType({})
    """How far the joints of each camera have reached."""
    unassigned: Mapping[str, Sequence[int]] = MappingProxyType({})
    """Detections of each camera while there were people, and those that were assigned to none of these."""

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if fewer than two cameras send detections, or all stand at one place."""
        return check_two_views(cameras, "a new person needs detections of")

    def setup(self) -> None:
        """Prepare the cameras. Raises FollowspotError if both kinds of detections are connected, or if
        people in boxes cannot stand on the floor.
        """
        if {Points2D, Boxes} <= set(self.context.receives):
            raise FollowspotError(f"{self.context.name} takes points or boxes; use a stage for each")
        given, cameras = self.params, self.room.cameras
        self.number = {name: number for number, name in enumerate(cameras)}
        self.views = views_of(tuple(cameras.values()))
        noise = Noise(given.point_sigma, given.body_sigma, given.delay_sigma)
        floor = self.room.planes.get("floor")
        if floor is not None and Boxes in set(self.context.receives):
            check_slope(np.asarray(floor), self.context.name)
        plane = None if floor is None else tuple(np.asarray(floor).tolist())
        self.joint_model = JointModel((), noise, len(cameras), plane)
        self.box_model = BoxModel(given.delay_sigma, FLOOR if floor is None else np.asarray(floor))
        p = given.confirmation_probability
        missed, recalled = to_ns(given.maximum_missed_time), to_ns(given.recall_time)
        self.rules = Rules(
            given.detection_probability, float(np.log(p / (1 - p))), missed, recalled, given.area
        )
        self.by_joints: Tracks[Any] = no_tracks(self.joint_model, self.views)
        self.by_boxes: Tracks[Any] = no_tracks(self.box_model, self.views)
        self.heading: dict[int, float] = {}
        self.limbs = Lengths.none()
        self.warned = False

    def process(
        self, points: Joined[Points2D] = (), boxes: Joined[Boxes] = (), frames: Joined[Frame] = ()
    ) -> Outputs | None:
        pictures = {frame.camera: frame.pixels for frame in frames}
        if points:
            return self.with_joints(points, pictures)
        return self.with_boxes(boxes, pictures) if boxes else None

    def with_joints(self, points: Sequence[Points2D], pictures: Mapping[str, Array]) -> Outputs:
        """The people after a set of joints."""
        points = [one for one in points if one.camera in self.number]
        for one in points:
            self.reach = {**self.reach, one.camera: self.reach.get(one.camera, Reach()).beyond(one.pixel)}
        self.name_joints(points)
        joints = self.joint_model.joints
        detections = [
            self.detections(one, joints_of(one, joints, self.params.minimum_score), pictures)
            for one in points
        ]
        self.by_joints = updated(self.by_joints, self.joint_model, self.views, detections, self.rules)
        self.unassigned = dict(zip(self.number, self.by_joints.unassigned.tolist(), strict=True))
        sigma = self.params.maximum_sigma
        self.limbs = learnt(self.limbs.of(self.by_joints.life.number), joints, self.by_joints.bodies)
        now = reported_at(self.by_joints, self.joint_model, _time(points, self.by_joints.time))
        now = replace(now, bodies=constrained(self.limbs, joints, now.bodies))
        poses = joint_poses(now, joints, sigma)
        self.warn_of_names(joints, poses)
        return Outputs(poses, skeletons_of(now, joints, sigma))

    def name_joints(self, points: Sequence[Points2D]) -> None:
        """Take up names of joints that came for the first time."""
        names = dict.fromkeys(name for one in points for name in one.labels)
        room = MOST_JOINTS - len(self.joint_model.joints)
        new = [name for name in names if name not in self.joint_model.joints][:room]
        if new:
            self.joint_model, bodies = self.joint_model.widened(self.by_joints.bodies, new)
            self.by_joints = replace(self.by_joints, bodies=bodies)

    def warn_of_names(self, joints: Sequence[str], poses: Poses) -> None:
        """Warn once of people whose joints tell no heading, for their names are those of another program."""
        if self.warned or not len(poses.person) or tell_heading(joints):
            return
        self.warned = True
        self.context.warn(
            f"joints named {', '.join(joints[:4])} ... tell no headings, and heights may be wrong: "
            "name them as COCO does, left_shoulder and right_shoulder, left_hip and right_hip, left_eye, nose"
        )

    def with_boxes(self, boxes: Sequence[Boxes], pictures: Mapping[str, Array]) -> Outputs:
        """The people after a set of boxes."""
        given = self.params
        detections = [
            self.detections(
                one,
                boxes_of(one, self.room.cameras[one.camera], given.overlap, given.minimum_score),
                pictures,
            )
            for one in boxes
            if one.camera in self.number
        ]
        self.by_boxes = updated(self.by_boxes, self.box_model, self.views, detections, self.rules)
        self.unassigned = dict(zip(self.number, self.by_boxes.unassigned.tolist(), strict=True))
        now = reported_at(self.by_boxes, self.box_model, _time(boxes, self.by_boxes.time))
        poses, self.heading = box_poses(now, self.heading)
        return Outputs(poses, Skeletons.empty())

    def close(self) -> None:
        """Warn of cameras whose joints may be of smaller pictures, or that see other people."""
        warnings = (picture_size_warning(self.reach, self.room.cameras), unassigned_warning(self.unassigned))
        for warning in filter(None, warnings):
            self.context.warn(warning)

    def state(self) -> Any:
        return {
            "joints": list(self.joint_model.joints),
            "by_joints": to_plain(self.by_joints),
            "by_boxes": to_plain(self.by_boxes),
            "heading": to_plain(self.heading),
            "limbs": to_plain(self.limbs),
        }

    def restore(self, state: Any) -> None:
        self.joint_model = replace(self.joint_model, joints=tuple(state["joints"]))
        self.by_joints = from_plain(Tracks[JointTracks], state["by_joints"])
        self.by_boxes = from_plain(Tracks[ShapeMixture], state["by_boxes"])
        self.heading = from_plain(dict[int, float], state["heading"])
        self.limbs = from_plain(Lengths, state["limbs"])

    def detections(
        self, message: Points2D | Boxes, found: Measured, pictures: Mapping[str, Array]
    ) -> Detections:
        """One camera's detections, at their time of exposure."""
        camera = self.number[message.camera]
        colors = np.full((len(found.measured), BINS), np.nan)
        picture = pictures.get(message.camera)
        if picture is not None and picture.shape[2] == 3:
            colors = histograms(picture, found.torsos)
        time = message.header.time + self.views.each[camera].offset
        return Detections(camera, time, found.measured, colors)


def check_slope(floor: Array, name: str) -> None:
    """Raise FollowspotError if a plane, (4,), is too steep to stand on upright. name: of the stage."""
    if abs(floor[2]) < STEEPEST * np.linalg.norm(floor[:3]):
        raise FollowspotError(
            f"{name} takes people for upright along z, and the room's plane floor is steeper than "
            "60 degrees: calibrate the cameras in a frame of reference whose z axis points up"
        )


def _time(messages: Sequence[Points2D] | Sequence[Boxes], without: int) -> int:
    """Capture time of a set, ns: the latest time stamp."""
    return max((message.header.time for message in messages), default=without)
