"""Signals that end a command as Ctrl-C does."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread


@contextmanager
def ending_as_on_ctrl_c() -> Iterator[None]:
    """Take SIGTERM and the end of the terminal for Ctrl-C while the block runs: KeyboardInterrupt.

    So a command that is ended by `timeout` or a closed window removes its temporary files, too. Signals that
    are ignored, as below nohup, stay so.
    """
    ends = (signal.SIGTERM, signal.SIGHUP) if current_thread() is main_thread() else ()
    taken = [number for number in ends if signal.getsignal(number) == signal.SIG_DFL]
    for number in taken:
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)
