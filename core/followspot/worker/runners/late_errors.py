"""What a live source raises after the run asked it to end: it is told, and does not fail the run."""

from __future__ import annotations

import errno

from followspot.errors import shown
from followspot.stage import Stage
from followspot.worker.runners.error_policy import text_of

_TAKEN_AWAY = {
    errno.EBADF,
    errno.ECANCELED,
    errno.ECONNABORTED,
    errno.ECONNRESET,
    errno.ENODEV,
    errno.ENOTCONN,
    errno.EPIPE,
    errno.ESHUTDOWN,
}
"""Errors of the operating system if a file, socket or device is closed while a thread waits for it."""
_CLOSED = ("closed file", "file descriptor cannot be a negative integer")
"""Parts of the texts of ValueErrors of Python for the same."""
_LONGEST_TEXT = 4_000
"""Characters of an error's text that are told."""


def tell_late_error(stage: Stage, error: BaseException) -> None:
    """Write to the stage's log that `close` ended its wait; warn of any other error."""
    text = shown(text_of(error), _LONGEST_TEXT)
    if ends_a_wait(error):
        stage.log.info("close ended its wait: %s", text)
    else:
        stage.context.warn(f"raised after it was asked to end: {text}")


def ends_a_wait(error: BaseException) -> bool:
    """Whether it is what a wait raises if another thread closes what it waits for."""
    if isinstance(error, OSError):
        return error.errno in _TAKEN_AWAY
    if isinstance(error, ValueError):
        return any(part in text_of(error) for part in _CLOSED)
    return isinstance(error, EOFError)
