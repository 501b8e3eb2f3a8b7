"""`followspot room import`."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from followspot import Camera, Room
from followspot.errors import InputError, Mistake, did_you_mean, require_unused, writing
from followspot.files import DOCUMENT, read_text
from followspot.graph.room_part import part_of
from followspot.room import StageUse
from followspot.room_document import room as room_document
from followspot.room_file import save
from followspot.yaml.reader import read
from followspot_cameras.recorded_times.beside import TABLE, spread_of_moments, times_beside
from followspot_cameras.recordings import POSE_TRUTH, find_recordings
from followspot_room.calibration import read_calibration
from followspot_room.format import Calibration
from followspot_room.moving import moved
from followspot_room.recorded_size import as_recorded, picture_size
from followspot_room.resized import resized

ROOM = re.compile(r"^room:", re.MULTILINE)
TRUTH = "truth.csv"
MILLISECOND = 1_000_000
DEFAULT_TOLERANCE = 4 * MILLISECOND
"""Difference of capture times up to which stages match messages if nothing else is said, ns."""
POSES = "cameras.pose_truth_csv"
"""The stage that reads true poses of persons, which need no templates."""


def import_room(
    calibration: Path,
    videos: Path | None,
    output: Path,
    *,
    only: Sequence[str],
    infrared: Sequence[str],
    allow_missing: bool,
    as_json: bool,
) -> int:
    """Write the room file and print its content; returns the exit code. Raises InputError.

    videos: None for cameras alone; only: cameras to take, empty for all; infrared: cameras that are infrared
    whatever the file says.
    """
    require_unused(output, calibration)
    base = without_recordings(part_of_file(calibration, only)) if is_room_file(calibration) else Room()
    given = calibration_of(base) if base.cameras else read_calibration(calibration)
    known = with_infrared(with_only(given, only), infrared)
    names = [camera.name for camera in known.cameras]
    recordings = find_recordings(videos, names) if videos else {}
    missing = [name for name in names if name not in recordings] if videos else []
    if videos and missing and not allow_missing:
        raise InputError([_no_recording(name, videos) for name in missing])
    known = with_spread(with_recorded_sizes(known, recordings), recordings)
    truth = find_truth(videos, names) if videos else None
    room = room_of(known, recordings, truth, output, base)
    with writing(output):
        output.parent.mkdir(parents=True, exist_ok=True)
        save(room, output)
    for name in missing:
        print(f"warning: camera {name} has no recording in {videos} and no source", file=sys.stderr)
    for note in known.notes:
        print(f"warning: {note}", file=sys.stderr)
    print(_as_json(room, missing, known) if as_json else _summary(room, known.ball_radius, output))
    return 0


def is_room_file(path: Path) -> bool:
    """Whether a file says that it is a room."""
    try:
        return path.suffix in (".yaml", ".yml") and bool(ROOM.search(read_text(path, DOCUMENT)))
    except (OSError, UnicodeDecodeError):
        return False


def part_of_file(path: Path, only: Sequence[str]) -> Room:
    """The room of a file with these cameras and what belongs to them; all of it for none. Raises InputError.

    All of it also if there is no camera of such a name, which `with_only` says.
    """
    document, mistakes = read(path), list[Mistake]()
    part = part_of(document, only, mistakes) if only else document
    return room_document.room_of(document if mistakes else part, str(path.parent))


def without_recordings(room: Room) -> Room:
    """The room without the sources of its cameras, and of sensors whose readings were recorded."""
    cameras = {name: replace(camera, source=None) for name, camera in room.cameras.items()}
    sensors = {
        name: replace(sensor, source=None) if sensor.source and "path" in sensor.source.params else sensor
        for name, sensor in room.sensors.items()
    }
    return replace(room, cameras=cameras, sensors=sensors)


def calibration_of(room: Room) -> Calibration:
    """The cameras and planes of a room, and which of its sensors have no source now."""
    silent = [name for name, sensor in room.sensors.items() if sensor.source is None]
    notes = (f"sensors without a source: {', '.join(silent)}",) if silent else ()
    return Calibration(tuple(room.cameras.values()), room.planes, notes=notes)


def with_only(calibration: Calibration, names: Sequence[str]) -> Calibration:
    """The calibration of these cameras alone; of all for no names. Raises InputError for unknown names."""
    _check_known(calibration, names, "--only")
    chosen = (camera for camera in calibration.cameras if camera.name in names or not names)
    return replace(calibration, cameras=tuple(chosen))


def with_infrared(calibration: Calibration, names: Sequence[str]) -> Calibration:
    """The calibration with these cameras as infrared ones. Raises InputError for unknown names."""
    _check_known(calibration, names, "--infrared")
    cameras = (replace(c, kind="infrared") if c.name in names else c for c in calibration.cameras)
    return replace(calibration, cameras=tuple(cameras))


def with_recorded_sizes(calibration: Calibration, recordings: Mapping[str, Path]) -> Calibration:
    """The calibration for pictures as they were recorded; what that changed is noted. Raises InputError."""
    fitted = [
        as_recorded(c, picture_size(recordings[c.name])) if c.name in recordings else (c, "")
        for c in calibration.cameras
    ]
    notes = (*calibration.notes, *(note for _, note in fitted if note))
    return replace(calibration, cameras=tuple(camera for camera, _ in fitted), notes=notes)


def _check_known(calibration: Calibration, names: Sequence[str], option: str) -> None:
    known = [camera.name for camera in calibration.cameras]
    unknown = [name for name in names if name not in known]
    if unknown:
        remedy = did_you_mean(unknown[0], known, "cameras")
        raise InputError.of(f'{option}: there is no camera "{unknown[0]}"', remedy)


def find_truth(videos: Path, cameras: Sequence[str]) -> tuple[str, Path] | None:
    """The stage that gives the truth recorded in a folder and the path that it reads; None without truth."""
    if (videos / TRUTH).is_file():
        return "cameras.truth_csv", videos / TRUTH
    files = [file for name in cameras if (file := videos / f"{name}{POSE_TRUTH}").is_file()]
    if not files:
        return None
    return POSES, files[0] if len(files) == 1 else videos


def room_of(
    calibration: Calibration,
    recordings: Mapping[str, Path],
    truth: tuple[str, Path] | None,
    output: Path,
    base: Room,
) -> Room:
    """The room that is to be written to the output; paths are relative to its folder.

    base: the room whose targets, sensors and tuned parameters it keeps.
    """

    def with_source(camera: Camera) -> Camera:
        path = recordings.get(camera.name)
        if path is None:
            return camera
        stage = "cameras.images" if path.is_dir() else "cameras.video"
        times = times_beside(camera.name, path)
        return replace(camera, source=_use(stage, path, {} if times is None else {"times": str(times)}))

    cameras = {camera.name: with_source(camera) for camera in calibration.cameras}
    room = replace(
        base,
        name=output.stem,
        cameras=cameras,
        targets={name: resized(target, base.cameras, cameras) for name, target in base.targets.items()},
        planes=calibration.planes,
        truth=_use(*truth) if truth else None,
    )
    return moved(room, output)


def _use(stage: str, path: Path, more: Mapping[str, str] = MappingProxyType({})) -> StageUse:
    return StageUse(stage, {"path": str(path), **more})


def with_spread(calibration: Calibration, recordings: Mapping[str, Path]) -> Calibration:
    """The calibration with a note on how far apart pictures of one moment were taken. Raises InputError."""
    tables: dict[Path, list[str]] = {}
    for name, path in recordings.items():
        if (times := times_beside(name, path)) is not None and times.name == TABLE:
            tables.setdefault(times, []).append(name)
    spreads = ((table, spread_of_moments(table, names)) for table, names in tables.items())
    notes = tuple(
        f"by {table.name}, pictures of one moment were taken up to {-(-spread // MILLISECOND)} ms apart; "
        f"stages match them with a tolerance of {-(-spread // MILLISECOND) / 1000:g} and more"
        for table, spread in spreads
        if spread > DEFAULT_TOLERANCE
    )
    return replace(calibration, notes=(*calibration.notes, *notes))


def _no_recording(camera: str, videos: Path) -> Mistake:
    return Mistake(
        None,
        f"camera {camera} has no recording in {videos}",
        f"add {videos / camera}.mkv, or leave the camera without a source: --allow-missing",
    )


def _summary(room: Room, ball_radius: float | None, output: Path) -> str:
    kinds = [camera.kind for camera in room.cameras.values()]
    radius = f" --radius {ball_radius:g}" if ball_radius else ""
    following = f"followspot calibrate targets --room {output} --clips CLIPS{radius}"
    if room.truth is not None and room.truth.uses == POSES:
        following = f"followspot run GRAPH --room {output}"
    return (
        f"{output}: {kinds.count('color')} color and {kinds.count('infrared')} infrared cameras, "
        f"planes {', '.join(room.planes) or 'none'}, {'with' if room.truth else 'without'} truth\n"
        f"next: {following}"
    )


def _as_json(room: Room, missing: Sequence[str], known: Calibration) -> str:
    sources = {c.name: c.source.params["path"] if c.source else None for c in room.cameras.values()}
    truth = room.truth.params["path"] if room.truth else None
    found = {"room": room.name, "cameras": sources, "planes": list(room.planes), "truth": truth}
    return json.dumps({**found, "missing": missing, "posed": known.posed, "notes": known.notes})
