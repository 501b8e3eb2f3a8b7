"""Prints the tables of docs/jin_qian_2008.md from what `followspot compare` wrote.

python tools/paper_tables.py runs/published/compare.json
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

HEADINGS = (
    "coverage",
    "RMSE",
    "median",
    "switches",
    "false when hidden",
    "false recoveries",
    "of frames sought",
    "to detections",
    "pairs",
)
Target = Mapping[str, Any]


def main(path: str) -> None:
    """A table of all variants over all rooms, then one of the graph files in each room."""
    data = json.loads(Path(path).read_text(encoding="utf-8"))
    print(lines(data, [("", data["rooms"])], data["variants"]), end="\n\n")
    files = data["variants"][:1] + [v for v in data["variants"] if v == "recorded"]
    print(lines(data, [(room, [room]) for room in data["rooms"]], files))


def lines(
    data: Mapping[str, Any], groups: Sequence[tuple[str, Sequence[str]]], variants: Sequence[str]
) -> str:
    """A row for each variant in each group of rooms."""
    several = len(groups) > 1
    head = (*(("room",) if several else ()), "variant", *HEADINGS)
    rows = [head, tuple("---" if name in ("room", "variant") else "---:" for name in head)]
    for name, rooms in groups:
        for variant in variants:
            cells = figures(targets_of(data, variant, rooms))
            rows.append((*((name,) if several else ()), variant, *cells))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def targets_of(data: Mapping[str, Any], variant: str, rooms: Sequence[str]) -> list[Target]:
    """Figures of every target of a variant in some rooms."""
    trials = [t for t in data["trials"] if t["variant"] == variant and t["room"] in rooms]
    return [target for trial in trials for target in trial["targets"].values()]


def figures(targets: Sequence[Target]) -> tuple[str, ...]:
    """Means over the targets that were there, sums over all, in the order of the headings."""
    there = [target for target in targets if target["frames"]]

    def total(key: str) -> int:
        return sum(target[key] for target in targets)

    found, sought, false = (total(f"recoveries_{key}") for key in ("found", "sought", "false"))
    return (
        number(100 * mean([t["coverage"] for t in there]), ".1f", " %"),
        *(number(mean([t[key] for t in there]), ".1f", " mm") for key in ("rmse_mm", "median_mm")),
        str(total("identity_switches")),
        f"{total('false_positions')} of {total('hidden_frames')}",
        f"{false} of {found}",
        number(100 * false / sought if sought else math.nan, ".2f", " %"),
        number(mean([t["detection_px"] for t in there]), ".2f", " px"),
        number(mean([t["pairs"][0] for t in there]), ".1f", ""),
    )


def mean(values: Sequence[float | None]) -> float:
    """Mean of what was measured; NaN for nothing."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else math.nan


def number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"


if __name__ == "__main__":
    main(*sys.argv[1:])
