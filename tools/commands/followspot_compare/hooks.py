"""The command `followspot compare`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from followspot.cli.graph_options import add_change_options
from followspot.cli.trial_options import add_trial_options
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `compare`."""
    return [Command("compare", configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("graphs", nargs="+", metavar="GRAPH", help="graph file; each file is a variant")
    parser.add_argument(
        "--variant",
        dest="variants",
        action="append",
        default=[],
        metavar="NAME:STAGE.KEY=VALUE[,STAGE.KEY=VALUE]...",
        help="another variant: the first graph with these overrides; repeatable",
    )
    add_change_options(parser)
    add_trial_options(parser, "folder for outputs and plots (default: runs/compare-DATE-TIME)")


def run(args: argparse.Namespace) -> int:
    """Run variants of a graph on the same recordings and compare their accuracy.

    Every graph file is a variant; each --variant is another variant of the first graph. The command prints
    for each target, and as means: coverage, RMSE, median and 95th percentile (mm), errors within the stated
    ellipsoid of 95 %, identity switches, false positions while hidden, recovery, false recoveries (the share
    of first positions after a frame without one that are farther than 15 cm from the target, and their share
    of all frames in which it was sought), jerk cost, reprojection error, speed, and ratios to the first
    variant.
    For graphs that write poses of persons (sinks.csv) it prints coverage, errors of direction,
    distance, height and position, torso heading, head pan and tilt, identity, false persons, times to
    acquire and to vanish, and speed.

    If a graph writes the output of its fusion to positions.jsonl, its candidates to candidates.jsonl and its
    pairs to pairs.jsonl, as graphs/experiments/recorded.yaml does, the command also prints the errors before
    the filter, the reprojection error of the detections, the pairs of a target in a frame (mean, 5th
    and 95th percentile) and the histogram of iterations. Plots need matplotlib:
    pip install "followspot[plots]".

    Examples:
      followspot compare graphs/glowballs.yaml --variant mean:fuse.uses=balls.mean
      followspot compare a.yaml b.yaml --room room1.yaml --room room2.yaml --frames 200 -o comparison
      followspot compare graphs/experiments/recorded.yaml --variant "no test:verify.homography_tolerance=0"
    """
    from followspot_compare.command import compare

    return compare(args)
