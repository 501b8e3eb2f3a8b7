"""Navigation of one target: frames and readings in the order of their capture times, whenever they arrive.

Readings that arrive after later frames were processed lead back to the last checkpoint before them, and the
frames since then are processed again.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.inertial.heading import begun, doubted, is_lost, settled
from followspot_balls.inertial.history import Rows
from followspot_balls.inertial.navigation import Navigation, carried, coasted, corrected, sighted
from followspot_balls.inertial.sensor_errors import SensorErrors

NANOSECOND = 1e-9
GATE = 6.0
"""Sigmas beyond which a position is no measurement of the target."""
CONTRADICTIONS = 5
"""Such positions in successive frames, after which the target is there."""


class Frame(NamedTuple):
    """One frame: its capture time, ns, and the measured position (3,) m with covariance (3, 3), or None."""

    time: int
    measured: tuple[Array, Array] | None


class Checkpoint(NamedTuple):
    """The navigation after a frame.

    read: capture time up to which readings are in it, ns; last: (6,) that reading.
    """

    frame: Frame
    nav: Navigation | None
    read: int
    last: Array


class Navigator:
    """The navigation of one target with its history.

    history: how long frames and readings are kept, s; maximum_gap: time between readings up to which the
    motion between them is known, s.
    """

    def __init__(self, errors: SensorErrors, history: float, maximum_gap: float) -> None:
        self.errors = errors
        self.history = round(history / NANOSECOND)
        self.gap = maximum_gap
        self.readings, self.orientations = Rows.none(6), Rows.none(5)
        self.checkpoints: list[Checkpoint] = []
        self.late = 0
        self.ahead: tuple[int, Checkpoint] | None = None

    def receive(self, readings: Rows, orientations: Rows) -> None:
        """Take up new readings; those older than the history are counted as `late`."""
        if self.checkpoints:
            oldest, newest = self.checkpoints[0].frame.time, self.checkpoints[-1].frame.time
            self.late += int(np.count_nonzero(readings.time <= min(oldest, newest - self.history)))
            readings, orientations = readings.since(oldest), orientations.since(oldest)
        self.readings = self.readings.with_rows(readings)
        self.orientations = self.orientations.with_rows(orientations)
        self.ahead = None
        new = [int(rows.time[0]) for rows in (readings, orientations) if len(rows.time)]
        if new:
            self._process_again_from(min(new))

    def now(self, time: int) -> Checkpoint | None:
        """The navigation with all readings up to a capture time, ns; None before it has begun."""
        if not self.checkpoints or self.checkpoints[-1].nav is None:
            return None
        last = self.checkpoints[-1]
        if time <= last.frame.time:
            return last if time == last.frame.time else None
        self.ahead = (time, self._carried(last, time))
        return self.ahead[1]

    def add(self, frame: Frame) -> None:
        """Process a frame. One that is not later than the last is left out."""
        if self.checkpoints and frame.time <= self.checkpoints[-1].frame.time:
            return
        self.checkpoints.append(self._processed(frame))
        kept = frame.time - self.history
        while len(self.checkpoints) > 1 and self.checkpoints[1].frame.time <= kept:
            del self.checkpoints[0]
        needed = min(self.checkpoints[0].read, self.checkpoints[0].frame.time - self.history)
        self.readings, self.orientations = self.readings.since(needed), self.orientations.since(needed)

    def _process_again_from(self, time: int) -> None:
        """Process the frames at and after a capture time again."""
        first = next((i for i, c in enumerate(self.checkpoints) if c.frame.time >= time), None)
        if first is None or first == 0:
            return
        frames = [checkpoint.frame for checkpoint in self.checkpoints[first:]]
        del self.checkpoints[first:]
        for frame in frames:
            self.checkpoints.append(self._processed(frame))

    def _processed(self, frame: Frame) -> Checkpoint:
        """The checkpoint that follows the last one."""
        if not self.checkpoints or self.checkpoints[-1].nav is None:
            return self._begun(frame)
        known = self.ahead is not None and self.ahead[0] == frame.time
        before = self.ahead[1] if known and self.ahead else self._carried(self.checkpoints[-1], frame.time)
        before = before._replace(frame=frame)
        self.ahead, nav = None, before.nav
        if nav is None:
            return before
        if frame.measured is None:
            return before._replace(nav=nav._replace(rejected=np.zeros_like(nav.rejected)))
        if is_lost(nav):
            return self._begun(frame)
        sight = sighted(nav, (frame.time - before.read) * NANOSECOND)
        nav = settled(corrected(nav, sight, *frame.measured, GATE))
        if nav.rejected.min() >= CONTRADICTIONS:
            nav = doubted(nav, *frame.measured)
        return before._replace(nav=nav)

    def _begun(self, frame: Frame) -> Checkpoint:
        """The checkpoint of a frame in which navigation begins, if position and orientation are known."""
        none = Checkpoint(frame, None, frame.time, np.zeros(6))
        seen = self.orientations.between(frame.time - self.history, frame.time)
        read = self.readings.between(frame.time - self.history, frame.time)
        if frame.measured is None or not len(seen.time) or not len(read.time):
            return none
        at = min(int(seen.time[-1]), int(read.time[-1]))
        row = int(np.searchsorted(seen.time, at, side="right")) - 1
        last = int(np.searchsorted(read.time, at, side="right")) - 1
        if row < 0 or last < 0 or frame.time - at > self.gap / NANOSECOND:
            return none
        *quaternion, inclination = seen.values[row]
        nav = begun(np.array(quaternion), inclination, *frame.measured, self.errors)
        return Checkpoint(frame, nav, int(read.time[last]), read.values[last])

    def _carried(self, checkpoint: Checkpoint, time: int) -> Checkpoint:
        """A checkpoint with the readings up to a capture time; over gaps without readings it coasts."""
        nav = checkpoint.nav
        assert nav is not None
        new = self.readings.between(checkpoint.read, time)
        times = np.concatenate([[checkpoint.read], new.time])
        values = np.concatenate([checkpoint.last[None], new.values])
        seconds = np.diff(times) * NANOSECOND
        means = (values[1:] + values[:-1]) / 2
        edges = [-1, *np.flatnonzero(seconds > self.gap), len(seconds)]
        for before, after in pairwise(edges):
            if before >= 0:
                nav = coasted(nav, float(seconds[before]))
            part = slice(before + 1, after)
            if before + 1 < after:
                nav = carried(nav, means[part, :3], means[part, 3:], seconds[part], self.errors)
        read, last = int(times[-1]), values[-1]
        if (time - read) * NANOSECOND > self.gap:
            nav, read = coasted(nav, (time - read) * NANOSECOND), time
        return Checkpoint(checkpoint.frame, nav, read, last)

    def state(self) -> dict[str, Any]:
        """Checkpoint of plain values: the oldest navigation, and what came since."""
        frames = [checkpoint.frame for checkpoint in self.checkpoints]
        unknown = (np.full(3, np.nan), np.full((3, 3), np.nan))
        measured = [frame.measured or unknown for frame in frames]
        oldest = self.checkpoints[0] if self.checkpoints else None
        return {
            "readings": self.readings._asdict(),
            "orientations": self.orientations._asdict(),
            "times": np.array([frame.time for frame in frames], np.int64),
            "xyz": np.array([xyz for xyz, _ in measured]).reshape(-1, 3),
            "noise": np.array([noise for _, noise in measured]).reshape(-1, 3, 3),
            "nav": oldest.nav._asdict() if oldest and oldest.nav else {},
            "read": oldest.read if oldest else 0,
            "last": oldest.last if oldest else np.zeros(6),
            "late": self.late,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Carry on from a checkpoint."""
        self.readings = Rows(*(np.array(state["readings"][name]) for name in Rows._fields))
        self.orientations = Rows(*(np.array(state["orientations"][name]) for name in Rows._fields))
        self.late = int(state["late"])
        rows = zip(state["times"], np.array(state["xyz"]), np.array(state["noise"]), strict=True)
        frames = [
            Frame(int(time), (xyz, noise) if np.isfinite(xyz).all() else None) for time, xyz, noise in rows
        ]
        nav = Navigation(**{name: np.array(v) for name, v in state["nav"].items()}) if state["nav"] else None
        self.checkpoints = [
            Checkpoint(frame, nav, int(state["read"]), np.array(state["last"])) for frame in frames[:1]
        ]
        for frame in frames[1:]:
            self.checkpoints.append(self._processed(frame))
