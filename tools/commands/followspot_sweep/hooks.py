"""The command `followspot sweep`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

from followspot.cli.graph_options import add_change_options, frame_count
from followspot.cli.trial_options import add_trial_options
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `sweep`."""
    return [Command("sweep", configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("graph", metavar="GRAPH", help="graph file")
    add_change_options(parser, "VALUES", "A,B,C or START:STOP:STEP, or one value for all runs; repeatable")
    add_trial_options(
        parser, "folder of the sweep; name it again to continue the sweep (default: runs/sweep-DATE-TIME)"
    )
    parser.add_argument(
        "--jobs",
        type=frame_count,
        default=os.cpu_count() or 1,
        metavar="N",
        help="number of runs at a time (default: number of processors)",
    )
    parser.add_argument(
        "--best",
        default="rmse_mm",
        metavar="FIGURE",
        help="figure to plot; the table marks its smallest value (default rmse_mm)",
    )


def run(args: argparse.Namespace) -> int:
    """Run a graph over a grid of parameters, several runs at a time, and report the best values.

    A --set with several values spans the grid: A,B,C or START:STOP:STEP, STOP included. Each point of the
    grid is a run. The command skips points whose results are in the folder, so the same command continues a
    sweep after an interruption. It writes sweep.csv, sweep.parquet (with pyarrow) and sweep.svg (with
    matplotlib).

    Examples:
      followspot sweep graphs/glowballs.yaml --set fuse.bandwidth_scale=2,3 --set color.similarity=0.7:0.9:0.1
      followspot sweep graphs/glowballs.yaml --set fuse.uses=balls.mean_shift,balls.mean --room a.yaml
      followspot sweep graphs/glowballs.yaml --set track.bounce_gate=2:6:1 --seed 1 --frames 300 -o runs/gate
    """
    from followspot_sweep.command import sweep

    return sweep(args)
