"""Stage `cameras.genicam`: a GigE Vision or USB3 Vision camera by its own clock and its own numbers."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing, nullcontext
from functools import partial
from threading import Lock

from followspot import Field, InputAddress, Source, StageParams, at
from followspot.tracking import Frame
from followspot_cameras.frame_numbers import FrameNumbers
from followspot_cameras.genicam.backends import BackendName, connected
from followspot_cameras.genicam.camera import CameraGone, Picture, VisionCamera
from followspot_cameras.genicam.camera_clock import Reading
from followspot_cameras.genicam.capture_times import CaptureTimes
from followspot_cameras.genicam.configuration import configure
from followspot_cameras.genicam.picture import as_frame
from followspot_cameras.genicam.ptp import ptp_problem
from followspot_cameras.genicam.trigger_times import trigger_times
from followspot_cameras.genicam.triggers import COMMAND, ActionCommands, firing, trigger_features
from followspot_cameras.reconnection import READ_TIMEOUT, LiveCamera

LONGEST_LOOK = 0.2
"""Longest wait for a picture before the stage looks whether the run ends, s."""


class Genicam(LiveCamera):
    """Pictures of a GigE Vision or USB3 Vision camera, each with the camera's own time and number.

    Pictures that lost packets on the way, that the host dropped, or that the camera's numbers skip stand in
    the ledger as lost at the source. The stage connects again to a camera that is gone.
    """

    class Params(StageParams):
        camera: InputAddress = Field(
            "", max_length=200, description="serial number, name or address; empty: the only one in sight"
        )
        backend: BackendName = Field(
            "any", description="program that speaks to the camera; any: the first that is installed"
        )
        features: dict[str, bool | int | float | str] = Field(
            {},
            description="features of the camera and their values, in the order in which they are set, for "
            "example {PixelFormat: BayerRG8, ExposureTime: 5000}",
        )
        packet_size: int = Field(
            0, ge=0, le=16_384, unit="bytes", description="largest packet; 0: as the camera has it"
        )
        interface: str = Field(
            "", max_length=100, description="own address in the camera's network; empty: as the system routes"
        )
        read_timeout: float = Field(
            2.0,
            gt=0,
            le=3600,
            unit="s",
            description=READ_TIMEOUT,
        )

    params: Params

    @property
    def origin(self) -> str:
        """The camera as the user named it."""
        return f"camera {self.params.camera}" if self.params.camera else "the camera"

    def process(self) -> Source[Frame]:
        """Whole pictures as they come. Raises InputError for features that the camera has not."""
        self._numbers = FrameNumbers()
        self._control = Lock()
        """A thread holds it while it asks the camera: triggers come from a thread of their own."""
        yield from super().process()

    def session(self) -> Iterator[Frame]:
        """Whole pictures of one connection. Raises CameraGone; InputError for features that it has not."""
        with closing(self._connected()) as camera, self._triggers(camera):
            problem = ptp_problem(camera.names(), camera.read, camera.execute)
            if problem:
                self.say(problem)
            yield from self._frames(camera)

    def _triggers(self, camera: VisionCamera) -> AbstractContextManager[None]:
        """Sends the triggers of this camera, or of all cameras of the room if this one leads."""
        sync = self.room.sync
        if sync is not None and sync.trigger == "software":
            return firing(partial(self._trigger, camera), sync.rate)
        if sync is not None and sync.trigger == "action" and sync.camera == self.camera.name:
            return firing(ActionCommands(sync, self.params.interface, self.say), sync.rate)
        return nullcontext()

    def _trigger(self, camera: VisionCamera) -> None:
        with self._control:
            camera.execute(COMMAND)

    def _read_clock(self, camera: VisionCamera) -> Reading | None:
        with self._control:
            return camera.read_clock()

    def _connected(self) -> VisionCamera:
        """The camera with its features set. Raises CameraGone, InputError."""
        p = self.params
        camera = connected(p.camera, p.backend, p.interface, p.packet_size)
        try:
            names = camera.names()
            wanted = {**trigger_features(self.room.sync, self.camera.name, names), **p.features}
            configure(camera, wanted, self.origin)
        except BaseException:
            camera.close()
            raise
        return camera

    def _frames(self, camera: VisionCamera) -> Iterator[Frame]:
        """Frames until the camera is gone, or the run ends."""
        times, triggers = (
            CaptureTimes(partial(self._read_clock, camera)),
            trigger_times(self.room.sync, self.say),
        )
        self._numbers.connected_again(camera.largest_identifier)
        self._overruns = 0
        times.update(time.monotonic_ns())
        times.start(time.monotonic_ns())
        camera.start()
        heard = time.monotonic()
        while not self.stopped.is_set():
            times.update(time.monotonic_ns())
            picture = camera.next(min(LONGEST_LOOK, self.params.read_timeout))
            if picture is None:
                if time.monotonic() - heard > self.params.read_timeout:
                    raise CameraGone(f"no picture came for {self.params.read_timeout:g} s")
                continue
            if self._is_whole(picture, camera):
                captured = times.capture_time(picture.camera_time, picture.arrival)
                if triggers is not None:
                    captured = triggers.capture_time(self._numbers.number, captured, exact=times.exact)
                frame = as_frame(picture, self.camera, self.context.loan, self.origin)
                yield at(captured, frame, seq=self._numbers.number)
            heard = time.monotonic()  # not while the graph held this picture

    def _is_whole(self, picture: Picture, camera: VisionCamera) -> bool:
        """Whether a picture is new and has all its packets; lost pictures go to the ledger."""
        missing = self._numbers.next(picture.identifier)
        if missing is None:
            return False
        lost, overruns = self.context.lost, camera.overruns()
        given_up = min(missing, overruns - self._overruns)
        self._overruns = overruns
        lost("device_overrun", given_up)
        lost("gap", missing - given_up)
        lost("packet_loss", int(picture.missing_packets > 0))
        return not picture.missing_packets
