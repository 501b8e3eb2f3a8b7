"""The error policy of a stage that raises: the run fails, the message is skipped, or it is built again."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from followspot.errors import FollowspotError, shown
from followspot.frame_times import to_seconds
from followspot.graph.plan import ErrorPolicy
from followspot.messages import Header
from followspot.stage import Stage
from followspot.worker.runners.forked_copy import set_up
from followspot.worker.runners.runner_count import RunnerCount

RAISED = BaseException
"""Type of the errors of stages that are handled: some libraries call `sys.exit`, and asyncio and extensions
in Rust raise errors that are not an `Exception`; each would end the worker, or the thread of a live source,
without a message."""
RESTARTS = 5
"""How often a stage with policy `restart` is rebuilt before the run fails."""
FIRST_BACK_OFF = 0.1
"""Pause before the first restart, s; it doubles each time."""
_LONGEST_TEXT, _LONGEST_FAILURE = 4_000, 16_000
"""Characters of an error's text, and of a failure with its traceback, that are told whole: a library may put
all the bytes that it cannot read into its error."""


class StageError(FollowspotError):
    """A stage raised; the text names the stage, the message it was given, and shows the traceback."""

    def __init__(self, stage: str, header: Header | None, error: BaseException) -> None:
        when = f" at {header.source}#{header.seq}, {to_seconds(header.time):.6f} s" if header else ""
        detail = "" if isinstance(error, FollowspotError) else _traceback(error)
        text = shown(text_of(error), _LONGEST_TEXT)
        super().__init__(shown(f"stage {stage} failed{when}: {text}{detail}", _LONGEST_FAILURE))


class Failing(Protocol):
    """The runner of a stage that raised. build: makes the stage again."""

    name: str
    stage: Stage
    build: Callable[[], Stage]
    on_error: ErrorPolicy
    count: RunnerCount


def recover(runner: Failing, header: Header, error: BaseException) -> None:
    """Apply the error policy of the stage. Raises StageError if the run is to fail.

    header: of the message that the stage was given.
    """
    policy = runner.on_error
    if policy == "fail" or (policy == "restart" and runner.count.restarts >= RESTARTS):
        raise StageError(runner.name, header, error) from error
    runner.count.skipped += 1
    runner.stage.context.warn(str(StageError(runner.name, header, error)))
    if policy == "restart":
        try:
            _restart(runner)
        except RAISED as second:
            raise StageError(runner.name, header, second) from error


def _restart(runner: Failing) -> None:
    """Build the stage again after a pause; it restores the checkpoint of the old one, if there is one."""
    runner.stage.context.pause(FIRST_BACK_OFF * 2**runner.count.restarts)
    runner.count.restarts += 1
    state = runner.stage.state()
    runner.stage.close()
    runner.stage = runner.build()
    runner.stage.context = replace(runner.stage.context, resumed=True)
    set_up(runner.stage).forget()
    if state is not None:
        runner.stage.restore(state)


def text_of(error: BaseException) -> str:
    """Type and text of an error that a stage raised, whose own `__str__` may fail."""
    try:
        text = str(error)
    except Exception:
        text = "its text cannot be read"
    return f"{type(error).__name__}: {text}"


def _traceback(error: BaseException) -> str:
    return "\n" + "".join(traceback.format_exception(error)).rstrip()
