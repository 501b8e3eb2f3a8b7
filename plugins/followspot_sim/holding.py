"""How hands hold balls: before the body, or against it, where arms and body cover much of the ball."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_sim.rounds import BALL_FROM_HAND, WALK, Round, smoothstep

HOLDS = ("before", "under the arm", "belly", "chest", "side", "back")
"""Where a hand may hold a ball; a hand before the body sways, the others press the ball against it."""
HANDS = np.array([
    [0.0, 0.0, 0.0], [0.12, 0.27, 1.04], [0.3, 0.07, 1.01], [0.3, 0.07, 1.23], [0.06, 0.32, 0.88],
    [-0.32, 0.12, 0.98],
])  # fmt: skip
"""Left hands of each hold, forward, left and up, m; the first is not used."""
BALLS = np.array([
    BALL_FROM_HAND, [-0.1, -0.04, 0.08], [-0.06, 0.03, 0.04], [-0.06, 0.03, 0.05], [-0.01, -0.07, -0.05],
    [0.07, -0.04, 0.02],
])  # fmt: skip
"""Centres of balls from left hands, in the same order and directions, m."""
MIRROR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])
"""Left and right hand."""
AROUND = np.array([0.0, 0.2, 0.0])
"""By how much a left hand passes beside the body on its way from one hold to another, m."""
LET_GO, TAKE_AGAIN, SWING = 1.5, 2.6, 0.4
"""Times of a round at which people who act move the ball before the body, and back, and how long each way
takes, s."""


def holding(before: Array, act: Round, u: float) -> tuple[Array, Array]:
    """Hands of standing people at `u` seconds of a round, and balls from hands: (P, 2, 3) m, in their frames.

    before: (P, 2, 3) m, hands that hold balls before the body. People who act in this round move their hands
    there to act.
    """
    if not act.held.any():
        return before, np.broadcast_to(BALL_FROM_HAND, before.shape)
    hands, balls = HANDS[act.held] * MIRROR, BALLS[act.held] * MIRROR  # (2, P, 2, 3)
    hands = np.where((act.held == 0)[..., None], before, hands)
    s = float(smoothstep(u / WALK))
    moving = (act.held[0] != act.held[1])[..., None]
    around = 4 * s * (1 - s) * moving * AROUND * MIRROR
    free = float(smoothstep((u - LET_GO) / SWING)) - float(smoothstep((u - TAKE_AGAIN) / SWING))
    kept = 1.0 - free * act.acting()[:, None, None]
    hand = hands[0] + s * (hands[1] - hands[0]) + around
    ball = balls[0] + s * (balls[1] - balls[0])
    return before + kept * (hand - before), BALL_FROM_HAND + kept * (ball - BALL_FROM_HAND)
