"""The stages of a worker that are scheduled, and the order in which they fire: nearest to the sinks first."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush

from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.runners.batch_group import BatchGroup, batch_groups
from followspot.worker.runners.stage_runner import StageRunner

_FIRINGS = 32
"""Largest number of firings before the worker receives from other workers."""


class Schedule:
    """Stage runners whose inputs or outputs changed; each has the rank of its place in topological order.

    ready: negative ranks as a heap, so that the stage nearest to the sinks comes first.
    """

    def __init__(self) -> None:
        self.ready: list[int] = []
        self._marked: list[bool] = []
        self._runners: Sequence[StageRunner] = ()
        self._in_rounds = False
        self._steps: list[Callable[[], None]] = []
        self._batch_groups: Sequence[BatchGroup] = ()

    def arrange(self, runners: Sequence[StageRunner], *, in_rounds: bool) -> None:
        """Take these runners in place of all others; none of them is scheduled before it is marked.

        in_rounds: whether each ready stage fires once before another fires again, so that a stage with
        endless work lets others fire; if not, the one nearest to the sinks fires as often as it can.
        """
        self.ready = []
        self._marked = [False] * len(runners)
        self._runners, self._in_rounds = runners, in_rounds
        self.regroup()

    def regroup(self) -> None:
        """Form the batch groups anew, after stages were replaced: alike stages fire together."""
        self._batch_groups = batch_groups(self._runners, self.mark)
        self._steps = [
            partial(self._fire_once, runner) if self._in_rounds else runner.step for runner in self._runners
        ]
        for group in self._batch_groups:
            for runner in group.runners:
                self._steps[runner.rank] = partial(group.step, runner)

    def mark(self, rank: int) -> None:
        """Schedule this stage runner: its inputs or outputs changed."""
        if not self._marked[rank]:
            self._marked[rank] = True
            heappush(self.ready, -rank)

    def mark_waiting(self, runner: StageRunner, queue: InputQueue) -> None:
        """Schedule this stage runner after something came to a sampled input.

        Without messages to fire with it is not scheduled, unless the edge is full.
        """
        if runner.done or len(queue.messages) >= queue.depth:
            self.mark(runner.rank)
            return
        for queue in runner.join.members:
            if queue.messages:
                self.mark(runner.rank)
                return

    def fire(self) -> None:
        """Let scheduled stage runners step. Raises StageError."""
        if self._in_rounds:
            self._fire_round()
            return
        for _ in range(_FIRINGS):
            if not self.ready:
                break
            rank = -heappop(self.ready)
            self._marked[rank] = False
            self._steps[rank]()

    def fire_overdue(self) -> None:
        """Let joins whose deadline has passed fire without the missing messages, now or in their turn.

        Raises StageError.
        """
        now = time.monotonic()
        for runner in self._runners:
            if runner.overdue_at is not None and runner.overdue_at <= now and not runner.done:
                runner.gives_up = True
                if not self._marked[runner.rank]:
                    self._steps[runner.rank]()

    def fire_waiting(self) -> bool:
        """Fire the ready members of a batch group without the others; False if no member waits."""
        for group in self._batch_groups:
            if group.waiting:
                group.fire()
                return True
        return False

    def _fire_round(self) -> None:
        """Let each stage runner step at most once; one that is scheduled again waits for the next round."""
        stepped: set[int] = set()
        later: list[int] = []
        while self.ready:
            negative = heappop(self.ready)
            if negative in stepped:
                later.append(negative)
                continue
            stepped.add(negative)
            self._marked[-negative] = False
            self._steps[-negative]()
        self.ready = sorted(later)

    def _fire_once(self, runner: StageRunner) -> None:
        if runner.fire():
            self.mark(runner.rank)
