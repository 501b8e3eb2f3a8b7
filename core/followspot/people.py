"""The message types of upper-body and head pose tracking (Weinrich et al. 2010), shared by all plugins.

A pose has six numbers: the place on the floor (x, y), the height of the head's top, the heading of the
torso, and pan and tilt of the head relative to the torso. Messages give them in room coordinates, so that
poses of several cameras can be compared; each camera's view (direction, distance, relative heading) follows
from its pose. Angles are in rad, counter-clockwise seen from above, 0 along the room's x axis;
pan is positive to the person's left, tilt upwards.
"""

from __future__ import annotations

import numpy as np

from followspot.geometry import direction, seen_from_above, wrap
from followspot.messages import Array, Message, column
from followspot.room import Camera, Room
from followspot.tables.table_column import TableColumn
from followspot.tracking import STATES


class Gradients(Message):
    """Gradients of one picture, spread over their neighbourhood (section 3.2), in the size of the picture."""

    camera: str
    magnitude: Array = column("H", "W", dtype="u1")
    """Magnitude, 0 to 255, after suppression of weak edges and spreading."""
    orientation: Array = column("H", "W", dtype="u1", unit="pi/256")
    """Direction modulo pi of the strongest gradient in the neighbourhood; 0 is along the x axis of the
    picture."""


class Boxes(Message):
    """Upper bodies (head top to waist) that a detector found in one picture."""

    camera: str
    box: Array = column("N", 4, unit="px", names="x0 y0 x1 y1", decimals=3)
    """x0, y0, x1, y1; in a panorama x1 may exceed the width, since columns wrap around."""
    score: Array = column("N")
    """Score of the detector; 0 is its threshold, larger is more certain."""
    torso: Array = column("N", "B")
    """Log-likelihood, up to a constant, that the chest points in each of B directions relative to the camera:
    direction i is 2 pi i / B, 0 faces the camera. B is 0 if the detector does not estimate it."""
    head: Array = column("N", "B")
    """The same for the face: torso heading plus pan, relative to the camera."""


class Appearances(Message):
    """Appearance of the known persons, one row each; F surface features of the shape model (section 3.3)."""

    camera: str
    person: Array = column("P", dtype="i4")
    """Number of the person, from 1; the same person keeps it."""
    mean: Array = column("P", "F", 3)
    """Colour of each feature: hue as a share of the circle, saturation, intensity, all 0 to 1."""
    variance: Array = column("P", "F", 3)
    evidence: Array = column("P", "F")
    """Weight of the observations of a feature; 0 if its colour is predicted from other features."""
    pose: Array = column("P", 6)
    """Pose at the last update of the appearance: x, y, height (m), heading, pan, tilt (rad)."""
    stature: Array = column("P", 2)
    """Height of the person and its sigma, m, from all updates."""
    contact: Array = column("P", 2)
    """Horizontal distance from the camera (m) by the feet on the floor at the last update, and its precision
    (1/m^2), 0 if they were not seen."""
    seen: Array = column("P", dtype="i8", unit="ns")
    """Capture time of the last update."""
    left: Array = column("P", dtype="u1")
    """1 if the picture shows the background where the person would be."""
    light: float = 1.0
    """How many times brighter the picture is than the light in which `mean` is given."""


