"""The command `followspot score`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, Scorer, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `score`."""
    return [Command("score", configure, run)]


@hookimpl
def followspot_scorers() -> Sequence[Scorer]:
    """Scores of tracks of targets, and of poses of persons."""

    def targets() -> object:
        from followspot_accuracy.scorings import TracksScoring

        return TracksScoring()

    def persons() -> object:
        from followspot_accuracy.scorings import PosesScoring

        return PosesScoring()

    return [Scorer("targets", targets), Scorer("persons", persons)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "reported",
        type=Path,
        metavar="TRACKS.csv",
        help="tracks or poses as the stage sinks.csv writes them",
    )
    parser.add_argument(
        "truth",
        type=Path,
        nargs="+",
        metavar="TRUTH.csv",
        help="of tracks: columns time (s), object, x, y, z (m), hidden, trackable, pair (0 or 1); of"
        " poses: time, person, x, y, z_head_top, r (m), torso_heading_room, torso_heading, head_pan,"
        " head_tilt (rad), visible_upper (0 to 1), or places alone: time, person, x, y",
    )
    parser.add_argument("--room", type=Path, help="room file, for the reprojection error of tracks")
    parser.add_argument(
        "--plot",
        type=Path,
        metavar="DIR",
        help="draw trajectories of tracks over time and in space beside the truth; errors of poses as "
        "histograms, and a plan",
    )
    parser.add_argument(
        "--between",
        type=float,
        nargs=2,
        metavar=("START", "END"),
        help="draw the trajectories of this span of time only (s)",
    )
    parser.add_argument(
        "--area",
        type=float,
        nargs=4,
        metavar=("X0", "Y0", "X1", "Y1"),
        help="part of the floor that the truth of persons covers (m), for MOTA and IDF1: poses outside it "
        "that are near no person do not count",
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object: target or person -> figures"
    )


def run(args: argparse.Namespace) -> int:
    """Score tracks of targets or poses of persons against ground truth.

    Tracks, per target: coverage, RMSE, median and 95th percentile (mm), identity switches, false positions
    while hidden, frames until recovery, jerk cost, errors within the stated ellipsoid of 95 %; with a room
    also the reprojection error (px). Rows are matched by time.

    Poses, per person and in all: coverage (pose within 0.5 m of a person whose upper body is half visible),
    errors of direction, distance, height and position, torso heading, head pan and tilt, identity switches,
    time to acquire and to vanish, false persons; MOTA, IDF1 and the mean distance at a gate of 0.5 m. Fused
    poses take the truth of every camera.

    Examples:
      followspot score runs/latest/tracks.csv recordings/truth.csv
      followspot score tracks.csv truth.csv --room room.yaml --json
      followspot score runs/latest/tracks.csv recordings/truth.csv --plot pictures --between 3.3 6.7
      followspot score runs/latest/poses.csv recordings/panorama_gt.csv --plot pictures
    """
    from followspot_score.command import score_files

    span = tuple(args.between) if args.between else None
    area = tuple(args.area) if args.area else None
    print(score_files(args.reported, args.truth, args.room, args.plot, span, area, as_json=args.json))
    return 0
