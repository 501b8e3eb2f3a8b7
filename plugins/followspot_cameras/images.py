"""A folder of pictures as a camera."""

from __future__ import annotations

from pathlib import Path

import cv2

from followspot import Source
from followspot.files import PICTURE, opencv_name, require_regular
from followspot.messages import Array
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame
from followspot_cameras.picture_folder import FolderParams, PictureFolder


class Images(PictureFolder):
    """Play the pictures of a folder in the natural order of their names (frame2 before frame10)."""

    class Params(FolderParams):
        """The folder."""

    params: Params

    def process(self) -> Source[Frame]:
        """Frames with their capture time and their number in the folder; unreadable files leave a gap."""
        yield from self.played(self.frame)

    def frame(self, path: Path) -> Frame | None:
        """The frame of a file, None if it cannot be read. Raises InputError if its size is another."""
        image = read_picture(path)
        return None if image is None else as_frame(image, self.camera, self.context.loan, str(path))


def read_picture(path: Path, flags: int = cv2.IMREAD_COLOR) -> Array | None:
    """The picture, (H, W, 3) uint8 unless flags say otherwise.

    None if it cannot be read, has more than `PICTURE` bytes, or claims a size beyond all reason.
    """
    try:
        require_regular(path, PICTURE)
        return cv2.imread(opencv_name(path), flags)
    except (OSError, cv2.error):
        return None
