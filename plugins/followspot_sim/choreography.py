"""The choreography: plans one round of the performance from the end of the last one.

A round has two halves. In the first the people walk to new stations, in the second they stand and act: put a
ball down, pick one up, pass it from hand to hand, throw it, put it into a bag or show it
again. Balls on the floor may roll meanwhile. A person does one thing a round.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Array
from followspot_sim.floor_paths import clear, rolling, still
from followspot_sim.holding import HOLDS
from followspot_sim.rounds import (
    BAG,
    BALL_FROM_HAND,
    FLIGHT,
    MEETING,
    ROLL,
    SWITCH,
    Move,
    Place,
    Round,
    in_room,
    turned,
)

STAGE = 1.9
"""Balls stay within this distance of the room's centre along x and y, m."""
LAST_RADIUS = 1.6
"""People stay within this circle unless they fetch a ball, m."""
TRIES = 12
"""Places that are tried for a person who walks or a ball that rolls."""
ACTS = (0.32, 0.3, 0.16, 0.22)
"""Probabilities that a held ball is put down, thrown, passed to the other hand, or put into the bag."""
FETCHED, SHOWN = 0.7, 0.8
"""Probabilities that a ball is fetched from the floor, and taken out of a bag again."""
LONGEST_FETCH, LONGEST_WALK = 2.5, 2.2
"""Longest ways to a ball that is fetched, and to another station, m."""
AT_HAND = 0.5
"""Distance of a person from a ball on the floor that it picks up or puts down, m."""
ROOMY = 0.8
"""Clearance of a walk at which no better one is sought, m."""
LOOK_ASIDE = 0.8
"""Largest angle by which people look past the middle of the room, rad."""
PUT_ASIDE = 0.25
"""Largest distance to the side at which a ball is put down, m."""
ROLLS, THROWS = (0.5, 2.3), (1.0, 2.8)
"""Shortest and longest distance over which balls roll, and are thrown, m."""
ROLLING_GAP, PUT_GAP = 0.17, 0.2
"""Smallest distance between the centres of balls of which one rolls, and is put down, m."""


