"""Numbers of control tokens of edges: true, a little off, or extreme."""

from __future__ import annotations

import random
from struct import Struct
from typing import NamedTuple

from fuzzing.extreme import extreme_integer


class Numbers(NamedTuple):
    """Numbers of a control token, (relative, number) each.

    A relative number is added to the true one at the time of sending; any other is sent as it is. noise:
    bytes to send instead.
    """

    layout: Struct
    parts: tuple[tuple[bool, int], ...]
    noise: bytes | None = None

    def packed(self, true: int) -> bytes:
        """The packed message, or the noise. true: the number that a correct sender would send."""
        if self.noise is not None:
            return self.noise
        return self.layout.pack(*(max(0, true + n) if relative else n for relative, n in self.parts))

    @classmethod
    def some(cls, layout: Struct, rng: random.Random) -> Numbers:
        """Numbers that are true, off by one, zero or extreme; in one of 20 cases noise."""
        near = [(True, 0), (True, 1), (True, -1), (False, 0)]
        most = (1 << 64) - 1
        parts = [rng.choice((*near, (False, extreme_integer(rng, 0, most)))) for _ in range(layout.size // 8)]
        noise = rng.randbytes(rng.choice((0, layout.size - 1, layout.size + 1, 5000)))
        return cls(layout, tuple(parts), noise if rng.random() < 0.05 else None)
