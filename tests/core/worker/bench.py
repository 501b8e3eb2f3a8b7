"""A stage between two edges, without a worker."""

from __future__ import annotations

from typing import Any

from followspot import Message, Stage
from followspot.messages import Header, stamped
from followspot.transport.token import END
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.ledger import Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.stage_runner import StageRunner


class Note(Message):
    value: int


class Bench:
    """A stage between two edges."""

    def __init__(self, kind: type[StageRunner], stage: Stage, depth: int = 100, **options: Any) -> None:
        ledger = Ledger(2)
        self.into = InputQueue("in", ledger.words, ledger.row(0), depth=100, lateness=0)
        self.out = InputQueue("out", ledger.words, ledger.row(1), depth=depth, lateness=0)
        port = OutputPort(Note, ledger.words, lateness=0)
        port.connect([self.out])
        join = Join([JoinInput("note", joined=False, members=(self.into,))], lateness=0)
        self.stage = stage
        self.runner = kind("asked", 0, lambda: stage, join, {"out": port}, **options)
        self.runner.setup()

    def put(self, *times: int) -> None:
        for time in times:
            self.into.put(stamped(Note(time), Header("a", time, time, 5)))
            self.runner.step()

    def end(self) -> None:
        self.into.advance(END)
        self.runner.step()

    def got(self) -> list[tuple[int, int]]:
        """Times and values of what was sent."""
        return [(one.header.time, one.value) for one in self.out.messages if isinstance(one, Note)]
