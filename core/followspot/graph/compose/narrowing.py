"""`cameras: SELECTOR` and `each:` of a sub-graph, carried over to the stages inside."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from followspot.document import Node
from followspot.errors import Mistake
from followspot.form import kind_of

_CAMERAS = re.compile(r"\s*cameras\s*(?:\[(.*)\])?\s*", re.DOTALL)


def narrowed(each: Node, selectors: Sequence[Node]) -> Node:
    """The value of `each` with the conditions of these selectors, if it fans out over cameras."""
    own = conditions(each)
    if own is None:
        return each
    parts = [part for part in (own, *(conditions(node) for node in selectors)) if part]
    return replace(each, value=f"cameras[{', '.join(dict.fromkeys(parts))}]" if parts else "cameras")


def conditions(selector: Node) -> str | None:
    """What stands in the brackets of a selector of cameras; None if it is none."""
    found = _CAMERAS.fullmatch(selector.value) if isinstance(selector.value, str) else None
    return None if found is None else (found[1] or "").strip()


def check_cameras(selector: Node, mistakes: list[Mistake]) -> None:
    """Note a mistake if this is no selector of cameras."""
    if conditions(selector) is None:
        text = f"cameras cannot be {kind_of(selector)}"
        mistakes.append(Mistake(selector.place, text, 'write for example "cameras[zone=hall]"'))
