"""The ways of actors: their positions and headings as functions of time alone."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.pose import CYCLE, Stance
from followspot_sim.rounds import smoothstep

PACE, TURN_RATE = 0.75, 1.9
"""Mean speed of walking, m/s, and of turning, rad/s."""
APART, ROUND_CUPBOARD = 0.75, 0.75
"""Distance that people keep from each other and from the middle of the cupboard, m."""
SHORT = 1.0
"""Smallest length of a walk, m; walks are shorter only if no other way is clear."""
HIDE_EVERY = 4
"""Of so many walks, one leads behind the cupboard."""
STAY = (0.3, 1.6)
"""Time between two walks, s."""
HIDDEN = 1.5
"""How long they stay behind the cupboard, s."""
ATTEMPTS, MOMENTS = 24, 24
GLANCES = np.array([[0.45, 0.23], [0.30, 0.61]])
"""Head pan: amplitude in rad and frequency in Hz of its waves."""
NODS = np.array([[0.12, 0.19], [0.07, 0.47]])
"""The same of the head's tilt."""


@dataclass(frozen=True)
class Walk:
    """Turn to a goal, walk there, and stay, perhaps turning on the spot.

    Times in s, places in m, headings in rad (not wrapped); phase: of the steps at its begin, rad.
    """

    begin: float
    turned: float
    arrived: float
    end: float
    start: tuple[float, float]
    goal: tuple[float, float]
    before: float
    ahead: float
    after: float
    phase: float

    def at(self, time: float) -> tuple[float, float, float, float, float]:
        """x, y, heading, stride and phase of the steps at a time."""
        u = min(max((time - self.turned) / (self.arrived - self.turned), 0.0), 1.0)
        s = float(smoothstep(u))
        first, last = (
            float(smoothstep((time - self.begin) / (self.turned - self.begin))),
            float(smoothstep((time - self.arrived) / (self.end - self.arrived))),
        )
        turn, spin = self.ahead - self.before, self.after - self.ahead
        length = float(np.hypot(self.goal[0] - self.start[0], self.goal[1] - self.start[1]))
        stepping = abs(turn) * 4 * first * (1 - first) + abs(spin) * 4 * last * (1 - last)
        stride = min(1.0, 4 * u * (1 - u) * min(1.0, length) + 0.12 * stepping)
        phase = self.phase + 2 * np.pi * s * length / CYCLE + abs(turn) * first + abs(spin) * last
        return (
            self.start[0] + s * (self.goal[0] - self.start[0]),
            self.start[1] + s * (self.goal[1] - self.start[1]),
            self.before + first * turn + last * spin,
            stride,
            phase,
        )


