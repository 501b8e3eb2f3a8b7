"""The position of a reader in its writer's stream: the next token, and the messages that it has consumed.

Every token carries three numbers (`NUMBER`): incarnation of the writer, number of the token, and number of
messages up to and with it. Gaps in these numbers are messages that never came.
"""

from __future__ import annotations

_CUTS = 64
"""Cuts in a row, each with a full edge, that may lie behind a start; a larger count is refused."""

Numbers = tuple[int, ...]


class StreamPosition:
    """Checks the numbers of starts and tokens. limit: most tokens that may be under way."""

    def __init__(self, limit: int) -> None:
        self.writer = -1
        """Incarnation of the writer that told the start; -1 before the first."""
        self.tokens = 0
        """Tokens of this writer so far."""
        self.joined = False
        """Whether the writer knows of this reader: other tokens are not for it."""
        self.refused = 0
        """Starts and tokens whose numbers cannot be those of the writer; no ledger counts them."""
        self._limit = limit
        self.messages = 0
        """Messages of this writer so far."""
        self._got = 0
        """Messages from this writer, or `Invalid`s in their place."""
        self._unread = 0
        """Messages in the queue from a former writer: the present one gets no credit for them."""
        self._consumed = 0

    @property
    def consumed(self) -> int:
        """Messages consumed, in the writer's numbers: those before this reader joined count as consumed."""
        return self.messages - self._got + self._consumed

    def consume(self, count: int) -> None:
        """Note that messages left the queue."""
        former = min(count, self._unread)
        self._unread -= former
        self._consumed += count - former

    def start(self, numbers: Numbers | None, newest: int) -> int | None:
        """Join where a writer says: at its stream, or at the rest after the link was cut.

        newest: latest incarnation of a writer that is there. Returns how many messages are missing before;
        None if the start is refused, or comes from a writer that another has replaced.
        """
        if numbers is None or not self._possible(*numbers):
            self.refused += 1
            return None
        writer, number, messages, given = numbers
        if writer < max(self.writer, newest):
            return None
        if writer > self.writer:
            self._unread += self._got - self._consumed
            self.writer, self._got, self._consumed = writer, 0, 0
        missing = max(0, given - self._got)
        self._got += missing
        self.tokens, self.messages, self.joined = number, messages, True
        return missing

    def left(self, writer: int) -> None:
        """Note that a writer left."""
        self.joined &= writer != self.writer

    def follows(self, numbers: Numbers) -> bool:
        """True if a token with these numbers may come next; False if it is refused or not for this reader."""
        writer, number, messages = numbers
        if not self.joined or writer != self.writer:
            return False
        skipped, new = number - self.tokens, messages - self.messages
        if not 0 <= skipped <= self._limit or not 0 <= new <= skipped + 1:
            self.refused += 1
            return False
        return True

    def advance(self, numbers: Numbers, *, message: bool) -> int | None:
        """Take the next token: how many messages are missing before it, None if it is refused.

        message: whether it is a message, not a watermark.
        """
        _, number, messages = numbers
        new = messages - self.messages
        if new < message:
            self.refused += 1
            return None
        self.tokens, self.messages = number + 1, messages
        self._got += new
        return new - message

    def _possible(self, writer: int, number: int, messages: int, given: int) -> bool:
        """Whether a start is possible: its counts agree, and those of one writer never decrease."""
        if not given <= messages <= number:
            return False
        if writer != self.writer:
            return given <= _CUTS * self._limit
        forward = number >= self.tokens and messages >= self.messages
        return forward and given - self._got <= _CUTS * self._limit
