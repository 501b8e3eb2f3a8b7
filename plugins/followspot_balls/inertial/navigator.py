"""Navigation of one target: frames and readings in the order of their capture times, whenever they arrive.

Out-of-sequence readings, which arrive after later frames were processed, reset the navigation to the last
state before them, and the frames since then are processed again.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from followspot.frame_times import NANOSECOND
from followspot_balls.inertial.alignment import search_from, searched, with_navigation
from followspot_balls.inertial.frame_state import GATE, MAXIMUM_REJECTED, Frame, FrameState
from followspot_balls.inertial.heading import HeadingSearch
from followspot_balls.inertial.history import Rows, changing, with_orientations
from followspot_balls.inertial.initiation import heading_is_lost, reinitiated
from followspot_balls.inertial.navigation import (
    Navigation,
    coasted,
    corrected,
    predicted_position,
    propagated,
)
from followspot_balls.inertial.sensor_errors import SensorErrors

MINIMUM_CONTRADICTIONS, CONTRADICTION_WINDOW = 3, 10_000_000_000
"""How often, within how long (ns), positions contradict a navigation that is then ignored."""

MINIMUM_LONG_INTERVALS = 4
"""Long intervals between readings that are no single gap."""


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
        self.valid = self.readings
        self.frame_states: list[FrameState] = []
        self.late = 0
        self.contradictions: tuple[int, ...] = ()
        self.ahead: tuple[int, FrameState] | None = None
        """Prediction of :meth:`now` for a capture time, which the next frame uses again."""

    def receive(self, readings: Rows, orientations: Rows) -> None:
        """Take up new readings; those older than the history are counted as `late`."""
        if self.frame_states:
            oldest, newest = self.frame_states[0].frame.time, self.frame_states[-1].frame.time
            self.late += int(np.count_nonzero(readings.time <= min(oldest, newest - self.history)))
            readings, orientations = readings.since(oldest), orientations.since(oldest)
        self.readings = self.readings.with_rows(readings)
        self.valid = changing(self.readings)
        self.orientations = self.orientations.with_rows(orientations)
        self.ahead = None
        new = [int(rows.time[0]) for rows in (readings, orientations) if len(rows.time)]
        if new:
            self._reprocess_from(min(new))

    def now(self, time: int) -> FrameState | None:
        """The navigation with all readings up to a capture time, ns; None before its initiation."""
        if not self.frame_states or self.frame_states[-1].nav is None:
            return None
        last = self.frame_states[-1]
        if time <= last.frame.time:
            return last if time == last.frame.time else None
        self.ahead = (time, self._propagated(last, time))
        return self.ahead[1]

    def add(self, frame: Frame) -> None:
        """Process a frame. One that is not later than the last is left out."""
        if self.frame_states and frame.time <= self.frame_states[-1].frame.time:
            return
        self.frame_states.append(self._processed(frame))
        kept = frame.time - self.history
        while len(self.frame_states) > 1 and self.frame_states[1].frame.time <= kept:
            del self.frame_states[0]
        needed = min(self.frame_states[0].read, self.frame_states[0].frame.time - self.history)
        self.readings, self.orientations = self.readings.since(needed), self.orientations.since(needed)

    def contradicted(self, time: int) -> bool:
        """Whether the positions have contradicted the navigation again and again before a capture time, ns.

        Its clock may be wrong, it may sit loosely, or on another target; or the positions are not the
        target's.
        """
        recent = [t for t in self.contradictions if time - CONTRADICTION_WINDOW < t <= time]
        return len(recent) >= MINIMUM_CONTRADICTIONS

    @property
    def sparse(self) -> bool:
        """Whether the readings come so slowly that the motion between them is mostly not known."""
        intervals = np.diff(self.readings.time) * NANOSECOND
        long = intervals[intervals > self.gap]
        return len(long) >= MINIMUM_LONG_INTERVALS and bool(2 * long.sum() > intervals.sum())

    @property
    def stuck(self) -> bool:
        """Whether the newest reading only repeats those before it, while the sensor moves."""
        return bool((self.readings.time[-1:] > self.valid.time[-1:]).any())

    def _reprocess_from(self, time: int) -> None:
        """Process the frames at and after a capture time again."""
        first = next((i for i, c in enumerate(self.frame_states) if c.frame.time >= time), None)
        if first is None or first == 0:
            return
        frames = [state.frame for state in self.frame_states[first:]]
        del self.frame_states[first:]
        for frame in frames:
            self.frame_states.append(self._processed(frame))

    def _processed(self, frame: Frame) -> FrameState:
        """The state after a frame."""
        last = self.frame_states[-1] if self.frame_states else None
        found = FrameState(frame, None, None, frame.time, np.zeros(6))
        if last is not None and last.nav is not None:
            found = self._navigated(last, frame)
            if found.nav is not None and last.search is None:
                return found
        return self._searched(last.search if last is not None else None, found)

    def _navigated(self, last: FrameState, frame: Frame) -> FrameState:
        """The state after a frame, from one with a navigation; without one if its heading is lost."""
        known = self.ahead is not None and self.ahead[0] == frame.time
        before = self.ahead[1] if known and self.ahead else self._propagated(last, frame.time)
        before = before._replace(frame=frame)
        self.ahead, nav = None, before.nav
        assert nav is not None
        if frame.measured is None:
            return before._replace(nav=nav._replace(rejected=0))
        if heading_is_lost(nav):
            return before._replace(nav=None)
        predicted = predicted_position(nav, (frame.time - before.read) * NANOSECOND)
        found: Navigation | None = corrected(nav, predicted, *frame.measured, GATE)
        if found is not None and found.rejected >= MAXIMUM_REJECTED:
            found = reinitiated(found, *frame.measured)
            others = (t for t in self.contradictions if frame.time - CONTRADICTION_WINDOW < t < frame.time)
            self.contradictions = (*others, frame.time)
        return before._replace(nav=found)

    def _searched(self, search: HeadingSearch | None, found: FrameState) -> FrameState:
        """The state after a frame with the search for the heading, which was not known before."""
        frame, whole = found.frame, self._with_orientations(found.frame.time - self.history, found.frame.time)
        if search is not None:
            search = searched(search, frame, whole.since(search.read), self.gap, self.errors)
        if search is None:
            search = search_from(frame, whole, self.gap, self.errors)
        if search is None:
            return found._replace(search=None)
        return with_navigation(found, search, whole, self.errors)

    def _with_orientations(self, after: int, until: int) -> Rows:
        """The readings with orientations later than one capture time, up to another, ns."""
        return with_orientations(self.valid.between(after, until), self.orientations.between(after, until))

    def _propagated(self, frame_state: FrameState, time: int) -> FrameState:
        """A state with the readings up to a capture time; over gaps without readings it coasts."""
        nav = frame_state.nav
        assert nav is not None
        new = self.valid.between(frame_state.read, time)
        times = np.concatenate([[frame_state.read], new.time])
        values = np.concatenate([frame_state.last[None], new.values])
        seconds = np.diff(times) * NANOSECOND
        means = (values[1:] + values[:-1]) / 2
        edges = [-1, *np.flatnonzero(seconds > self.gap), len(seconds)]
        for before, after in pairwise(edges):
            if before >= 0:
                nav = coasted(nav, float(seconds[before]))
            part = slice(before + 1, after)
            if before + 1 < after:
                nav = propagated(nav, means[part, :3], means[part, 3:], seconds[part], self.errors)
        read, last = int(times[-1]), values[-1]
        if (time - read) * NANOSECOND > self.gap:
            nav, read = coasted(nav, (time - read) * NANOSECOND), time
        return FrameState(frame_state.frame, nav, frame_state.search, read, last)

    def state(self) -> dict[str, Any]:
        """Checkpoint of plain values: the oldest navigation, and frames and readings since."""
        frames = [state.frame for state in self.frame_states]
        unknown = (np.full(3, np.nan), np.full((3, 3), np.nan))
        measured = [frame.measured or unknown for frame in frames]
        oldest = self.frame_states[0] if self.frame_states else None
        return {
            "readings": self.readings._asdict(),
            "orientations": self.orientations._asdict(),
            "times": np.array([frame.time for frame in frames], np.int64),
            "xyz": np.array([xyz for xyz, _ in measured]).reshape(-1, 3),
            "noise": np.array([noise for _, noise in measured]).reshape(-1, 3, 3),
            "nav": oldest.nav.plain() if oldest and oldest.nav else {},
            "search": oldest.search.plain() if oldest and oldest.search else {},
            "read": oldest.read if oldest else 0,
            "last": oldest.last if oldest else np.zeros(6),
            "late": self.late,
            "contradictions": np.array(self.contradictions, np.int64),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Carry on from a checkpoint."""
        self.readings = Rows(*(np.array(state["readings"][name]) for name in Rows._fields))
        self.valid = changing(self.readings)
        self.orientations = Rows(*(np.array(state["orientations"][name]) for name in Rows._fields))
        self.late = int(state["late"])
        self.contradictions = tuple(np.array(state["contradictions"], np.int64).tolist())
        rows = zip(state["times"], np.array(state["xyz"]), np.array(state["noise"]), strict=True)
        frames = [
            Frame(int(time), (xyz, noise) if np.isfinite(xyz).all() else None) for time, xyz, noise in rows
        ]
        nav = Navigation.restored(state["nav"]) if state["nav"] else None
        search = HeadingSearch.restored(state["search"]) if state["search"] else None
        read, last = int(state["read"]), np.array(state["last"])
        self.frame_states = [FrameState(frame, nav, search, read, last) for frame in frames[:1]]
        for frame in frames[1:]:
            self.frame_states.append(self._processed(frame))
