"""An output port: checks each message once, sends it along all edges of the port, and counts it."""

from __future__ import annotations

from followspot.context import SourceLoss
from followspot.message_checks.room_fit import FitCheck
from followspot.message_checks.sealing import seal
from followspot.messages import Header, InvalidMessage, Message, stamped
from followspot.transport.token import ABSENT, END, UNKNOWN, Watermark
from followspot.worker.ledger import AWAY, OVERRUN, PRODUCED, REFUSED, SOURCE_LOSSES
from followspot.worker.port_edges import PortEdges


class OutputPort(PortEdges):
    """One output port: checks and stamps each message once, and sends it along every edge.

    type: of its messages; lateness: see `InputQueue`.
    """

    __slots__ = ("_refused_at", "counts", "lateness", "type", "unfit", "watermark")

    def __init__(self, kind: type[Message], words: memoryview, *, lateness: int) -> None:
        super().__init__(words)
        self.type = kind
        self.lateness = lateness
        self.counts = True
        """Whether `send` counts messages as produced; a live source counts them in its thread."""
        self.watermark = self._refused_at = -END
        self.unfit: FitCheck | None = None
        """Says why a message does not fit the room; a reader in another worker asks again, for itself."""

    def send(self, message: Message | None, header: Header, following: int = UNKNOWN) -> None:
        """Stamp, check and send a message; it counts as invalid on every edge if it breaks its contract.

        message: None only advances the watermark; following: the watermark after it, ns, if more is known
        than what the message itself announces.
        """
        own = header.time + 1 + self.lateness
        if message is None:
            self.advance(max(own, following))
            return
        words = self.words
        if self.counts:
            for row in self.all_rows:
                words[row + PRODUCED] += 1
        try:
            if header.time < self.watermark:
                raise InvalidMessage(self._too_early(header.time))
            seal(message)  # also one that was sent before: copy.deepcopy makes arrays that can be written
            if self.unfit is not None and (why := self.unfit(message)):
                raise InvalidMessage(why)
        except InvalidMessage as error:
            self.invalid()
            self.refused(str(error))
            self.advance(max(header.time + 1, following))
            return
        if message.header is not header:
            message = stamped(message, header)
        if not self.filled and not message.is_empty:
            self.filled = True
            self._fill(self.all_rows)
        following = following if following > own else UNKNOWN
        self.watermark = self.announced = max(own, following)
        for tap in self.taps:
            tap(message)
        for queue in self.queues:
            queue.put(message)
            if following != UNKNOWN:
                queue.advance(following)
        for row in self._away:
            words[row + AWAY] += 1
        if self._living:
            self._write(message, following)

    def _too_early(self, time: int) -> str:
        """Why a time, ns, is refused; the same words for all that follow, which may be very many."""
        if self._refused_at == self.watermark:
            return "later times lie before that watermark, too"
        self._refused_at = self.watermark
        return f"time {time} ns lies before the watermark {self.watermark} ns"

    def advance(self, watermark: int) -> None:
        """Advance the watermark, ns, and tell every reader."""
        if watermark <= self.watermark:
            return
        self.watermark = self.announced = watermark
        for queue in self.queues:
            queue.advance(watermark)
        for writer in self.writers:
            writer.send(Watermark(watermark))

    def absent(self) -> None:
        """Announce that nothing comes for now, so that joins downstream do not wait."""
        if self.watermark == END:
            return
        self.announced = ABSENT
        for queue in self.queues:
            queue.advance(ABSENT)
        for writer in self.writers:
            writer.send(Watermark(ABSENT))

    def end(self) -> None:
        """End the stream."""
        self.advance(END)

    @property
    def count_produced(self) -> int:
        """The number of messages of this run that count as produced; 0 without an edge."""
        return max((self.words[row + PRODUCED] for row in self.all_rows), default=0)

    def produced(self) -> None:
        """Count a message that a live source has made; called in the source's thread."""
        self._count(self.all_rows, PRODUCED)

    def invalid(self) -> None:
        """Count a message that breaks its contract, and that counts as produced already."""
        self._count(self._present(), REFUSED)
        self._count(self._away, AWAY)

    def overrun(self) -> None:
        """Count a message that a live source has made and dropped; called in the source's thread."""
        self._count(self.all_rows, OVERRUN)

    def lost_at_source(self, kind: SourceLoss, number: int) -> None:
        """Count frames that were lost between a device and its source; called in the source's thread."""
        for row in self.all_rows:
            self.words[row + SOURCE_LOSSES[kind]] += number

    def _write(self, message: Message, following: int) -> None:
        """Send a message to other workers; edges on which its head is too large to travel refuse it."""
        for writer, rows in self._living:
            try:
                writer.send(message, following)
            except InvalidMessage as error:
                self._count(rows, REFUSED)
                self.refused(str(error))
                if following != UNKNOWN:
                    writer.send(Watermark(following))

    def _present(self) -> list[int]:
        """Ledger rows of every edge whose reader is present."""
        return [queue.row for queue in self.queues] + [row for _, rows in self._living for row in rows]
