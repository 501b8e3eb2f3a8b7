"""Results drawn into the pictures that they come from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import cv2
import numpy as np

from followspot import Array, Field, Joined, Latest, OutputFolder, Stage, StageParams
from followspot.errors import FollowspotError
from followspot.files import unused_path
from followspot.geometry import project
from followspot.people import Boxes, Poses
from followspot.room import Camera
from followspot.tracking import Blobs, Forecast, Frame, Tracks
from followspot_sinks.line_sink import below
from followspot_sinks.picture_files import PictureFile, PictureFolder, VideoFile, side_by_side
from followspot_sinks.pose_drawing import arrows, images, outline
from followspot_sinks.primitives import label, polyline, visible, whole
from followspot_sinks.target_drawing import PALETTE, draw_blobs, draw_search_regions, draw_tracks

BOX = (200, 200, 200)
TOGETHER = "all"
"""Name of the file for the pictures of all cameras side by side."""


class Draw(Stage):
    """Draw the results of stages into the pictures: a video or a folder of pictures per camera, or of all.

    Poses have an outline of head and shoulders, arrows in the directions of face and chest, number and
    confidence; poses without a camera are drawn in all pictures. Boxes have their score. Tracks are bold
    circles as large as the target, in its colour and with its name; blobs are slim red circles. Slim yellow
    circles are the search regions by the forecast of the frame before (figure 6 of Jin & Qian 2008).
    """

    class Params(StageParams):
        path: OutputFolder = Field(
            "drawn", description="folder below the output folder, with a file per camera"
        )
        format: Literal["mp4", "mkv", "jpg", "png"] = Field(
            "mp4",
            description="mp4: a video that can be played once it is complete; mkv: a video that can be played"
            " if its worker dies, too, but for its last megabyte; jpg, png: a folder of pictures",
        )
        layout: Literal["each", "grid"] = Field(
            "each", description="each: a file per camera; grid: one of all cameras side by side"
        )
        minimum_search_radius: float = Field(
            10.0, gt=0, unit="px", description="smallest radius of a search region, as the detectors have it"
        )
        search_radius_scale: float = Field(
            1.5,
            gt=0,
            unit="1",
            description="radius of a search region over the expected travel, as the detectors have it",
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
        blobs: Joined[Blobs] = (),
        forecast: Latest[Forecast] = None,
    ) -> None:
        """Draw into copies of the pictures of one time and write them. Raises FollowspotError."""
        drawn: dict[str, Array] = {}
        for frame in frames:
            camera = self.room.cameras[frame.camera]
            picture = drawn[frame.camera] = colored(frame.pixels)
            for found in boxes:
                if found.camera == frame.camera:
                    draw_boxes(picture, found)
            for one in poses:
                if one.camera in ("", frame.camera):
                    draw_poses(picture, camera, one)
            self.draw_targets(picture, camera, tracks, blobs, forecast)
        for name, picture in self.arranged(drawn).items():
            self.file(name).write(picture, frames[0].header.seq, frames[0].header.time)

    def draw_targets(
        self,
        picture: Array,
        camera: Camera,
        tracks: Joined[Tracks],
        blobs: Joined[Blobs],
        forecast: Forecast | None,
    ) -> None:
        """Search regions, then blobs, then tracks, so that the result is on top."""
        p = self.params
        if forecast is not None:
            draw_search_regions(picture, camera, forecast, p.minimum_search_radius, p.search_radius_scale)
        for seen in blobs:
            if seen.camera == camera.name:
                draw_blobs(picture, seen)
        for moving in tracks:
            draw_tracks(picture, camera, moving, self.targets)

    def arranged(self, drawn: Mapping[str, Array]) -> Mapping[str, Array]:
        """The picture of each file by its name; of a camera that gave none, a black one in the grid."""
        if self.params.layout == "each" or not drawn:
            return drawn
        sizes = [camera.size for camera in self.room.cameras.values()]
        pictures = [
            drawn.get(name, np.zeros((height, width, 3), np.uint8))
            for name, (width, height) in zip(self.room.cameras, sizes, strict=True)
        ]
        return {TOGETHER: side_by_side(pictures)}

    def file(self, camera: str) -> PictureFile:
        """The file for the camera's pictures."""
        if camera not in self.files:
            form = self.params.format
            path = self.folder / f"{camera}.{form}"
            self.files[camera] = (
                PictureFolder(self.folder, camera, form)
                if form in ("jpg", "png")
                else VideoFile(unused_path(path) if self.context.resumed else path)
            )
        return self.files[camera]

    def close(self) -> None:
        """Complete all files."""
        for file in getattr(self, "files", {}).values():
            file.close()


def colored(pixels: Array) -> Array:
    """A BGR copy of a picture."""
    return cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.shape[2] == 1 else pixels.copy()


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