class Ways:
    """The ways of all people; walks are planned when they are first asked for."""

    def __init__(self, params: ActorParams) -> None:
        self._params = params
        self._rng = np.random.default_rng([params.seed, 31])
        self._glance = self._rng.uniform(0, 2 * np.pi, (params.people, 2, 2))
        self._lock = threading.Lock()  # sources of one process run in threads of their own
        self._walks: list[list[Walk]] = []
        self._plans: list[list[tuple[float, float]]] = [[] for _ in range(params.people)]
        for _ in range(params.people):
            self._walks.append([self._opening()])

    def stances(self, time: float) -> list[Stance]:
        """The poses of all people at a time, s."""
        with self._lock:
            while self._walks and min(walks[-1].end for walks in self._walks) < time:
                self._plan_next()
        return [self._stance(person, time) for person in range(len(self._walks))]

    def _stance(self, person: int, time: float) -> Stance:
        x, y, heading, stride, phase = self._walk(person, time).at(time)
        pan, tilt = (
            float((waves[:, 0] * np.sin(2 * np.pi * waves[:, 1] * time + self._glance[person, i])).sum())
            for i, waves in enumerate((GLANCES, NODS))
        )
        return Stance(
            x, y, float(np.mod(heading + np.pi, 2 * np.pi) - np.pi), pan, tilt - 0.05, stride, phase
        )

    def _walk(self, person: int, time: float) -> Walk:
        return next(walk for walk in reversed(self._walks[person]) if walk.begin <= time or walk.begin == 0)

    def _opening(self) -> Walk:
        """Standing still at a place of one's own."""
        places = [self._somewhere() for _ in range(ATTEMPTS)]
        others = [walks[0].goal for walks in self._walks]
        place = max(places, key=lambda p: min((_distance(p, o) for o in others), default=0.0))
        heading = float(self._rng.uniform(-np.pi, np.pi))
        end = float(self._rng.uniform(*STAY))
        return Walk(0.0, 0.1, 0.2, 0.3 + end, place, place, heading, heading, heading, 0.0)

    def _plan_next(self) -> None:
        """The next walk of the first person that is free: one of several candidates with a clear way."""
        person = min(range(len(self._walks)), key=lambda p: self._walks[p][-1].end)
        last, plan = self._walks[person][-1], self._plans[person]
        if not any(self._plans) and (len(self._walks[person]) + 2 * person) % HIDE_EVERY == 0:
            plan.extend(self._hiding(last.goal))
        if plan:
            goal = plan.pop(0)
            self._walks[person].append(self._walk_to(last, goal, HIDDEN if len(plan) == 1 else 0.3, 0.0))
            return
        best, widest = last, -1.0
        for goal in [*(self._somewhere() for _ in range(ATTEMPTS)), last.goal]:
            spin = float(self._rng.choice([0.0, 0.0, 1.0, -1.0]) * self._rng.uniform(1.5, 2 * np.pi))
            walk = self._walk_to(last, goal, float(self._rng.uniform(*STAY)), spin)
            gap = min(self._gap(person, walk) / APART, self._clearance(walk))
            gap *= 0.5 if _distance(walk.start, walk.goal) < SHORT else 1.0
            if gap > widest:
                best, widest = walk, gap
            if gap > 1.0:
                break
        self._walks[person].append(best)

    def _walk_to(self, last: Walk, goal: tuple[float, float], stay: float, spin: float) -> Walk:
        way = np.subtract(goal, last.goal)
        length = float(np.hypot(*way))
        direction = np.arctan2(way[1], way[0]) if length > 0 else last.after
        turn = float(np.mod(direction - last.after + np.pi, 2 * np.pi) - np.pi)
        turned = last.end + 0.3 + abs(turn) / TURN_RATE
        arrived = turned + 0.4 + length / PACE
        ahead = last.after + turn
        end = arrived + stay + abs(spin) / TURN_RATE
        return Walk(
            last.end,
            turned,
            arrived,
            end,
            last.goal,
            goal,
            last.after,
            ahead,
            ahead + spin,
            last.at(last.end)[4],
        )

    def _somewhere(self) -> tuple[float, float]:
        x0, y0, x1, y1 = self._params.walking_area
        return float(self._rng.uniform(x0, x1)), float(self._rng.uniform(y0, y1))

    def _hiding(self, place: tuple[float, float]) -> list[tuple[float, float]]:
        """Round one side of the cupboard, behind it, and out on the other side; nothing without one."""
        if self._params.cupboard is None:
            return []
        middle = np.array(self._params.cupboard)
        away = middle / np.hypot(*middle)
        aside = np.array([-away[1], away[0]])
        side = 1.0 if aside @ (np.array(place) - middle) > 0 else -1.0
        corners = ((-0.35, 1.0), (0.65, 1.0), (0.65, 0.0), (0.65, -1.0))
        points = [middle + far * away + 1.15 * k * side * aside for far, k in corners]
        return [(float(p[0]), float(p[1])) for p in points]

    def _gap(self, person: int, walk: Walk) -> float:
        """Smallest distance from the others during a walk, m."""
        others = [p for p in range(len(self._walks)) if p != person]
        moments = np.linspace(walk.begin, walk.end, MOMENTS)
        return min(
            (_distance(walk.at(t)[:2], self._walk(p, t).at(t)[:2]) for p in others for t in moments),
            default=np.inf,
        )

    def _clearance(self, walk: Walk) -> float:
        """Distance of a way from the middle of the floor and from the cupboard over the required distance."""
        keep = [((0.0, 0.0), self._params.clear_radius), (self._params.cupboard, ROUND_CUPBOARD)]
        path = np.linspace(walk.start, walk.goal, MOMENTS)
        found = [
            float(np.hypot(*(path - place).T).min()) / wanted
            for place, wanted in keep
            if place and wanted > 0
        ]
        return min(found, default=np.inf)


def _distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))
