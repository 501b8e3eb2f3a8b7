"""A recorded video as another camera at the same place would have taken it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Literal

import cv2
import numpy as np

from followspot import Array, Camera, Context, Field, Room, Source, Stage, StageParams, at
from followspot.errors import Mistake
from followspot.geometry import project, ray
from followspot.room import Member
from followspot.tracking import Frame
from followspot_cameras.video.stage import Video, check_recording

Row = tuple[float, float, float]


class Lens(StageParams):
    """The camera that took the video, as in a room file."""

    model: Literal["pinhole", "rational", "fisheye"] = Field("pinhole", description="camera model")
    size: tuple[int, int] = Field(description="width and height of the video", unit="px")
    matrix: tuple[Row, Row, Row] = Field(description="camera matrix K", unit="px")
    distortion: tuple[float, ...] = Field(
        description="k1 k2 p1 p2 k3, and k4 k5 k6 if rational; of a fisheye k1 k2 k3 k4", unit="1"
    )
    rotation: tuple[Row, Row, Row] = Field(description="from the room to the camera that took it", unit="1")


class RectifiedVideo(Stage):
    """Play a video turned upright, without distortion, smaller: as the room's camera would have taken it.

    The room's camera and the one that took the video stand at the same place, so that no depth is needed.
    Pixels outside the video repeat the colours at its edge.
    """

    per_camera = True

    class Params(Video.Params):
        lens: Lens = Field(description="the camera that took the video")

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """See `Video.check_files`; the pictures have the size of the lens that took them."""
        name = member.name if member is not None else ""
        camera = room.cameras.get(name)
        return check_recording(params, name, taken_by(camera, params.lens) if camera is not None else None)

    def setup(self) -> None:
        """Open the file and prepare the mapping. Raises InputError as `cameras.video`."""
        taken = taken_by(self.camera, self.params.lens)
        own = self.context
        context = Context.serving(taken, name=own.name, seed=own.seed, warn=own.warn)
        self._video = Video(context, **self.params.model_dump(exclude={"lens"}))
        self._video.setup()
        self._maps = rectification(self.camera, taken)

    def length(self) -> int | None:
        """Number of frames, if the file states it."""
        return self._video.length()

    def capture_time(self, number: int) -> int | None:
        """As the video says, ns."""
        return self._video.capture_time(number)

    def process(self) -> Source[Frame]:
        """The video's frames, each with its time and number."""
        width, height = self.camera.size
        for frame in self._video.process():
            channels = frame.pixels.shape[2]
            pixels = self.context.loan((height, width, channels), "u1")
            cv2.remap(
                frame.pixels,
                *self._maps,
                cv2.INTER_LINEAR,
                dst=pixels,
                borderMode=cv2.BORDER_REPLICATE,
            )
            yield at(frame.header.time, Frame(camera=self.camera.name, pixels=pixels), seq=frame.header.seq)

    def close(self) -> None:
        """Close the file."""
        self._video.close()


def taken_by(camera: Camera, lens: Lens) -> Camera:
    """The camera that took a video, at the place of the room's camera."""
    rotation = np.array(lens.rotation)
    return replace(
        camera,
        model=lens.model,
        size=lens.size,
        matrix=np.array(lens.matrix),
        distortion=np.array(lens.distortion),
        rotation=rotation,
        translation=-rotation @ camera.center,
    )


def rectification(camera: Camera, taken: Camera) -> tuple[Array, Array]:
    """Coordinates of each pixel of a camera in the pictures of another at the same place, for `cv2.remap`.

    Pixels that the other camera does not see get coordinates outside the picture.
    """
    width, height = camera.size
    y, x = np.mgrid[:height, :width]
    directions = ray(camera, np.column_stack([x.ravel(), y.ravel()]).astype(float))
    pixel = project(taken, camera.center + directions)
    pixel[~np.isfinite(pixel)] = -1.0
    place = pixel.astype(np.float32).reshape(height, width, 2)
    whole, fraction = cv2.convertMaps(place[..., 0], place[..., 1], cv2.CV_16SC2)
    return np.asarray(whole), np.asarray(fraction)
