"""A stage with inputs of some kinds, and the messages that it is given."""

from __future__ import annotations

from followspot.messages import Header, Message, stamped
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import SampledInput
from followspot.worker.ledger import PRODUCED, Ledger

MS = 1_000_000


class Tick(Message):
    """A number, to be told apart."""

    value: int


def tick(time: int, value: int = 0) -> Tick:
    return stamped(Tick(value), Header("test", value, time))


class Bench:
    """Some input queues with a ledger of their own."""

    def __init__(self, edges: int, *, lateness: int = 0) -> None:
        self.ledger = Ledger(edges)
        self.queues = [
            InputQueue(f"edge{n}", self.ledger.words, self.ledger.row(n), depth=100, lateness=lateness)
            for n in range(edges)
        ]

    def put(self, edge: int, message: Message) -> None:
        """As an output port of the same worker does."""
        self.ledger.words[self.ledger.row(edge) + PRODUCED] += 1
        self.queues[edge].put(message)

    def joined(self, window: int = 4 * MS, lateness: int | None = None) -> Join:
        port = JoinInput("all", joined=True, members=tuple(self.queues))
        self._let_differ(window)
        return Join([port], lateness=window if lateness is None else lateness)

    def plain(self, window: int = 4 * MS) -> Join:
        ports = [JoinInput(f"in{n}", joined=False, members=(queue,)) for n, queue in enumerate(self.queues)]
        self._let_differ(window)
        return Join(ports, lateness=window)

    def _let_differ(self, window: int) -> None:
        for queue in self.queues:
            queue.window = window


def fire(join: Join) -> list[object] | None:
    time = join.ready()
    return None if time is None else join.take(time)[0]


def windowed(bench: Bench, sampled: SampledInput) -> Join:
    main = JoinInput("in", joined=False, members=(bench.queues[0],))
    return Join([main, JoinInput("readings", joined=False, sampled=sampled)], lateness=0)


def values(argument: object) -> list[int]:
    return [message.value for message in argument]  # type: ignore[attr-defined]
