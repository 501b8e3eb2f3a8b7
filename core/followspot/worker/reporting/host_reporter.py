"""Reports of a running worker to its host: progress, stages, checkpoints, log records."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from itertools import count

from followspot.control.checkpoint import state_to_data
from followspot.control.pipe import Channel, ChannelClosed
from followspot.control.swap import ChangeStatus
from followspot.control.worker_messages import ChangeAnswer, Log, Progress, StageCheckpoint, Stages
from followspot.log.collector import LogCollector
from followspot.worker.reporting.report import Warnings
from followspot.worker.reporting.stage_status import Idleness, paths_now, stages_now
from followspot.worker.scheduler import Scheduler

_PROGRESS_PERIOD = 0.2
"""Seconds between two reports of progress; each is a heartbeat."""
_STAGES_EVERY = 3
"""Reports of progress from one status of all stages to the next."""


class HostReporter:
    """Sends reports over the control channel, some from a thread of its own.

    log: its records are sent; warnings: the newest of each stage is part of the stage's status.
    """

    def __init__(self, channel: Channel, log: LogCollector, warnings: Warnings) -> None:
        self._channel = channel
        self._log = log
        self._warnings = warnings
        self._idleness = Idleness()
        self._over = threading.Event()
        self._sending_log = threading.Lock()

    def start(
        self, scheduler: Scheduler, on_closed: Callable[[], None], before_each: Callable[[], None]
    ) -> None:
        """Report progress from now on, in a thread.

        on_closed: called once if the host has closed the channel; before_each: called before each report.
        """
        arguments = scheduler, on_closed, before_each
        threading.Thread(target=self._send_progress, args=arguments, name="progress", daemon=True).start()

    def stop(self) -> None:
        """Report no more progress."""
        self._over.set()

    def send_log(self) -> None:
        """Send the new log records; on return, those that another thread has taken are sent as well.

        Safe from any thread. Raises ChannelClosed.
        """
        with self._sending_log:
            if records := self._log.take():
                self._channel.send(Log(records=tuple(records)))

    def send_crash(self) -> None:
        """Send the traceback of the exception that is being handled, which ends the worker."""
        with suppress(ChannelClosed):
            self._log.say("error", "", f"the worker breaks down\n{traceback.format_exc()}")
            self.send_log()

    def send_stages(self, scheduler: Scheduler) -> None:
        """Send the status of all stages. Raises ChannelClosed."""
        stages = tuple(self._idleness.noted(stages_now(scheduler, self._warnings.last)))
        self._channel.send(Stages(stages=stages, paths=paths_now(scheduler)))

    def send_states(self, scheduler: Scheduler) -> None:
        """Send a checkpoint of each stage that has a state; warn of a state that cannot be sent."""
        for runner in scheduler.runners:
            try:
                state = state_to_data(runner.stage.state())
            except Exception as error:  # stages may raise anything
                self._warnings.add(runner.name, f"its state cannot be kept: {error}")
                continue
            if state is not None:
                self._channel.send(StageCheckpoint(stage=runner.name, state=state))

    def send_change(self, status: ChangeStatus) -> None:
        """Send how far a hot swap is."""
        with suppress(ChannelClosed):  # the worker notices that when it next reads orders
            self._channel.send(ChangeAnswer(status=status))

    def _send_progress(
        self, scheduler: Scheduler, on_closed: Callable[[], None], before_each: Callable[[], None]
    ) -> None:
        """Report until `stop`, or until the host has closed the channel; in a thread."""
        for turn in count():
            if self._over.wait(_PROGRESS_PERIOD):
                return
            before_each()
            try:
                self._channel.send(_progress(scheduler))
                self.send_log()
                if turn % _STAGES_EVERY == 0:
                    self.send_stages(scheduler)
            except ChannelClosed:
                on_closed()
                return


def _progress(scheduler: Scheduler) -> Progress:
    """How far the worker has come: its sinks that still have inputs, else its stages without readers, else
    its sources.
    """
    sources = scheduler.sources.all
    fed = [runner for runner in scheduler.runners if runner.join.members]
    unread = [runner for runner in fed if not any(output.all_rows for _, output in runner.outputs)]
    ends = [runner for runner in fed if runner.is_sink] or unread
    fired = [runner.count.fired for runner in ends]
    counted = fired or [source.yielded for source in sources if not source.accompanying]
    return Progress(fired=min(counted, default=0), time=max((s.watermark for s in sources), default=-1))
