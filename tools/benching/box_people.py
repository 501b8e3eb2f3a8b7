"""People who walk about a small area, jump, fall and get up again, as points on their bodies."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from followspot import Array

AREA = np.array([[-2.0, -1.5], [2.0, 1.5]])
"""Corners of the floor on which people walk, m."""
MARGIN = 0.7
"""How far they evade one another beyond it, m."""
HEIGHTS, PACES = (1.55, 1.9), (0.5, 1.1)
"""Smallest and largest height, m, and pace, m/s."""
FASTEST, AGILITY = 1.3, 2.5
"""Largest speed, m/s, and largest change of the velocity in a second, m/s."""
EVADING = 0.6
"""Distance below which people evade each other, m."""
ARRIVED, LINGERING, LONGEST = 0.15, 0.3, 1.5
"""Distance from a goal at which it is reached, m; share of goals at which people linger; and how long, s."""
JUMPS, FALLS = 0.3, 0.12
"""How often in a second a person who may do so jumps, and falls."""
TAKE_OFF, GRAVITY = 2.4, 9.8
"""Speed of a jump, m/s, and acceleration, m/s^2."""
FALLING, LYING, RISING = 0.6, 2.0, 1.2
"""Duration of a fall, of lying and of getting up, s."""
ARRIVALS = (0.6, 1.8)
"""Time between the arrivals of two people, s."""
NEVER = np.inf


@dataclass(frozen=True, eq=False)
class People:
    """N people: what stays, and what changes from step to step.

    time: s; arrives: (N,) s, when each comes into the room; height: (N,) m; pace: (N,) m/s; shape: (N, P, 3)
    points of the head, the trunk and the hips, over the height; xy, velocity, goal: (N, 2) m, m/s and m;
    stride: (N,) rad, phase of the legs; pause: (N,) s left of lingering; jumped, fell: (N,) s since the jump
    or fall began, `NEVER` without one; lying: (N,) rad, the direction in which a body falls.
    """

    time: float
    arrives: Array
    height: Array
    pace: Array
    shape: Array
    xy: Array
    velocity: Array
    goal: Array
    stride: Array
    pause: Array
    jumped: Array
    fell: Array
    lying: Array

    @property
    def present(self) -> Array:
        """Who is in the room, (N,) bool."""
        return np.asarray(self.arrives <= self.time)

    @property
    def tilt(self) -> Array:
        """Angle of each body from upright, (N,) rad."""
        t = np.where(np.isfinite(self.fell), self.fell, 0.0)
        share = np.minimum(t / FALLING, 1 - np.clip((t - FALLING - LYING) / RISING, 0, 1))
        return np.asarray(np.pi / 2 * share)

    @property
    def level(self) -> Array:
        """Height of the feet above the floor, (N,) m."""
        t = np.where(np.isfinite(self.jumped), self.jumped, 0.0)
        return np.maximum(TAKE_OFF * t - GRAVITY / 2 * t * t, 0.0)


def people(count: int, rng: np.random.Generator) -> People:
    """That many people, each at a place of its own; they come one after the other."""
    low, high = AREA
    none = np.full(count, NEVER)
    return People(
        time=0.0,
        arrives=np.append(0.0, rng.uniform(*ARRIVALS, count).cumsum())[:count],
        height=rng.uniform(*HEIGHTS, count),
        pace=rng.uniform(*PACES, count),
        shape=np.stack([_shape(rng) for _ in range(count)]),
        xy=rng.uniform(low, high, (count, 2)),
        velocity=np.zeros((count, 2)),
        goal=rng.uniform(low, high, (count, 2)),
        stride=rng.uniform(0, 2 * np.pi, count),
        pause=np.zeros(count),
        jumped=none,
        fell=none,
        lying=np.zeros(count),
    )


def moved(before: People, seconds: float, acts: Collection[str], rng: np.random.Generator) -> People:
    """The people some time later. acts: may contain "jump" and "fall"."""
    count = len(before.height)
    jumped, fell = before.jumped + seconds, before.fell + seconds
    jumped[before.level == 0] = NEVER
    fell[fell > FALLING + LYING + RISING] = NEVER
    free = before.present & ~np.isfinite(fell)
    jumps = ("jump" in acts) & free & (rng.random(count) < JUMPS * seconds)
    falls = ("fall" in acts) & free & (rng.random(count) < FALLS * seconds)
    jumped[jumps & ~np.isfinite(jumped)] = 0.0
    fell[falls] = 0.0
    arrived = np.linalg.norm(before.goal - before.xy, axis=1) < ARRIVED
    lingers = arrived & (rng.random(count) < LINGERING)
    pause = np.where(lingers, rng.uniform(0, LONGEST, count), np.maximum(before.pause - seconds, 0.0))
    goal = np.where(arrived[:, None], rng.uniform(AREA[0], AREA[1], (count, 2)), before.goal)
    wanted = np.where((pause > 0)[:, None], 0.0, _wanted(before, goal))
    change = wanted - before.velocity
    most = AGILITY * seconds / np.maximum(np.linalg.norm(change, axis=1), 1e-9)
    velocity = before.velocity + change * np.minimum(most, 1.0)[:, None]
    velocity[~free] = 0.0
    return replace(
        before,
        time=before.time + seconds,
        xy=np.clip(before.xy + velocity * seconds, AREA[0] - MARGIN, AREA[1] + MARGIN),
        velocity=velocity,
        goal=goal,
        stride=before.stride + 6 * np.linalg.norm(velocity, axis=1) * seconds,
        pause=pause,
        jumped=jumped,
        fell=fell,
        lying=np.where(falls, rng.uniform(0, 2 * np.pi, count), before.lying),
    )


def surfaces(of: People) -> Array:
    """Points on the bodies, (N, P, 3) m."""
    points = np.concatenate([of.shape, _limbs(of.stride, np.isfinite(of.jumped))], axis=1)
    points = points * of.height[:, None, None]
    cos, sin = np.cos(of.tilt)[:, None], np.sin(of.tilt)[:, None]
    x, y, z = np.moveaxis(points, 2, 0)
    along, up = x * cos + z * sin, np.maximum(z * cos - x * sin + 0.12 * sin, 0.0)
    way = np.where(of.tilt > 0, of.lying, np.arctan2(of.velocity[:, 1], of.velocity[:, 0]))[:, None]
    around = np.stack([along * np.cos(way) - y * np.sin(way), along * np.sin(way) + y * np.cos(way)], axis=2)
    return np.concatenate([around + of.xy[:, None], (up + of.level[:, None])[..., None]], axis=2)


def _wanted(before: People, goal: Array) -> Array:
    """Velocities towards the goals and away from people nearby, (N, 2) m/s."""
    way = goal - before.xy
    ahead = way / np.maximum(np.linalg.norm(way, axis=1), 1e-9)[:, None] * before.pace[:, None]
    apart = before.xy[:, None] - before.xy
    distance = np.linalg.norm(apart, axis=2)
    push = 3 * np.maximum(EVADING - distance, 0.0) / np.maximum(distance, 0.05)
    np.fill_diagonal(push, 0.0)
    push *= before.present
    wanted = ahead + (push[..., None] * apart).sum(axis=1)
    speed = np.linalg.norm(wanted, axis=1)
    return np.asarray(wanted * np.minimum(FASTEST / np.maximum(speed, 1e-9), 1.0)[:, None])


def _shape(rng: np.random.Generator) -> Array:
    """Points on ellipsoids for head, trunk and hips of a body of height 1, x forward: (P, 3)."""
    parts = (
        ((0, 0, 0.93), (0.09, 0.08, 0.065), 40),
        ((0, 0, 0.70), (0.13, 0.23, 0.14), 80),
        ((0, 0, 0.52), (0.11, 0.18, 0.08), 40),
    )
    found = []
    for middle, half, count in parts:
        way = rng.normal(size=(count, 3))
        found.append(np.array(middle) + way / np.linalg.norm(way, axis=1)[:, None] * half)
    return np.concatenate(found)


def _limbs(stride: Array, jumping: Array) -> Array:
    """Points of legs and arms that swing, over the height: (N, P, 3). jumping: (N,) bool, raised arms."""
    along = np.linspace(0, 1, 14)[:, None]
    swing, zero = 0.28 * np.sin(stride), np.zeros(len(stride))
    lifted = 0.45 + 0.6 * jumping
    found = []
    for side in (1, -1):
        hip, foot = (zero, side * 0.09, 0.5), (side * swing, side * 0.09, 0.0)
        shoulder, hand = (zero, side * 0.216, 0.8), (-0.8 * side * swing, side * 0.243, lifted)
        for start, end in ((hip, foot), (shoulder, hand)):
            a, b = (np.stack(np.broadcast_arrays(*one), axis=1)[:, None] for one in (start, end))
            found.append(a + (b - a) * along)
    return np.concatenate(found, axis=1)
