"""Stage `imu.csv`: readings of an inertial sensor from a file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from followspot import Mistake, Room, Source, Stage, at
from followspot.csv_rows import FIRST_ROWS
from followspot.inertial import Inertial
from followspot.room import Member
from followspot.sensors.reading_batches import BatchParams, batches
from followspot_imu.reading_rate import gaps_told
from followspot_imu.readings_file import FileParams, read_readings
from followspot_imu.units import converted, doubts_of_units


class ImuCsv(Stage):
    """Readings from a CSV file: time, gx, gy, gz (gyroscope), ax, ay, az (accelerometer), and if there are
    any, mx, my, mz (magnetometer).

    Rows are sorted by time. A file of several sensors has a column `sensor` with their names in the room. A
    magnetometer that reads less often leaves its cells empty.
    """

    per_sensor: ClassVar[bool] = True

    class Params(FileParams, BatchParams):
        """The file, its times, units and axes, and the size of messages."""

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first rows; warn if they seem to be of another unit. Raises InputError."""
        name = member.name if member is not None else None
        _, values = read_readings(params, name, room.sensors, FIRST_ROWS)
        turn_rate, force, _ = converted(values, params.scale, params.axes)
        return [
            Mistake(None, f"{parameter}: {doubt}", "say the unit of the file", warning=True)
            for parameter, doubt in doubts_of_units(turn_rate, force).items()
        ]

    def setup(self) -> None:
        """Read the file whole. Raises InputError with file, line and remedy."""
        p, name = self.params, self.sensor.name
        time, values = read_readings(p, name, self.room.sensors)
        if not len(time):
            self.context.warn(f"{p.path} has no readings of sensor {name}")
        if gaps := gaps_told(time):
            self.context.warn(f"{p.path} has {gaps}: what follows from them begins anew or coasts there")
        self.readings = Inertial(name, time, *converted(values, p.scale, p.axes))
        doubts = doubts_of_units(self.readings.turn_rate, self.readings.specific_force)
        for parameter, doubt in doubts.items():
            self.context.warn(f"{p.path}: {doubt}; is {parameter} {getattr(p, parameter)} right?")

    def length(self) -> int:
        """Number of messages."""
        return sum(1 for _ in batches(self.readings.time, self.params))

    def process(self) -> Source[Inertial]:
        """The readings, several in a message."""
        for rows in batches(self.readings.time, self.params):
            message = self.readings.where(rows)
            yield at(int(message.time[-1]), message)
