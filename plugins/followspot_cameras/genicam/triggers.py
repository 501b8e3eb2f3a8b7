"""Triggers of all cameras of a room at once: the features that wait for them, and what sends them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction

from followspot.errors import InputError
from followspot.frame_times import SECOND, exact_rate
from followspot.room import Sync
from followspot_cameras.genicam.features import Value

LINE, ACTION, SOFTWARE = "Line1", "Action1", "Software"
"""Sources of triggers, as SFNC names them."""
COMMAND = "TriggerSoftware"
ANSWER, NO_ANSWER = 200, 1
"""Waits for acknowledgements of action commands, ms: of the first, which tells whether any camera acts, and
of the others."""
BROADCAST = "255.255.255.255"
Send = Callable[[int, int, int, str, int], int]
"""Sends an action command: three keys, the receiver, the wait in ms; returns how many cameras acknowledge."""


def trigger_features(sync: Sync | None, camera: str, names: Collection[str]) -> Mapping[str, Value]:
    """Features with which a camera waits for the triggers of its room, in the order in which they are set.

    names: of all its features, of which those that select something may be missing. The camera that leads by
    a line runs freely; which of its outputs tells the others is a matter of its own features.
    """
    if sync is None or (sync.trigger == "line" and sync.camera == camera):
        return {}
    chosen: dict[str, Value] = {"TriggerSelector": "FrameStart"} if "TriggerSelector" in names else {}
    if sync.trigger == "action":
        chosen |= {"ActionSelector": 1} if "ActionSelector" in names else {}
        chosen |= {
            "ActionDeviceKey": sync.device_key,
            "ActionGroupKey": sync.group_key,
            "ActionGroupMask": sync.group_mask,
        }
    source = {"line": LINE, "software": SOFTWARE, "action": ACTION}[sync.trigger]
    return {**chosen, "TriggerSource": source, "TriggerMode": "On"}


def next_moment(now: int, rate: float) -> int:
    """The next trigger after `now`, ns since 1970: whole periods, which are the same on all hosts."""
    period = Fraction(SECOND) / exact_rate(rate)
    return int((now // period + 1) * period)


@contextmanager
def firing(fire: Callable[[], None], rate: float) -> Iterator[None]:
    """Calls `fire` at each moment of the rate, 1/s, from a thread, until the context ends.

    A moment that is over when the thread gets to it is left out. That `fire` finds the camera gone ends the
    calls; whoever takes its pictures finds out, too.
    """
    over = threading.Event()

    def work() -> None:
        due, half = next_moment(time.time_ns(), rate), int(SECOND / rate / 2)
        while not over.wait(max(0.0, (due - time.time_ns()) / SECOND)):
            try:
                fire()
            except (ConnectionError, ValueError):
                return
            due = next_moment(max(time.time_ns(), due + half), rate)

    thread = threading.Thread(target=work, name="triggers", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(1.0)


class ActionCommands:
    """Sends the action commands of a room; say: tells the user once that no camera acts on them."""

    def __init__(self, sync: Sync, send: Send | None, interface: str, say: Callable[[str], None]) -> None:
        """Raises InputError if nothing that is installed sends action commands."""
        if send is None:
            text = "action commands are sent by viva-genicam, which is not installed"
            raise InputError.of(text, "pip install 'followspot[genicam]', or trigger by software or a line")
        self._sync, self._send, self._say = sync, send, say
        self._receiver = interface if interface.startswith("127.") else BROADCAST
        self._first = True

    def __call__(self) -> None:
        """Send one command."""
        sync, wait = self._sync, ANSWER if self._first else NO_ANSWER
        heard = self._send(sync.device_key, sync.group_key, sync.group_mask, self._receiver, wait)
        if self._first and not heard:
            self._say("no camera acknowledges its action commands; are the keys those of the cameras?")
        self._first = False
