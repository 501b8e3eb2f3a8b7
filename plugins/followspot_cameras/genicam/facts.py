"""Facts about the pictures and the clock of a camera, for lists and room files."""

from __future__ import annotations

from dataclasses import dataclass

from followspot_cameras.genicam.camera import Backend, CameraGone, CameraInfo, VisionCamera
from followspot_cameras.genicam.clock_features import clock_features
from followspot_cameras.genicam.ptp import ptp_state

RATES = (
    "ResultingFrameRate",
    "AcquisitionResultingFrameRate",
    "AcquisitionFrameRate",
    "AcquisitionFrameRateAbs",
)
"""Features that tell frames a second: as it will be, then as it is asked for."""


@dataclass(frozen=True)
class Facts:
    """Facts of one camera; problem: why they are not known, "" if they are.

    size: width and height, px; format: of its pixels; rate: frames a second, None if it is not told;
    clock: "readable", or "" if it cannot be read; ptp: its state of PTP, "" if it has none.
    """

    size: tuple[int, int] = (0, 0)
    format: str = ""
    rate: float | None = None
    clock: str = ""
    ptp: str = ""
    problem: str = ""

    @property
    def time(self) -> str:
        """The clock in a few words."""
        ptp = f", PTP {self.ptp}" if self.ptp else ""
        return f"{self.clock or 'stamps only'}{ptp}"


def facts(info: CameraInfo, backend: Backend) -> Facts:
    """The facts of a camera, which is connected for them and released."""
    try:
        camera = backend.connect_read_only(info)
    except CameraGone as error:
        return Facts(problem=str(error))
    try:
        return facts_of(camera)
    except (CameraGone, ValueError, OverflowError) as error:
        return Facts(problem=str(error))
    finally:
        camera.close()


def facts_of(camera: VisionCamera) -> Facts:
    """The facts of a connected camera. Raises CameraGone, ValueError."""
    names, read = camera.names(), camera.read
    size = int(read("Width")), int(read("Height"))
    rates = [float(read(name)) for name in RATES if name in names]
    clock = "readable" if clock_features(names, read) else ""
    form = read("PixelFormat") if "PixelFormat" in names else ""
    return Facts(size, form, rates[0] if rates else None, clock, ptp_state(names, read, camera.execute))
