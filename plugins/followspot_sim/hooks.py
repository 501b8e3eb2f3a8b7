"""Joins `followspot simulate` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `simulate`."""
    return [Command("simulate", configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("--room", type=Path, required=True, metavar="ROOM.yaml", help="a simulated room")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    parser.add_argument("--frames", type=int, metavar="N", help="record N frames (default: as the room says)")
    parser.add_argument("--seed", type=int, metavar="S", help="another performance")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--templates", action="store_true", help="record each target alone")
    what.add_argument(
        "--live", action="store_true", help="write a room, too, that plays the recording as live cameras"
    )


def run(args: argparse.Namespace) -> int:
    """Record a simulated room: one lossless video per camera, and the ground truth.

    The room file says with which parameters its cameras are simulated (source: {uses: sim.camera, with: ...},
    or sim.person_camera for people; the true poses are then in CAMERA_gt.csv). DIR gets CAMERA.mkv and
    truth.csv; with --templates it gets TARGET/CAMERA.mkv instead, 20 frames of each target alone, for
    `followspot calibrate targets`. With --live, DIR/room.yaml plays the videos again and again, as cameras
    that do not wait: to practise with moving stages and dying hosts.

    Examples:
      followspot simulate --room graphs/rooms/simulated.yaml --out recording --frames 300
      followspot simulate --room graphs/rooms/simulated.yaml --out show --frames 600 --live
      followspot run graphs/glowballs.yaml --room show/room.yaml --placement camera
    """
    from followspot import room_file
    from followspot_sim.actor.recording import actor_parameters_of, has_people, record_people
    from followspot_sim.live_room import write_live_room
    from followspot_sim.recording import parameters_of, record, record_templates

    room = room_file.load(args.room)
    if has_people(room) and not args.templates:
        record_people(room, actor_parameters_of(room, frames=args.frames, seed=args.seed), args.out)
        if args.live:
            write_live_room(room, args.out)
        return 0
    params = parameters_of(room, frames=args.frames, seed=args.seed)
    if args.templates:
        record_templates(room, params, args.out, args.frames)
    else:
        record(room, params, args.out)
    if args.live:
        write_live_room(room, args.out)
    return 0
