"""Prints the tables of docs/jin_qian_2008.md, of all targets, from what `followspot compare` wrote.

python tools/paper_tables.py runs/published/compare.json
"""

from __future__ import annotations

import json
import math
import statistics
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
SPREADS = (
    "pairs",
    "10 to 18",
    "5th to 95th",
    "to detections",
    "deviation",
    "from the truth",
    "jerk cost",
    "of the truth",
)
PAIRS = 10, 18
"""Of an object, as in section 4."""
Target = Mapping[str, Any]


def main(path: str) -> None:
    """A table of all variants over all rooms, one of the graph files in each room, one of section 4."""
    data = json.loads(Path(path).read_text(encoding="utf-8"))
    print(lines(data, [("", data["rooms"])], data["variants"]), end="\n\n")
    files = data["variants"][:1] + [v for v in data["variants"][1:] if v == "recorded"]
    print(lines(data, [(room, [room]) for room in data["rooms"]], files), end="\n\n")
    rows = [(v, *spreads(targets_of(data, v, data["rooms"]))) for v in files]
    print(table([("variant", *SPREADS), ("---", *("---:" for _ in SPREADS)), *rows]))


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
    return table(rows)


def table(rows: Sequence[Sequence[str]]) -> str:
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


def spreads(targets: Sequence[Target]) -> tuple[str, ...]:
    """Smallest and largest figure of a target, with the median of all, in the order of `SPREADS`."""
    there = [target for target in targets if target["frames"] and target["pairs"][0] is not None]

    def spread(key: str, form: str) -> str:
        values = [target[key] for target in there if target[key] is not None]
        if not values:
            return "-"
        return f"{min(values):{form}} to {max(values):{form}} ({statistics.median(values):{form}})"

    pairs = [target["pairs"][0] for target in there]
    within = sum(PAIRS[0] <= count <= PAIRS[1] for count in pairs)
    middle = [statistics.median(target["pairs"][n] for target in there) for n in (1, 2)] if there else []
    return (
        f"{min(pairs):.1f} to {max(pairs):.1f} ({statistics.median(pairs):.1f})" if pairs else "-",
        f"{within} of {len(pairs)}",
        " to ".join(f"{value:.0f}" for value in middle) or "-",
        *(spread(key, ".2f") for key in ("detection_px", "detection_std_px", "reprojection_px")),
        *(spread(key, ".5f") for key in ("jerk_cost", "true_jerk_cost")),
    )


def mean(values: Sequence[float | None]) -> float:
    """Mean of what was measured; NaN for nothing."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else math.nan


def number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"


if __name__ == "__main__":
    main(*sys.argv[1:])
