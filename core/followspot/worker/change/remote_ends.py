"""The ends of edges to other workers that come and go with a new plan while a worker runs.

New ends are made beside those that work. Old ones stay open until all workers have taken the plan over: one
that saw such an edge close would take its stream for ended.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import groupby

from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.token import END, Watermark
from followspot.worker.build import Builder
from followspot.worker.ledger import COLUMNS
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler


class RemoteEnds:
    """Adds and removes a worker's ends of edges to other workers.

    builder: of the new plan, with the queues of all its edges and the writers of its new stages; stays: the
    stage runners that stay.
    """

    def __init__(self, scheduler: Scheduler, builder: Builder, stays: Mapping[str, StageRunner]) -> None:
        """Make the writers of new edges from stages that stay; their readers are not written to yet."""
        self._scheduler = scheduler
        self._builder = builder
        self._stays = stays
        self._more: list[tuple[StageRunner, OutputPort, PortWriter, list[int]]] = []
        self._old: list[PortReader | PortWriter] = []
        for runner in stays.values():
            for port, output in runner.outputs:
                self._more += self._added(runner, port, output)

    def _added(
        self, runner: StageRunner, port: str, output: OutputPort
    ) -> Iterator[tuple[StageRunner, OutputPort, PortWriter, list[int]]]:
        """A writer for the new edges of one output port that have the same way."""
        wiring, builder = self._builder.wiring, self._builder
        known = {row // COLUMNS for rows in output.rows for row in rows}
        new = [
            number
            for number in wiring.out_of[runner.name]
            if wiring.plan.edge(number).from_port == port
            and wiring.plan.edge(number).kind != "reference"
            and number not in known
        ]
        for _, group in groupby(sorted(new, key=builder.writer_key), key=builder.writer_key):
            numbers = list(group)
            writer = builder.edge_factory.writer(numbers, wiring.plan.edge(numbers[0]).kind)
            yield runner, output, writer, numbers

    def exchange(self, new: Mapping[str, StageRunner]) -> None:
        """Poll and write to the ends of the new plan, and no longer to those of edges that go.

        new: the stage runners that come.
        """
        ends, builder = self._scheduler.ends, self._builder
        kept = set(builder.inputs.queues.values())
        gone = [queue for queue in ends.readers if queue not in kept]
        self._old += [queue.reader for queue in gone if queue.reader is not None]
        staying = set(self._stays.values())
        left = [writer for writer, owner in ends.writers if owner not in staying]
        for runner in staying:
            for _, output in runner.outputs:
                left += runner.exchange(output, partial(self._dismissed, output))
        ends.remove(gone, left)
        self._old += left
        come = [queue for queue in builder.inputs.queues.values() if queue.reader is not None]
        writers = [(writer, new[name]) for writer, name in builder.writers.items()]
        for runner, output, writer, numbers in self._more:
            names = [builder.plan.edge(number).name for number in numbers]
            rows = [builder.ledger.row(number) for number in numbers]
            runner.exchange(output, partial(output.attach, writer, names, rows))
            if output.announced > -END:
                writer.send(Watermark(output.announced))
            writers.append((writer, runner))
        ends.add([queue for queue in come if queue not in ends.readers], writers)

    def _dismissed(self, output: OutputPort) -> list[PortWriter]:
        """Let the edges of a port go that the new plan lacks; returns writers without any other reader."""
        stay = {self._builder.ledger.row(number) for number, _ in self._builder.plan.numbered()}
        rows = {row for own in output.rows for row in own if row >= 0} - stay
        left = []
        for writer, indices in output.detach(rows) if rows else ():
            if writer not in output.writers:
                left.append(writer)
            else:
                self._scheduler.ends.dismiss(writer, indices)
        return left

    def close_old(self) -> None:
        """Close the ends that are no longer used: all workers have the new plan."""
        for end in self._old:
            if isinstance(end, RingReader):
                end.hand_over()
        for end in self._old:
            end.close()
        self._old = []
