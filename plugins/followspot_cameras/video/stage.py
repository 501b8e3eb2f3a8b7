"""A recorded video as a camera."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import cv2

from followspot import Field, Source, Stage, at
from followspot.errors import Mistake
from followspot.room import Camera, Member, Room
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame, color_buffer
from followspot_cameras.recorded_times.params import read_times
from followspot_cameras.video.checksums import Checksums
from followspot_cameras.video.container import cut_off
from followspot_cameras.video.file import announced_frames, check_video, open_video, require_size
from followspot_cameras.video.times import ListedTimes, TimeStamps, VideoParams, times_of


class Video(Stage):
    """Play a video file as the camera's pictures; frame f is captured at f / fps, or at its recorded time.

    Frames that cannot be decoded leave a gap in the numbers if the file has time stamps. They are reported at
    the end, and so is a file that ends early. A warning says from which time on the checksums of a Matroska
    file do not match; in other files, a damaged picture that can be decoded is not noticed. If the size of
    the pictures changes within a file, all are stretched to the size that the file states. The decoder does
    not report this, so there is no warning: give each part a file of its own.
    """

    per_camera = True

    class Params(VideoParams):
        """The file, its times, and the part to play."""

        start_frame: int = Field(0, ge=0, unit="frames", description="number of the first frame to play")
        frames: int = Field(0, ge=0, unit="frames", description="largest number of frames to play; 0: all")

    params: Params
    capture = cv2.VideoCapture()  # plays nothing until setup

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read recorded times, and the size of the pictures. Warn if the file is cut off: it plays, and its
        end would be a surprise. Raises InputError.
        """
        name = member.name if member is not None else ""
        return check_recording(params, name, room.cameras.get(name))

    def setup(self) -> None:
        """Open the file. Raises InputError if it is no video, has another size, or frames have no times."""
        path = self.params.path
        self.capture = open_video(path)
        require_size(self.capture, self.camera, path)
        self.times = times_of(self.params, self.capture, self.camera.name)
        self.damaged = self.mismatches = 0

    def length(self) -> int | None:
        """Number of frames as they are listed or the container states it; None if its time stamps are
        unusable or irregular.
        """
        p = self.params
        if p.time_stamps:
            return None
        total = len(read_times(p.times, self.camera.name)) if p.times else announced_frames(p.path)
        total -= p.start_frame
        return min(total, p.frames or total) if total > 0 else None

    def capture_time(self, number: int) -> int | None:
        """Capture time of a frame of the file, damaged or not, ns; None if the file's time stamps say it."""
        times = self.times
        return None if isinstance(times, TimeStamps) else times.time_of(self.params.start_frame + number)

    def process(self) -> Source[Frame]:
        """Frames with their capture time and the number that they have in the file."""
        camera, loan = self.camera, self.context.loan
        first = self.params.start_frame
        last = first + self.params.frames - 1 if self.params.frames else None
        with Checksums(self.params.path) as checksums:
            for number in self.numbered(last):
                time = self.times.time_of(number)
                self._compare(checksums, self.capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3)
                if number < first:
                    continue
                ok, image = self.capture.retrieve(color_buffer(camera, loan))
                if not ok:
                    self.damaged += 1
                    continue
                frame = as_frame(image, camera, loan, str(self.params.path))
                yield at(time, frame, seq=number)
            if last is None:
                self._compare(checksums, math.inf)
        self._warn_of_damage()

    def _compare(self, checksums: Checksums, until: float) -> None:
        """Count the parts of the file that begin by a time in it, s, and are damaged; warn of the first."""
        for time in checksums.damaged(until):
            self.mismatches += 1
            if self.mismatches == 1:
                what = f"is damaged from {time:.2f} s on: it does not match its checksum there"
                advice = "pictures may be wrong; copy the recording again"
                self.context.warn(f"{self.params.path.name} {what}, {advice}")

    def _warn_of_damage(self) -> None:
        """Warn at the end of frames that could not be decoded, and of more parts that are damaged."""
        if self.mismatches > 1:
            told = f"{self.mismatches} parts do not match their checksums"
            self.context.warn(f"{self.params.path.name}: {told}")
        if self.damaged:
            lost = f"{self.damaged} frames are missing or damaged"
            advice = "unless its frame rate varies: then say time_stamps: true"
            self.context.warn(f"{self.params.path.name}: {lost}, {advice}")

    def numbered(self, last: int | None) -> Iterator[int]:
        """Grab one picture after the other up to number `last` and give each its number.

        Where frames come at a fixed rate the number follows the time stamp if that leaps, because then frames
        before it are damaged.
        """
        number, origin = -1, None
        while last is None or number < last:
            if not self.capture.grab():
                self.warn_of_early_end(number + 1)
                break
            stamp = int(self.capture.get(cv2.CAP_PROP_PTS))
            origin = stamp if origin is None else origin
            leap = max(0, stamp - origin - number - 1) if self.times.regular else 0
            self.damaged += leap
            number += 1 + leap
            if last is None or number <= last:
                yield number

    def warn_of_early_end(self, played: int) -> None:
        """Warn if fewer frames came than times are listed, or than the container announced."""
        path = self.params.path
        total = self.times.announced(self.capture)
        missing = cut_off(path)
        if total > played:
            self.context.warn(f"{path.name} ended after {played} of {total} frames{missing}")
        elif missing:
            self.context.warn(f"{path.name} ended after {played} frames{missing}")

    def close(self) -> None:
        """Close the file."""
        self.capture.release()


def check_recording(params: VideoParams, name: str, camera: Camera | None) -> Iterator[Mistake]:
    """Mistakes in the recording that a camera of this name plays; in its size if the file is on this host.

    camera: that took it, None if it is not known. Raises InputError.
    """
    if camera is not None and not camera.host:
        check_video(params.path, camera)
    if params.times is not None:
        ListedTimes.read(params.path, params.times, name, 0)
    if missing := cut_off(params.path):
        text = f"path: {params.path.name} ends early{missing}"
        yield Mistake(None, text, "copy the recording again", warning=True)
