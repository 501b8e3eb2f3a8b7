"""Runs a stage that gives several messages for one firing (`Outputs`)."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

from followspot.message_checks.outputs import WrongOutput, check_one_of_several, several
from followspot.messages import UNSTAMPED, Header, in_range
from followspot.transport.token import END
from followspot.worker.runners.error_policy import RAISED, recover
from followspot.worker.runners.stage_runner import FiringInputs, StageRunner

MAX_OUTPUTS = 10_000
"""Most messages for one firing; a generator that goes on for ever ends there."""


class OutputsRunner(StageRunner):
    """Sends the messages of a firing one by one, as the outputs have room, before the next firing."""

    _newest = -END
    """Capture time of the newest message, ns."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._unsent: deque[tuple[Any, Header]] = deque()

    def due(self) -> int | None:
        """See `StageRunner.due`; None as long as messages of the last firing wait."""
        self._send_waiting()
        return None if self._unsent else super().due()

    def run(self, firing: FiringInputs) -> Sequence[Any]:
        """All results of the firing, none if the stage raised. Raises StageError if the policy is `fail`."""
        result = super().run(firing)
        if result is None:
            return ()
        started = time.monotonic_ns()
        try:
            items = tuple(islice(several(result), MAX_OUTPUTS + 1))
            if len(items) > MAX_OUTPUTS:
                raise WrongOutput(f"gave more than {MAX_OUTPUTS} messages for one")
        except RAISED as error:
            recover(self, firing.header, error)
            items = ()
        self.count.busy_ns += time.monotonic_ns() - started
        return items

    def deliver(self, result: Sequence[Any], header: Header) -> None:
        """End a firing: send its results, or keep those for which there is no room yet."""
        self.count.fired += 1
        try:
            self._unsent.extend(self._stamped(result, header))
        except RAISED as error:
            recover(self, header, error)
        self._send_waiting()
        self.note_budget(header)

    def _stamped(self, items: Sequence[Any], firing: Header) -> Iterator[tuple[Any, Header]]:
        """Each item with its header. Raises WrongOutput or InvalidMessage at the first that is wrong."""
        for item in items:
            given = check_one_of_several(self.declared, item)
            at = firing.time if given is UNSTAMPED else given.time
            if at < firing.time or at <= self._newest:
                raise WrongOutput(
                    f"gave a message for {at} ns at {firing.time} ns, after one for {self._newest} ns:"
                    " times rise, from that of the firing on; write at(time_ns, message)"
                )
            self._newest = at
            seq = firing.seq if given.seq < 0 else given.seq
            yield item, in_range(Header(firing.source, seq, at, firing.entered))

    def _send_waiting(self) -> None:
        """Send the waiting messages, then announce that no message comes before the next possible firing."""
        while self._unsent:
            if not self.outputs.has_room():
                self.blocked = True
                return
            self.outputs.send(*self._unsent.popleft())
        self._announce(self.join.closed + 1)
