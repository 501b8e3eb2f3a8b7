"""Promises about devices that a stalled machine may spoil now and then."""

from collections.abc import Callable


def one_of(tries: int, attempt: Callable[[], bool]) -> bool:
    """Whether one of so many attempts succeeds: a busy machine spoils some, a broken promise all of them."""
    return any(attempt() for _ in range(tries))