class Poses(Message):
    """Persons whose pose is known, one row each; the output of a pose tracker or of their fusion."""

    camera: str
    """The camera of the picture; empty for poses fused from several cameras."""
    person: Array = column("M", dtype="i4")
    state: Array = column("M", dtype="u1", refers="states")
    """Index into `followspot.tracking.STATES`."""
    xy: Array = column("M", 2, unit="m")
    """Point on the floor below the middle between pelvis and neck."""
    height: Array = column("M", unit="m")
    """Height of the highest point of the head, hair included, above the floor."""
    heading: Array = column("M", unit="rad")
    """Direction of the chest."""
    pan: Array = column("M", unit="rad")
    tilt: Array = column("M", unit="rad")
    sigma: Array = column("M", 6)
    """One standard deviation of x, y, height (m), heading, pan, tilt (rad)."""
    confidence: Array = column("M")
    """Agreement of the picture with the pose, 0 to 1."""

    def as_table(self, room: Room) -> list[TableColumn]:
        """Poses as their camera sees them: phi, r and torso_heading are relative to it (phi 0: its axis,
        torso_heading 0: the chest faces it); of fused poses they are relative to the room.
        """
        phi, r, torso = as_seen(room.cameras.get(self.camera), self.xy, self.heading)
        x, y = self.xy.T
        metres = {"x": x, "y": y, "z_head_top": self.height}
        angles = {"torso_heading": torso, "head_pan": self.pan, "head_tilt": self.tilt}
        parts = ("x", "y", "height", "heading", "pan", "tilt")
        units = ("m", "m", "m", "rad", "rad", "rad")
        return [
            TableColumn("person", self.person),
            *(TableColumn(name, values, "m", 4) for name, values in metres.items()),
            TableColumn("phi", phi, "rad", 4),
            TableColumn("r", r, "m", 4),
            *(TableColumn(name, values, "rad", 4) for name, values in angles.items()),
            TableColumn("confidence", self.confidence, decimals=4),
            TableColumn("camera", [self.camera] * len(x)),
            TableColumn(
                "state", np.array(STATES, object)[np.minimum(self.state, len(STATES) - 1)], extra=True
            ),
            TableColumn("heading", self.heading, "rad", extra=True),
            *(
                TableColumn(f"sigma_{part}", values, unit, extra=True)
                for part, unit, values in zip(parts, units, self.sigma.T, strict=True)
            ),
        ]


BONES: tuple[tuple[str, str], ...] = (
    ("left_ear", "left_eye"),
    ("left_eye", "nose"),
    ("nose", "right_eye"),
    ("right_eye", "right_ear"),
    ("left_shoulder", "right_shoulder"),
    ("left_hip", "right_hip"),
    *(
        (f"{side}_{upper}", f"{side}_{lower}")
        for side in ("left", "right")
        for upper, lower in (
            ("shoulder", "elbow"),
            ("elbow", "wrist"),
            ("shoulder", "hip"),
            ("hip", "knee"),
            ("knee", "ankle"),
        )
    ),
)
"""Bones of a drawn skeleton: the names of the joints at both ends of each."""


class Skeletons(Message):
    """Joints in the room of persons whose identity is known, one row each."""

    labels: tuple[str, ...]
    """Names of the joints that `label` indexes."""
    person: Array = column("N", dtype="i4")
    """Number of the person, as in `Poses`."""
    label: Array = column("N", dtype="i4", refers="labels", names="joint")
    xyz: Array = column("N", 3, unit="m", decimals=4)
    covariance: Array = column("N", 3, 3, unit="m^2", extra=True)
    views: Array = column("N", dtype="i4")
    """Number of cameras that saw the joint in this frame; 0 if its place is predicted."""


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


def bones_of(skeletons: Skeletons) -> tuple[Array, Array]:
    """Both ends of each bone of `BONES` whose joints are there, (B, 2, 3) m, and its person, (B,)."""
    row = {
        (int(person), skeletons.labels[label]): number
        for number, (person, label) in enumerate(zip(skeletons.person, skeletons.label, strict=True))
    }
    people = dict.fromkeys(skeletons.person.tolist())
    ends = [
        (row[person, a], row[person, b], person)
        for person in people
        for a, b in BONES
        if (person, a) in row and (person, b) in row
    ]
    table = np.array(ends, int).reshape(-1, 3)
    return skeletons.xyz[table[:, :2]], table[:, 2]


def as_seen(camera: Camera | None, xy: Array, heading: Array) -> tuple[Array, Array, Array]:
    """Direction, distance and heading relative to the camera, of (M, 2) m and (M,) rad; None: to the room."""
    if camera is None:
        return direction(xy), np.hypot(xy[:, 0], xy[:, 1]), wrap(heading)
    phi, r = seen_from_above(camera, xy)
    return phi, r, wrap(heading - direction(camera.center[:2] - xy))
