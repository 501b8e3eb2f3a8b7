"""The commands of `followspot room`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands `room new`, `room import`, `room export`, `room guess` and `room rectify`."""
    return [
        Command("new", configure_new, run_new, parent="room"),
        Command("import", configure_import, run_import, parent="room"),
        Command("export", configure_export, run_export, parent="room"),
        Command("guess", configure_guess, run_guess, parent="room"),
        Command("rectify", configure_rectify, run_rectify, parent="room"),
    ]


def _add_output(parser: argparse.ArgumentParser) -> None:
    help_text = "room file to write; an old file is refused"
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="ROOM.yaml", help=help_text)


def configure_new(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `room new`."""
    add = parser.add_argument
    video = "video, or folder of pictures; repeatable, one camera each"
    add("--video", type=Path, action="append", default=[], metavar="FILE", help=video)
    add("--webcam", metavar="DEVICE", help="number of a webcam, or its path, for example 0")
    add("--size", default="640x480", metavar="WxH", help="of the webcam's pictures, px (default: 640x480)")
    add("--field", type=float, default=60.0, metavar="DEG", help="horizontal field of view (default: 60)")
    _add_output(parser)
    add("--json", action="store_true", help="print the cameras as one JSON object")


def run_new(args: argparse.Namespace) -> int:
    """Make a room file for videos of your own, or a webcam, without a calibration.

    The cameras are good for what is seen in the pictures: detections, image tracks, drawn videos. Their poses
    are not known, so there are no places in space.

    Examples:
      followspot room new --video balls.mp4 -o room.yaml
      followspot room new --webcam 0 --size 1280x720 -o desk.yaml
    """
    import re
    from math import radians

    from followspot.errors import InputError
    from followspot_room.new_room import new_room

    size = re.fullmatch(r"([1-9]\d{0,4})x([1-9]\d{0,4})", args.size)
    if size is None or not 5.0 <= args.field <= 150.0:
        text = f"--size {args.size} or --field {args.field:g} is wrong"
        raise InputError.of(text, "a size is 640x480, a field 5 to 150 degrees")
    pixels = (int(size[1]), int(size[2]))
    return new_room(args.video, args.webcam, pixels, args.output, radians(args.field), as_json=args.json)


def configure_import(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `room import`."""
    add = parser.add_argument
    add("calibration", type=Path, metavar="CALIBRATION", help="file or folder with calibrated cameras")
    add("--videos", type=Path, metavar="DIR", help="folder with the recordings; without it, no sources")
    _add_output(parser)
    only, infrared = "import these cameras only; repeatable", "names of infrared cameras; repeatable"
    add("--only", nargs="+", action="extend", default=[], metavar="CAMERA", help=only)
    add("--infrared", nargs="+", action="extend", default=[], metavar="CAMERA", help=infrared)
    add("--allow-missing", action="store_true", help="accept cameras that have no recording and no source")
    add("--json", action="store_true", help="print the imported cameras as one JSON object")


def run_import(args: argparse.Namespace) -> int:
    """Make a room file from a calibration and, optionally, a folder with one video per camera.

    The command recognises the format of the calibration by its content: TOML of aniposelib or caliscope,
    Qualisys Calib.qca.txt, a folder of MultiCamSelfCal, OpenCV YAML (a file or a folder of files), JSON
    with K, dist, R and t, JSON of pinhole and cylinder cameras by name, or Tsai's XML. A room file is a
    calibration, too: its targets, planes and sensors stay, its recordings are replaced. Recordings have
    the names of the cameras: VIDEOS/cam0.mkv (any video) or a folder VIDEOS/cam0 of pictures. The command
    accepts scaled copies, and pictures that a codec cut at the right or below, with a warning.
    VIDEOS/truth.csv becomes the truth of the room; without it, VIDEOS/cam0_gt.csv does, with poses of
    persons.

    Examples:
      followspot room import calibration.toml -o room.yaml
      followspot room import Calib.qca.txt --videos recordings -o room.yaml
      followspot room import monday.yaml --videos tuesday -o tuesday.yaml
      followspot room import calib.json --only panorama --videos recordings -o panorama.yaml
    """
    from followspot_room.importing import import_room

    return import_room(
        args.calibration,
        args.videos,
        args.output,
        only=args.only,
        infrared=args.infrared,
        allow_missing=args.allow_missing,
        as_json=args.json,
    )


def configure_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `room export`."""
    add = parser.add_argument
    add("room", type=Path, metavar="ROOM.yaml", help="room file")
    add(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="file or folder to write; old files are refused",
    )
    add(
        "--format",
        choices=("anipose", "caliscope", "qualisys", "svoboda", "opencv"),
        help="format of the output",
    )
    add("--json", action="store_true", help="print what was written as one JSON object")


def run_export(args: argparse.Namespace) -> int:
    """Write the cameras of a room file for another program.

    The name of the output gives the format: camera_array.toml is caliscope, any other .toml
    aniposelib, .qca.txt Qualisys, .yml OpenCV; svoboda writes a folder and needs --format. Planes and targets
    stay behind.

    Examples:
      followspot room export room.yaml -o calibration.toml
      followspot room export room.yaml -o selfcal --format svoboda
    """
    from followspot_room.exporting import export_room

    return export_room(args.room, args.output, args.format, as_json=args.json)


def configure_guess(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `room guess`."""
    add = parser.add_argument
    add("video", type=Path, metavar="VIDEO", help="video in which people walk")
    _add_output(parser)
    add("--field", type=float, default=50.0, metavar="DEG", help="horizontal field of view (default: 50)")
    add("--person", type=float, default=1.72, metavar="M", help="usual height of people (default: 1.72)")
    add("--json", action="store_true", help="print the guess as one JSON object")


def run_guess(args: argparse.Namespace) -> int:
    """Make a rough room file for one video without a calibration, from the sizes of the people in it.

    The guess assumes a camera without roll and distortion, above a flat floor on which people walk upright.
    The result is good enough to follow people and to tell near from far; calibrate for exact positions.

    Example:
      followspot room guess street.avi --field 50 -o street.yaml
    """
    from math import radians

    from followspot.errors import InputError
    from followspot_room.guessing import guess_room

    if not 5.0 <= args.field <= 150.0 or not 0.5 <= args.person <= 2.5:
        text = f"--field {args.field:g} or --person {args.person:g} is out of range"
        raise InputError.of(text, "a field is 5 to 150 degrees, a person 0.5 to 2.5 m")
    return guess_room(args.video, args.output, radians(args.field), args.person, as_json=args.json)


def configure_rectify(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `room rectify`."""
    add = parser.add_argument
    add("room", type=Path, metavar="ROOM.yaml", help="room with videos")
    _add_output(parser)
    add(
        "--scale",
        type=float,
        default=1.0,
        metavar="S",
        help="size of the new pictures relative to the old, 0.05 to 1 (default: 1)",
    )
    add("--json", action="store_true", help="print the changes as one JSON object")


def run_rectify(args: argparse.Namespace) -> int:
    """Replace tilted, distorted cameras by upright ones; stages rectify the videos while they play.

    Detectors expect upright people and straight lines. They search large videos faster with
    --scale 0.5. Places in the room stay the same.

    Example:
      followspot room rectify room.yaml --scale 0.5 -o upright.yaml
    """
    from followspot.errors import InputError
    from followspot_room.rectifying import rectify_room

    if not 0.05 <= args.scale <= 1.0:
        raise InputError.of(f"--scale {args.scale:g} is out of range", "give 0.05 to 1")
    return rectify_room(args.room, args.output, args.scale, as_json=args.json)
