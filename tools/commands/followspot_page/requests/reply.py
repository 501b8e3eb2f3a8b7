"""The answer to a request of a browser."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Reply:
    """text: what became of what was asked for; about: more of it; picture: a JPEG, b"" for none."""

    text: str = ""
    about: Mapping[str, Any] | None = None
    picture: bytes = b""
