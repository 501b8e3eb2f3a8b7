"""Marks a moment of a run, and waits until its flight recorder says which file holds it."""

from __future__ import annotations

import time

from followspot.control.dispatch import Ask, NoAnswer
from followspot.errors import FollowspotError
from followspot.operator.mark_queue import Moment, RecorderState
from followspot.operator.run_requests import GetRecorderState, MarkMoment

_POLL_INTERVAL = 0.1
_ANSWER = 10.0
"""Seconds for the operator to answer, and for the flight recorder to take a mark."""
_WRITING = 120.0
"""Seconds that the writing of a file may take beyond the time that belongs to its mark."""


def mark_moment(ask: Ask, after: float, note: str, *, wait: bool) -> Moment:
    """See `RunHandle.mark`."""
    number = ask(MarkMoment(after=after, note=note), _ANSWER)
    moment, deadline = None, time.monotonic() + _ANSWER
    while time.monotonic() < deadline:
        try:
            state = recorder_state(ask)
        except NoAnswer:
            raise
        except FollowspotError:
            if moment is None:
                raise
            return moment  # the run has ended; its recorder completes the file
        if state is None:
            raise NoAnswer("the flight recorder of this run has ended")
        found = next((one for one in reversed(state.moments) if number in one.marks), None)
        if found is not None and moment is None:
            deadline += after + _WRITING
        moment = found or moment
        if moment is not None and moment.state == "failed":
            raise FollowspotError(f"the moment is not saved: {moment.problem}")
        if moment is not None and not (wait and moment.state == "open"):
            return moment
        time.sleep(_POLL_INTERVAL)
    raise NoAnswer("the flight recorder of this run does not answer")


def recorder_state(ask: Ask) -> RecorderState | None:
    """See `RunHandle.kept`."""
    found: RecorderState | None = ask(GetRecorderState(), _ANSWER)
    return found
