"""The stage that fuses positions with the readings of inertial sensors on the targets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from followspot import Camera, Mistake, Room, Window
from followspot.inertial import Inertial, Orientation, PosedTracks
from followspot.messages import stamped
from followspot.sensors.stuck_readings import REMEDY
from followspot.tracking import PREDICTED, TRACKED, Forecast, Positions, Tracks
from followspot_balls.filtering.predicted_positions import with_predicted
from followspot_balls.inertial.fix import Fix, fix_at
from followspot_balls.inertial.frame_state import Frame
from followspot_balls.inertial.history import implausible_count, orientations_of, readings_of
from followspot_balls.inertial.messages import Fixes, forecast_with_fixes, posed, searched_everywhere
from followspot_balls.inertial.navigator import Navigator
from followspot_balls.inertial.parameters import InertialParams
from followspot_balls.inertial.sensor_errors import SensorErrors
from followspot_balls.kalman import Kalman
from followspot_target_filter import stage as target_filter

READING_TIMEOUT = 3_000_000_000
"""Time without a current reading after which the user is warned, ns."""
WELL_KNOWN = 0.03
"""Sigma of a hidden target up to which it is searched near its forecast only, m."""


@dataclass(frozen=True)
class Outputs(target_filter.Outputs):
    """The targets now, with their orientations, and their forecast for the next frame."""

    tracks: PosedTracks
    forecast: Forecast


class InertialFilter(Kalman):
    """Fuse positions with inertial sensors on the targets: position and orientation, also while hidden.

    The stage learns the heading between sensor and room, the sensor's biases, its place on the target and its
    delay from the motion. A target without a sensor, or whose heading is not yet learnt, is filtered as by
    `balls.kalman`. If a target carries several sensors, the estimate with the smallest sigma counts, so
    another sensor takes over if one falls silent. Late readings are used; readings of a sensor that the
    positions contradict again and again are left out.
    """

    class Params(InertialParams):
        """The life cycle, the motion of targets without readings, and the errors of the sensors."""

    params: Params

    @classmethod
    def check_room(cls, params: Any, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if no target carries a sensor."""
        yield from super().check_room(params, room, cameras)
        if room.targets and not carriers(room):
            yield Mistake(None, "no sensor of the room is mounted on a target", "mount: {target: NAME}")

    def setup(self) -> None:
        """Begin with every target lost and every heading unknown."""
        super().setup()
        self.carriers = carriers(self.room)
        p = self.params
        errors = SensorErrors(**{f.name: getattr(p, f.name) for f in fields(SensorErrors)})
        self.navigators = {
            sensor: Navigator(errors, p.history, p.maximum_reading_gap) for sensor in self.carriers
        }
        self.warned: set[tuple[str, str]] = set()
        self.newest: dict[str, int] = {}
        """Time of the newest reading of each sensor, or at first that of the first positions, ns."""
        self.widened = False

    def process(
        self,
        positions: Positions,
        readings: Window[Inertial] = (),
        orientations: Window[Orientation] = (),
    ) -> Outputs:
        time = positions.header.time
        for sensor, navigator in self.navigators.items():
            rows = readings_of(readings, sensor)
            if implausible_count(readings, sensor):
                self.warn_once(
                    sensor,
                    "are left out that are no numbers or beyond what sensors can read: look at its units",
                )
            navigator.receive(rows, orientations_of(orientations, sensor))
            self.newest[sensor] = max(self.newest.get(sensor, time), rows.time.max(initial=0))
            self.warn_of(sensor, navigator, time)
        before = self.fixes(time)
        consistent = self.consistent(positions, before)
        outputs = super().process(stamped(self.with_fixes(consistent, before), positions.header))
        predicted = list(before)
        bridging = self.life.status[predicted] == PREDICTED
        self.life.missed[predicted] *= ~bridging  # a target whose sensor says where it is does not grow old
        self.correct(time, positions, consistent, outputs.tracks)
        fixes = self.fixes(time)
        ahead = self.fixes(time, outputs.forecast.period)
        forecast = forecast_with_fixes(outputs.forecast, outputs.tracks, ahead)
        return Outputs(posed(outputs.tracks, fixes), self.widened_search(forecast, fixes))

    def widened_search(self, forecast: Forecast, fixes: Fixes) -> Forecast:
        """The forecast; in every second frame, targets with uncertain fixes are searched everywhere."""
        self.widened = not self.widened
        vague = [
            number
            for number, fix in fixes.items()
            if self.life.status[number] == PREDICTED and fix.sigma.max() > WELL_KNOWN
        ]
        if not vague or not self.widened:
            return forecast
        return searched_everywhere(forecast, vague)

    def fixes(self, time: int, ahead: float = 0.0) -> Fixes:
        """The fix of the surest sensor of each target, if its heading is known. time: ns; ahead: s."""
        found: dict[int, Fix] = {}
        for sensor, number in self.carriers.items():
            navigator = self.navigators[sensor]
            if navigator.contradicted(time):
                continue
            fix = fix_at(navigator.now(time), time, ahead)
            if fix is not None and (number not in found or fix.surer_than(found[number])):
                found[number] = fix
        return found

    def consistent(self, positions: Positions, fixes: Fixes) -> Positions:
        """The positions without those that contradict the sensor of their target."""
        if not fixes:
            return positions
        noise = self.noise(positions.covariance)
        false = [
            number in fixes and not predicted and fixes[number].rejects(xyz, spread)
            for number, predicted, xyz, spread in zip(
                positions.target.tolist(), positions.predicted, positions.xyz, noise, strict=True
            )
        ]
        return positions.where(~np.array(false, bool)) if any(false) else positions

    def with_fixes(self, positions: Positions, fixes: Fixes) -> Positions:
        """The positions, and the fixes of targets that were not measured."""
        vague = self.params.maximum_predicted_sigma
        measured = set(positions.target[~positions.predicted].tolist())
        target = [n for n, fix in fixes.items() if n not in measured and fix.sigma.max() <= vague]
        if not target:
            return positions
        chosen = [fixes[number] for number in target]
        xyz, covariance = np.array([f.xyz for f in chosen]), np.array([f.covariance for f in chosen])
        return with_predicted(positions, np.array(target, np.intp), xyz, covariance)

    def correct(self, time: int, positions: Positions, consistent: Positions, tracks: Tracks) -> None:
        """Correct the navigation of each target by its measured position, if it was used or inconsistent."""
        tracked = set(tracks.target[tracks.state == TRACKED].tolist())
        tracked |= set(positions.target.tolist()) - set(consistent.target.tolist())
        noise = self.noise(positions.covariance)
        rows = {int(n): row for row, n in enumerate(positions.target) if not positions.predicted[row]}
        for sensor, number in self.carriers.items():
            row = rows.get(number)
            counted = row is not None and number in tracked and np.isfinite(positions.xyz[row]).all()
            seen = (positions.xyz[row], noise[row]) if counted else None
            self.navigators[sensor].add(Frame(time, seen))

    def warn_of(self, sensor: str, navigator: Navigator, time: int) -> None:
        """Warn, once of each sensor, of readings that are missing, come too late or contradict positions."""
        if time - self.newest[sensor] > READING_TIMEOUT:
            self.warn_once(
                sensor,
                "are missing for 3 s: look whether the sensor sends, and compare its clock, or `start_time` "
                "and `time_unit`, with the cameras'",
            )
        if navigator.late:
            self.warn_once(
                sensor,
                f"come more than {self.params.history:g} s late and are left out: raise `history`, or "
                "compare the clocks",
            )
        if navigator.sparse:
            self.warn_once(
                sensor,
                f"come more than {self.params.maximum_reading_gap:g} s apart, so the motion between them is "
                "not known: let the sensor read more often, or raise `maximum_reading_gap`",
            )
        if navigator.stuck:
            self.warn_once(
                sensor,
                f"do not change although it moves, and are left out meanwhile: {REMEDY}",
            )
        if navigator.contradicted(time):
            self.warn_once(
                sensor,
                "contradict the positions again and again and are left out meanwhile: compare the clocks, "
                "look how the sensor is fixed, whether it is on the target that `mount` names, and at the "
                "units, `axes` and `at_rest` of its source",
            )

    def warn_once(self, sensor: str, trouble: str) -> None:
        """Warn about the readings of a sensor."""
        if (sensor, trouble) not in self.warned:
            self.warned.add((sensor, trouble))
            self.context.warn(f"readings of {sensor} {trouble}")

    def state(self) -> Any:
        return super().state() | {
            "widened": self.widened,
            "sensors": {sensor: navigator.state() for sensor, navigator in self.navigators.items()},
        }

    def restore(self, state: Any) -> None:
        """Carry on from a checkpoint of this filter; from one of another filter with unknown headings."""
        super().restore(state)
        self.widened = bool(state.get("widened", False))
        for sensor, navigator in self.navigators.items():
            known = state.get("sensors", {}).get(sensor)
            if known is not None:
                navigator.restore(known)


def carriers(room: Room) -> dict[str, int]:
    """The number of the target that carries each sensor, by its name; others are left out."""
    numbers = {name: number for number, name in enumerate(room.targets)}
    mounts = {sensor.name: sensor.mount for sensor in room.sensors.values()}
    return {
        name: numbers[mount.name]
        for name, mount in mounts.items()
        if mount is not None and mount.set == "targets"
    }
