"""Each mistake once, although a fan-out makes it in every member, and one value in several stages."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from followspot.errors import Mistake, Place

_OF_A_MEMBER = re.compile(r"[\w-]+(?:/[\w-]+)+|\[[^\]]*\]")
"""Parts in which messages on members of a fan-out differ: names in sub-graphs, and selectors like [cam0]."""
_OF_A_VALUE = re.compile(r'stage "[^"]*" (\([^)]*\))(?= cannot be | has no parameter )')
"""The stage that a written value does not suit; an interface may give it to several."""


def distinct_mistakes(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """The first of the mistakes that have one cause.

    Mistakes have one cause if they have the same text about one value, although sub-graphs pass the value to
    several stages; or if they have one place in a file, and their texts differ only in members of a fan-out
    and in the names of the sub-graphs that use the file.
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
