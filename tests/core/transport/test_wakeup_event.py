"""Wakeup events that are closed while others set them."""

from __future__ import annotations

import os
import threading

import pytest

from followspot.transport.wakeup_event import WakeupEvent


def test_a_signal_handler_may_set_a_wakeup_event_that_its_thread_is_closing() -> None:
    wakeup = WakeupEvent()

    def interrupted() -> None:
        with wakeup._lock:  # as `close` does
            wakeup.set()
        wakeup.close()

    closing = threading.Thread(target=interrupted, daemon=True)
    closing.start()
    closing.join(20)
    assert not closing.is_alive()


def test_a_closed_wakeup_event_does_not_touch_the_next_owner_of_its_descriptor() -> None:
    wakeup = WakeupEvent()
    number = wakeup.fileno()
    wakeup.close()
    other = WakeupEvent()
    assert other.fileno() == number
    wakeup.set()
    with pytest.raises(BlockingIOError):
        os.eventfd_read(number)
    other.close()
