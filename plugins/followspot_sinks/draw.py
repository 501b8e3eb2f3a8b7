"""Results drawn into the pictures that they come from."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from followspot import Array, Field, Joined, OutputPath, Stage, StageParams
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.people import Boxes, Poses
from followspot.room import Camera, Target
from followspot.tracking import Frame, Tracks
from followspot_sinks.line_sink import below
from followspot_sinks.picture_files import PictureFile, PictureFolder, VideoFile
from followspot_sinks.pose_drawing import arrows, images, outline

PALETTE = ((66, 135, 245), (80, 200, 90), (240, 120, 60), (200, 90, 220), (60, 210, 230), (150, 150, 250))
"""BGR, for one person or target after the other."""
RADIUS = 0.05
"""Of a target that the room does not have, m."""
BOX = (200, 200, 200)
FONT = cv2.FONT_HERSHEY_SIMPLEX
FRACTION = 4
"""Binary places of coordinates that OpenCV draws with."""
FARTHEST = 1 << 14
"""Pixels beyond which nothing is drawn."""


class Draw(Stage):
    """Draw poses, boxes and tracks into the pictures: a video or a folder of pictures per camera.

    Poses: outline of head and shoulders, arrows where face and chest point, number and confidence; those
    without a camera are drawn in all. Boxes with their score; tracks as circles with the target's name.
    """

    class Params(StageParams):
        path: OutputPath = Field(
            "drawn", description="folder below the output folder, with a file per camera"
        )
        format: Literal["mp4", "jpg", "png"] = Field(
            "mp4", description="mp4: a video; jpg, png: a folder of pictures"
        )

    params: Params

    def setup(self) -> None:
        """Create the folder. Raises FollowspotError if that is not possible."""
        self.folder = below(self.context.out, self.params.path)
        self.files: dict[str, PictureFile] = {}
        self.targets = tuple(self.room.targets.values())
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FollowspotError(f"{self.folder} cannot be written: {error.strerror}") from None

    def process(
        self,
        frames: Joined[Frame],
        poses: Joined[Poses] = (),
        boxes: Joined[Boxes] = (),
        tracks: Joined[Tracks] = (),
    ) -> None:
        """Draw into copies of the pictures of one time and write them. Raises FollowspotError."""
        for frame in frames:
            camera = self.room.cameras[frame.camera]
            gray = frame.pixels.shape[2] == 1
            picture = cv2.cvtColor(frame.pixels, cv2.COLOR_GRAY2BGR) if gray else frame.pixels.copy()
            for found in boxes:
                if found.camera == frame.camera:
                    draw_boxes(picture, found)
            for one in poses:
                if one.camera in ("", frame.camera):
                    draw_poses(picture, camera, one)
            for moving in tracks:
                self.draw_tracks(picture, camera, moving)
            self.file(frame.camera).write(picture, frame.header.seq, frame.header.time)

    def file(self, camera: str) -> PictureFile:
        """The file for the camera's pictures."""
        if camera not in self.files:
            form = self.params.format
            video = form == "mp4"
            self.files[camera] = (
                VideoFile(self.folder, camera) if video else PictureFolder(self.folder, camera, form)
            )
        return self.files[camera]

    def draw_tracks(self, picture: Array, camera: Camera, tracks: Tracks) -> None:
        """A circle as large as the target, and its name."""
        for target, xyz in zip(tracks.target.tolist(), tracks.xyz, strict=True):
            known = self.targets[target] if 0 <= target < len(self.targets) else Target(str(target), RADIUS)
            edge = xyz + known.radius * camera.rotation[0]
            for middle, rim in images(camera, np.array([xyz, edge])):
                radius = max(3.0, float(np.linalg.norm(rim - middle)))
                color = PALETTE[target % len(PALETTE)]
                if visible(picture, middle):
                    cv2.circle(
                        picture, fixed(middle), round(radius * 2**FRACTION), color, 1, cv2.LINE_AA, FRACTION
                    )
                    label(picture, middle + np.array([radius, -radius]), known.name, color)

    def close(self) -> None:
        """Complete all files."""
        for file in getattr(self, "files", {}).values():
            file.close()


def draw_poses(picture: Array, camera: Camera, poses: Poses) -> None:
    """Outline, arrows and number of each person."""
    for i, person in enumerate(poses.person.tolist()):
        color = PALETTE[person % len(PALETTE)]
        xy, height, heading = poses.xy[i], float(poses.height[i]), float(poses.heading[i])
        for run in images(camera, outline(xy, height, heading, camera.center)):
            polyline(picture, run, color)
        for arrow in arrows(xy, height, heading, float(poses.pan[i]), float(poses.tilt[i])):
            for tail, tip in images(camera, arrow):
                if visible(picture, tail) and visible(picture, tip):
                    cv2.arrowedLine(picture, whole(tail), whole(tip), color, 2, cv2.LINE_AA, 0, 0.3)
        top = project(camera, np.array([[*xy, height]]))[0]
        if visible(picture, top):
            label(picture, top - 6, f"{person}  {poses.confidence[i]:.2f}", color)


def draw_boxes(picture: Array, boxes: Boxes) -> None:
    """Draw a rectangle and the score; beyond a panorama's width it continues at the other end."""
    width = picture.shape[1]
    for (x0, y0, x1, y1), score in zip(boxes.box.tolist(), boxes.score.tolist(), strict=True):
        for shift in (0, width) if x1 > width else (0,):
            corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]) - [shift, 0]
            polyline(picture, corners, BOX)
        label(picture, np.array([x0, y1 + 12]), f"{score:.2f}", BOX)


def polyline(picture: Array, points: Array, color: tuple[int, int, int]) -> None:
    """Lines through (K, 2) px."""
    if (np.abs(points) < FARTHEST).all():
        at = np.rint(points * 2**FRACTION).astype("i4")[:, None]
        cv2.polylines(picture, [at], False, color, 1, cv2.LINE_AA, FRACTION)


def label(picture: Array, at: Array, text: str, color: tuple[int, int, int]) -> None:
    """Text with a dark rim, from its lower left corner (2,) px."""
    if visible(picture, at):
        cv2.putText(picture, text, whole(at), FONT, 0.42, (0, 0, 0), 3, cv2.LINE_AA)
        cv2.putText(picture, text, whole(at), FONT, 0.42, color, 1, cv2.LINE_AA)


def visible(picture: Array, at: Array) -> bool:
    """Whether a point (2,) px is in the picture or near it."""
    height, width = picture.shape[:2]
    return bool(-width < at[0] < 2 * width and -height < at[1] < 2 * height)


def whole(at: Array) -> tuple[int, int]:
    """The nearest pixel."""
    return round(float(at[0])), round(float(at[1]))


def fixed(at: Array) -> tuple[int, int]:
    """Coordinates as OpenCV draws them."""
    return whole(at * 2**FRACTION)
