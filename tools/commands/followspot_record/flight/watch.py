"""Conditions that mark a moment when they begin to hold."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from followspot.errors import InputError, Mistake
from followspot.graph.output_ports import chosen_ports
from followspot.graph.plan import Plan
from followspot.library.handle import RunStatus
from followspot.messages import Message
from followspot.wire import unpack
from followspot_record.flight.condition import OPTION, Condition, split_condition
from followspot_record.flight.figures import LEDGER, losses


class _Watched:
    """A condition at one port, and whether it held last."""

    def __init__(self, port: str, condition: Condition) -> None:
        self.port = port
        self.condition = condition
        self._held = False

    def begins(self, message: Message | None, losses: Mapping[str, int]) -> bool:
        """Whether it holds now and did not before."""
        before, self._held = self._held, self.condition.holds(message, losses)
        return self._held and not before


class ConditionWatch:
    """Watches the conditions of a run; each marks when it begins to hold, not while it goes on to.

    mark: takes the text of a condition; types: of the messages, by port that is kept.
    """

    def __init__(
        self,
        texts: Sequence[str],
        plan: Plan,
        types: Mapping[str, type[Message]],
        mark: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Raises InputError with every mistake."""
        self._mark = mark
        self._types = types
        self._of_messages: dict[str, list[_Watched]] = defaultdict(list)
        self._of_ledger: list[_Watched] = []
        self._totals: dict[str, Mapping[str, int]] = {}
        self._losses: dict[str, Mapping[str, int]] = defaultdict(lambda: dict.fromkeys(LEDGER, 0))
        mistakes: list[Mistake] = []
        for text in texts:
            try:
                self._add(text, plan)
            except InputError as error:
                mistakes += error.mistakes
        if mistakes:
            raise InputError(mistakes)

    def take(self, port: str, packed: bytes) -> None:
        """Look at a message. Raises InvalidMessage."""
        if watched := self._of_messages.get(port):
            message = unpack(packed, self._types[port])
            if isinstance(message, Message):
                self._check(watched, message)

    def check(self, status: RunStatus, plan: Plan) -> None:
        """Look at the ledger for losses since the last look."""
        edges = list(status.edges(plan))
        for port in {*self._of_messages, *(watched.port for watched in self._of_ledger)}:
            total = losses(edges, port)
            before = self._totals.get(port, total)
            self._losses[port] = {name: total[name] - before[name] for name in LEDGER}
            self._totals[port] = total
        self._check(self._of_ledger, None)

    def _add(self, text: str, plan: Plan) -> None:
        word, source = split_condition(text)
        for port in chosen_ports(word, self._types, OPTION, plan.offered):
            condition = Condition(source, self._types[port], plan.room)
            watched = _Watched(port, condition)
            (self._of_messages[port] if condition.in_messages else self._of_ledger).append(watched)

    def _check(self, conditions: Sequence[_Watched], message: Message | None) -> None:
        for watched in conditions:
            if watched.begins(message, self._losses[watched.port]):
                self._mark(watched.condition.text)
