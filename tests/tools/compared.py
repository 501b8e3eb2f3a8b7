"""Trials of variants, with figures, and the rooms that they run in."""

from __future__ import annotations

import math
from pathlib import Path

from followspot_accuracy import TargetScore
from followspot_compare.trial import TargetFigures, Trial

ROOT = Path(__file__).parents[2]
SIMULATED = str(ROOT / "graphs/rooms/simulated.yaml")


def figures(rmse: float = 5.0, **score: object) -> TargetFigures:
    values: dict[str, object] = {
        "frames": 100,
        "coverage": 1.0,
        "rmse_mm": rmse,
        "median_mm": rmse,
        "p95_mm": 2 * rmse,
        "identity_switches": 0,
        "hidden_frames": 0,
        "false_positions": 0,
        "false_share": math.nan,
        "recovery_frames": (),
        "recovery_worst": 0,
        "jerk_cost": 0.001,
        "reprojection_px": 0.2,
        "reprojection_std_px": 0.1,
    }
    return TargetFigures(TargetScore(**{**values, **score}), 0.001, math.nan, math.nan, math.nan, math.nan)


def trial(variant: str, room: str, iterations: tuple[int, ...] = (), **targets: TargetFigures) -> Trial:
    return Trial(variant, room, 100, 2.0, 1.5, targets, iterations)