class Planner:
    """Plans one round. hide: whether balls may vanish into bags; cover: whether bodies may cover them."""

    def __init__(
        self, rng: np.random.Generator, last: Round, rest_height: Array, hide: bool, cover: bool = False
    ) -> None:
        self.rng, self.start, self.rest_height, self.hide = rng, last.end, rest_height, hide
        people = len(last.end)
        self.held, self.cover = last.held[1], cover
        self.places = [move.after for move in last.moves]
        self.end = np.full((people, 3), np.nan)
        self.reach = np.full((people, 2, 3), np.nan)
        self.bow = np.zeros(people)
        self.moves = [Move(place, place) for place in self.places]
        self.idle = set(range(people))
        self.full = {(p.person, p.hand) for p in self.places if p.kind == "hand"}
        self.bags = {p.person for p in self.places if p.kind == "bag"}
        self.lying = {b: still(p.xyz) for b, p in enumerate(self.places) if p.kind == "floor"}

    def plan(self) -> Round:
        """The round: fetch balls from the floor, walk, then let every ball have its act."""
        order = [int(b) for b in self.rng.permutation(len(self.places))]
        fetched = {b for b in order if self.places[b].kind == "floor" and self._fetch(b)}
        for person in range(len(self.end)):
            if np.isnan(self.end[person, 0]):
                self._wander(person)
        for ball in order:
            if ball not in fetched:
                self._act(ball)
        held = self.rng.integers(len(HOLDS), size=self.held.shape) if self.cover else self.held
        moves = tuple(self.moves)
        return Round(self.start, self.end, self.reach, self.bow, moves, np.stack([self.held, held]))

    def _act(self, ball: int) -> None:
        kind = self.places[ball].kind
        if kind == "floor":
            self._roll(ball)
        elif kind == "bag":
            self._show(ball)
        elif self.places[ball].person in self.idle:
            acts: list[Callable[[int], bool]] = [self._put, self._throw, self._switch, self._stow]
            likely = np.array(ACTS) * [1, 1, 1, self.hide]
            for k in self.rng.choice(4, size=4 - (not self.hide), replace=False, p=likely / likely.sum()):
                if acts[k](ball):
                    break

    def _fetch(self, ball: int) -> bool:
        """The nearest idle person with a free hand walks to the ball and picks it up."""
        xy = np.array(self.places[ball].xyz[:2])
        able = [p for p in sorted(self.idle) if self._hand_for_more(p) is not None]
        if not able or self.rng.random() > FETCHED:
            return False
        away = xy - self.start[able, :2]
        distance = np.hypot(away[:, 0], away[:, 1])
        nearest = int(distance.argmin())
        if distance[nearest] > LONGEST_FETCH:
            return False
        person, heading = able[nearest], float(np.arctan2(*away[nearest][::-1]))
        self.end[person] = [*(xy - AT_HAND * np.array([np.cos(heading), np.sin(heading)])), heading]
        hand = self._hand_for_more(person)
        assert hand is not None  # able says so
        self._reach_ball(person, hand, np.array(self.places[ball].xyz), bow=True)
        self._hand_over(ball, Place("hand", person, hand))
        return True

    def _wander(self, person: int) -> None:
        """Walk to a station that is free, and face the others."""
        best, gap = self.start[person], -1.0
        for _ in range(TRIES):
            radius, angle = LAST_RADIUS * np.sqrt(self.rng.random()), self.rng.uniform(-np.pi, np.pi)
            xy = np.array([radius * np.cos(angle), radius * np.sin(angle)])
            if np.hypot(*(xy - self.start[person, :2])) < LONGEST_WALK:
                clearance = self._clearance(person, xy)
                if clearance > gap:
                    heading = angle + np.pi + self.rng.uniform(-LOOK_ASIDE, LOOK_ASIDE)
                    best, gap = np.array([*xy, heading]), clearance
                if gap > ROOMY:
                    break
        self.end[person] = best

    def _clearance(self, person: int, xy: Array) -> float:
        """Smallest distance to the walks of the others planned so far, m."""
        s = np.linspace(0, 1, 7)[:, None]
        walk = self.start[person, :2] * (1 - s) + xy * s
        gaps = [
            np.hypot(*(walk - self.start[p, :2] * (1 - s) - self.end[p, :2] * s).T).min()
            for p in range(len(self.end))
            if p != person and not np.isnan(self.end[p, 0])
        ]
        return float(min(gaps, default=9.0))

    def _roll(self, ball: int) -> None:
        """Roll to a free place, past a neighbour if there is one."""
        start = np.array(self.places[ball].xyz)
        others = [track for b, track in self.lying.items() if b != ball]
        for attempt in range(TRIES):
            if attempt < len(others):
                ahead = others[attempt][0] - start[:2]
                side = np.array([-ahead[1], ahead[0]]) / max(float(np.hypot(*ahead)), 0.1)
                goal = start[:2] + 1.8 * ahead + 0.4 * side
            else:
                goal = self.rng.uniform(-STAGE, STAGE, 2)
            track = rolling(start[:2], goal)
            fair = np.abs(goal).max() < STAGE and ROLLS[0] < np.hypot(*(goal - start[:2])) < ROLLS[1]
            if fair and clear(track, others, ROLLING_GAP):
                self.lying[ball] = track
                goal_place = Place("floor", xyz=(float(goal[0]), float(goal[1]), float(start[2])))
                self.moves[ball] = Move(self.places[ball], goal_place, *ROLL)
                return

    def _put(self, ball: int) -> bool:
        """Put the ball on the floor ahead."""
        place = self.places[ball]
        for side in self.rng.uniform(-PUT_ASIDE, PUT_ASIDE, 4):
            xyz = in_room(self.end[place.person], np.array([AT_HAND, side, self.rest_height[ball]]))
            track = still(xyz)
            if np.abs(xyz[:2]).max() < STAGE and clear(track, self.lying.values(), PUT_GAP):
                self.lying[ball] = track
                self._reach_ball(place.person, place.hand, xyz, bow=True)
                self._hand_over(ball, Place("floor", xyz=(float(xyz[0]), float(xyz[1]), float(xyz[2]))))
                return True
        return False

    def _throw(self, ball: int) -> bool:
        """Throw the ball to an idle person with a free hand; both turn to each other."""
        place = self.places[ball]
        for other in sorted(self.idle - {place.person}):
            hand = self._hand_for_more(other)
            ahead = self.end[other, :2] - self.end[place.person, :2]
            if hand is not None and THROWS[0] < np.hypot(*ahead) < THROWS[1]:
                heading = float(np.arctan2(ahead[1], ahead[0]))
                self.end[place.person, 2], self.end[other, 2] = heading, heading + np.pi
                self.idle.discard(other)
                leave = SWITCH - FLIGHT / 2
                self._hand_over(ball, Place("hand", other, hand), leave, leave + FLIGHT)
                return True
        return False

    def _switch(self, ball: int) -> bool:
        """Pass the ball to the other hand."""
        place = self.places[ball]
        if (place.person, 1 - place.hand) in self.full:
            return False
        self.reach[place.person] = in_room(self.end[place.person], MEETING)
        self._hand_over(ball, Place("hand", place.person, 1 - place.hand))
        return True

    def _stow(self, ball: int) -> bool:
        """Put the ball into the bag."""
        place = self.places[ball]
        if place.person in self.bags or (place.person, 1 - place.hand) in self.full:
            return False
        self.bags.add(place.person)
        self._reach_ball(place.person, place.hand, in_room(self.end[place.person], BAG))
        self._hand_over(ball, Place("bag", place.person))
        return True

    def _show(self, ball: int) -> bool:
        """Take the ball out of the bag again."""
        person = self.places[ball].person
        hand = self._free_hand(person)
        if person not in self.idle or hand is None or self.rng.random() > SHOWN:
            return False
        self._reach_ball(person, hand, in_room(self.end[person], BAG))
        self._hand_over(ball, Place("hand", person, hand))
        return True

    def _reach_ball(self, person: int, hand: int, ball: Array, bow: bool = False) -> None:
        self.reach[person, hand] = ball - turned(self.end[person, 2], BALL_FROM_HAND)
        self.bow[person] = bow

    def _hand_over(self, ball: int, after: Place, leave: float = SWITCH, arrive: float = SWITCH) -> None:
        """Add the move: its people are busy, and hands that held or get a ball are full."""
        self.moves[ball] = Move(self.places[ball], after, leave, arrive)
        for place in (self.places[ball], after):
            self.idle.discard(place.person)
            if place.kind == "hand":
                self.full.add((place.person, place.hand))

    def _free_hand(self, person: int) -> int | None:
        free = [hand for hand in (0, 1) if (person, hand) not in self.full]
        return free[0] if free else None

    def _hand_for_more(self, person: int) -> int | None:
        """A hand for another ball; a person with a ball in the bag keeps one hand free for it."""
        return None if person in self.bags and self._hands_full(person) else self._free_hand(person)

    def _hands_full(self, person: int) -> bool:
        return any((person, hand) in self.full for hand in (0, 1))
