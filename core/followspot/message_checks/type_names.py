"""Names of types as users write them, for error messages."""

from __future__ import annotations

from typing import Any


def named_type(kind: Any) -> str:
    """A declared type as a declaration writes it: int, Blobs, tuple[str, ...]."""
    return kind.__name__ if isinstance(kind, type) else str(kind)


def named_value(value: object) -> str:
    """A value by its type, with an article: a list, an ndarray, None."""
    if value is None:
        return "None"
    name = type(value).__name__
    return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
