"""Setting the features of a machine-vision camera, in an order in which cameras take them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from followspot_cameras.camera_features import Value, as_text, set_features
from followspot_cameras.genicam.camera import VisionCamera

OFFSETS = {"OffsetX": "Width", "OffsetY": "Height"}
"""Features of the region of the sensor; most cameras allow offset and size together as much as it has."""
STOP = "AcquisitionStop"


def configure(camera: VisionCamera, wanted: Mapping[str, Value], origin: str) -> None:
    """Set the features that a user wants; origin: the camera, for texts.

    A camera that still sends pictures to a program which died locks its format, so it is told to stop first.
    Raises InputError with all mistakes, CameraGone.
    """
    if not wanted:
        return
    names = camera.names()
    if STOP in names:
        with suppress(ValueError):  # a camera that cannot be told so locks nothing, or says that it does
            camera.execute(STOP)
    for offset, size in OFFSETS.items():
        if {offset, size} <= wanted.keys() & set(names):
            _reset(camera, offset)
    ordered = {name: wanted[name] for name in sorted(wanted, key=OFFSETS.__contains__)}  # offsets last
    set_features(
        ordered, names, camera.feature, lambda name, value: camera.write(name, as_text(value)), origin
    )


def _reset(camera: VisionCamera, offset: str) -> None:
    """Set an offset to the least that the camera takes, so that it does not limit the size."""
    known = camera.feature(offset)
    if known is not None and known.writable and known.low is not None:
        with suppress(ValueError):  # what it limits will be told
            camera.write(offset, as_text(int(known.low)))
