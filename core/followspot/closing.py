"""What is closed at the end of its ``with`` block."""

from __future__ import annotations

from typing import Self


class Closing:
    """Base of what a ``with`` block closes. Subclasses define `close`, which may be called twice."""

    def close(self) -> None:
        """Let go of everything."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close()
