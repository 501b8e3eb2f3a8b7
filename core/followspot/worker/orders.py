"""The orders of its host to a running worker: a stop takes effect at once, all others between two firings."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from functools import partial

from followspot.control.dispatch import Dispatcher, Handlers
from followspot.control.lifecycle import StopRun
from followspot.control.pipe import Channel, ChannelClosed, Received
from followspot.worker.process_end import end_process
from followspot.worker.scheduler import Scheduler

GRACE = 3.0
"""Seconds that a worker has to complete its outputs after its host has gone."""


class Orders:
    """Receives orders from the host, and passes each to its handler.

    handlers: called between two firings, in the worker's thread, with the order and its descriptors.
    """

    def __init__(
        self, channel: Channel, scheduler: Scheduler, handlers: Handlers, *, in_process: bool, restart: bool
    ) -> None:
        """in_process: the worker is a thread of its host; restart: the host restarts workers that die."""
        self._channel = channel
        self._scheduler = scheduler
        self._dispatcher = Dispatcher("worker", handlers)
        self._in_process = in_process
        self._restart = restart

    def listen(self, earlier: Sequence[Received]) -> None:
        """Carry out the orders that came before the start, and all that come from now on."""
        self._scheduler.ends.watch(self._channel.fileno(), self._arrived)
        self._scheduler.pace.watch(self._channel.fileno(), self._arrived)
        self._carry_out([*earlier, *self._channel.buffered()])

    def leave_soon(self) -> None:
        """Exit after `GRACE` seconds: the host has gone, and the outputs are completed by then or never."""
        if not self._in_process:
            threading.Thread(target=_exit_later, daemon=True).start()

    def _arrived(self) -> bool:
        """Receive orders; called when the channel is readable. True if the host has gone."""
        try:
            received = self._channel.arrived()
        except ChannelClosed:
            self.leave_soon()
            if self._restart:  # another worker will continue these streams, so they must not end
                self._scheduler.between_firings(_leave)
            self._scheduler.stop()
            return True
        if any(isinstance(order, StopRun) for order, _ in received):
            self._scheduler.stop()
        self._scheduler.between_firings(partial(self._carry_out, received))
        return False

    def _carry_out(self, received: Sequence[Received]) -> None:
        for order, descriptors in received:
            self._dispatcher.dispatch(order, *descriptors)


def _leave() -> None:
    """End the worker in the middle of its streams. Raises ChannelClosed."""
    raise ChannelClosed("the host has gone")


def _exit_later() -> None:
    """End the process after `GRACE` seconds, whatever the worker does."""
    time.sleep(GRACE)
    end_process(1)
