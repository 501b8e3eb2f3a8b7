"""The stage that filters targets, with any motion model (Jin & Qian 2008, sections 3.7 and 3.8)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot.errors import Mistake
from followspot.frame_times import NANOSECOND
from followspot.messages import Array
from followspot.room import Camera, Member, Room
from followspot.stage import Stage
from followspot.tracking import LOST, MISSING, PREDICTED, Forecast, Positions, Tracks
from followspot_target_filter.confirmation import (
    ConfirmationRules,
    LastPositions,
    confirmed,
    supported,
    within,
)
from followspot_target_filter.departure import DepartureTest
from followspot_target_filter.known_positions import known_positions, unknown_positions
from followspot_target_filter.life_cycle import (
    LifeCycle,
    coasted,
    has_position,
    search_status,
    with_weak_counted,
)
from followspot_target_filter.marks import indistinguishable, marks_of
from followspot_target_filter.motion_model import MotionModel
from followspot_target_filter.not_found import not_found
from followspot_target_filter.parameters import TargetFilterParams

DEFAULT_PERIOD = 1 / 30
"""Frame interval before the second frame, s."""


@dataclass(frozen=True)
class Outputs:
    """The targets now, and their forecast for the next frame."""

    tracks: Tracks
    forecast: Forecast


class TargetFilter(Stage, ABC):
    """Base of filters of targets: their life cycle, marks and forecast. Subclasses give the motion model."""

    advice = (
        "no target was confirmed: check the calibration (`followspot calibrate check`), or lower "
        "minimum_support and confirmation_frames"
    )

    class Params(TargetFilterParams):
        """The life cycle."""

    params: Params
    measured: Array = np.zeros((0, 3))
    """(T, 3) m, the last measured positions; none before the stage is set up."""
    unknown = 0
    """Positions so far whose coordinates were no numbers."""

    @abstractmethod
    def motion_model(self, count: int) -> MotionModel:
        """The motion model of `count` targets, before any measurement."""

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn if nothing tells several targets apart."""
        if alike := indistinguishable(params.marks, room, cameras):
            text = f"no camera sees colours, so nothing tells {', '.join(alike)} apart, and none is found"
            yield Mistake(None, text, "with: {marks: {TARGET: [x, y, z]}}, where each is at the beginning")

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Raises InputError if a mark is that of no target."""
        marks_of(params.marks, tuple(room.targets))
        return ()

    def setup(self) -> None:
        """Begin with every target lost. Raises InputError if a mark is that of no target."""
        count = len(self.room.targets)
        p = self.params
        self.marks = marks_of(p.marks, tuple(self.room.targets))
        separation = min((t.radius for t in self.room.targets.values()), default=0.0)
        self.rules = ConfirmationRules(
            p.minimum_support,
            p.confirmation_frames,
            p.confirmation_distance,
            separation,
            p.return_distance,
            p.maximum_missed_frames,
        )
        self.constant = np.eye(3) * p.measurement_sigma**2
        self.motion = self.motion_model(count)
        self.departure = DepartureTest(self.room, self.marks.there, p.doubt_frames)
        self.life = LifeCycle.lost(count)
        self.last, self.before, self.measured = np.zeros((3, count, 3))
        self.time, self.period = -1, DEFAULT_PERIOD
        self.decide_search()

    def process(self, positions: Positions) -> Outputs:
        p = self.params
        self.advance(positions.header.time)
        given, positions = positions, known_positions(positions)
        self.unknown += len(given.target) - len(positions.target)
        doubt, status = self.doubt, self.search_status
        self.motion.predict(self.period)
        if np.count_nonzero(doubt):
            status = self.unless_at_forecast(status, doubt, positions)
        last = LastPositions(self.last, self.measured)
        life, counted = confirmed(self.life, status, p.local_search_frames, positions, last, self.rules)
        if np.count_nonzero(counted) < len(counted):
            positions = positions.where(counted)
        target, xyz = positions.target.astype(np.intp), positions.xyz
        noise, sure = self.noise(positions.covariance), supported(positions, p.minimum_support)
        new = ((status == LOST) | (self.life.status == LOST)).take(target)
        old = slice(None)
        if np.count_nonzero(new):
            self.motion.initiate(target[new], xyz[new], noise[new])
            old = ~new
        self.motion.update(target[old], xyz[old], noise[old], sure[old], self.period)
        measured, agreed, bridged = np.zeros((3, len(life.status)), bool)
        measured[target] = ~positions.predicted
        agreed[target] = self.departure.agreed(positions.support, positions.confirmed, xyz, p.minimum_support)
        bridged[target] = positions.predicted
        bridged |= doubt & ~measured
        if np.count_nonzero(bridged):
            bridged &= self.motion.estimate.sigma.max(axis=1) <= p.maximum_predicted_sigma
        life = with_weak_counted(life, measured, agreed)
        self.life = coasted(life, measured, bridged, p.maximum_missed_frames)
        self.remember(target, target[new], measured)
        self.decide_search()
        return Outputs(self.tracks(), self.forecast())

    def close(self) -> None:
        """Warn the user of positions that were no numbers, and of targets that were not found, though others
        were.
        """
        missing = not_found(self.room, np.asarray(self.measured.any(axis=1)))
        for text in filter(None, (unknown_positions(self.unknown), missing)):
            self.context.warn(text)

    def decide_search(self) -> None:
        """Decide where the next frame is searched, and which targets are also searched elsewhere."""
        self.doubt = self.departure.doubted(self.life, self.motion.estimate.xyz)
        """(T,) bool."""
        local_frames, marked = self.params.local_search_frames, self.marks.there
        self.search_status = search_status(self.life, local_frames, marked, self.doubt)
        """(T,) u8, the status of each target as far as the search is concerned."""

    def unless_at_forecast(self, status: Array, doubt: Array, positions: Positions) -> Array:
        """The status of the search; a doubted target that is found at its forecast keeps its own.

        status, doubt: (T,) of :meth:`decide_search`. Returns (T,) u8.
        """
        there = doubt.take(positions.target)
        ahead = self.motion.estimate.xyz.take(positions.target, axis=0)
        there &= within(positions.xyz, ahead, self.params.return_distance)
        target = positions.target[there]
        status = status.copy()
        status[target] = self.life.status[target]
        return status

    def advance(self, time: int) -> None:
        """Measure the period from capture times, ns; frame intervals may vary."""
        if self.time >= 0 and time > self.time:
            self.period = (time - self.time) * NANOSECOND
        self.time = time

    def noise(self, covariance: Array) -> Array:
        """Covariances of measurements, with the constant one if the fusion gives none."""
        return np.where(np.isfinite(covariance), covariance, self.constant)

    def remember(self, target: Array, new: Array, measured: Array) -> None:
        """Store the last two estimates of targets with positions, and slow down coasting targets.

        measured: (T,) bool; a position that was predicted from one view does not count as measured.
        """
        self.before[target] = self.last.take(target, axis=0)
        here, status = self.motion.estimate.xyz, self.life.status
        self.last[target] = here.take(target, axis=0)
        self.before[new] = self.last[new]
        self.measured[measured] = here[measured]
        missing = status == MISSING
        if self.params.fade_time > 0:
            missing |= status == PREDICTED
        coasting = missing.nonzero()[0]
        if not len(coasting):
            return
        if self.params.fade_time > 0:
            self.motion.slow(coasting, np.exp(-self.period / self.params.fade_time))
        else:
            self.motion.stop(coasting, self.last[coasting])

    def tracks(self) -> Tracks:
        """Rows of the targets that are tracked or predicted."""
        target = has_position(self.life.status).nonzero()[0]
        now = self.motion.estimate
        return Tracks(
            target=target.astype(np.int32),
            state=self.life.status.take(target),
            xyz=now.xyz.take(target, axis=0),
            velocity=now.velocity.take(target, axis=0),
            sigma=self.departure.widened(now.sigma, self.life, now.xyz, self.period).take(target, axis=0),
        )

    def forecast(self) -> Forecast:
        """The targets one period later; the rows of lost targets are zero."""
        known = self.search_status != LOST
        ahead = self.motion.ahead(self.period)
        keep = known[:, None]
        forecast = Forecast(
            period=self.period,
            state=self.search_status,
            xyz=ahead.xyz * keep,
            velocity=ahead.velocity * keep,
            covariance=ahead.covariance * keep[..., None],
            last=self.last * keep,
            before=self.before * keep,
        )
        at_mark = known & (self.life.status == LOST)
        return self.marks.placed(forecast, at_mark) if np.count_nonzero(at_mark) else forecast

    def state(self) -> Any:
        return {
            **self.motion.state(),
            **self.life._asdict(),
            "last": self.last,
            "before": self.before,
            "measured": self.measured,
            "time": self.time,
            "period": self.period,
            "unknown": self.unknown,
        }

    def restore(self, state: Any) -> None:
        self.motion.restore(state)
        self.life = LifeCycle(*(np.array(state[name]) for name in LifeCycle._fields))
        self.last, self.before = np.array(state["last"]), np.array(state["before"])
        self.measured = np.array(state["measured"])
        self.time, self.period = int(state["time"]), float(state["period"])
        self.unknown = int(state.get("unknown", 0))  # not in recordings of before
        self.decide_search()
