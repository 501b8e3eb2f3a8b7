"""Test stages whose source waits for a file at its third number."""

from __future__ import annotations

GATED = """for n in range(p.count):
            while n == 2 and not (self.context.out / "gate").exists():
                if not self.context.pause(0.01):
                    return"""
"""Lines of the test stages, which hold the source up at its third number."""
