"""Notes in the log about workers that died and are restarted."""

from __future__ import annotations


class RestartNotes:
    """Notes of restarts; a worker that dies of one error again and again shows its traceback once."""

    def __init__(self) -> None:
        self._tracebacks: dict[str, str] = {}

    def of(self, worker: str, why: str, wait: float) -> str:
        """The note. why: a line, and below it a traceback, if any; wait: until the restart, s."""
        line, _, traceback = why.partition("\n")
        note = f"{line}; it is started again in {wait:.1f} s"
        if not traceback or self._tracebacks.get(worker) == traceback:
            return note
        self._tracebacks[worker] = traceback
        return f"{note}\n{traceback}"
