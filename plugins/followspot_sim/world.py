"""The performance as a function of time: positions of every ball and every limb."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from followspot import Array, InputError, Room
from followspot.errors import Mistake, did_you_mean
from followspot_sim.body import PARTS, RADII, Pose, limbs, pose
from followspot_sim.choreography import Planner
from followspot_sim.marks import MARK_RADII, MARKS, marks
from followspot_sim.parameters import SimParams
from followspot_sim.recent import Recent
from followspot_sim.rounds import ROUND, Move, Place, Round, opening, smoothstep

GRAVITY = np.array([0.0, 0.0, -9.81])
"""m/s^2."""
GAP = 0.02
"""Balls keep this distance between their surfaces, m."""
ALONE_SPAN = np.array([1.7, 1.7, 0.8])
"""Half the volume in which a ball alone appears, m."""


@dataclass(frozen=True)
class Setting:
    """Parameters of the performance; equal ones give equal performances in every process."""

    seed: int
    fps: float
    people: int
    hide: bool
    alone: int
    """Number of the only target shown, or -1."""
    radii: tuple[float, ...]
    floor: tuple[float, float, float, float]
    clock_offset: float = 0.0
    """By how much its scenes are later than their frames, s; the performance does not depend on it."""
    cover: bool = False
    """Whether people hold balls against their bodies and wear marks."""


@dataclass(frozen=True, eq=False)
class Scene:
    """One time: balls (T, 3) m, NaN for those not shown; limbs (K, 2, 3) m with radius (K,) m, part (K,).

    `part` indexes PARTS and the MARKS after them; the limbs of all people come before their marks.
    """

    time: float
    balls: Array
    limbs: Array
    radius: Array
    part: Array


def check_targets(params: SimParams, room: Room) -> None:
    """Raises InputError if `only_target` or `colors` names no target of the room."""
    named = [("colors", name) for name in params.colors]
    if params.only_target:
        named.append(("only_target", params.only_target))
    mistakes = [
        Mistake(None, f'{key}: the room has no target "{name}"', did_you_mean(name, room.targets, "targets"))
        for key, name in named
        if name not in room.targets
    ]
    if mistakes:
        raise InputError(mistakes)


def setting(params: SimParams, room: Room, clock_offset: float = 0.0) -> Setting:
    """The setting of a room, seen `clock_offset` seconds late.

    Raises InputError as `check_targets`.
    """
    check_targets(params, room)
    names = list(room.targets)
    floor = room.planes.get("floor", np.array([0.0, 0.0, 1.0, 0.0]))
    a, b, c, d = (float(v) for v in floor)
    return Setting(
        seed=params.seed,
        fps=params.fps,
        people=0 if params.only_target else params.people,
        hide=params.hide_balls,
        alone=names.index(params.only_target) if params.only_target else -1,
        radii=tuple(t.radius for t in room.targets.values()),
        floor=(a, b, c, d),
        clock_offset=clock_offset,
        cover=params.cover_balls,
    )


@lru_cache(maxsize=4)
def world_of(choice: Setting) -> World:
    """The world of a setting, shared by the cameras of one process."""
    return World(choice)


class World:
    """Rounds are planned when they are first asked for; any frame may be asked for at any time."""

    def __init__(self, choice: Setting) -> None:
        self.setting = choice
        _, _, c, d = choice.floor
        self._rest = np.array(choice.radii) - d / c
        self._rounds = [opening(choice.people, len(choice.radii), self._rest)]
        self._lock = threading.Lock()  # sources of one process run in threads of their own
        self.scene = Recent(self._build_scene)

    def balls(self, time: float) -> Array:
        """Centres of all balls at a time (s; before 0 as at 0), (T, 3) m; NaN for balls not shown."""
        if self.setting.alone >= 0:
            return self._alone(round(time * self.setting.fps))
        act, u = self._round(max(time, 0.0))
        now = pose(act, u, max(time, 0.0))
        return self._balls(act, u, max(time, 0.0), now)

    def _build_scene(self, frame: int) -> Scene:
        """Everything at the middle of the exposure of a frame; before the performance as at its beginning."""
        time = max(frame / self.setting.fps + self.setting.clock_offset, 0.0)
        if self.setting.alone >= 0:
            return Scene(time, self._alone(frame), np.empty((0, 2, 3)), np.empty(0), np.empty(0, int))
        act, u = self._round(time)
        now = pose(act, u, time)
        people, body = self.setting.people, limbs(now)
        radius, part = np.tile(RADII, people), np.tile(np.arange(len(PARTS)), people)
        if self.setting.cover:
            body = np.concatenate([body, marks(now, body)])
            radius = np.concatenate([radius, np.tile(MARK_RADII, people)])
            part = np.concatenate([part, np.tile(len(PARTS) + np.arange(len(MARKS)), people)])
        return Scene(time, self._balls(act, u, time, now), body, radius, part)

    def _round(self, time: float) -> tuple[Round, float]:
        """The round at a time and the seconds since it began."""
        number = int(time / ROUND)
        with self._lock:
            while len(self._rounds) < number + 2:
                self._rounds.append(self._plan())
            return self._rounds[number + 1], time - number * ROUND

    def _plan(self) -> Round:
        """The next round: the first of several plans in which no ball passes through another."""
        best, widest = self._rounds[-1], -1.0
        for attempt in range(12):
            rng = np.random.default_rng([self.setting.seed, len(self._rounds), attempt])
            choice = self.setting
            plan = Planner(rng, self._rounds[-1], self._rest, choice.hide, choice.cover).plan()
            gap = self._gap(plan, (len(self._rounds) - 1) * ROUND)
            if gap > widest:
                best, widest = plan, gap
            if gap > GAP:
                break
        return best

    def _gap(self, plan: Round, begin: float) -> float:
        """Smallest distance between two balls' surfaces in a round that begins at that time, m."""
        i, j = np.triu_indices(len(plan.moves), 1)
        if len(i) == 0:
            return np.inf
        moments = np.linspace(0.0, ROUND, 60)
        paths = np.array([self._balls(plan, u, begin + u, pose(plan, u, begin + u)) for u in moments])
        touching = np.add(*np.array(self.setting.radii)[[i, j]])
        return float((np.linalg.norm(paths[:, i] - paths[:, j], axis=2) - touching).min())

    def _balls(self, act: Round, u: float, time: float, now: Pose) -> Array:
        centres = np.empty((len(act.moves), 3))
        for ball, move in enumerate(act.moves):
            if u < move.leave:
                centres[ball] = _resting(move.before, now)
            elif u >= move.arrive:
                centres[ball] = _resting(move.after, now)
            elif move.before.kind == "floor":
                a, b = np.array(move.before.xyz), np.array(move.after.xyz)
                centres[ball] = a + (b - a) * smoothstep((u - move.leave) / (move.arrive - move.leave))
            else:
                centres[ball] = _flying(act, move, u, time)
        return centres

    def _alone(self, frame: int) -> Array:
        """One ball that jumps from frame to frame (R3 sequence, fills the volume evenly)."""
        step = np.array([0.8191725, 0.6710436, 0.5497005])
        where = 2 * np.mod(0.5 + step * (frame + 1), 1.0) - 1
        centres = np.full((len(self.setting.radii), 3), np.nan)
        centres[self.setting.alone] = where * ALONE_SPAN + [0, 0, ALONE_SPAN[2] + 0.1]
        return centres


def _resting(place: Place, now: Pose) -> Array:
    if place.kind == "floor":
        return np.array(place.xyz)
    if place.kind == "bag":
        return np.asarray(now.bags()[place.person])
    return now.held(place.person, place.hand)


def _flying(act: Round, move: Move, u: float, time: float) -> Array:
    """On the parabola that leaves one hand and meets the other."""
    begin = time - u
    start = _resting(move.before, pose(act, move.leave, begin + move.leave))
    end = _resting(move.after, pose(act, move.arrive, begin + move.arrive))
    s, flight = u - move.leave, move.arrive - move.leave
    return np.asarray(start + (end - start) * s / flight + 0.5 * GRAVITY * s * (s - flight))
