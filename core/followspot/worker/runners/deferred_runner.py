"""Runs a stage whose answers come later (`Deferred`)."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from typing import Any

from followspot.errors import FollowspotError
from followspot.message_checks.outputs import WrongOutput
from followspot.messages import Header
from followspot.stage import Stage
from followspot.transport.token import UNKNOWN
from followspot.worker.runners.answer_pool import AnswerPool
from followspot.worker.runners.error_policy import RAISED, recover
from followspot.worker.runners.stage_runner import StageRunner

_ANSWER_TIMEOUT = 5.0
"""Seconds for which answers are awaited after a run was stopped."""


class DeferredRunner(StageRunner):
    """Asks the stage for up to `concurrency` answers at once, and sends them in the order of the firings.

    Until the oldest answer is there, the outputs announce nothing beyond its capture time. So the streams
    alone decide what is sent and in which order, however long an answer takes.
    """

    concurrency = 1

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._pool: AnswerPool | None = None
        self._answers: deque[tuple[Future[Any], Header, Stage]] = deque()
        self._replaced: list[Stage] = []
        """Former stages that still owe answers."""
        self._give_up_at: float | None = None
        self.answered: Callable[[], None] = lambda: None
        """Called in any thread when an answer has come."""

    @property
    def asks(self) -> bool:
        """Whether answers are under way."""
        return bool(self._answers)

    def fire(self) -> bool:
        """Send the answers that are there, and ask for more. Raises StageError if the policy is `fail`."""
        while (fire_at := self.due()) is not None:
            firing = self.take(fire_at)
            future = self._asked(self.run(firing), firing.header)
            self._answers.append((future, firing.header, self.stage))
            future.add_done_callback(lambda _: self.answered())
        return False

    def due(self) -> int | None:
        """Send the answers that have come; then see `StageRunner.due`."""
        self._send_answers()
        if self.blocked or len(self._answers) >= self.concurrency:
            return None
        fire_at = super().due()
        if self._answers and self._give_up_at is not None:
            self.overdue_at = self._give_up_at
        return fire_at

    def limit_wait(self) -> None:
        """Give up answers that do not come soon: the run was stopped."""
        self._give_up_at = time.monotonic() + _ANSWER_TIMEOUT
        self.overdue_at = self._give_up_at

    def retire(self, stage: Stage) -> None:
        """Close a stage that was replaced as soon as its last answer has come."""
        self._replaced.append(stage)
        self._close_replaced()

    def close(self) -> None:
        """Cancel the answers that are under way and close the stage. Raises StageError."""
        for future, _, _ in self._answers:
            future.cancel()
        self._answers.clear()
        self._close_replaced()
        if self._pool is not None:
            self._pool.close()
            self._pool = None
        self.answered = lambda: None
        super().close()

    def _asked(self, result: Any, header: Header) -> Future[Any]:
        """The future of what `process` returned; one that is there already if it has nothing to say."""
        if isinstance(result, Future):
            return result
        if callable(result):
            if self._pool is None:
                self._pool = AnswerPool(self.name, self.concurrency)
            return self._pool.submit(result)
        if result is not None:
            wrong = f"returned a {type(result).__name__}, declared Deferred: return a future or a function"
            recover(self, header, WrongOutput(wrong))
        nothing: Future[Any] = Future()
        nothing.set_result(None)
        return nothing

    def _send_answers(self) -> None:
        """Send the answers that have come, in the order of the firings, as far as the outputs have room."""
        self.blocked = False
        while self._answers:
            future, header, _ = self._answers[0]
            if not future.done() and not self._timed_out():
                return
            if not self.outputs.has_room():
                self.blocked = True
                return
            self._answers.popleft()
            self.deliver(self._result(future, header), header)
            self._close_replaced()

    def _result(self, future: Future[Any], header: Header) -> Any:
        """The answer, None if it failed. Raises StageError if the policy is `fail`."""
        if not future.done():
            future.cancel()
            self._skip(header, f"did not come within {_ANSWER_TIMEOUT:g} s of the stop")
            return None
        try:
            return future.result()
        except CancelledError:
            if self._give_up_at is None:
                recover(self, header, FollowspotError("the answer was cancelled"))
            else:
                self._skip(header, "was cancelled at the stop")
        except RAISED as error:
            recover(self, header, error)
        return None

    def _skip(self, header: Header, why: str) -> None:
        self.count.skipped += 1
        self.stage.context.warn(f"the answer to {header.source}#{header.seq} {why}")

    def _timed_out(self) -> bool:
        return self._give_up_at is not None and time.monotonic() >= self._give_up_at

    def _idle(self) -> None:
        """Without a firing, pass the watermark on or end, unless answers are under way."""
        if self._answers:
            self.join.relieve_backpressure(self.join.watermark())
        else:
            super()._idle()

    def _following(self) -> int:
        """Nothing is known while answers are under way: their capture times are earlier."""
        return UNKNOWN if self._answers else super()._following()

    def _close_replaced(self) -> None:
        for stage in tuple(self._replaced):
            if not any(asked is stage for _, _, asked in self._answers):
                self._replaced.remove(stage)
                super().retire(stage)
