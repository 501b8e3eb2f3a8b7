"""Findings of checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["ok", "warning", "problem"]


@dataclass(frozen=True)
class Finding:
    """subject: of the check; text: the observation; remedy: what to do, empty if all is well."""

    subject: str
    state: State
    text: str
    remedy: str = ""


def fine(subject: str, text: str) -> Finding:
    """All is well."""
    return Finding(subject, "ok", text)


def doubtful(subject: str, text: str, remedy: str) -> Finding:
    """A graph runs, but not as well as it could."""
    return Finding(subject, "warning", text, remedy)


def wrong(subject: str, text: str, remedy: str) -> Finding:
    """A graph that needs this does not run."""
    return Finding(subject, "problem", text, remedy)
