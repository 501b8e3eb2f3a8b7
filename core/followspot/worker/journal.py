"""The journal of a stage: which messages each firing takes, and checkpoints from which firings are repeated.

The journal holds what only the run knows: which messages came in time, were dropped or sampled, and which
stage with which parameters processed them. So a stage can be repeated without a clock and without the other
stages.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, stamped
from followspot.ports.firing import Firing
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, WindowInput
from followspot.worker.output_port import OutputPort
from followspot.worker.stage_checkpoint import Journaled, checkpoint_of, edges_into
from followspot.worker.tap_point import TapPoint

_INTERVAL = 1_000_000_000
"""Capture time between two checkpoints, ns."""


class _Note(NamedTuple):
    """The messages of joins and windows, by input, noted before a firing takes them."""

    checkpoint: bytes
    taken: Sequence[Sequence[tuple[int, int]]]


class Journal(TapPoint):
    """Notes the firings of a stage for its taps and for a recording; without both it costs nothing.

    output: leads to the recording; None without one.
    """

    def __init__(self, output: OutputPort | None = None) -> None:
        super().__init__()
        self._output = output
        self._number = 0
        self._newest: int | None = None
        """Capture time of the newest checkpoint, ns; None if the next firing has one."""
        self._rows: dict[int, int] = {}
        """Row in the checkpoint's edges by the row of an edge in the ledger."""
        self._join: Join | None = None
        """The join at the newest checkpoint; a swap of the stage or of its edges replaces the join."""

    def tap(self, by: Callable[[Message], None]) -> None:
        """See `TapPoint.tap`. The next firing begins with a checkpoint."""
        self._newest = None
        super().tap(by)

    @property
    def read(self) -> bool:
        """Whether a tap or a recording reads the journal."""
        return bool(self.taps) or self._output is not None

    def before(self, runner: Journaled, time: int) -> _Note:
        """Note the messages that the firing at this time, ns, will take; call before the firing."""
        newest, data = self._newest, b""
        if newest is None or runner.join is not self._join or abs(time - newest) >= _INTERVAL:
            self._newest, self._join = time, runner.join
            self._rows = {queue.row: row for row, (queue, _) in enumerate(edges_into(runner.join))}
            data = checkpoint_of(runner).model_dump_json().encode()
        return _Note(data, [self._coming(port, runner.join, time) for port in runner.join.ports])

    def after(self, runner: Journaled, header: Header, note: _Note, arguments: Sequence[object]) -> None:
        """Give the firing to all that read the journal; call after it took its messages.

        header: of what it sends.
        """
        rows = [
            row
            for port, argument, taken in zip(runner.join.ports, arguments, note.taken, strict=True)
            for row in (self._sampled(port, argument) or taken)
        ]
        found = np.array(rows, "i8").reshape(-1, 2)
        firing = Firing(
            np.frombuffer(note.checkpoint, "u1"), found[:, 0].astype("i4"), np.ascontiguousarray(found[:, 1])
        )
        firing = stamped(seal(firing), header._replace(source=runner.name, seq=self._number))
        self._number += 1
        for tap in self.taps:
            tap(firing)
        if self._output is not None:
            self._output.send(firing, firing.header)

    def _coming(self, port: JoinInput, join: Join, time: int) -> list[tuple[int, int]]:
        """Edge and capture time of the messages that the input of a join or a window gives, in its order."""
        if isinstance(port.sampled, WindowInput):
            found = [
                (self._rows[queue.row], message.header.time)
                for queue in port.sampled.queues
                for message in queue.messages
                if message.header.time <= time
            ]
            return sorted(found, key=lambda one: one[1])
        heads = [(queue, queue.messages[0].header.time) for queue in port.members if join.gives(queue, time)]
        return [(self._rows[queue.row], head) for queue, head in heads]

    def _sampled(self, port: JoinInput, argument: object) -> list[tuple[int, int]]:
        """Edge and capture time of the message that a sampled input gave, if it gave one that was sent."""
        if not isinstance(port.sampled, NewestInput | NearestInput) or not isinstance(argument, Message):
            return []
        if not argument.header.source:
            return []
        return [(self._rows[port.sampled.queue.row], argument.header.time)]
