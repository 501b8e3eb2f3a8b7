"""Promises of sources, except devices, which deliver at their own pace."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import islice, pairwise
from typing import Any

from followspot.message_checks.outputs import WrongOutput, check_yielded
from followspot.messages import InvalidMessage, Message
from followspot.testing.promises.work import contents
from followspot.testing.trial import Trial, outputs, reason

FRAMES = 4


def yields_what_it_declares(trial: Trial) -> Iterator[str]:
    """Messages have the declared type, dtypes and shapes, and their capture time."""
    if not trial.yields:
        return
    try:
        for item in _items(trial):
            check_yielded(trial.ports.outputs, item, live=False)
            for message in outputs(item):
                trial.seal(message)
    except WrongOutput as error:
        yield f"it {error}"
    except InvalidMessage as error:
        yield f"a message breaks its contract: {error}"
    except Exception as error:
        yield f"it raises {reason(error)}"


def never_goes_back_in_time(trial: Trial) -> Iterator[str]:
    """Capture times rise; `at(time, message)` says them."""
    times = [message.header.time for message in first_or_none(trial)]
    if any(later <= earlier for earlier, later in pairwise(dict.fromkeys(times))):
        yield f"capture times do not rise: {times} ns"


def tells_its_capture_times(trial: Trial) -> Iterator[str]:
    """`capture_time` gives the times of the messages, or None."""
    times = list(dict.fromkeys(message.header.time for message in first_or_none(trial)))
    if not times:
        return
    try:
        with trial.at_work() as stage:
            told = [stage.capture_time(number) for number in range(len(times))]
    except Exception as error:
        yield f"capture_time raises {reason(error)}"
        return
    if any(said not in (None, time) for said, time in zip(told, times, strict=True)):
        yield f"capture times are {times} ns, capture_time tells {told}"


def yields_the_same_again(trial: Trial) -> Iterator[str]:
    """A recording and a simulation are the same each time."""
    first, second = first_or_none(trial), first_or_none(trial)
    if [contents(message) for message in first] != [contents(message) for message in second]:
        yield "two instances with one seed yield different messages"


def stops_within_a_second(trial: Trial) -> Iterator[str]:
    """Ctrl-C closes the generator and then the stage."""
    if not trial.yields:
        return
    try:
        with trial.at_work() as stage:
            generator = stage.process()
            next(generator, None)
            started = time.monotonic()
            refused = _refused(generator)
    except Exception:
        return  # `yields_what_it_declares` reports it
    if refused:
        yield f"closing its generator raises {refused}"
    if time.monotonic() - started > 1.0:
        yield f"it took {time.monotonic() - started:.1f} s to stop"


def _refused(generator: Any) -> str:
    """The error that a generator raises when it is closed; empty if none."""
    try:
        generator.close()
    except Exception as error:
        return reason(error)
    return ""


def _items(trial: Trial) -> list[Any]:
    with trial.at_work(seed=1) as stage:
        return list(islice(stage.process(), FRAMES))


def first_or_none(trial: Trial) -> list[Message]:
    """The messages of a source; none if it fails, which `yields_what_it_declares` reports."""
    try:
        return [message for item in _items(trial) for message in outputs(item)] if trial.yields else []
    except Exception:
        return []
