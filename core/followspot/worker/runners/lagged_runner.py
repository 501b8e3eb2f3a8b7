"""Runs a stage that gives messages for earlier firings (`Lagged`)."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from followspot.message_checks.outputs import WrongOutput, check_one_of_several, several
from followspot.messages import UNSTAMPED, Header, in_range
from followspot.transport.token import END
from followspot.worker.runners.error_policy import RAISED, recover
from followspot.worker.runners.outputs_runner import OutputsRunner


class LaggedRunner(OutputsRunner):
    """Sends what the stage gives with the headers of the firings that it belongs to.

    Only a message announces what is settled: until the next one, its readers wait. When the inputs have
    ended, the stage gives what it still owes.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._owed: deque[Header] = deque()
        """Headers of the firings after the newest message."""
        self._last: Header | None = None
        """Header of the last firing, until what remains has been asked for."""

    def deliver(self, result: Sequence[Any], header: Header) -> None:
        """End a firing: send its results, or keep those for which there is no room yet."""
        self._owed.append(header)
        self._last = header
        super().deliver(result, header)

    def _stamped(self, items: Sequence[Any], firing: Header) -> Iterator[tuple[Any, Header]]:
        for item in items:
            given = check_one_of_several(self.declared, item)
            if given is UNSTAMPED or not self._newest < given.time <= firing.time:
                at = "no time" if given is UNSTAMPED else f"{given.time} ns"
                raise WrongOutput(
                    f"gave a message for {at} at {firing.time} ns, after one for {self._newest} ns: times"
                    " rise up to that of the firing; write at(time_ns, message)"
                )
            self._newest = given.time
            yield item, in_range(self._header(given, firing))

    def _header(self, given: Header, firing: Header) -> Header:
        """Header of the earlier firing that a message belongs to, by its capture time.

        A firing before the worker was started again is not known: its message gets the number that the stage
        gives it, else that of this firing.
        """
        while self._owed and self._owed[0].time < given.time:
            self._owed.popleft()
        if self._owed and self._owed[0].time == given.time:
            return self._owed.popleft()
        seq = firing.seq if given.seq < 0 else given.seq
        return Header(firing.source, seq, given.time, firing.entered)

    @property
    def owed(self) -> Sequence[Header]:
        """See `StageRunner.owed`."""
        return tuple(self._owed)

    def owe(self, headers: Sequence[Header]) -> None:
        """Carry on from firings of an earlier instance, whose messages are yet to come."""
        self._owed.extend(headers)

    def leave(self) -> None:
        """See `StageRunner.leave`; then send the remaining messages of the stage."""
        super().leave()
        self._send_remaining()

    def _idle(self) -> None:
        """Without a firing, wait; at the end of the inputs, first send the remaining messages."""
        if self.join.watermark() == END:
            self._send_remaining()
        if not self._unsent:
            super()._idle()

    def _send_remaining(self) -> None:
        """Send the messages that the stage gives when no firing follows, once."""
        if self._last is None:
            return
        firing, self._last = self._last, None
        try:
            self._unsent.extend(self._stamped(tuple(several(self.stage.remaining())), firing))
        except RAISED as error:
            recover(self, firing, error)
        self._send_waiting()

    def _announce(self, watermark: int) -> None:
        """Announce nothing: messages for earlier firings are still owed."""
