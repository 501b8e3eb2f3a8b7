"""A folder of 16-bit PNG files as a depth camera."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np

from followspot import Field, InputError, Source
from followspot.errors import Mistake
from followspot.files import PICTURE, open_regular
from followspot.messages import Array
from followspot.tracking import DepthImage
from followspot_cameras.images import read_picture
from followspot_cameras.picture import check_size
from followspot_cameras.picture_folder import FolderParams, PictureFolder

SIGNATURE = b"\x89PNG\r\n\x1a\n"
GRAY = 0
"""PNG's colour type of one grey channel."""


class DepthImages(PictureFolder):
    """Play the 16-bit grey PNG files of a folder in the natural order of their names, as depth images.

    A level is a depth along the optical axis in multiples of `unit`; level 0 says that nothing was measured.
    """

    suffixes = frozenset({".png"})

    class Params(FolderParams):
        """The folder, and the meaning of its numbers."""

        unit: float = Field(
            0.001, gt=0, le=1, unit="m", description="depth of level 1; 0.001 for pictures in millimetres"
        )

    params: Params

    def process(self) -> Source[DepthImage]:
        """Depth images with their capture time and their number in the folder; unreadable files leave a
        gap.
        """
        yield from self.played(self.depth_image)

    def depth_image(self, path: Path) -> DepthImage | None:
        """The depth image of a file, None if it cannot be read.

        Raises InputError if it is no 16-bit grey picture of the camera's size, before it is decoded.
        """
        form = png_form(path)
        if form is None:
            return None
        width, height, bits, color_type = form
        if (bits, color_type) != (16, GRAY):
            has = f"{bits}-bit {'grey' if color_type == GRAY else 'colour'} pictures"
            text = f"{path} has {has}, but depth images are 16-bit grey PNG files"
            raise InputError([Mistake(None, text, "write depth in multiples of `unit` as 16-bit levels")])
        check_size(width, height, self.camera, str(path))
        levels = read_picture(path, cv2.IMREAD_UNCHANGED)
        if levels is None or levels.shape != (height, width) or levels.dtype != np.uint16:
            return None
        depth = self.context.loan((height, width), "f4")
        np.multiply(levels, np.float32(self.params.unit), out=depth)
        return DepthImage(camera=self.camera.name, depth=depth)


def png_form(path: Path) -> tuple[int, int, int, int] | None:
    """Width, height, bits and colour type that a PNG file claims; None if it is none, or too large."""
    try:
        with open_regular(path, PICTURE) as file:
            head = file.read(26)
    except OSError:
        return None
    if len(head) < 26 or head[:8] != SIGNATURE or head[12:16] != b"IHDR":
        return None
    width, height, bits, color_type = struct.unpack(">IIBB", head[16:26])
    return width, height, bits, color_type


def written(path: Path, depth: Array, unit: float = 0.001) -> None:
    """Write a depth image, (H, W) m, as `DepthImages` reads it. Raises OSError.

    Depths beyond the largest level, and what is no number, are written as not measured.
    """
    levels = np.nan_to_num(depth / unit, nan=0.0, posinf=0.0, neginf=0.0).round()
    levels[(levels < 0) | (levels > 0xFFFF)] = 0
    done, data = cv2.imencode(".png", levels.astype(np.uint16))
    if not done:
        raise OSError(f"{path} cannot be written")
    path.write_bytes(data.tobytes())
