"""Each mistake once, although a fan-out makes it in every member, and one value in several stages."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from followspot.errors import Mistake, Place

_OF_A_MEMBER = re.compile(r"[\w-]+(?:/[\w-]+)+|\[[^\]]*\]")
"""What members of a fan-out differ in: names of stages in sub-graphs, and selectors of what they serve."""
_OF_A_VALUE = re.compile(r'stage "[^"]*" (\([^)]*\))(?= cannot be | has no parameter )')
"""The stage that a written value does not suit; an interface may give it to several."""


def distinct_mistakes(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """The first of the mistakes that have one cause.

    One text about one value is one mistake, wherever sub-graphs take the value to. So are texts at one
    place, reached by whatever uses of its file, that differ in members and sub-graphs alone.
    """
    kept: list[Mistake] = []
    seen: set[tuple[Place | None, str]] = set()
    for mistake in mistakes:
        written = _OF_A_VALUE.sub(r"\1", mistake.text)
        at = mistake.place and replace(mistake.place, outer=None)
        value, member = (at, written), (at, _OF_A_MEMBER.sub("/", mistake.text))
        if value in seen or (at is not None and member in seen):
            continue
        seen |= {value, member}
        kept.append(mistake)
    return kept
