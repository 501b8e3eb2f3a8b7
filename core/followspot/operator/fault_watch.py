"""Faults of a run that begin and end while it goes on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator


class FaultWatch:
    """Gives a line for the log when a fault begins, and one when it ends.

    fault: a word in the lines of such faults, before their first colon, for example "stalls"; repair: the
    word that replaces it in the line about the end, for example "moves".
    """

    def __init__(self, fault: str, repair: str) -> None:
        self._fault, self._repair = fault, repair
        self._known: dict[str, str] = {}

    def changes(self, lines: Iterable[str]) -> Iterator[tuple[str, bool]]:
        """New lines for the log, and whether each is about a beginning. lines: of all present faults."""
        now = {line.partition(":")[0]: line for line in lines}
        before, self._known = self._known, now
        yield from ((line, True) for key, line in now.items() if key not in before)
        for key in before.keys() - now.keys():
            yield f"{key.replace(self._fault, self._repair)} again", False
