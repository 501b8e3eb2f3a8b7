"""A source of messages one of which names what is not there. Loaded with --plugin."""

from __future__ import annotations

import numpy as np

from followspot import Array, Message, Source, Stage, at, column


class Seen(Message):
    names: tuple[str, ...]
    name: Array = column("N", dtype="i4", refers="names")


class See(Stage):
    """Sees two things in turn, and once a third one, which has no name."""

    def process(self) -> Source[Seen]:
        for number, name in enumerate((0, 1, -1, 1)):
            yield at(number * 10_000_000, Seen(("ball", "lamp"), np.array([name], "i4")))
