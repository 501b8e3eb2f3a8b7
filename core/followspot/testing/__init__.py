"""For plugin authors: `check_stage` says whether a stage keeps the promises that graphs rely on."""

from __future__ import annotations

from followspot.testing.conformance import Finding, check_stage, findings
from followspot.testing.tiny_room import tiny_room

__all__ = ["Finding", "check_stage", "findings", "tiny_room"]
