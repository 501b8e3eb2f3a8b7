"""Triggers of all cameras of a room at once: the features that wait for them, and their sender."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction

from followspot.frame_times import SECOND, exact_rate
from followspot.room import Sync
from followspot_cameras.camera_features import Value
from followspot_cameras.genicam.action_command import Keys, send_action
from followspot_cameras.genicam.broadcast import broadcast_address

LINE, ACTION, SOFTWARE = "Line1", "Action1", "Software"
"""Sources of triggers, as SFNC names them."""
COMMAND = "TriggerSoftware"
ANSWER = 0.2
"""Wait for acknowledgements of the first action command, s; they tell whether any camera acts."""
NUMBERS = 65_535
Send = Callable[[Keys, str, int, float], int]
"""Sends an action command, as `send_action` does."""


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

    A moment that is over when the thread gets to it is left out. If `fire` finds the camera gone, the calls
    end; the source, which takes its pictures, finds out by itself.
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
    """Sends the action commands of a room.

    interface: own address in the cameras' network; say: tells the user once that no camera acts on them, or
    why they cannot be sent.
    """

    def __init__(
        self, sync: Sync, interface: str, say: Callable[[str], None], send: Send = send_action
    ) -> None:
        self._keys = sync.device_key, sync.group_key, sync.group_mask
        self._send, self._say = send, say
        self._receiver = broadcast_address(interface)
        self._sent = 0

    def __call__(self) -> None:
        """Send one command."""
        first, number = not self._sent, self._sent % NUMBERS + 1
        self._sent += 1
        problem = "no camera acknowledges its action commands; are the keys those of the cameras?"
        try:
            heard = self._send(self._keys, self._receiver, number, ANSWER if first else 0.0)
        except OSError as error:
            heard = 0
            problem = (
                f"its action commands cannot be sent to {self._receiver} ({error}); "
                "`interface` names this host's address in the network of the cameras"
            )
        if first and not heard:
            self._say(problem)
