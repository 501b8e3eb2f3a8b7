"""The message types of inertial sensors, and of targets whose orientation is known.

Axes of the sensor are those of its data sheet. A quaternion (w, x, y, z) turns a vector in these axes into
the frame of reference that the message names; it has length 1 and w >= 0; all four are NaN if it is unknown.
"""

from __future__ import annotations

from followspot.messages import Array, Message, column
from followspot.room import Room
from followspot.tables.table_column import TableColumn
from followspot.tracking import Tracks, Truth


class Inertial(Message):
    """Readings of one inertial sensor, in the order of their times; the message has the time of the last."""

    sensor: str
    time: Array = column("N", dtype="i8", unit="ns", names="reading_time")
    """Capture time of each reading."""
    turn_rate: Array = column("N", 3, unit="rad/s", names="gx gy gz", decimals=6)
    """Of the gyroscope, in axes of the sensor."""
    specific_force: Array = column("N", 3, unit="m/s^2", names="ax ay az", decimals=6)
    """Of the accelerometer, in axes of the sensor: the acceleration minus gravity, so 9.8 upward at rest."""
    field: Array = column("N", 3, unit="uT", names="mx my mz", decimals=4)
    """Of the magnetometer, in axes of the sensor; NaN without one, and between readings of a slower one."""


class Orientation(Message):
    """Orientation of one inertial sensor at each of its readings, from these alone.

    The frame of reference has z upward; its heading is arbitrary, but does not turn faster than the gyroscope
    drifts.
    """

    sensor: str
    time: Array = column("N", dtype="i8", unit="ns", names="reading_time")
    """Capture time of each reading."""
    quaternion: Array = column("N", 4, names="qw qx qy qz", decimals=6)
    inclination_sigma: Array = column("N", unit="rad", names="inclination_sigma", decimals=6)
    """One standard deviation of the angle between the z axes."""


class PosedTracks(Tracks):
    """Tracks with the orientation of each target in the room; any stage that takes Tracks takes these."""

    quaternion: Array = column("M", 4, names="qw qx qy qz", decimals=6)
    """Turns a vector in axes of the target into axes of the room; NaN if it is unknown."""
    orientation_sigma: Array = column("M", unit="rad", names="orientation_sigma", decimals=6)
    """One standard deviation of the angle between the true and the given orientation; NaN if unknown."""


class PosedTruth(Truth):
    """Ground truth of one frame, with the orientation of each object in the room."""

    quaternion: Array = column("M", 4)
    """Turns a vector in axes of the object into axes of the room; NaN if it is unknown."""

    def as_table(self, room: Room) -> list[TableColumn]:
        """The columns of `Truth`, then qw, qx, qy, qz."""
        names = (f"q{axis}" for axis in "wxyz")
        turned = (TableColumn(name, values) for name, values in zip(names, self.quaternion.T, strict=True))
        return [*super().as_table(room), *turned]
