"""Run a plan to its end in this process, and score its outputs against the truth of its room."""

from __future__ import annotations

from followspot.control.progress import OnProgress, Progress
from followspot.operator.launch import run_plan, unused_agents
from followspot.operator.output_folder import replaced_outputs
from followspot.operator.reporting.report import RunReport
from followspot.operator.reporting.scored import scored_file
from followspot.operator.reporting.truth import (
    room_truth,
    run_scores,
)
from followspot.worker.wiring import RunOptions

__all__ = [
    "OnProgress",
    "Progress",
    "RunOptions",
    "RunReport",
    "replaced_outputs",
    "room_truth",
    "run_plan",
    "run_scores",
    "scored_file",
    "unused_agents",
]
