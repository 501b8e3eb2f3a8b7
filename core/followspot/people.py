"""The message types of upper-body and head pose tracking (Weinrich et al. 2010), shared by all plugins.

A pose has six numbers: the place on the floor (x, y), the height of the head's top, the heading of the
torso, and pan and tilt of the head relative to the torso. In messages they are room quantities, so that
poses of several cameras can be compared; what a camera sees (direction, distance, heading towards it)
follows from its place. Angles are in rad, counter-clockwise seen from above, 0 along the room's x axis;
pan is positive to the person's left, tilt upwards.
"""

from __future__ import annotations

from followspot.messages import Array, Message, column


class Gradients(Message):
    """Edges of one picture, spread out over their neighbourhood (section 3.2); as large as the picture."""

    camera: str
    magnitude: Array = column("H", "W", dtype="u1")
    """0 to 255, after suppression of weak edges and spreading."""
    orientation: Array = column("H", "W", dtype="u1", unit="pi/256")
    """Direction of the gradient modulo pi, of the strongest edge in reach; 0 is along the columns' axis x."""


class Boxes(Message):
    """Upper bodies (head top to waist) that a detector found in one picture."""

    camera: str
    box: Array = column("N", 4, unit="px")
    """x0, y0, x1, y1; x1 may exceed the width of a panorama, whose columns go on at 0."""
    score: Array = column("N")
    """Larger is surer; 0 is the detector's own threshold."""
    torso: Array = column("N", "B")
    """Log-likelihood, up to a constant, that the chest points in each of B directions relative to the camera:
    direction i is 2 pi i / B, 0 faces the camera. B is 0 where the detector does not know."""
    head: Array = column("N", "B")
    """The same for the face: torso heading plus pan, relative to the camera."""


class Appearances(Message):
    """What the known persons look like, one row each; F surface features of the shape model (section 3.3)."""

    camera: str
    person: Array = column("P", dtype="i4")
    """Number of the person, from 1; the same person keeps it."""
    mean: Array = column("P", "F", 3)
    """Colour of each feature: hue as a share of the circle, saturation, intensity, all 0 to 1."""
    variance: Array = column("P", "F", 3)
    evidence: Array = column("P", "F")
    """Weight of the observations of a feature; 0 where its colour is only predicted from others."""
    pose: Array = column("P", 6)
    """Pose in which the person was learnt last: x, y, height (m), heading, pan, tilt (rad)."""
    seen: Array = column("P", dtype="i8", unit="ns")
    """Capture time of that picture."""


class Poses(Message):
    """Persons whose pose is known, one row each; the output of a pose tracker or of their fusion."""

    camera: str
    """The camera that saw them; empty for poses fused from several."""
    person: Array = column("M", dtype="i4")
    state: Array = column("M", dtype="u1", refers="states")
    """As `followspot.tracking.STATES`."""
    xy: Array = column("M", 2, unit="m")
    """Place on the floor below the middle between pelvis and neck."""
    height: Array = column("M", unit="m")
    """Of the highest point of the head, hair included, above the floor."""
    heading: Array = column("M", unit="rad")
    """Where the chest points."""
    pan: Array = column("M", unit="rad")
    tilt: Array = column("M", unit="rad")
    sigma: Array = column("M", 6)
    """One standard deviation of x, y, height (m), heading, pan, tilt (rad)."""
    confidence: Array = column("M")
    """0 to 1: how well the picture agrees with the pose."""


class PoseTruth(Message):
    """Ground truth of the persons in one frame, one row each; columns as in `Poses`."""

    person: Array = column("M", dtype="i4")
    xy: Array = column("M", 2, unit="m")
    height: Array = column("M", unit="m")
    heading: Array = column("M", unit="rad")
    pan: Array = column("M", unit="rad")
    tilt: Array = column("M", unit="rad")
    visible: Array = column("M")
    """Visible share of the upper body in the camera that sees most of it."""
