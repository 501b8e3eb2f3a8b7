"""Findings as text and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict

from followspot_doctor.finding import Finding

_SIGNS = {"ok": "ok     ", "warning": "warning", "problem": "PROBLEM"}


def as_text(findings: Sequence[Finding]) -> str:
    """A line a finding, its remedy below; the count at the end."""
    width = max(len(f.subject) for f in findings)
    lines = []
    for found in findings:
        lines.append(f"{_SIGNS[found.state]}  {found.subject:{width}}  {found.text}")
        if found.remedy:
            lines.append(f"{'':{width + 11}}{found.remedy}")
    counts = {state: sum(f.state == state for f in findings) for state in ("problem", "warning")}
    said = [f"{n} {state}{'s' * (n != 1)}" for state, n in counts.items() if n]
    return "\n".join([*lines, "", ", ".join(said) or "all is well"])


def as_json(findings: Sequence[Finding]) -> str:
    """{"ok": ..., "findings": [{subject, state, text, remedy}]}."""
    ok = all(f.state != "problem" for f in findings)
    return json.dumps({"ok": ok, "findings": [asdict(f) for f in findings]}, indent=2)
