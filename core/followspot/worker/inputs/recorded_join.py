"""The inputs of a stage whose recorded firings are repeated: each gets the messages that it had."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from followspot.messages import Message
from followspot.transport.token import END
from followspot.worker.inputs.join import Join


class RecordedFiring(NamedTuple):
    """time: capture time, ns; arguments: of `process`; fired: the messages of its joined inputs."""

    time: int
    arguments: Sequence[object]
    fired: Sequence[Message]


class RecordedJoin(Join):
    """Gives recorded firings in their order, as soon as the outputs have room."""

    def __init__(self) -> None:
        super().__init__((), lateness=0)
        self.coming: deque[RecordedFiring] = deque()

    def ready(self, *, overdue: bool = False) -> int | None:
        """Capture time, ns, of the next firing; None if none is left."""
        return self.coming[0].time if self.coming else None

    def take(self, time: int) -> tuple[list[object], list[Message]]:
        """The arguments of the next firing, and the messages that fired."""
        self.closed = time
        found = self.coming.popleft()
        return list(found.arguments), list(found.fired)

    def watermark(self) -> int:
        """Nothing is announced between two firings."""
        return -END
