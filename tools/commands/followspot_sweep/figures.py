"""The figures of a run, from the JSON object that `followspot run --json` ends with, as one row."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean
from typing import Any

_SUMS = ("identity_switches", "hidden_frames", "false_positions")
_MOST = ("recovery_worst",)
_ALL = "all"
"""Stands for all persons in the scores of a run."""


def figures_of(summary: Mapping[str, Any]) -> dict[str, float]:
    """Means over the targets (switches and false positions: sums, recovery: the slowest), or of all persons.

    Figures that nothing was measured for are left out.
    """
    found = {"frames": float(summary["frames"])}
    targets = [one for one in summary.get("targets", {}).values() if one.get("frames")]
    for key in dict.fromkeys(key for one in targets for key in one if key != "frames"):
        values = [one[key] for one in targets if _known(one.get(key))]
        if values:
            found[key] = sum(values) if key in _SUMS else max(values) if key in _MOST else fmean(values)
    persons = summary.get("persons", {}).get(_ALL)
    return found | (_flat(persons) if isinstance(persons, Mapping) else {})


def _flat(values: Mapping[str, Any], before: str = "") -> dict[str, float]:
    """Numbers of nested maps, the keys that lead to each joined by underscores."""
    found: dict[str, float] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{before}{key}_")
        elif _known(value):
            found[f"{before}{key}"] = float(value)
    return found


def _known(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
