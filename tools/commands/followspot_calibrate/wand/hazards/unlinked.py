"""Why two cameras have hardly any points in common: what their numbers and pixels show."""

from __future__ import annotations

import numpy as np

from followspot_calibrate.sightings import Sightings

PART = 0.6
"""Share of the width and of the height beyond which a recording of half the size has no points."""
FEWEST = 30
"""Points that tell how far they reach."""


def why_unlinked(sightings: Sightings, one: int, other: int) -> str:
    """The cause and its remedy, as far as the data show it; "" if they do not."""
    size = other_size(sightings, one) or other_size(sightings, other)
    return _other_frames(sightings, one, other) or size


def _other_frames(sightings: Sightings, one: int, other: int) -> str:
    """Frames that are numbered apart, so that no moment is common to both."""
    names, seen = sightings.cameras, sightings.seen
    frames = [sightings.frame[seen[:, camera]] for camera in (one, other)]
    if not all(map(len, frames)):
        silent = names[one] if not len(frames[0]) else names[other]
        return f"{silent} has no points at all: wave in its view; is it in the file, by its name?"
    (low, high), (begin, end) = ((int(f.min()), int(f.max())) for f in frames)
    gap, span = max(begin - high, low - end), max(high - low, end - begin)
    if gap <= span:  # else they may have seen the wand one after the other
        return ""
    return (
        f"{names[one]} has the frames {low} to {high}, {names[other]} {begin} to {end}: "
        "number the frames of all cameras from one moment on"
    )


def other_size(sightings: Sightings, camera: int) -> str:
    """Points in one corner only, as if the recording were half as large as the room says."""
    pixel = sightings.pixel[sightings.seen[:, camera], camera]
    width, height = sightings.sizes[camera]
    if len(pixel) < FEWEST:
        return ""
    reach = np.percentile(pixel, 99, axis=0)
    if not (reach < PART * sightings.sizes[camera]).all():
        return ""
    return (
        f"the points of {sightings.cameras[camera]} reach {reach[0]:.0f}x{reach[1]:.0f} of "
        f"{width:.0f}x{height:.0f} px only: was it recorded at another size than its lens was calibrated for?"
    )
