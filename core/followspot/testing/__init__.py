"""For plugin authors: `check_stage` says whether a stage keeps the promises that graphs rely on.

    def test_my_stage_keeps_every_promise():
        check_stage(MyStage)

The fixtures `tiny_room`, `virtual_clock` and `memory_edge` are there in every test.
"""

from __future__ import annotations

from followspot.testing.clock import MemoryEdge, VirtualClock
from followspot.testing.conformance import PROMISES, Finding, check_stage, findings
from followspot.testing.tiny_room import tiny_room

__all__ = ["PROMISES", "Finding", "MemoryEdge", "VirtualClock", "check_stage", "findings", "tiny_room"]
