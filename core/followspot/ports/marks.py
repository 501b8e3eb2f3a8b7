"""Marks of a stage's inputs and outputs in the signature of `process`: `Latest[Forecast]`, `Outputs[Tracks]`.

An input without a mark fires the stage. `followspot.ports.signature` reads the marks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from typing import Annotated, TypeVar

T = TypeVar("T")


class LatestMark:
    """Marks an input that samples and holds: it never fires."""


class JoinedMark:
    """Marks an input that collects one message from each connected edge."""


class NearestMark:
    """Marks an input that gives the message nearest in time to the firing: it never fires."""


class WindowMark:
    """Marks an input that gives every message since the last firing: it never fires."""


class OutputsMark:
    """Marks a result that is several messages for one firing."""


class DeferredMark:
    """Marks a result that a future or a thread of the runtime gives later."""


class LaggedMark:
    """Marks a result that is messages for this firing and earlier ones."""


Latest = Annotated[T | None, LatestMark()]
"""The newest message, or None before the first."""
Joined = Annotated[tuple[T, ...], JoinedMark()]
"""One message per connected camera that has one at this time, in the order of the room's cameras."""
Nearest = Annotated[T | None, NearestMark()]
"""The message nearest in capture time to the firing, before or after it, or None if none lies within the
tolerance of the edge or the stage."""
Window = Annotated[tuple[T, ...], WindowMark()]
"""Every message since the last firing up to the capture time of this one, in the order of capture times."""
Outputs = Annotated[Iterable[T], OutputsMark()]
"""Return type of a stage that gives any number of messages for one firing. Their capture times rise, from
that of the firing on: `at(time, message)` sets them; the first may leave its time to the runtime."""
Deferred = Annotated[Future[T | None] | Callable[[], T | None] | None, DeferredMark()]
"""Return type of a stage without a state that answers later: a future, or a function that a thread of the
runtime calls. Answers are sent in the order of the firings, with their capture times; at most as many are
under way as the graph says (`concurrency`, 1 if it says nothing)."""
Lagged = Annotated[Iterable[T], LaggedMark()]
"""Return type of a stage that waits for later inputs: messages for firings up to this one, any number for one
firing. Each has the capture time of its firing (`at(time, message)`), and the times rise. `Stage.remaining`
gives those that are left when the inputs have ended."""
Source = Iterator
"""Return type of a source's `process`: a generator of messages made with :func:`followspot.at`."""
