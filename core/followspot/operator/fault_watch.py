"""Faults that come and go while a run goes on: when each begins, and when it is over."""

from __future__ import annotations

from collections.abc import Iterable, Iterator


class FaultWatch:
    """Tells when a fault begins, and when it ends.

    fault, repair: words in the lines of such a fault before their first colon, and what replaces them in the
    line that tells of its end.
    """

    def __init__(self, fault: str, repair: str) -> None:
        self._fault, self._repair = fault, repair
        self._known: dict[str, str] = {}

    def changes(self, lines: Iterable[str]) -> Iterator[tuple[str, bool]]:
        """New lines for the log, and whether each tells of a beginning. lines: of all faults that last."""
        now = {line.partition(":")[0]: line for line in lines}
        before, self._known = self._known, now
        yield from ((line, True) for key, line in now.items() if key not in before)
        for key in before.keys() - now.keys():
            yield f"{key.replace(self._fault, self._repair)} again", False
