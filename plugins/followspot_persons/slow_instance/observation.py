"""One picture with its boxes, as the slow instance uses it."""

from __future__ import annotations

from dataclasses import dataclass

from followspot import Array
from followspot.people import Boxes
from followspot_persons.background.background import Background
from followspot_persons.background.scene import Scene
from followspot_persons.likelihood.fitness import Detection, Picture


@dataclass(frozen=True, eq=False)
class Observation:
    """A picture with B boxes: those of the detector first, then those of the foreground."""

    picture: Picture
    pixels: Array
    """(H, W, 3) u1 BGR, in the usual light."""
    background: Background
    """Before this picture."""
    scene: Scene | None
    """The picture beside the background; None while that is unknown."""
    mask: Array | None
    """The foreground, of :func:`foreground_box`; None without a background."""
    boxes: Boxes
    detections: list[Detection]
    """The same boxes, one each."""
    still: Array
    """(B,) bool, boxes before which the background is seen."""
    upright: Array
    """(B,) bool, boxes of the foreground."""
    seconds: float
    """Since the last picture."""
    now: int
    """Capture time, ns."""
