"""Threads of stages that go on after their stages were closed, and so hold up the end of the process."""

from __future__ import annotations

import inspect
import sys
import threading
import time
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import thread as thread_pool
from contextlib import suppress
from pathlib import Path
from types import CodeType, FrameType

from followspot.stage import Stage

_PATIENCE, _PATIENCE_BESIDE = 5.0, 1.0
"""Seconds that threads have to end after the close of their stage, in a process of their own and beside other
threads."""
_LOOK = 0.05
"""Seconds after which a thread is looked at again: one of a pool may have no work left."""
_LIBRARY = Path(threading.__file__).parent
_REMEDY = "end it in close(), or start it with daemon=True"


def late_threads(
    before: Collection[threading.Thread], stages: Sequence[tuple[str, Stage]], *, own_process: bool
) -> Iterator[tuple[str, str]]:
    """The stage, "" if that is not known, and a warning for each thread that a process waits for at its end.

    before: threads that other code had started; stages: by name, all closed; own_process: whether nothing but
    the stages can have started a thread since.
    """
    limit = time.monotonic() + (_PATIENCE if own_process else _PATIENCE_BESIDE)
    for thread in threading.enumerate():
        if thread.daemon or thread in before or thread is threading.current_thread():
            continue
        while thread.is_alive() and not _is_idle(thread) and (left := limit - time.monotonic()) > 0:
            thread.join(min(left, _LOOK))
        frames = [frame for frame in _calls(thread) if not _in_library(frame)]
        stage = _stage_of([frame.f_code for frame in frames], stages)
        if _is_idle(thread) or not thread.is_alive() or not (stage or own_process):
            continue
        place = f" at {frames[0].f_code.co_filename}:{frames[0].f_lineno}" if frames else ""
        yield stage, f'its thread "{thread.name}" goes on{place} after close(): {_REMEDY}'


def _is_idle(thread: threading.Thread) -> bool:
    """Whether a thread of a pool waits for work: the end of the process ends it."""
    calls = _calls(thread)
    return bool(calls) and calls[-1].f_code is thread_pool._worker.__code__


def _stage_of(calls: Sequence[CodeType], stages: Sequence[tuple[str, Stage]]) -> str:
    """The stage whose class calls, else one whose file does; a script has threads of its own."""
    ours = [(name, type(stage)) for name, stage in stages for call in calls if _is_in(call, type(stage))]
    named = [name for name, kind in ours if any(_is_method(call, kind) for call in calls)]
    return next(iter(named or [name for name, kind in ours if kind.__module__ != "__main__"]), "")


def _is_in(call: CodeType, kind: type[Stage]) -> bool:
    """Whether code is in the file of a class."""
    with suppress(OSError, TypeError):
        return call.co_filename == inspect.getfile(kind)
    return False


def _is_method(call: CodeType, kind: type[Stage]) -> bool:
    return call.co_qualname.startswith(f"{kind.__qualname__}.")


def _calls(thread: threading.Thread) -> list[FrameType]:
    """The calls of a thread, the outermost one first."""
    frames = []
    frame = sys._current_frames().get(thread.ident or 0)
    while frame is not None:
        frames.append(frame)
        frame = frame.f_back
    return frames[::-1]


def _in_library(frame: FrameType) -> bool:
    """Whether a call is of a module of Python itself."""
    path = Path(frame.f_code.co_filename)
    return path.is_relative_to(_LIBRARY) and "site-packages" not in path.parts
