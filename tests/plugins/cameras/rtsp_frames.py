"""Pictures of a network camera, and the errors of their capture times."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
import pytest
from tests.plugins.cameras.rtsp_server import RtspCamera

from followspot.tracking import Frame


def error(frames: list[Frame], camera: RtspCamera) -> float:
    """How far the worst capture time is off, ms; infinite unless the pictures follow each other."""
    true = np.array(camera.captured)
    found = np.array([frame.header.time for frame in frames])
    nearest = np.abs(found[:, None] - true).argmin(axis=1)
    off = np.abs(found - true[nearest]).max() / 1e6
    return float(off) if (np.diff(nearest) == 1).all() else np.inf


def last(count: int, frames: Iterator[Frame], camera: RtspCamera, within: float) -> list[Frame]:
    """So many pictures, the last ones, once their capture times are within so many ms: sooner or later one
    comes without delay, however busy the machine.
    """
    held: list[Frame] = []
    for frame in islice(frames, 400):
        held = [*held[1 - count :], frame]
        if len(held) == count and error(held, camera) < within:
            return held
    pytest.fail(f"the last pictures are off by {error(held, camera)} ms")
